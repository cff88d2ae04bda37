//! The words of the board, which `cargo xtask` writes into the image after it is linked (`xtask/src/board_words.rs`):
//! the contact of the emergency stop, the timing of the stepper drivers, and the times that moves last at least. They are a property
//! of the image, which no console can change.
#![expect(
    unsafe_code,
    reason = "the linker puts the words into a section of their own, and they are read as they are in flash"
)]

use core::hint::black_box;
use core::ops::RangeInclusive;
use core::ptr;

use isostep_motion::{Contact, DriverTiming, LeastTimes};

use crate::chip;

/// The mark of the section, and the number of this layout.
const MAGIC: [u8; 8] = *b"ISOWORDS";
const VERSION: u32 = 2;
/// `contact`: the emergency stop is wired normally open, closed while it is pressed; or normally closed.
const NORMALLY_OPEN: u32 = 0;
/// `driver`: a TMC2209, or otherwise a DRV8825.
const TMC2209: u32 = 1;
/// `least_times`: each of them is from 10 us to 1 s. Doubles above 0 are in the order of their bits, in which a NaN is above all.
const TIME_BITS: RangeInclusive<u64> = 1e-5_f64.to_bits()..=1.0_f64.to_bits();

#[repr(C)]
struct BoardWords {
    magic: [u8; 8],
    version: u32,
    contact: u32,
    driver: u32,
    /// So that what follows begins at a multiple of 8 bytes.
    unused: u32,
    least_times: LeastTimes,
}

// SAFETY: memory.x keeps the section in flash, and nothing else is in it.
#[unsafe(link_section = ".board_words")]
#[used]
static WORDS: BoardWords = BoardWords {
    magic: MAGIC,
    version: VERSION,
    contact: NORMALLY_OPEN,
    driver: 0,
    unused: 0,
    least_times: chip::LEAST_TIMES,
};

/// The contact between the emergency stop's pin and ground. A word that nobody has written is one that opens: then a machine
/// that is wired otherwise does not move.
pub fn emergency_contact() -> Contact {
    if read(&raw const WORDS.contact) == NORMALLY_OPEN { Contact::NormallyOpen } else { Contact::NormallyClosed }
}

/// The timing of the stepper drivers. The slower one fits all of them.
pub fn driver_timing() -> DriverTiming {
    if read(&raw const WORDS.driver) == TMC2209 { DriverTiming::TMC2209 } else { DriverTiming::DRV8825 }
}

/// The times that moves last at least. If a word is none that can be, they are those that the image is linked with.
#[cold]
pub fn least_times() -> &'static LeastTimes {
    const WORDS_OF_TIMES: usize = size_of::<LeastTimes>() / size_of::<u64>();

    // The compiler must not take them for what stood there before the image was finished.
    let times = black_box(&WORDS.least_times);
    // SAFETY: they are doubles one after the other, and every double is 64 bits.
    let bits = unsafe { &*ptr::from_ref(times).cast::<[u64; WORDS_OF_TIMES]>() };
    if bits.iter().all(|time| TIME_BITS.contains(time)) { times } else { &chip::LEAST_TIMES }
}

/// The word as it is in flash: the compiler knows only what stood there before the image was finished.
fn read(word: *const u32) -> u32 {
    // SAFETY: it points to a field of a static that is never written while the firmware runs.
    unsafe { ptr::read_volatile(word) }
}
