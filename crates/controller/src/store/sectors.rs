//! Sectors that are erased wholly or not at all, whenever the power goes.
//!
//! # Design
//! The log above takes a sector for erased, or for in use, by its first and last byte. But an erase that was cut short may
//! leave any of the bytes in between, or none: flash brings all bits to 0 before it brings them to 1. So every sector
//! begins with a stamp: a mark, a blank, and the mark again.
//!
//! | stamp | the sector |
//! |---|---|
//! | mark, blank, mark | is what it reads as |
//! | anything else | is erased, whatever is in it |
//!
//! To erase a sector is to program the blank, which takes a moment and no erase. The chip's own erase comes when the sector
//! is next written to, and only when it has succeeded is the stamp put on again.
//!
//! All is read and written by whole words, as long as a header of the log. Where the power went in the midst of a header, the log
//! looks for the next one a word behind it, and that is where it is. Were it to look at every byte, it would look at many places
//! that are none, and now and then take one for a header: what follows would be lost.

use core::ops::Range;

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Another where the words of the log are of another length.
const MARK: [u8; 8] = *b"isostep2";
const BLANK: [u8; 8] = [ERASED; 8];
const CONDEMNED: [u8; 8] = [0; 8];
const STAMP_BYTES: usize = 24;
const ERASED: u8 = 0xFF;
/// As long as a header of the log.
pub(super) const WORD_BYTES: usize = 8;
/// One bit for each sector.
const SECTORS_MAX: u32 = 32;

/// Part of a flash.
pub(crate) struct Sectors<F> {
    flash: F,
    range: Range<u32>,
    /// The sectors with a good stamp.
    live: u32,
}

impl<F: NorFlash> Sectors<F> {
    const SIZE: usize = {
        assert!(WORD_BYTES.is_multiple_of(F::WRITE_SIZE) && WORD_BYTES.is_multiple_of(F::READ_SIZE));
        assert!(MARK.len().is_multiple_of(WORD_BYTES) && F::ERASE_SIZE.is_multiple_of(WORD_BYTES));
        F::ERASE_SIZE - STAMP_BYTES
    };

    /// All sectors count as erased until [`open`](Self::open) has looked at them.
    ///
    /// # Panics
    /// When `range` is not 4 to 32 whole sectors.
    pub fn new(flash: F, range: Range<u32>) -> Self {
        let sector = F::ERASE_SIZE as u32;
        let whole = range.start.is_multiple_of(sector) && range.end.is_multiple_of(sector);
        assert!(whole && (4..=SECTORS_MAX).contains(&(range.len() as u32 / sector)), "4 to 32 whole sectors");
        Self { flash, range, live: 0 }
    }

    /// How many bytes there are.
    pub fn bytes(&self) -> u32 {
        self.count() * Self::SIZE as u32
    }

    /// Looks at the stamps. False if there is something, but nothing of ours.
    ///
    /// # Errors
    /// The flash's.
    pub async fn open(&mut self) -> Result<bool, F::Error> {
        self.live = 0;
        let mut strange = false;
        for sector in 0..self.count() {
            let mut stamp = [0; STAMP_BYTES];
            let address = self.address(sector, 0);
            self.flash.read(address, &mut stamp).await?;
            match stamp_of(BLANK) == stamp {
                true => self.live |= 1 << sector,
                false => strange |= stamp != [ERASED; STAMP_BYTES] && stamp != stamp_of(CONDEMNED),
            }
        }
        Ok(self.live != 0 || !strange)
    }

    fn count(&self) -> u32 {
        self.range.len() as u32 / F::ERASE_SIZE as u32
    }

    fn is_live(&self, sector: u32) -> bool {
        self.live & 1 << sector != 0
    }

    fn address(&self, sector: u32, offset: u32) -> u32 {
        self.range.start + sector * F::ERASE_SIZE as u32 + offset
    }

    /// The sector of an offset, and where in the flash the offset is. The log never asks for bytes of two sectors at once.
    fn locate(&self, offset: u32) -> (u32, u32) {
        let size = Self::SIZE as u32;
        let sector = offset / size;
        (sector, self.address(sector, STAMP_BYTES as u32 + offset % size))
    }

    async fn prepare(&mut self, sector: u32) -> Result<(), F::Error> {
        let (from, to) = (self.address(sector, 0), self.address(sector + 1, 0));
        self.flash.erase(from, to).await?;
        self.flash.write(from, &stamp_of(BLANK)).await?;
        self.live |= 1 << sector;
        Ok(())
    }
}

/// A stamp with `middle` between its marks: an erase that comes from either end takes a mark first.
fn stamp_of(middle: [u8; 8]) -> [u8; STAMP_BYTES] {
    let mut stamp = [0; STAMP_BYTES];
    stamp[..8].copy_from_slice(&MARK);
    stamp[8..16].copy_from_slice(&middle);
    stamp[16..].copy_from_slice(&MARK);
    stamp
}

impl<F: NorFlash> ErrorType for Sectors<F> {
    type Error = F::Error;
}

impl<F: NorFlash> ReadNorFlash for Sectors<F> {
    const READ_SIZE: usize = WORD_BYTES;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), F::Error> {
        let (sector, address) = self.locate(offset);
        if self.is_live(sector) {
            return self.flash.read(address, bytes).await;
        }
        bytes.fill(ERASED);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes() as usize
    }
}

impl<F: NorFlash> NorFlash for Sectors<F> {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = Self::SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), F::Error> {
        let size = Self::SIZE as u32;
        for sector in from / size..to / size {
            if self.is_live(sector) {
                self.live &= !(1 << sector);
                let address = self.address(sector, MARK.len() as u32);
                self.flash.write(address, &CONDEMNED).await?;
            }
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), F::Error> {
        let (sector, address) = self.locate(offset);
        if !self.is_live(sector) {
            self.prepare(sector).await?;
        }
        self.flash.write(address, bytes).await
    }
}
