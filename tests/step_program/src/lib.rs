//! The firmware's programs for PIO are tested on two independent emulators: those of PIO1 in `guard` and `output_watchdog`, and
//! the step program here, word by word. Every edge of STEP and DIR, in both directions, every halt and every count must
//! be where the firmware's own arithmetic says, to the cycle. Both emulators count from the write that opens the start barrier,
//! and agree on every cycle without an offset.
//!
//! `cargo test -p isostep-step-program` uses the published emulator. The project's own needs Node's packages, so
//! `cargo xtask test` runs its tests. Every run is the same; a failure names its seed.
//!
//! The package is none that a plain `cargo test` builds: an assembler and an emulator are much to compile.

#![cfg(test)]

mod emulator;
mod experiment;
mod guard;
mod output_watchdog;
#[path = "../../../boards/pico-gantry/src/pio_port/program.rs"]
mod program;
mod stampers;

use std::env;
use std::ops::Range;

use isostep_motion::{Capabilities, DriverTiming, Wiring, ticks_covering};
use oorandom::Rand32;
use pio::{InstructionOperands, IrqIndexMode, JmpCondition, WaitSource};

use self::emulator::{Emulator, on_each};
use self::experiment::{Axis, Experiment, OPENS_AT, Seen, Wait};
use self::program::{AXES_MAX, STARVED_AT, TURN_CYCLES, WAIT_MAX_CYCLES, Words};

/// Cycles from the write that opens the start barrier to time zero of a run, at which a first step of 0 cycles would rise.
const ZERO_AFTER_BARRIER_CYCLES: u64 = 9;
/// The number of cycles before time zero at which the first word is fetched.
const FETCH_BEFORE_ZERO_CYCLES: u64 = 7;
/// The shortest time for which STEP is low.
const LOW_MIN_CYCLES: u32 = 7;
const REST_MIN_CYCLES: u32 = 9;
const WAITS_UP_TO_CYCLES: u32 = 3_000;
const WAITS: u32 = 1_000;
/// Each seed makes three machines, which is enough for every pulse.
const SEEDS: Range<u64> = 0..3;
/// Pulse widths: none, the shortest, a TMC2209's, a DRV8825's, and longer ones.
const PULSES: [u32; 7] = [0, 4, 5, 13, 238, 250, 1_000];
/// An instruction that waits for a flag continues one cycle after the flag was cleared; the edge comes one cycle later.
const EDGE_AFTER_RELEASE_CYCLES: u64 = 2;
/// Cycles from the fetch of a word to the flag of a machine that finds none, at the end and otherwise.
const END_AFTER_FETCH_CYCLES: u64 = 7;
const STARVED_AFTER_FETCH_CYCLES: u64 = 8;
/// Cycles from that fetch to the look at STATUS, which must have been written before, and to the flag of the inhibit.
const STATUS_AFTER_FETCH_CYCLES: u64 = 5;
const INHIBIT_AFTER_FETCH_CYCLES: u64 = 7;
/// The inhibit is not released.
const FOR_EVER: u64 = u64::MAX;
/// Clock of the chip.
const TICK_HZ: u32 = 125_000_000;

/// The edges, halt and count that follow from the words of an axis.
fn predicted(axis: &Axis, inhibit: &Range<u64>) -> Seen {
    let pulse = u64::from(axis.words.pulse_cycles());
    let mut at = OPENS_AT + ZERO_AFTER_BARRIER_CYCLES;
    let mut fetch = at - FETCH_BEFORE_ZERO_CYCLES;
    let mut seen = Seen::default();
    for wait in &axis.waits {
        at += u64::from(wait.cycles());
        let Some(high) = wait.dir() else {
            fetch += u64::from(wait.cycles());
            continue;
        };
        if high != seen.turns.last().is_some_and(|turn| turn.1) {
            seen.turns.push((fetch + u64::from(TURN_CYCLES), high));
        }
        // The program tests the inhibit one cycle before the edge. The inhibit takes effect one cycle after it was set.
        if inhibit.start < at - 1 && at - 1 <= inhibit.end {
            if inhibit.end == FOR_EVER {
                return Seen { count: seen.rises.len() as u32, ..seen };
            }
            at = inhibit.end + EDGE_AFTER_RELEASE_CYCLES;
        }
        fetch = at + pulse;
        seen.rises.push(at);
        seen.falls.push(fetch);
    }
    let is_end = axis.end_known_at.is_some_and(|known| known < fetch + STATUS_AFTER_FETCH_CYCLES);
    let flag_cycles = if is_end { END_AFTER_FETCH_CYCLES } else { STARVED_AFTER_FETCH_CYCLES };
    let (halt, count) = (Some(fetch + flag_cycles), seen.rises.len() as u32);
    Seen { halt, count, ..seen }
}

