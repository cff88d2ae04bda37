//! Sectors that are erased wholly or not at all, whenever the power fails, and in which no word is programmed twice.
//!
//! # Design
//! The log above judges by the first and the last byte of a sector whether it is erased or in use. But an erase that
//! was cut short may have changed any of the bytes in between, or none: flash brings all bits to 0 before it brings
//! them to 1. So every sector begins with a stamp of three words: a mark, a blank, and the mark again.
//!
//! | stamp | the sector |
//! |---|---|
//! | mark, blank, mark | counts as what it reads as |
//! | anything else | counts as erased, whatever is in it |
//!
//! A sector is erased by programming the blank, which takes a moment and needs no erase. The chip's own erase comes
//! when the sector is next written to. Only when it has succeeded are the marks written again.
//!
//! Many flashes keep a checksum of each word, so a word may be programmed once only. Therefore the blank is left out when
//! the marks are written. A word whose programming the power has cut short may be anything. The log skips one that does
//! not read as erased, except its own marks at both ends of a sector, of which it would write a faint one again; so they
//! read as whole as soon as a bit of them is programmed. A word that still reads as erased is programmed again: nothing
//! tells that it was begun.
//!
//! Everything is read and written in whole words, which are at least as long as a header of the log. If the power fails in
//! the middle of a header, the log looks for the next header one word behind it, which is where it is. If the log looked at
//! every byte, it would look at many places that are no header, and now and then take one for a header; everything
//! behind it would be lost.

use core::ops::Range;

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

const MARK: FlashWord = FlashWord(*b"isostep2isostep2isostep2isostep2");
const CONDEMNED: FlashWord = FlashWord([0; WORD_BYTES_MAX]);
const ERASED: u8 = 0xFF;
/// The byte of which the log's own marks consist.
const LOG_MARK: u8 = 0;
const STAMP_WORDS: usize = 3;
const HEADER_BYTES: usize = 8;
/// The longest word that the log takes.
pub(super) const WORD_BYTES_MAX: usize = 32;
/// At most as many as `live` has bits.
const SECTORS_MAX: u32 = 32;

/// A word of any flash, aligned for drivers that program by words of the processor.
#[repr(align(4))]
struct FlashWord([u8; WORD_BYTES_MAX]);

/// Part of a flash.
pub(crate) struct Sectors<F> {
    flash: F,
    range: Range<u32>,
    /// The sectors with a good stamp.
    live: u32,
}

impl<F: NorFlash> Sectors<F> {
    /// The length of a word.
    pub const WORD_BYTES: usize = match word_bytes(F::WRITE_SIZE, F::READ_SIZE) {
        Some(bytes) => bytes,
        None => panic!("the store needs a flash that is written and read in units of 1, 2, 4, 8, 16 or 32 bytes"),
    };
    const STAMP_BYTES: usize = STAMP_WORDS * Self::WORD_BYTES;
    /// The length of what a sector holds.
    pub const SIZE: usize = {
        assert!(F::ERASE_SIZE.is_multiple_of(Self::WORD_BYTES), "a sector of the flash is not whole words");
        F::ERASE_SIZE - Self::STAMP_BYTES
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

    /// The length of the log, bytes.
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
            let mut bytes = [0; STAMP_WORDS * WORD_BYTES_MAX];
            let stamp = &mut bytes[..Self::STAMP_BYTES];
            let address = self.address(sector, 0);
            self.flash.read(address, stamp).await?;
            let mark = &MARK.0[..Self::WORD_BYTES];
            let (first, rest) = stamp.split_at(Self::WORD_BYTES);
            let (middle, last) = rest.split_at(Self::WORD_BYTES);
            match first == mark && is_erased(middle) && last == mark {
                true => self.live |= 1 << sector,
                false => strange |= !is_erased(stamp) && first != mark,
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
        (sector, self.address(sector, Self::STAMP_BYTES as u32 + offset % size))
    }

    async fn prepare(&mut self, sector: u32) -> Result<(), F::Error> {
        let (from, to) = (self.address(sector, 0), self.address(sector + 1, 0));
        self.flash.erase(from, to).await?;
        // There are two, so that an erase from either end destroys a mark first.
        for word in [0, STAMP_WORDS - 1] {
            self.program(sector, word, &MARK).await?;
        }
        self.live |= 1 << sector;
        Ok(())
    }

    /// Programs a word of a sector's stamp.
    async fn program(&mut self, sector: u32, word: usize, value: &FlashWord) -> Result<(), F::Error> {
        let address = self.address(sector, (word * Self::WORD_BYTES) as u32);
        self.flash.write(address, &value.0[..Self::WORD_BYTES]).await
    }

    /// True if the word at an offset is the log's mark at the beginning or the end of a sector.
    fn is_mark(offset: u32, bytes: usize) -> bool {
        let place = offset as usize % Self::SIZE;
        bytes == Self::WORD_BYTES && (place == 0 || place == Self::SIZE - Self::WORD_BYTES)
    }
}

/// The length of a word, which is whole units of the flash and holds a header of the log; `None` if there is none.
const fn word_bytes(write_bytes: usize, read_bytes: usize) -> Option<usize> {
    let mut bytes = HEADER_BYTES;
    while bytes <= WORD_BYTES_MAX {
        if bytes.is_multiple_of(write_bytes) && bytes.is_multiple_of(read_bytes) {
            return Some(bytes);
        }
        bytes *= 2;
    }
    None
}

fn is_erased(bytes: &[u8]) -> bool {
    bytes.iter().all(|&byte| byte == ERASED)
}

impl<F: NorFlash> ErrorType for Sectors<F> {
    type Error = F::Error;
}

impl<F: NorFlash> ReadNorFlash for Sectors<F> {
    const READ_SIZE: usize = Self::WORD_BYTES;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), F::Error> {
        let (sector, address) = self.locate(offset);
        if !self.is_live(sector) {
            bytes.fill(ERASED);
            return Ok(());
        }
        self.flash.read(address, bytes).await?;
        if Self::is_mark(offset, bytes.len()) && !is_erased(bytes) {
            bytes.fill(LOG_MARK);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes() as usize
    }
}

impl<F: NorFlash> NorFlash for Sectors<F> {
    const WRITE_SIZE: usize = Self::WORD_BYTES;
    const ERASE_SIZE: usize = Self::SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), F::Error> {
        let size = Self::SIZE as u32;
        for sector in from / size..to / size {
            if self.is_live(sector) {
                self.live &= !(1 << sector);
                self.program(sector, 1, &CONDEMNED).await?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_whole_units_of_the_flash_and_holds_a_header() {
        for (write_bytes, read_bytes, bytes) in [
            (1, 1, Some(8)),
            (4, 4, Some(8)),
            (8, 1, Some(8)),
            (16, 1, Some(16)),
            (4, 16, Some(16)),
            (32, 1, Some(32)),
            (64, 1, None),
            (12, 1, None),
        ] {
            assert_eq!(word_bytes(write_bytes, read_bytes), bytes, "{write_bytes}, {read_bytes}");
        }
    }
}
