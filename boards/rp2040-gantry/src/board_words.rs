//! The words of the board, which `cargo xtask` writes into the image after it is linked (`xtask/src/board_words.rs`):
//! the contact of the emergency stop, and the timing of the stepper drivers. They are a property of the image, which no
//! console can change. They are read once, at start-up.
#![expect(
    unsafe_code,
    reason = "the linker puts the words into a section of their own, and they are read as they are in flash"
)]

use core::ptr;

use isostep_motion::{Contact, DriverTiming};

/// The mark of the section, and the number of this layout.
const MAGIC: [u8; 8] = *b"ISOWORDS";
const VERSION: u32 = 1;
/// `contact`: the emergency stop is wired normally open, closed while it is pressed; or normally closed.
const NORMALLY_OPEN: u32 = 0;
/// `driver`: a TMC2209, or otherwise a DRV8825.
const TMC2209: u32 = 1;

#[repr(C)]
struct BoardWords {
    magic: [u8; 8],
    version: u32,
    contact: u32,
    driver: u32,
}

// SAFETY: memory.x keeps the section in flash, and nothing else is in it.
#[unsafe(link_section = ".board_words")]
#[used]
static WORDS: BoardWords = BoardWords { magic: MAGIC, version: VERSION, contact: NORMALLY_OPEN, driver: 0 };

/// The contact between the emergency stop's pin and ground. A word that nobody has written is one that opens: then a machine
/// that is wired otherwise does not move.
pub fn emergency_contact() -> Contact {
    if read(&raw const WORDS.contact) == NORMALLY_OPEN { Contact::NormallyOpen } else { Contact::NormallyClosed }
}

/// The timing of the stepper drivers. The slower one fits all of them.
pub fn driver_timing() -> DriverTiming {
    if read(&raw const WORDS.driver) == TMC2209 { DriverTiming::TMC2209 } else { DriverTiming::DRV8825 }
}

/// The word as it is in flash: the compiler knows only what stood there before the image was finished.
fn read(word: *const u32) -> u32 {
    // SAFETY: it points to a field of a static that is never written while the firmware runs.
    unsafe { ptr::read_volatile(word) }
}
