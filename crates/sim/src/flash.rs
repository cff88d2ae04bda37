//! Flash that survives a simulated machine: NOR cells, wear of its sectors, and power cuts on request. Like flash that
//! keeps a checksum of each word, it takes a word once only between two erases.

use std::cell::RefCell;
use std::fmt;
use std::ops::Range;
use std::rc::Rc;

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use oorandom::Rand64;

/// Sector size in the chip of a Pico.
pub const SECTOR_BYTES: usize = 4096;
/// Page size. An operation never programs across the end of a page.
const PAGE_BYTES: usize = 256;
/// Size of the firmware's store for settings.
pub const FLASH_BYTES: usize = 16 * SECTOR_BYTES;
const ERASED: u8 = 0xFF;

/// A handle to a flash that is programmed in words of so many bytes, and erased in sectors of so many; clones refer to the
/// same flash.
#[derive(Clone)]
pub struct WordFlash<const WORD_BYTES: usize, const ERASE_BYTES: usize = SECTOR_BYTES>(Rc<RefCell<Cells>>);

/// Flash that is programmed byte by byte, as that of a Pico.
pub type Flash = WordFlash<1>;

struct Cells {
    bytes: Vec<u8>,
    /// The bytes whose words have been programmed since they were erased.
    programmed: Vec<bool>,
    erases: Vec<u32>,
    operations: u64,
    fault: Option<Fault>,
}

/// A fault while a page is programmed or a sector erased.
struct Fault {
    /// Number of completed operations after which it comes.
    at_operation: u64,
    /// If set, the operation stops at a random point. If `None`, the flash refuses it.
    torn: Option<Rand64>,
}

/// The reason why an operation failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FlashError {
    /// The range is not whole sectors.
    Unaligned,
    /// The range is beyond the end.
    OutOfBounds,
    /// A fault was injected.
    Refused,
}

impl<const WORD_BYTES: usize, const ERASE_BYTES: usize> WordFlash<WORD_BYTES, ERASE_BYTES> {
    /// A flash that is completely erased.
    pub fn blank() -> Self {
        Self::with(vec![ERASED; FLASH_BYTES])
    }

    /// A flash with these contents.
    ///
    /// # Panics
    /// If `bytes` are not whole sectors.
    pub fn with(bytes: Vec<u8>) -> Self {
        assert!(bytes.len().is_multiple_of(ERASE_BYTES), "{} bytes are not whole sectors", bytes.len());
        let erases = vec![0; bytes.len() / ERASE_BYTES];
        let mut cells = Cells { programmed: vec![false; bytes.len()], bytes, erases, operations: 0, fault: None };
        cells.look(0..cells.bytes.len(), WORD_BYTES);
        Self(Rc::new(RefCell::new(cells)))
    }

    /// The contents.
    pub fn bytes(&self) -> Vec<u8> {
        self.0.borrow().bytes.clone()
    }

    /// Changes the contents directly, without the rules of a flash.
    pub fn change(&self, change: impl FnOnce(&mut [u8])) {
        change(&mut self.0.borrow_mut().bytes);
    }

    /// The number of times that each sector was erased.
    pub fn erases(&self) -> Vec<u32> {
        self.0.borrow().erases.clone()
    }

    /// Pages programmed and sectors erased so far.
    pub fn operations(&self) -> u64 {
        self.0.borrow().operations
    }

    /// Cuts the power during the operation after `operations` more. `seed` chooses the point at which that operation
    /// stops. After that nothing works until [`mend`](Self::mend).
    pub fn cut_power_after(&self, operations: u64, seed: u64) {
        self.fault_after(operations, Some(Rand64::new(seed.into())));
    }

    /// Refuses to program and to erase until [`mend`](Self::mend).
    pub fn refuse(&self) {
        self.fault_after(0, None);
    }

    /// Removes the fault.
    pub fn mend(&self) {
        self.0.borrow_mut().fault = None;
    }

    fn fault_after(&self, operations: u64, torn: Option<Rand64>) {
        let mut cells = self.0.borrow_mut();
        cells.fault = Some(Fault { at_operation: cells.operations + operations, torn });
    }
}

impl Cells {
    fn check(&self, from: usize, to: usize, unit: usize) -> Result<(), FlashError> {
        if from > to || to > self.bytes.len() {
            return Err(FlashError::OutOfBounds);
        }
        let aligned = from.is_multiple_of(unit) && to.is_multiple_of(unit);
        if aligned { Ok(()) } else { Err(FlashError::Unaligned) }
    }

    /// Takes a word for programmed if any of its bits is.
    fn look(&mut self, range: Range<usize>, word_bytes: usize) {
        // Most pages are erased, and quickly passed over.
        let pages = self.bytes[range.clone()].chunks(PAGE_BYTES).zip(self.programmed[range].chunks_mut(PAGE_BYTES));
        for (page, programmed) in pages {
            programmed.fill(false);
            if *page == [ERASED; PAGE_BYTES] {
                continue;
            }
            for (word, programmed) in page.chunks(word_bytes).zip(programmed.chunks_mut(word_bytes)) {
                programmed.fill(word.iter().any(|&byte| byte != ERASED));
            }
        }
    }

    /// True if the next operation changes cells: not where the flash refuses it, nor after the power has gone.
    fn works(&self) -> bool {
        !self.fault.as_ref().is_some_and(|fault| self.operations >= fault.at_operation && fault.torn.is_none())
    }

