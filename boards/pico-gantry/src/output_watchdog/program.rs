//! The program of the output watchdog: one state machine that counts down, and when it has run out says so for ever.
//!
//! # Design
//! It counts X down, a round each cycle. To feed it is to force an instruction on it that fills X again from OSR, and
//! leaves it in its loop. When X has run out the machine leaves the loop, and from then on it puts the word in Y into
//! its RX FIFO whenever there is room.
//!
//! Nothing here accesses the chip: the tests run this file's program on emulators.

use pio::{InstructionOperands, JmpCondition, MovDestination, MovOperation, MovSource, Program};

/// The program's place: the last of the block's 32 instructions. Those of the guard are the first. A machine that counts
/// is at this address, and one that has run out at another.
pub const ORIGIN: u8 = pio::RP2040_MAX_PROGRAM_SIZE as u8 - 3;

/// The program, for the place [`ORIGIN`]. Its wrap counts from there.
pub fn count_down() -> Program<{ pio::RP2040_MAX_PROGRAM_SIZE }> {
    let mut program =
        pio::pio_asm!("count:", "    jmp x-- count", ".wrap_target", "    mov isr, y", "    push block", ".wrap",)
            .program;
    program.code[0] |= u16::from(ORIGIN);
    program
}

/// Instructions that are forced on the state machine.
pub mod forced {
    use super::*;

    pub const PULL: u16 = InstructionOperands::PULL { if_empty: false, block: false }.encode();
    /// Takes the word to say from OSR.
    pub const SET_WORD: u16 = from_osr(MovDestination::Y);
    /// Counts from OSR on. A machine that has run out stays so.
    pub const FEED: u16 = from_osr(MovDestination::X);
    /// Begins to count.
    pub const COUNT: u16 = InstructionOperands::JMP { condition: JmpCondition::Always, address: ORIGIN }.encode();

    const fn from_osr(destination: MovDestination) -> u16 {
        InstructionOperands::MOV { destination, op: MovOperation::None, source: MovSource::OSR }.encode()
    }
}
