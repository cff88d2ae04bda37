//! An experiment with a PIO block, independent of the emulator, and its results.

use std::ops::Range;

use pio::{InstructionOperands, SetDestination};
use serde::{Deserialize, Serialize};

use crate::program::{self, Words, forced};

const PIO0: u32 = 0x5020_0000;
pub const CTRL: u32 = PIO0;
pub const FLEVEL: u32 = PIO0 + 0x0C;
const TXF: u32 = PIO0 + 0x10;
const RXF: u32 = PIO0 + 0x20;
pub const IRQ: u32 = PIO0 + 0x30;
const IRQ_FORCE: u32 = PIO0 + 0x34;
const INSTR_MEM: u32 = PIO0 + 0x48;
/// The registers of the first state machine, and the distance to those of the next one.
pub const CLKDIV: u32 = PIO0 + 0xC8;
pub const EXECCTRL: u32 = PIO0 + 0xCC;
pub const SHIFTCTRL: u32 = PIO0 + 0xD0;
pub const INSTR: u32 = PIO0 + 0xD8;
pub const PINCTRL: u32 = PIO0 + 0xDC;
pub const MACHINE_BYTES: u32 = 0x18;
const GPIO_CTRL: u32 = 0x4001_4004;
const FUNCSEL_PIO0: u32 = 6;
const FUNCSEL_SIO: u32 = 5;
/// The level at the pad is seen.
const PAD: u32 = 0x4001_C004;
const PAD_INPUT_ENABLE: u32 = 1 << 6;
pub const SIO_OUT: u32 = 0xD000_0010;
pub const SIO_OE: u32 = 0xD000_0020;

/// Bit 19 is clear, so OUT shifts left. IN shifts right, as after a reset.
const OUT_SHIFTS_LEFT: u32 = 1 << 18;
pub const STATUS_OF_RX: u32 = 1 << 4;
const FIFO_IS_ALL_TX: u32 = 1 << 30;

/// By this cycle every machine waits at the start barrier and its FIFO is full.
pub const OPENS_AT: u64 = 100;
/// The time that the experiment goes on after the last halt, so that surplus edges are seen.
const AFTER_CYCLES: u64 = 4_000;

/// The input of one state machine.
#[derive(Clone)]
pub struct Axis {
    pub words: Words,
    pub waits: Vec<Wait>,
    /// The cycle of the write that announces the end. Without it an empty FIFO is a fault.
    pub end_known_at: Option<u64>,
}

/// Cycles up to a step, with DIR low or high, or to the end of a rest.
#[derive(Clone, Copy, Debug)]
pub enum Wait {
    Low(u32),
    High(u32),
    Rest(u32),
}

impl Wait {
    pub fn cycles(self) -> u32 {
        let (Self::Low(cycles) | Self::High(cycles) | Self::Rest(cycles)) = self;
        cycles
    }

    /// The level of DIR at its step; `None` for a rest.
    pub fn dir(self) -> Option<bool> {
        match self {
            Self::Low(_) => Some(false),
            Self::High(_) => Some(true),
            Self::Rest(_) => None,
        }
    }
}

impl Axis {
    /// An axis whose end is announced before it starts.
    pub fn new(words: Words, waits: Vec<Wait>) -> Self {
        Self { words, waits, end_known_at: Some(0) }
    }

    /// The words as `PioPort` writes them.
    pub fn encoded(&self) -> Vec<u32> {
        let mut has_stepped = false;
        let mut encode = |wait: &Wait| match wait.dir() {
            None => self.words.rest(wait.cycles()),
            Some(high) if has_stepped => self.words.step(wait.cycles(), high),
            Some(high) => {
                has_stepped = true;
                self.words.first_step(wait.cycles(), high)
            }
        };
        self.waits.iter().map(&mut encode).collect()
    }
}

