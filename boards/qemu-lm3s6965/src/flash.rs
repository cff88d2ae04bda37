//! Flash for settings: the last 16 KiB of the chip's. QEMU has no controller that would program it, so it refuses to be
//! written: a setting is in force until power-down, and `error:7` says so.
//!
//! QEMU's flash begins as zeros, where a chip's is erased. So it is read inverted.

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use isostep_controller::{Settings, Store};

use crate::chip::Register;

/// Flash that can be read only.
pub struct Flash;

const BEGIN: u32 = 0x3_C000;
const SECTOR_BYTES: usize = 1024;
const SECTORS: u32 = 16;

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

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), ReadOnly> {
        for (at, word) in (BEGIN + offset..).step_by(4).zip(bytes.chunks_exact_mut(4)) {
            word.copy_from_slice(&(!Register::at(at, 0).read()).to_le_bytes());
        }
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