/// Axes that run at once, the actions on them, and the expected results.
struct Case {
    name: String,
    experiment: Experiment,
    wanted: Vec<Seen>,
}

impl Case {
    fn new(name: String, axes: &[Axis]) -> Self {
        Self::of(name, axes, &(0..0))
    }

    /// The inhibit is set by hand, and released.
    fn inhibited(name: String, axes: &[Axis], inhibit: &Range<u64>) -> Self {
        let mut case = Self::of(name, axes, inhibit);
        case.experiment.inhibit(inhibit);
        case
    }

    /// The inhibit is on during these cycles, whatever sets it.
    fn of(name: String, axes: &[Axis], inhibit: &Range<u64>) -> Self {
        let wanted: Vec<_> = axes.iter().map(|axis| predicted(axis, inhibit)).collect();
        let until = wanted.iter().filter_map(|seen| seen.halt).max().unwrap();
        Self { name, experiment: Experiment::new(axes, until), wanted }
    }

    fn check(&self, emulator: Emulator, seen: &[Seen]) {
        assert_eq!(seen.len(), self.wanted.len());
        for (machine, (seen, wanted)) in seen.iter().zip(&self.wanted).enumerate() {
            let what = format!("{}, state machine {machine}, emulator: {emulator:?}", self.name);
            same("rise", &seen.rises, &wanted.rises, &what);
            same("fall", &seen.falls, &wanted.falls, &what);
            let turn = |turns: &[(u64, bool)]| turns.iter().map(|turn| turn.0).collect::<Vec<_>>();
            same("change of DIR", &turn(&seen.turns), &turn(&wanted.turns), &what);
            assert!(seen.turns == wanted.turns, "levels of DIR; {what}");
            assert_eq!(seen.halt, wanted.halt, "halt; {what}");
            assert_eq!(seen.count, wanted.count, "count; {what}");
        }
    }
}

fn check(emulator: Emulator, cases: impl IntoIterator<Item = Case>) {
    let cases: Vec<_> = cases.into_iter().collect();
    let experiments: Vec<_> = cases.iter().map(|case| &case.experiment).collect();
    for (case, seen) in cases.iter().zip(emulator.run(&experiments)) {
        case.check(emulator, &seen);
    }
}

/// Panics with the first edge that is on the wrong cycle.
fn same(edge: &str, seen: &[u64], wanted: &[u64], what: &str) {
    let differs = seen.iter().zip(wanted).position(|(seen, wanted)| seen != wanted);
    if let Some(i) = differs {
        panic!("{edge} {i} is on cycle {}, not {}; {what}", seen[i], wanted[i]);
    }
    assert_eq!(seen.len(), wanted.len(), "{edge}s; {what}");
}

/// Random waits. One in eight is the shortest, half of them are short, one in sixteen is a rest. One step in four
/// reverses the direction.
fn random_waits(random: &mut Rand32, words: Words) -> Vec<Wait> {
    let shortest = words.pulse_cycles() + LOW_MIN_CYCLES;
    let mut high = false;
    let mut wait = |_| {
        high ^= random.rand_range(0..4) == 0;
        match random.rand_range(0..16) {
            0 => Wait::Rest(random.rand_range(REST_MIN_CYCLES..WAITS_UP_TO_CYCLES)),
            1 | 2 => step(high, shortest),
            3..11 => step(high, shortest + random.rand_range(1..100)),
            _ => step(high, random.rand_range(shortest..WAITS_UP_TO_CYCLES + 1)),
        }
    };
    (0..WAITS).map(&mut wait).collect()
}

fn random_axes(seed: u64) -> Vec<Axis> {
    let mut random = Rand32::new(seed);
    let pulse = |machine| PULSES[(seed as usize * 3 + machine) % PULSES.len()];
    (0..3)
        .map(|machine| {
            let words = Words::with_pulse(pulse(machine));
            Axis::new(words, random_waits(&mut random, words))
        })
        .collect()
}

/// The seed that `ISOSTEP_SEED` names, or all.
fn seeds() -> Range<u64> {
    let one = env::var("ISOSTEP_SEED").ok().map(|seed| seed.parse().expect("a number"));
    one.map_or(SEEDS, |seed| seed..seed + 1)
}

fn step(high: bool, cycles: u32) -> Wait {
    if high { Wait::High(cycles) } else { Wait::Low(cycles) }
}

