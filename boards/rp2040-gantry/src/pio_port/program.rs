//! The step program, its words, and what they cost in cycles.
//!
//! # Design
//! One state machine makes the edges of one axis. It takes a word per step, sets DIR as the word says, waits as many cycles
//! as it says, and raises STEP; Y counts the step with the very instruction that raises it, so the count is exact wherever
//! the machine is stopped. It counts down, from -1, without an end. Three things may keep it from the next edge:
//!
//! - **the gate**, before the first word: opened once for all axes, which so start on the same cycle;
//! - **the brake**, before every edge: set by whoever stops the machine; pulses stay whole;
//! - **an empty FIFO**: the machine flags it and halts. It never stretches an interval. So a run ends, too: who has given it
//!   the last word knows which it is.
//!
//! DIR changes a fixed number of cycles after the fall of STEP ([`TURN_CYCLES`]), and the rest of the interval is its
//! set-up time. A rest leaves it as it is.
//!
//! An empty FIFO yields what X holds (RP2040 datasheet, 3.4.7), all ones: the word to halt on, for which no cycle is spent
//! but the one that makes X so. Emulators differ in what a loop leaves in X, so it is not left to the loop.
//!
//! Gate and brake are flags of the PIO block, which every state machine of it sees.
//!
//! Nothing here touches the chip: the tests run this very file's program and words on emulators.

use pio::{InstructionOperands, JmpCondition, MovDestination, MovOperation, MovSource, Program};

/// How many axes a PIO block can step: it has four state machines.
pub const AXES_MAX: usize = 4;

/// Flag of the gate. The flags below 4 are the state machines' own, raised by one that has halted.
pub const GATE: u8 = 1 << 6;
pub const BRAKE: u8 = 1 << 7;

/// Set in a word that only waits; clear in one that ends in a step.
const REST: u32 = 1 << 31;
/// The level of DIR, in the word of a step. In a rest it would be a halt.
const DIR: u32 = 1 << 30;
/// The longest that a word waits, cycles: half the range, so that a rest leaves a whole wait behind it.
pub const WAIT_MAX_CYCLES: u32 = 1 << 29;

/// A pulse of 0 loops.
const PULSE_MIN_CYCLES: u32 = 4;
/// From one rise to the next when pulse and wait are of 0 loops.
const STEP_CYCLES: u32 = 11;
/// What a rest takes when it waits for 0 loops.
const REST_CYCLES: u32 = 9;
/// From the fall of STEP to the change of DIR that the next step asks for.
pub const TURN_CYCLES: u32 = 3;

/// Twenty of the block's 32 instructions; at address 0, so that labels are addresses.
pub fn steps() -> Program<{ pio::RP2040_MAX_PROGRAM_SIZE }> {
    let assembled = pio::pio_asm!(
        ".origin 0",
        ".side_set 1",
        "    mov x, !null        side 0",
        "    wait 0 irq 6        side 0", // the gate
        ".wrap_target",
        "fetch:",
        "    pull noblock        side 0", // X, all ones, when the FIFO is empty
        "    out x, 1            side 0",
        "    jmp !x step         side 0",
        "    out x, 1            side 0",
        "    jmp !x rest         side 0",
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
        "    wait 0 irq 7        side 0", // the brake
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

/// Instructions forced upon a halted state machine. All of them hold STEP low.
pub mod forced {
    use super::*;

    pub const GO_TO_START: u16 = InstructionOperands::JMP { condition: JmpCondition::Always, address: 0 }.encode();
    pub const PULL: u16 = InstructionOperands::PULL { if_empty: false, block: false }.encode();
    pub const SET_PULSE: u16 = mov(MovDestination::ISR, MovSource::OSR);
    /// From -1 down.
    pub const CLEAR_COUNT: u16 = mov_inverted(MovDestination::Y, MovSource::NULL);
    /// So many are gone from there.
    pub const GET_COUNT: u16 = mov_inverted(MovDestination::ISR, MovSource::Y);
    pub const PUSH: u16 = InstructionOperands::PUSH { if_full: false, block: false }.encode();

    const fn mov(destination: MovDestination, source: MovSource) -> u16 {
        InstructionOperands::MOV { destination, op: MovOperation::None, source }.encode()
    }

    const fn mov_inverted(destination: MovDestination, source: MovSource) -> u16 {
        InstructionOperands::MOV { destination, op: MovOperation::Invert, source }.encode()
    }
}

/// What turns instants into words, for one pulse width.
#[derive(Clone, Copy)]
pub struct Words {
    pulse_loops: u32,
}

impl Words {
    /// For a pulse of at least `cycles`.
    pub fn with_pulse(cycles: u32) -> Self {
        Self { pulse_loops: cycles.saturating_sub(PULSE_MIN_CYCLES) }
    }

    pub fn pulse_cycles(self) -> u32 {
        self.pulse_loops + PULSE_MIN_CYCLES
    }

    /// What ISR holds.
    pub fn pulse_loops(self) -> u32 {
        self.pulse_loops
    }

    /// What to add to the cycles from one step to the next, which DIR is `high` for.
    pub fn bias(self, high: bool) -> u32 {
        dir(high).wrapping_sub(STEP_CYCLES + self.pulse_loops)
    }

    /// The word of a step `cycles` after the one before, with DIR `high` or low.
    pub fn step(self, cycles: u32, high: bool) -> u32 {
        cycles.wrapping_add(self.bias(high))
    }

    /// The word of the first step of a run, `cycles` after the gate has opened, and some more that are the same for every
    /// axis. DIR changes before those `cycles`, which are its set-up time.
    pub fn first_step(self, cycles: u32, high: bool) -> u32 {
        dir(high) | cycles
    }

    /// A wait of `cycles` without a step.
    pub fn rest(self, cycles: u32) -> u32 {
        REST | (cycles - REST_CYCLES)
    }
}

fn dir(high: bool) -> u32 {
    if high { DIR } else { 0 }
}
