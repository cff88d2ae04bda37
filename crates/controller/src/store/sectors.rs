//! Sectors that are erased wholly or not at all, whenever the power fails.
//!
//! # Design
//! The log above judges by the first and the last byte of a sector whether it is erased or in use. But an erase that
//! was cut short may have changed any of the bytes in between, or none: flash brings all bits to 0 before it brings
//! them to 1. So every sector begins with a stamp: a mark, a blank, and the mark again.
//!
//! | stamp | the sector |
//! |---|---|
//! | mark, blank, mark | counts as what it reads as |
//! | anything else | counts as erased, whatever is in it |
//!
//! A sector is erased by programming the blank, which takes a moment and needs no erase. The chip's own erase comes
//! when the sector is next written to. Only when it has succeeded is the stamp written again.
//!
//! Everything is read and written in whole words, which are as long as a header of the log. If the power fails in the
//! middle of a header, the log looks for the next header one word behind it, which is where it is. If the log looked at
//! every byte, it would look at many places that are no header, and now and then take one for a header; everything
//! behind it would be lost.

use core::ops::Range;

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// It has to be another one if the words of the log have another length.
const MARK: [u8; 8] = *b"isostep2";
const BLANK: [u8; 8] = [ERASED; 8];
const CONDEMNED: [u8; 8] = [0; 8];
const STAMP_BYTES: usize = 24;
const ERASED: u8 = 0xFF;
/// As long as a header of the log.
pub(super) const WORD_BYTES: usize = 8;
/// At most as many as `live` has bits.
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

    /// How many bytes the log has.
    pub fn bytes(&self) -> u32 {
        self.count() * Self::SIZE as u32
    }

    /// Reads the stamps. False if there is something in the flash, but nothing of ours.
    ///
    /// # Errors
    /// The flash's error.
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

    /// The sector of an offset, and the address of the offset in the flash. The log never asks for bytes of two sectors
    /// at once.
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

/// A stamp with `middle` between its marks. There are two, so that an erase from either end destroys a mark first.
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