    /// Changes the cells from index `from` on to `wanted`, or as far as a fault allows.
    fn operate(&mut self, from: usize, wanted: &[u8]) -> Result<(), FlashError> {
        let cells = &mut self.bytes[from..from + wanted.len()];
        match &mut self.fault {
            Some(fault) if self.operations >= fault.at_operation => {
                if let Some(mut random) = fault.torn.take() {
                    tear(cells, wanted, &mut random);
                }
                return Err(FlashError::Refused);
            }
            _ => cells.copy_from_slice(wanted),
        }
        self.operations += 1;
        Ok(())
    }
}

/// Leaves cells in an intermediate state: only some bytes have changed (from the front, from the back or at random), or
/// only some bits. An erase may first set them all to 0.
fn tear(cells: &mut [u8], wanted: &[u8], random: &mut Rand64) {
    let erases = cells.iter().zip(wanted).any(|(&is, &to)| is & to != to);
    let to_zero = erases && random.rand_range(0..3) == 0;
    let place = random.rand_range(0..cells.len() as u64 + 1) as usize;
    let hits_of_256 = random.rand_range(0..257);
    let pattern = random.rand_range(0..4);
    for (index, (cell, &wanted)) in cells.iter_mut().zip(wanted).enumerate() {
        let mut hits = || random.rand_range(0..256) < hits_of_256;
        let arrived = match pattern {
            0 => whole(index < place),
            1 => whole(index >= place),
            2 => whole(hits()),
            _ => (0..8).fold(0, |bits, bit| bits | u8::from(hits()) << bit),
        };
        let wanted = if to_zero { 0 } else { wanted };
        *cell = *cell & !arrived | wanted & arrived;
    }
}

/// All bits of a byte if it has changed, otherwise none.
fn whole(arrived: bool) -> u8 {
    if arrived { 0xFF } else { 0 }
}

impl<const WORD_BYTES: usize, const ERASE_BYTES: usize> ErrorType for WordFlash<WORD_BYTES, ERASE_BYTES> {
    type Error = FlashError;
}

impl<const WORD_BYTES: usize, const ERASE_BYTES: usize> ReadNorFlash for WordFlash<WORD_BYTES, ERASE_BYTES> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let cells = self.0.borrow();
        let (from, to) = (offset as usize, offset as usize + bytes.len());
        cells.check(from, to, 1)?;
        bytes.copy_from_slice(&cells.bytes[from..to]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.borrow().bytes.len()
    }
}

impl<const WORD_BYTES: usize, const ERASE_BYTES: usize> NorFlash for WordFlash<WORD_BYTES, ERASE_BYTES> {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = ERASE_BYTES;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let mut cells = self.0.borrow_mut();
        cells.check(from as usize, to as usize, ERASE_BYTES)?;
        for sector in from as usize / ERASE_BYTES..to as usize / ERASE_BYTES {
            let bytes = sector * ERASE_BYTES..(sector + 1) * ERASE_BYTES;
            if cells.works() {
                // What is erased in part has to be erased again.
                cells.programmed[bytes.clone()].fill(true);
            }
            cells.operate(bytes.start, &[ERASED; ERASE_BYTES])?;
            cells.programmed[bytes].fill(false);
            cells.erases[sector] += 1;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let mut cells = self.0.borrow_mut();
        let mut from = offset as usize;
        cells.check(from, from + bytes.len(), WORD_BYTES)?;
        let mut left = bytes;
        while !left.is_empty() {
            let (part, rest) = left.split_at(left.len().min(PAGE_BYTES - from % PAGE_BYTES));
            let range = from..from + part.len();
            assert!(!cells.programmed[range.clone()].contains(&true), "a word at {from} is programmed a second time");
            // Programming changes bits from 1 to 0 only.
            let wanted: Vec<u8> = cells.bytes[from..].iter().zip(part).map(|(&is, &to)| is & to).collect();
            let done = cells.operate(from, &wanted);
            match done {
                Ok(()) => cells.programmed[range].fill(true),
                Err(_) => cells.look(range, WORD_BYTES),
            }
            done?;
            (from, left) = (from + part.len(), rest);
        }
        Ok(())
    }
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Unaligned => NorFlashErrorKind::NotAligned,
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::Refused => NorFlashErrorKind::Other,
        }
    }
}

impl<const WORD_BYTES: usize, const ERASE_BYTES: usize> fmt::Debug for WordFlash<WORD_BYTES, ERASE_BYTES> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cells = self.0.borrow();
        f.debug_struct("Flash").field("bytes", &cells.bytes.len()).field("erases", &cells.erases).finish()
    }
}

#[cfg(test)]
mod tests {
    use embassy_futures::block_on;

    use super::*;

    /// After a power cycle a word with some bits programmed takes no others, and its neighbours are free.
    #[test]
    #[should_panic(expected = "a word at 4104 is programmed a second time")]
    fn what_was_programmed_before_a_power_cycle_is_known_after_it() {
        let mut bytes = vec![ERASED; FLASH_BYTES];
        bytes[SECTOR_BYTES + 13] = 0x7F;
        let mut flash = WordFlash::<8>::with(bytes);
        block_on(flash.write(SECTOR_BYTES as u32, &[0; 8])).unwrap();
        block_on(flash.write(SECTOR_BYTES as u32 + 8, &[0; 8])).unwrap();
    }
}