/// Steps that all have the same direction.
fn steps(cycles: &[u32]) -> Vec<Wait> {
    cycles.iter().copied().map(Wait::High).collect()
}

fn random_words(emulator: Emulator) {
    let replay = "cargo test --package isostep-step-program -- --include-ignored random_words";
    let case = |seed| Case::new(format!("replay: ISOSTEP_SEED={seed} {replay}"), &random_axes(seed));
    check(emulator, seeds().map(case));
}

/// All axes start together, however full their FIFOs are and whatever follows.
fn one_barrier(emulator: Emulator) {
    let words = Words::with_pulse(250);
    let axes = [(20, 300), (0, 300), (3, 700), (20, 300)]
        .map(|(more, cycles)| Axis::new(words, steps(&[&[40], &vec![cycles; more][..]].concat())));
    assert_eq!(axes.len(), AXES_MAX);
    let case = Case::new("the start barrier".to_owned(), &axes);
    assert!(case.wanted.iter().all(|seen| seen.rises[0] == case.wanted[0].rises[0]));
    check(emulator, [case]);
}

/// The inhibit is set on every cycle around a step, and released. Pulses must stay whole, and no edge may rise while the
/// inhibit is on. DIR may already have changed for a step that does not rise.
fn inhibits(emulator: Emulator) {
    let axes = [4, 30].map(|pulse| {
        let waits = [true, false, false, true, false, true].map(|high| step(high, 60)).to_vec();
        Axis::new(Words::with_pulse(pulse), waits)
    });
    let second = predicted(&axes[0], &(0..0)).rises[1];
    let inhibits = (second - 3..second + 35).flat_map(|from| [1, 2, 500].map(|cycles| from..from + cycles));
    let case = |inhibit| Case::inhibited(format!("inhibit on cycles {inhibit:?}"), &axes, &inhibit);
    check(emulator, inhibits.map(case));
}

/// The FIFO is empty before the first step, after a step, and after a rest. The state machine must halt and leave DIR
/// unchanged, and a word that comes too late must not make a step.
fn empty_fifos(emulator: Emulator) {
    let words = Words::with_pulse(13);
    let late = vec![Wait::Low(20), Wait::Rest(500)];
    let axes = [vec![], steps(&[50, 60, 70]), vec![Wait::Rest(90)], late].map(|waits| Axis::new(words, waits));
    let mut case = Case::new("an empty FIFO".to_owned(), &axes);
    for machine in 0..axes.len() as u32 {
        case.experiment.send(OPENS_AT + 2_000, machine, words.step(60, true));
    }
    check(emulator, [case]);
}

/// An axis starves: its FIFO is empty and its end was not announced, or one cycle too late. No other axis makes another
/// step, whatever it is about to do, and none is inhibited by an end that was announced in time.
fn starved(emulator: Emulator) {
    let words = Words::with_pulse(13);
    let fetch = predicted(&Axis::new(words, steps(&[50, 60, 70])), &(0..0)).falls[2];
    let status = fetch + STATUS_AFTER_FETCH_CYCLES;
    let case = |end_known_at: Option<u64>, others: u32| {
        let short = Axis { end_known_at, ..Axis::new(words, steps(&[50, 60, 70])) };
        let long = Axis::new(words, [vec![Wait::High(40)], vec![step(false, others); 200]].concat());
        let is_end = end_known_at.is_some_and(|known| known < status);
        let inhibit = if is_end { 0..0 } else { fetch + INHIBIT_AFTER_FETCH_CYCLES..FOR_EVER };
        let name =
            format!("the end is announced on cycle {end_known_at:?} of {status}, the others step every {others}");
        Case::of(name, &[short, long.clone(), long], &inhibit)
    };
    let known = (status - 3..status + 3).map(|known| case(Some(known), 31));
    check(emulator, known.chain((30..70).map(|others| case(None, others))));
}

