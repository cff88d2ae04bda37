//! Flash that survives a simulated machine: NOR cells, wear of its sectors, and power cuts on request.

use std::cell::RefCell;
use std::fmt;
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

/// A handle to a flash; clones refer to the same flash.
#[derive(Clone)]
pub struct Flash(Rc<RefCell<Cells>>);

struct Cells {
    bytes: Vec<u8>,
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

/// Why an operation failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// The range is not whole sectors.
    Unaligned,
    /// The range is beyond the end.
    OutOfBounds,
    /// A fault was injected.
    Refused,
}

impl Flash {
    /// A flash that is completely erased.
    pub fn blank() -> Self {
        Self::with(vec![ERASED; FLASH_BYTES])
    }

    /// A flash with these contents.
    ///
    /// # Panics
    /// If `bytes` are not whole sectors.
    pub fn with(bytes: Vec<u8>) -> Self {
        assert!(bytes.len().is_multiple_of(SECTOR_BYTES), "{} bytes are not whole sectors", bytes.len());
        let erases = vec![0; bytes.len() / SECTOR_BYTES];
        Self(Rc::new(RefCell::new(Cells { bytes, erases, operations: 0, fault: None })))
    }

    /// The contents.
    pub fn bytes(&self) -> Vec<u8> {
        self.0.borrow().bytes.clone()
    }

    /// Changes the contents directly, without the rules of a flash.
    pub fn change(&self, change: impl FnOnce(&mut [u8])) {
        change(&mut self.0.borrow_mut().bytes);
    }

    /// How often each sector was erased.
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

impl ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
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

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR_BYTES;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let mut cells = self.0.borrow_mut();
        cells.check(from as usize, to as usize, SECTOR_BYTES)?;
        for sector in from as usize / SECTOR_BYTES..to as usize / SECTOR_BYTES {
            cells.operate(sector * SECTOR_BYTES, &[ERASED; SECTOR_BYTES])?;
            cells.erases[sector] += 1;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let mut cells = self.0.borrow_mut();
        cells.check(offset as usize, offset as usize + bytes.len(), 1)?;
        let mut from = offset as usize;
        let mut left = bytes;
        while !left.is_empty() {
            let (part, rest) = left.split_at(left.len().min(PAGE_BYTES - from % PAGE_BYTES));
            // Programming changes bits from 1 to 0 only.
            let wanted: Vec<u8> = cells.bytes[from..].iter().zip(part).map(|(&is, &to)| is & to).collect();
            cells.operate(from, &wanted)?;
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

impl fmt::Debug for Flash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cells = self.0.borrow();
        f.debug_struct("Flash").field("bytes", &cells.bytes.len()).field("erases", &cells.erases).finish()
    }
}
