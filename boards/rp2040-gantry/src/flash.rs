//! The flash in which settings are stored: its last 64 KiB, which `memory.x` keeps free of firmware.
//!
//! # Design
//! While a page is programmed (0.7 ms) or a sector erased (45 ms, at most 400 ms by its datasheet) the flash cannot be
//! read, and some code is in it. So the HAL masks every interrupt and waits in RAM. A step that is due then would
//! be late, and a switch would be noticed late. So the controller stores only while nothing moves. Between two
//! operations the other tasks run, so that the watchdog is refreshed. Motors stay energised. The USB hardware makes its
//! host wait, but a UART loses what does not fit into its 32 bytes.

use embassy_embedded_hal::adapter::BlockingAsync;
use embassy_rp::Peri;
use embassy_rp::flash::{self, Blocking};
use embassy_rp::peripherals::FLASH;
use isostep_controller::{Settings, Store};

/// Flash size of a Pico.
const FLASH_BYTES: usize = 2 * 1024 * 1024;
/// Size of the store, as in `memory.x`.
const STORE_BYTES: usize = 64 * 1024;

/// The chip's flash. It blocks the core while it works, so a future that waits for it is always ready at once.
pub type Flash = BlockingAsync<flash::Flash<'static, FLASH, Blocking, FLASH_BYTES>>;

/// Opens the store in the flash, without reading it yet.
pub fn open(flash: Peri<'static, FLASH>) -> Store<Flash> {
    let flash = BlockingAsync::new(flash::Flash::new_blocking(flash));
    Store::new(flash, (FLASH_BYTES - STORE_BYTES) as u32..FLASH_BYTES as u32, Settings::DEFAULT)
}
