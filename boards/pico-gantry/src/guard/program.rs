//! The guard's program: one state machine that watches any number of pins next to each other.
//!
//! # Design
//! It reads all pins at once and compares their levels with those that it read last, in X. When they differ it puts the
//! new levels into its RX FIFO, and the FIFO requests the interrupt for as long as it is not empty. So no change is
//! lost between the machine and the handler, and each is reported with the levels that came with it. If the FIFO is full the
//! machine waits; when there is room it goes on from the levels that it has reported last.
//!
//! It reads the pins every 4 cycles, and 5 after a change. So it may miss a pulse shorter than that: 40 ns.
//!
//! Nothing here accesses the chip: the tests run this file's program on emulators.

use pio::{InstructionOperands, MovDestination, MovOperation, MovSource, Program};

/// The program. It watches `inputs` pins from the base of the IN pins on. Its labels are addresses if it is at address 0;
/// elsewhere it is [`moved`].
pub fn watch(inputs: u8) -> Program<{ pio::RP2040_MAX_PROGRAM_SIZE }> {
    let mut program = pio::pio_asm!(
        ".origin 0",
        "changed:",
        "    push block",
        "    mov x, y",
        ".wrap_target",
        "    in pins, 32", // as many as are watched
        "    mov y, isr",
        "    jmp x!=y changed",
        "    mov isr, null",
        ".wrap",
    )
    .program;
    let look = &mut program.code[usize::from(program.wrap.target)];
    *look |= u16::from(inputs);
    program
}

/// The instruction for a program that begins at `origin`: a jump leads on by as much. The others name no address.
pub const fn moved(instruction: u16, origin: u8) -> u16 {
    const OPERATION: u16 = 0b111 << 13;
    if instruction & OPERATION == 0 { instruction + origin as u16 } else { instruction }
}

/// Forced before the start: no levels are like these, so the machine tells the levels that it sees first.
pub const KNOW_NOTHING: u16 =
    InstructionOperands::MOV { destination: MovDestination::X, op: MovOperation::Invert, source: MovSource::NULL }
        .encode();
/// Forced before the start.
pub const fn go_to(address: u8) -> u16 {
    InstructionOperands::JMP { condition: pio::JmpCondition::Always, address }.encode()
}
