//! The step program, its words, and their cost in cycles.
//!
//! # Design
//! One state machine makes the edges of one axis. It takes a word per step, sets DIR as the word says, waits as many
//! cycles as it says, and raises STEP. The instruction that raises STEP also counts the step in Y, so the count is
//! exact wherever the machine is stopped. Y counts down from -1 and wraps around. Three things can keep the machine
//! from the next edge:
//!
//! - **the start barrier**, before the first word: it is opened once for all axes, which therefore start on the same cycle;
//! - **the inhibit**, before every edge: it is set by whatever stops the machine; pulses keep their full length;
//! - **an empty FIFO**: the machine raises a flag and halts; it never stretches an interval. A run also ends like this.
//!   If the end was not announced, it is a fault, and the machine sets the inhibit itself: no other axis makes another
//!   step. Whether it was announced, the program asks as MOV's STATUS.
//!
//! DIR changes a fixed number of cycles after the fall of STEP ([`TURN_CYCLES`]), and the rest of the interval is its
//! set-up time. A rest leaves DIR unchanged.
//!
//! A pull from an empty FIFO yields the content of X (RP2040 datasheet, 3.4.7). It is all ones, which is the word to
//! halt on, so the check for an empty FIFO costs only the cycle that sets X. Emulators differ in what a loop leaves in
//! X, so the program sets it explicitly.
//!
//! Start barrier and inhibit are flags of the PIO block, which all its state machines see, and with [`steps_before`] those of another.
//!
//! Nothing here accesses the chip: the tests run this file's program and words on emulators.

use pio::{InstructionOperands, JmpCondition, MovDestination, MovOperation, MovSource, Program};

/// The most axes that one PIO block can drive: it has four state machines.
pub const AXES_MAX: usize = 4;

/// Flag of the start barrier. The flags below 4 belong to the state machines; each raises its own when it halts.
pub const BARRIER: u8 = 1 << 6;
pub const INHIBIT: u8 = 1 << 7;

/// Set in a word that only waits, clear in one that ends with a step.
const REST: u32 = 1 << 31;
/// The level of DIR, in the word of a step. In a rest this bit would mean a halt.
const DIR: u32 = 1 << 30;
/// The longest wait of a word, cycles. It is half the range of a wait, so that splitting off a rest always leaves a
/// valid wait.
pub const WAIT_MAX_CYCLES: u32 = 1 << 29;

/// The shortest pulse: its loop runs 0 times.
const PULSE_MIN_CYCLES: u32 = 4;
/// From one rise to the next when the loops of pulse and wait run 0 times.
const STEP_CYCLES: u32 = 11;
/// Duration of a rest whose loop runs 0 times.
const REST_CYCLES: u32 = 9;
/// From the fall of STEP to the change of DIR for the next step.
pub const TURN_CYCLES: u32 = 3;

/// The address at which a machine stays after it has found its FIFO empty before the end.
pub const STARVED_AT: u8 = 11;

/// True where STATUS says that the end was announced: STATUS_N is 1 as long as an empty FIFO is a fault, and 0 from the
/// announcement on. STATUS is all ones if the level of the RX FIFO, which is 0 during a run, is below STATUS_N.
pub const fn status_n(end_is_known: bool) -> u8 {
    if end_is_known { 0 } else { 1 }
}

/// The program: 26 of the block's 32 instructions, at address 0 so that labels are addresses.
pub fn steps() -> Program<{ pio::RP2040_MAX_PROGRAM_SIZE }> {
    let assembled = pio::pio_asm!(
        ".origin 0",
        ".side_set 1",
        "    mov x, !null        side 0",
        "    wait 0 irq 6        side 0", // the start barrier
        ".wrap_target",
        "fetch:",
        "    pull noblock        side 0", // X, all ones, if the FIFO is empty
        "    out x, 1            side 0",
        "    jmp !x step         side 0",
        "    out x, 1            side 0",
        "    jmp !x rest         side 0",
        "    mov x, status       side 0", // 0 if the end was announced
        "    jmp !x end          side 0",
        "    irq nowait 7        side 0", // the inhibit
        "    irq nowait 0 rel    side 0",
        "starved:",
        "    jmp starved         side 0",
        "end:",
        "    irq nowait 0 rel    side 0",
        "over:",
        "    jmp over            side 0",
        "rest:",
        "    out x, 30           side 0",
        "idle:",
        "    jmp x-- idle        side 0",
        "    mov x, !null        side 0",
        "    jmp fetch           side 0",
        "step:",
        "    out pins, 1         side 0", // DIR
        "    out x, 30           side 0",
        "dwell:",
        "    jmp x-- dwell       side 0",
        "    wait 0 irq 7        side 0", // the inhibit
        "    jmp y-- risen       side 1", // the edge, and its count
        "risen:",
        "    mov x, isr          side 1",
        "pulse:",
        "    jmp x-- pulse       side 1",
        "    mov x, !null        side 1",
        ".wrap",
    );
    assembled.program
}