/// Register writes and words for the FIFOs, by cycle. A write on cycle N takes effect on N + 1.
#[derive(Serialize)]
pub struct Experiment {
    /// Writes before cycle 0: address and value.
    pub setup: Vec<(u32, u32)>,
    /// The GPIO of each state machine's STEP. DIR is on the next GPIO.
    pub pins: Vec<u8>,
    /// The words for each state machine. One word is written per cycle while its FIFO has room, as by DMA.
    pub words: Vec<Vec<u32>>,
    /// Writes as cycle, address and value, in order of cycle.
    pub writes: Vec<(u64, u32, u32)>,
    pub cycles: u64,
    /// From this cycle on, what the state machines put into their RX FIFOs is taken, a word per cycle.
    pub takes_from: u64,
    /// Writes after the last cycle. Afterwards the RX FIFOs are read.
    pub finish: Vec<(u32, u32)>,
}

/// The edges of one state machine, in cycles.
#[derive(Debug, Default, PartialEq, Deserialize)]
pub struct Seen {
    pub rises: Vec<u64>,
    pub falls: Vec<u64>,
    /// When DIR changed, and whether it is high then.
    pub turns: Vec<(u64, bool)>,
    /// When the machine raised its own flag, at the end or because it starved.
    pub halt: Option<u64>,
    /// The words that it has put into its RX FIFO, with the cycle after which each was there to be taken.
    pub taken: Vec<(u64, u32)>,
    /// The number of edges that it has counted.
    pub count: u32,
}

impl Experiment {
    /// One run of these axes. It is observed until `until` and some time beyond.
    pub fn new(axes: &[Axis], until: u64) -> Self {
        let mut setup: Vec<_> = at_origin(0, program::steps().code.iter().copied()).collect();
        setup.push((IRQ_FORCE, program::BARRIER.into()));
        let pins: Vec<_> = (0..axes.len() as u8).map(|machine| 2 + 2 * machine).collect();
        for (machine, (axis, &pin)) in (0..).zip(axes.iter().zip(&pins)) {
            setup.extend(configured(machine, pin));
            setup.extend(loaded(machine, axis));
        }
        let all = (1 << axes.len()) - 1;
        setup.extend([(IRQ, all), (CTRL, all)]);
        let announced = (0..).zip(axes).filter_map(|(machine, axis)| {
            Some((axis.end_known_at?, of(machine, EXECCTRL), exec_ctrl(program::status_n(true))))
        });
        let mut writes: Vec<_> = announced.chain([(OPENS_AT, IRQ, program::BARRIER.into())]).collect();
        writes.sort_unstable();
        let finish = (0..axes.len() as u32).flat_map(counted);
        Self {
            setup,
            pins,
            words: axes.iter().map(Axis::encoded).collect(),
            writes,
            cycles: until + AFTER_CYCLES,
            takes_from: 0,
            finish: [(CTRL, 0)].into_iter().chain(finish).collect(),
        }
    }

    /// One state machine, which has nothing to do with steps.
    pub fn alone(setup: Vec<(u32, u32)>, writes: Vec<(u64, u32, u32)>, cycles: u64) -> Self {
        Self { setup, pins: vec![2], words: vec![vec![]], writes, cycles, takes_from: 0, finish: vec![] }
    }

    /// Engages the inhibit on the first of these cycles, and releases it at their end.
    pub fn inhibit(&mut self, cycles: &Range<u64>) {
        self.writes.push((cycles.start, IRQ_FORCE, program::INHIBIT.into()));
        self.writes.push((cycles.end, IRQ, program::INHIBIT.into()));
    }

    /// Writes one more word, which may be late.
    pub fn send(&mut self, cycle: u64, machine: u32, word: u32) {
        self.writes.push((cycle, TXF + 4 * machine, word));
    }
}

pub const fn dir_pin(step_pin: u8) -> u8 {
    step_pin + 1
}

pub const fn txf(machine: u32) -> u32 {
    TXF + 4 * machine
}

pub const fn rxf(machine: u32) -> u32 {
    RXF + 4 * machine
}

