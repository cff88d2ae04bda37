//! Flash for settings. QEMU's has none that a program can change, so it reads as erased and refuses to be written: a
//! setting is in force until power-down, and `error:7` says so.

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use isostep_controller::{Settings, Store};

/// Erased sectors.
pub struct Flash;

const SECTOR_BYTES: usize = 4096;
const SECTORS: u32 = 4;

/// Opens the store.
pub fn open() -> Store<Flash> {
    Store::new(Flash, 0..SECTORS * SECTOR_BYTES as u32, Settings::DEFAULT)
}

/// It cannot be written.
#[derive(Debug)]
pub struct ReadOnly;

impl NorFlashError for ReadOnly {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl ErrorType for Flash {
    type Error = ReadOnly;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 4;

    async fn read(&mut self, _offset: u32, bytes: &mut [u8]) -> Result<(), ReadOnly> {
        bytes.fill(0xFF);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTORS as usize * SECTOR_BYTES
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR_BYTES;

    async fn erase(&mut self, _from: u32, _to: u32) -> Result<(), ReadOnly> {
        Err(ReadOnly)
    }

    async fn write(&mut self, _offset: u32, _bytes: &[u8]) -> Result<(), ReadOnly> {
        Err(ReadOnly)
    }
}