/// The program for a block before the one of [`steps`], in the ring of blocks: start barrier and inhibit are the other's flags, which it
/// sees and sets on the same cycles as that block's own machines (RP2350 datasheet, 11.1.1 and 11.4.11.2).
#[allow(dead_code, reason = "only an image with five motors has it")]
pub fn steps_before() -> Program<{ pio::RP2040_MAX_PROGRAM_SIZE }> {
    let mut program = steps();
    program.code.iter_mut().for_each(|instruction| *instruction = with_flag_of_next(*instruction));
    program
}

/// An instruction that names a flag of the block names that of the next block instead. The others are as they were.
#[allow(dead_code, reason = "as `steps_before`")]
const fn with_flag_of_next(instruction: u16) -> u16 {
    const WAIT: u16 = 0b001;
    const IRQ: u16 = 0b110;
    /// What WAIT waits for, if it is a flag.
    const FOR_FLAG: u16 = 0b10;
    /// The bits that say whose the flag is. They are 0 if it is the block's own.
    const MODE: u16 = 0b11 << 3;

    let (operation, source) = (instruction >> 13, instruction >> 5 & 0b11);
    let names_flag = operation == IRQ || operation == WAIT && source == FOR_FLAG;
    if names_flag && instruction & MODE == 0 { instruction | MODE } else { instruction }
}

/// Instructions that are forced on a halted state machine. All of them keep STEP low.
pub mod forced {
    use super::*;

    pub const GO_TO_START: u16 = InstructionOperands::JMP { condition: JmpCondition::Always, address: 0 }.encode();
    pub const PULL: u16 = InstructionOperands::PULL { if_empty: false, block: false }.encode();
    pub const SET_PULSE: u16 = mov(MovDestination::ISR, MovSource::OSR);
    /// Sets the count to -1, from which it decreases.
    pub const CLEAR_COUNT: u16 = mov_inverted(MovDestination::Y, MovSource::NULL);
    /// Gets the number of steps counted down from there.
    pub const GET_COUNT: u16 = mov_inverted(MovDestination::ISR, MovSource::Y);
    pub const PUSH: u16 = InstructionOperands::PUSH { if_full: false, block: false }.encode();

    const fn mov(destination: MovDestination, source: MovSource) -> u16 {
        InstructionOperands::MOV { destination, op: MovOperation::None, source }.encode()
    }

    const fn mov_inverted(destination: MovDestination, source: MovSource) -> u16 {
        InstructionOperands::MOV { destination, op: MovOperation::Invert, source }.encode()
    }
}

/// Turns instants into words, for one pulse width.
#[derive(Clone, Copy)]
pub struct Words {
    pulse_loops: u32,
}

impl Words {
    /// Words for a pulse of at least `cycles`.
    pub fn with_pulse(cycles: u32) -> Self {
        Self { pulse_loops: cycles.saturating_sub(PULSE_MIN_CYCLES) }
    }

    pub fn pulse_cycles(self) -> u32 {
        self.pulse_loops + PULSE_MIN_CYCLES
    }

    /// The content of ISR.
    pub fn pulse_loops(self) -> u32 {
        self.pulse_loops
    }

    /// The value to add to the cycles between two steps to get the word of the second, whose DIR level is `high`.
    pub fn bias(self, high: bool) -> u32 {
        dir(high).wrapping_sub(STEP_CYCLES + self.pulse_loops)
    }

    /// The word of a step `cycles` after the previous one, with DIR `high` or low.
    pub fn step(self, cycles: u32, high: bool) -> u32 {
        cycles.wrapping_add(self.bias(high))
    }

    /// The word of the first step of a run. It comes `cycles` after the opening of the start barrier, plus a few cycles that are
    /// the same for every axis. DIR changes before those `cycles`, which are its set-up time.
    pub fn first_step(self, cycles: u32, high: bool) -> u32 {
        dir(high) | cycles
    }

    /// The word for a wait of `cycles` without a step.
    pub fn rest(self, cycles: u32) -> u32 {
        REST | (cycles - REST_CYCLES)
    }
}

fn dir(high: bool) -> u32 {
    if high { DIR } else { 0 }
}
