//! Where settings are stored: the last 64 KiB of the flash, which `memory.x` keeps the firmware out of.
//!
//! # Design
//! While a page is programmed (0.7 ms) or a sector erased (45 ms, by its datasheet 400 ms at most) the flash cannot be read, and
//! nearly all code is in it: the HAL masks every interrupt and waits in RAM. A step that is due then would be late, and a switch
//! be heard late. So the controller stores only while nothing moves; and between two operations the other tasks run, so that
//! the watchdog is refreshed. Motors stay energised, and USB's hardware holds its host off; a UART loses what does not fit its
//! 32 bytes.

use embassy_embedded_hal::adapter::BlockingAsync;
use embassy_rp::Peri;
use embassy_rp::flash::{self, Blocking};
use embassy_rp::peripherals::FLASH;
use isostep_controller::{Settings, Store};

/// Of a Pico.
const FLASH_BYTES: usize = 2 * 1024 * 1024;
/// As `memory.x` has it.
const STORE_BYTES: usize = 64 * 1024;

/// The chip's flash, which holds the core while it works: no future that waits for it ever waits.
pub type Flash = BlockingAsync<flash::Flash<'static, FLASH, Blocking, FLASH_BYTES>>;

/// What the flash keeps; not read yet.
pub fn open(flash: Peri<'static, FLASH>) -> Store<Flash> {
    let flash = BlockingAsync::new(flash::Flash::new_blocking(flash));
    Store::new(flash, (FLASH_BYTES - STORE_BYTES) as u32..FLASH_BYTES as u32, Settings::DEFAULT)
}
