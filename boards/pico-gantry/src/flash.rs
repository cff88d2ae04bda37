//! The flash in which settings are stored: its last 64 KiB, which `memory.x` keeps free of firmware.
//!
//! # Design
//! While a page is programmed (0.7 ms) or a sector erased (45 ms, at most 400 ms by its datasheet) the flash cannot be
//! read, and some code is in it. So the HAL masks every interrupt and waits in RAM. A step that is due then would
//! be late, and a switch would be noticed late. So the controller stores only while nothing moves. The output watchdog
//! is told to wait for as long. Between two operations the other tasks run, so that the watchdog is refreshed. Motors
//! stay energised. The USB hardware makes its host wait, but a UART loses what does not fit into its 32 bytes.

use embassy_rp::Peri;
use embassy_rp::flash::{self, Blocking, ERASE_SIZE, Error, READ_SIZE, WRITE_SIZE};
use embassy_rp::peripherals::FLASH;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use isostep_controller::{Settings, Store};

use crate::chip::FLASH_BYTES;
use crate::output_watchdog;

/// Size of the store, as in `memory.x`.
const STORE_BYTES: usize = 64 * 1024;

/// The chip's flash. It blocks the core while it works, so a future that waits for it is always ready at once.
pub struct Flash(flash::Flash<'static, FLASH, Blocking, FLASH_BYTES>);

/// The end of the store. That of a proving image is below the other, so that the user's settings stay as they are.
const STORE_END: usize = if cfg!(feature = "prove") { FLASH_BYTES - STORE_BYTES } else { FLASH_BYTES };

/// Takes the flash.
pub fn take(flash: Peri<'static, FLASH>) -> Flash {
    Flash(flash::Flash::new_blocking(flash))
}

/// Opens the store in the flash, without reading it yet.
pub fn open(flash: Flash) -> Store<Flash> {
    Store::new(flash, (STORE_END - STORE_BYTES) as u32..STORE_END as u32, Settings::DEFAULT)
}

#[cfg(feature = "prove")]
impl Flash {
    /// The number that the maker of flash or chip gave it; 0 if it cannot be read.
    pub fn board_id(&mut self) -> u64 {
        crate::chip::prove::board_id(&mut self.0)
    }
}

impl ErrorType for Flash {
    type Error = Error;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        self.0.blocking_read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        FLASH_BYTES
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WRITE_SIZE;
    const ERASE_SIZE: usize = ERASE_SIZE;

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        output_watchdog::outlast(|| self.0.blocking_write(offset, bytes))
    }

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        // All sectors at once would be more than the switch has patience for.
        let mut sectors = (from..to).step_by(ERASE_SIZE);
        sectors.try_for_each(|sector| {
            output_watchdog::outlast(|| self.0.blocking_erase(sector, (sector + ERASE_SIZE as u32).min(to)))
        })
    }
}