/// Every step reverses the direction, as soon after the previous step as `PioPort` allows, and the first step comes as
/// soon as DIR is set up. The drivers' hold and set-up times must be kept.
fn reversals(emulator: Emulator) {
    let drivers = [(DriverTiming::DRV8825, 0), (DriverTiming::TMC2209, 0), (DriverTiming::TMC2209, 5_000)];
    let axis = |(timing, pulse_ns): (DriverTiming, u32)| {
        let wiring = Wiring { pulse_ns, ..Wiring::default() };
        let mut capabilities = Capabilities::new(TICK_HZ, timing);
        capabilities.turn_ticks = TURN_CYCLES + 1;
        let words = Words::with_pulse(ticks_covering(capabilities.pulse_ns(wiring), TICK_HZ));
        let period = capabilities.period_min_ticks(wiring);
        let first = Wait::High(ticks_covering(timing.setup_ns, TICK_HZ));
        let others = (0..60).map(|k| step(k % 2 == 1, period));
        Axis::new(words, [first].into_iter().chain(others).collect())
    };
    let axes = drivers.map(axis);
    let case = Case::new("reversals".to_owned(), &axes);
    for ((timing, _), seen) in drivers.iter().zip(&case.wanted) {
        let needs = u64::from(ticks_covering(timing.setup_ns, TICK_HZ));
        assert_eq!(seen.turns.len(), seen.rises.len());
        for ((turn, _), rise) in seen.turns.iter().zip(&seen.rises) {
            assert!(rise - turn >= needs, "set-up before cycle {rise}");
        }
        for (rise, (turn, _)) in seen.rises.iter().zip(&seen.turns[1..]) {
            assert!(turn - rise >= needs, "hold from cycle {rise}");
        }
    }
    check(emulator, [case]);
}

on_each! {
    random_words_are_exact: random_words;
    the_barrier_opens_all_machines_on_one_cycle: one_barrier;
    the_inhibit_keeps_edges_from_rising: inhibits;
    an_empty_fifo_halts_the_machine: empty_fifos;
    a_machine_that_starves_inhibits_the_others: starved;
    reversals_keep_the_drivers_times: reversals;
}

/// The firmware tells a fault from an end by the place at which the machine stays.
#[test]
fn a_machine_that_starves_stays_where_the_firmware_looks() {
    let raise = |index, index_mode| InstructionOperands::IRQ { clear: false, wait: false, index, index_mode }.encode();
    let (inhibit, own) = (raise(7, IrqIndexMode::DIRECT), raise(0, IrqIndexMode::REL));
    let stay = InstructionOperands::JMP { condition: JmpCondition::Always, address: STARVED_AT }.encode();
    let address = usize::from(STARVED_AT);
    assert_eq!(program::steps().code[address - 2..=address], [inhibit, own, stay]);
}

/// The program of a fifth motor is that of the others, but for whose flags start barrier and inhibit are: those of the next block. The
/// machine's own flag, which tells that it has halted, stays its own. No published emulator has flags of another block: the project's
/// has (`tests/emulator/test/rp2350.test.mjs`).
#[test]
fn a_fifth_motor_waits_for_the_flags_of_the_next_block() {
    const OWN_TO_NEXT: u16 = 0b11 << 3;
    let (steps, before) = (program::steps(), program::steps_before());
    let differ: Vec<_> = (0..steps.code.len()).filter(|&at| steps.code[at] != before.code[at]).collect();
    let wait =
        |index: u8| InstructionOperands::WAIT { polarity: 0, source: WaitSource::IRQ, index, relative: false }.encode();
    let raise =
        InstructionOperands::IRQ { clear: false, wait: false, index: 7, index_mode: IrqIndexMode::DIRECT }.encode();
    assert_eq!(differ.iter().map(|&at| steps.code[at]).collect::<Vec<_>>(), [wait(6), raise, wait(7)]);
    assert!(differ.iter().all(|&at| before.code[at] ^ steps.code[at] == OWN_TO_NEXT));
}

/// These waits are too long to be emulated. Their words must still encode whether it is a step or a rest, and DIR.
#[test]
fn the_longest_waits_fit_into_a_word() {
    const REST: u32 = 1 << 31;
    for (words, high) in PULSES.map(Words::with_pulse).into_iter().flat_map(|words| [(words, false), (words, true)]) {
        let step = u32::from(high) << 30;
        // The wait before the first step of a run is longer by the lead.
        assert_eq!(words.first_step(WAIT_MAX_CYCLES + TICK_HZ, high), step + WAIT_MAX_CYCLES + TICK_HZ);
        let loops = |cycles| cycles - words.pulse_cycles() - LOW_MIN_CYCLES;
        // An interval within a segment may be twice as long as the limit for a wait.
        let longest = 2 * WAIT_MAX_CYCLES - 64;
        assert_eq!(words.step(longest, high), step + loops(longest));
        assert_eq!(words.rest(WAIT_MAX_CYCLES), REST + WAIT_MAX_CYCLES - REST_MIN_CYCLES);
    }
}

/// A pulse is never shorter than requested.
#[test]
fn pulses_are_long_enough() {
    for cycles in PULSES {
        assert_eq!(Words::with_pulse(cycles).pulse_cycles(), cycles.max(4));
    }
}
