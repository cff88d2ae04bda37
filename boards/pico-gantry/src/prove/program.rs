//! The stampers' programs: state machines that note when their pad rises.
//!
//! # Design
//! A stamper counts X down, a count each second cycle, and looks at its pad in the cycles between. When the pad is high
//! it pushes X. Then it counts on until the pad is low again. What an edge takes is not counted, but always takes the
//! same number of cycles, so [`seen_cycles`] adds it. A stamp is the cycle in which the pad was seen high; it has been
//! high since then or since the cycle before.
//!
//! All stampers wait for a pad, the marker, and so begin on the same cycle, also those of different PIO blocks. One that
//! begins at [`LATE`] looks in the cycles in which the others do not, so two of them on one pad are exact to a cycle.
//!
//! In the block that the step program leaves there are 6 instructions free, and so the program there pushes at each edge.
//! Where there are more, the program pushes at the first edge, takes from OSR how many edges to skip, and pushes at all that
//! follow.
//!
//! Nothing here accesses the chip: the tests run this file's programs on emulators.

use pio::{InstructionOperands, JmpCondition, MovDestination, MovOperation, MovSource, Program};

/// The pad that all wait for: GP27.
pub const MARKER: u8 = 27;

/// The address of the program that skips, behind the guard's.
pub const SKIPPING_ORIGIN: u8 = 6;
/// The place where a stamper of that program begins, and one that looks in the cycles between.
pub const EARLY: u8 = 0;
pub const LATE: u8 = 2;
/// The address of the short program: behind the step program.
pub const SHORT_ORIGIN: u8 = 26;

/// Cycles that are not counted: of an edge that is stamped, of one that is skipped, and of one of the short program.
const STAMPED_CYCLES: u32 = 4;
const SKIPPED_CYCLES: u32 = 3;
const SHORT_CYCLES: u32 = 2;
/// The first look of a stamper that begins late comes so much later.
pub const LATE_CYCLES: u32 = 1;

/// The program that skips, as if at address 0; see [`moved`].
#[cold]
pub fn skipping() -> Program<{ pio::RP2040_MAX_PROGRAM_SIZE }> {
    pio::pio_asm!(
        ".origin 0",
        "    wait 1 gpio 27",
        "    jmp low",
        "    wait 1 gpio 27 [2]", // late
        ".wrap_target",
        "low:",
        "    jmp pin rise",
        "    jmp x-- low",
        "rise:",
        "    jmp !y stamp",
        "    jmp y-- high",
        "stamp:",
        "    in x, 32", // which pushes
        "    out y, 32",
        "high:",
        "    jmp x-- still",
        "still:",
        "    jmp pin high",
        ".wrap",
    )
    .program
}

/// The short program, as if at address 0. It is as early as the other.
#[cold]
pub fn short() -> Program<{ pio::RP2040_MAX_PROGRAM_SIZE }> {
    pio::pio_asm!(
        ".origin 0",
        "    wait 1 gpio 27 [1]",
        ".wrap_target",
        "low:",
        "    jmp pin rise",
        "    jmp x-- low",
        "rise:",
        "    in x, 32", // which pushes
        "high:",
        "    jmp x-- still",
        "still:",
        "    jmp pin high",
        ".wrap",
    )
    .program
}

/// The instruction for a program that begins at `origin`: a jump leads on by as much.
pub const fn moved(instruction: u16, origin: u8) -> u16 {
    const OPERATION: u16 = 0b111 << 13;
    if instruction & OPERATION == 0 { instruction + origin as u16 } else { instruction }
}

/// The cycle since the beginning at which a stamper of the program that skips saw the edge whose stamp, from 0, is
/// `index`. `x` is what it pushed, `skip` how many edges it skipped after the first.
pub fn seen_cycles(x: u32, index: u32, skip: u32) -> u32 {
    let skipped = if index == 0 { 0 } else { skip };
    counted_cycles(x) + STAMPED_CYCLES * index + SKIPPED_CYCLES * skipped
}

/// The same of the short program, at the edge `index`.
pub fn short_seen_cycles(x: u32, index: u32) -> u32 {
    counted_cycles(x) + SHORT_CYCLES * index
}

fn counted_cycles(x: u32) -> u32 {
    2 * !x
}

/// Instructions that are forced on a stamper before it begins.
pub mod forced {
    use super::*;

    /// Takes how many edges to skip from the TX FIFO.
    pub const PULL: u16 = InstructionOperands::PULL { if_empty: false, block: false }.encode();
    /// The first edge is stamped.
    pub const STAMP_FIRST: u16 =
        InstructionOperands::MOV { destination: MovDestination::Y, op: MovOperation::None, source: MovSource::NULL }
            .encode();
    /// The count begins with all ones.
    pub const BEGIN: u16 =
        InstructionOperands::MOV { destination: MovDestination::X, op: MovOperation::Invert, source: MovSource::NULL }
            .encode();

    pub const fn go_to(address: u8) -> u16 {
        InstructionOperands::JMP { condition: JmpCondition::Always, address }.encode()
    }
}