/// Loads a program from this address of the memory on.
pub fn at_origin(origin: u8, code: impl IntoIterator<Item = u16>) -> impl Iterator<Item = (u32, u32)> {
    let first = INSTR_MEM + 4 * u32::from(origin);
    (first..).step_by(4).zip(code).map(|(address, instruction)| (address, instruction.into()))
}

/// Runs the first state machine on every cycle, with the wrap of a program at this address, and its JMP pin.
pub fn clocked(origin: u8, wrap: pio::Wrap, jmp_pin: u8) -> [(u32, u32); 2] {
    let [source, target] = [wrap.source, wrap.target].map(|address| u32::from(origin + address));
    [(CLKDIV, 1 << 16), (EXECCTRL, u32::from(jmp_pin) << 24 | source << 12 | target << 7)]
}

/// Makes these pads outputs that are set by SIO and seen by PIO.
pub fn by_hand(pins: impl IntoIterator<Item = u8>) -> Vec<(u32, u32)> {
    let (mut all, mut writes) = (0, Vec::new());
    for pin in pins.into_iter().map(u32::from) {
        all |= 1 << pin;
        writes.extend([(GPIO_CTRL + 8 * pin, FUNCSEL_SIO), (PAD + 4 * pin, PAD_INPUT_ENABLE)]);
    }
    writes.push((SIO_OE, all));
    writes
}

const fn of(machine: u32, register: u32) -> u32 {
    register + MACHINE_BYTES * machine
}

fn shift_ctrl(fifo_is_all_tx: bool) -> u32 {
    OUT_SHIFTS_LEFT | if fifo_is_all_tx { FIFO_IS_ALL_TX } else { 0 }
}

fn exec_ctrl(status_n: u8) -> u32 {
    let wrap = program::steps().wrap;
    u32::from(wrap.source) << 12 | u32::from(wrap.target) << 7 | STATUS_OF_RX | u32::from(status_n)
}

/// The registers as embassy-rp sets them for `pio_port`.
fn configured(machine: u32, pin: u8) -> Vec<(u32, u32)> {
    let program = program::steps();
    let dir = dir_pin(pin);
    // STEP is the side-set pin, DIR the pin of OUT. SET has both, to set their direction.
    let pin_ctrl = u32::from(program.side_set.bits()) << 29 | 2 << 26 | 1 << 20;
    let pin_ctrl = pin_ctrl | u32::from(pin) << 10 | u32::from(pin) << 5 | u32::from(dir);
    let low = InstructionOperands::SET { destination: SetDestination::PINS, data: 0 }.encode();
    let outputs = InstructionOperands::SET { destination: SetDestination::PINDIRS, data: 3 }.encode();
    vec![
        (GPIO_CTRL + 8 * u32::from(pin), FUNCSEL_PIO0),
        (GPIO_CTRL + 8 * u32::from(dir), FUNCSEL_PIO0),
        (of(machine, CLKDIV), 1 << 16),
        (of(machine, EXECCTRL), exec_ctrl(program::status_n(false))),
        (of(machine, SHIFTCTRL), shift_ctrl(true)),
        (of(machine, PINCTRL), pin_ctrl),
        (of(machine, INSTR), low.into()),
        (of(machine, INSTR), outputs.into()),
    ]
}

/// Loads the registers as the firmware's `StateMachine` does.
fn loaded(machine: u32, axis: &Axis) -> [(u32, u32); 5] {
    let force = |instruction: u16| (of(machine, INSTR), instruction.into());
    [
        (txf(machine), axis.words.pulse_loops()),
        force(forced::PULL),
        force(forced::SET_PULSE),
        force(forced::CLEAR_COUNT),
        force(forced::GO_TO_START),
    ]
}

/// Moves the count into the RX FIFO.
fn counted(machine: u32) -> [(u32, u32); 3] {
    let force = |instruction: u16| (of(machine, INSTR), instruction.into());
    [(of(machine, SHIFTCTRL), shift_ctrl(false)), force(forced::GET_COUNT), force(forced::PUSH)]
}
