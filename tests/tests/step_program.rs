//! The firmware's step program, word by word, on two emulators that know nothing of each other: every edge, both ways,
//! every halt and every count is where the firmware's own arithmetic says, to the cycle. Both count from the write that
//! opens the gate, and agree on every cycle without an offset.
//!
//! A plain `cargo test` runs the published emulator; the project's own needs Node's packages, so `cargo xtask test` runs
//! those. A failure names its seed: the same in every run.

#[path = "step_program/emulator.rs"]
mod emulator;
#[path = "step_program/experiment.rs"]
mod experiment;
#[path = "../../boards/rp2040-gantry/src/pio_port/program.rs"]
mod program;

use std::env;
use std::ops::Range;

use oorandom::Rand32;

use self::emulator::Emulator;
use self::experiment::{Axis, Experiment, OPENS_AT, Seen, Wait};
use self::program::{AXES_MAX, WAIT_MAX_CYCLES, Words};

/// From the write that opens the gate to time zero of a run, on which a first step of 0 cycles would rise.
const ZERO_AFTER_GATE_CYCLES: u64 = 10;
/// From there back to the fetch of the first word.
const FETCH_BEFORE_ZERO_CYCLES: u64 = 8;
/// STEP is low so long at the least.
const LOW_MIN_CYCLES: u32 = 8;
const REST_MIN_CYCLES: u32 = 7;
const WAITS_UP_TO_CYCLES: u32 = 3_000;
const WAITS: u32 = 2_000;
/// Three machines each: enough for every pulse.
const SEEDS: Range<u64> = 0..3;
/// None at all, the shortest, a TMC2209's, a DRV8825's, and more.
const PULSES: [u32; 7] = [0, 3, 4, 13, 238, 250, 1_000];
/// An instruction that waits for a flag goes on a cycle after it was cleared, and the edge is the next.
const EDGE_AFTER_RELEASE_CYCLES: u64 = 2;
/// From the end of a pulse to the flag of a machine that has made its last step, or that finds no word.
const HALT_AFTER_LAST_CYCLES: u64 = 1;
const HALT_AFTER_FETCH_CYCLES: u64 = 2;

/// What the words say.
fn predicted(axis: &Axis, brake: &Range<u64>) -> Seen {
    let pulse = u64::from(axis.words.pulse_cycles());
    let mut at = OPENS_AT + ZERO_AFTER_GATE_CYCLES;
    let (mut rises, mut falls) = (Vec::new(), Vec::new());
    for wait in &axis.waits {
        let (Wait::Step(cycles) | Wait::Rest(cycles)) = *wait;
        at += u64::from(cycles);
        if let Wait::Step(_) = wait {
            // The brake is looked at one cycle before the edge, and takes effect one after it was set.
            if brake.start < at - 1 && at - 1 <= brake.end {
                at = brake.end + EDGE_AFTER_RELEASE_CYCLES;
            }
            rises.push(at);
            falls.push(at + pulse);
        }
    }
    let halt = match falls.last() {
        // It looks at no word after its last step.
        Some(last) if falls.len() == axis.steps as usize => last + HALT_AFTER_LAST_CYCLES,
        Some(_) => at + pulse + HALT_AFTER_FETCH_CYCLES,
        None => at - FETCH_BEFORE_ZERO_CYCLES + HALT_AFTER_FETCH_CYCLES,
    };
    Seen { rises, falls, halt: Some(halt), left: 0 }
}

/// Axes that run at once, what is done to them, and what they must do.
struct Case {
    name: String,
    experiment: Experiment,
    axes: Vec<Axis>,
    wanted: Vec<Seen>,
}

impl Case {
    fn new(name: String, axes: Vec<Axis>) -> Self {
        Self::braked(name, axes, &(0..0))
    }

    fn braked(name: String, axes: Vec<Axis>, brake: &Range<u64>) -> Self {
        let wanted: Vec<_> = axes.iter().map(|axis| predicted(axis, brake)).collect();
        let until = wanted.iter().filter_map(|seen| seen.halt).max().unwrap();
        let mut experiment = Experiment::new(&axes, until);
        if !brake.is_empty() {
            experiment.brake(brake);
        }
        Self { name, experiment, axes, wanted }
    }

    fn check(&self, emulator: Emulator, seen: &[Seen]) {
        assert_eq!(seen.len(), self.axes.len());
        for (machine, (axis, (seen, wanted))) in self.axes.iter().zip(seen.iter().zip(&self.wanted)).enumerate() {
            let what = format!("{}, state machine {machine}, emulator: {emulator:?}", self.name);
            same("rise", &seen.rises, &wanted.rises, &what);
            same("fall", &seen.falls, &wanted.falls, &what);
            assert_eq!(seen.halt, wanted.halt, "halt; {what}");
            assert_eq!(seen.left, emulator.left(axis.steps, wanted.rises.len() as u32), "count; {what}");
        }
    }
}

fn check(emulator: Emulator, cases: &[Case]) {
    let experiments: Vec<_> = cases.iter().map(|case| &case.experiment).collect();
    for (case, seen) in cases.iter().zip(emulator.run(&experiments)) {
        case.check(emulator, &seen);
    }
}

/// Names the first edge that is elsewhere.
fn same(edge: &str, seen: &[u64], wanted: &[u64], what: &str) {
    let differs = seen.iter().zip(wanted).position(|(seen, wanted)| seen != wanted);
    if let Some(i) = differs {
        panic!("{edge} {i} is on cycle {}, not {}; {what}", seen[i], wanted[i]);
    }
    assert_eq!(seen.len(), wanted.len(), "{edge}s; {what}");
}

/// Random waits: one in eight the shortest, half of them short, one in sixteen a rest.
fn random_waits(random: &mut Rand32, words: Words) -> Vec<Wait> {
    let shortest = words.pulse_cycles() + LOW_MIN_CYCLES;
    let mut wait = |_| match random.rand_range(0..16) {
        0 => Wait::Rest(random.rand_range(REST_MIN_CYCLES..WAITS_UP_TO_CYCLES)),
        1 | 2 => Wait::Step(shortest),
        3..11 => Wait::Step(shortest + random.rand_range(1..100)),
        _ => Wait::Step(random.rand_range(shortest..WAITS_UP_TO_CYCLES + 1)),
    };
    (0..WAITS).map(&mut wait).collect()
}

fn random_axes(seed: u64) -> Vec<Axis> {
    let mut random = Rand32::new(seed);
    let pulse = |machine| PULSES[(seed as usize * 3 + machine) % PULSES.len()];
    (0..3)
        .map(|machine| {
            let words = Words::with_pulse(pulse(machine));
            Axis::whole(words, random_waits(&mut random, words))
        })
        .collect()
}

/// The one that `ISOSTEP_SEED` names, or all.
fn seeds() -> Range<u64> {
    let one = env::var("ISOSTEP_SEED").ok().map(|seed| seed.parse().expect("a number"));
    one.map_or(SEEDS, |seed| seed..seed + 1)
}

fn steps(cycles: &[u32]) -> Vec<Wait> {
    cycles.iter().copied().map(Wait::Step).collect()
}

fn random_words() -> Vec<Case> {
    let replay = "cargo test --package isostep-tests --test step_program -- --include-ignored random_words";
    seeds().map(|seed| Case::new(format!("replay: ISOSTEP_SEED={seed} {replay}"), random_axes(seed))).collect()
}

/// However full their FIFOs are, and whatever is to come.
fn one_gate() -> Vec<Case> {
    let words = Words::with_pulse(250);
    let axes = [(20, 300), (0, 300), (3, 700), (20, 300)]
        .map(|(more, cycles)| Axis::whole(words, steps(&[&[40], &vec![cycles; more][..]].concat())));
    assert_eq!(axes.len(), AXES_MAX);
    let case = Case::new("the gate".to_owned(), axes.to_vec());
    assert!(case.wanted.iter().all(|seen| seen.rises[0] == case.wanted[0].rises[0]));
    vec![case]
}

/// Set on every cycle around a step, and released: pulses stay whole, and no edge rises while it is engaged.
fn brakes() -> Vec<Case> {
    let axes = [3, 30].map(|pulse| Axis::whole(Words::with_pulse(pulse), steps(&[60; 6])));
    let second = predicted(&axes[0], &(0..0)).rises[1];
    let brakes = (second - 3..second + 35).flat_map(|from| [1, 2, 500].map(|cycles| from..from + cycles));
    brakes.map(|brake| Case::braked(format!("brake on cycles {brake:?}"), axes.to_vec(), &brake)).collect()
}

/// Before the first step, after one, and after a rest: it halts, and a word that comes too late is no step.
fn empty_fifos() -> Vec<Case> {
    let words = Words::with_pulse(13);
    let waits = [vec![], steps(&[50, 60, 70]), vec![Wait::Rest(90)], vec![Wait::Step(20), Wait::Rest(500)]];
    let axes = waits.map(|waits| Axis { words, steps: 100, waits });
    let mut case = Case::new("an empty FIFO".to_owned(), axes.to_vec());
    for machine in 0..axes.len() as u32 {
        case.experiment.send(OPENS_AT + 2_000, machine, words.step(60));
    }
    vec![case]
}

/// Words beyond the last step stay where they are.
fn last_steps() -> Vec<Case> {
    let words = Words::with_pulse(4);
    let axes = [1, 2, 9].map(|count| Axis::whole(words, steps(&vec![50; count])));
    let mut case = Case::new("more words than steps".to_owned(), axes.to_vec());
    for list in &mut case.experiment.words {
        list.extend([words.step(50); 3]);
    }
    vec![case]
}

macro_rules! on {
    ($emulator:expr $(, #[$ignored:meta])?) => {
        #[test]
        $(#[$ignored])?
        fn random_words_are_exact() {
            check($emulator, &random_words());
        }

        #[test]
        $(#[$ignored])?
        fn the_gate_opens_all_machines_on_one_cycle() {
            check($emulator, &one_gate());
        }

        #[test]
        $(#[$ignored])?
        fn the_brake_keeps_edges_from_rising() {
            check($emulator, &brakes());
        }

        #[test]
        $(#[$ignored])?
        fn an_empty_fifo_halts_the_machine() {
            check($emulator, &empty_fifos());
        }

        #[test]
        $(#[$ignored])?
        fn the_last_step_halts_the_machine() {
            check($emulator, &last_steps());
        }
    };
}

mod published {
    use super::*;

    on!(Emulator::Published);
}

mod own {
    use super::*;

    on!(Emulator::Own, #[ignore = "needs Node's packages: cargo xtask test"]);
}

/// Waits too long to be emulated: their words must still say step or rest.
#[test]
fn the_longest_waits_fit_into_a_word() {
    const STEP: u32 = 1 << 31;
    for words in PULSES.map(Words::with_pulse) {
        assert_eq!(words.first_step(WAIT_MAX_CYCLES), STEP + WAIT_MAX_CYCLES);
        let loops = WAIT_MAX_CYCLES - words.pulse_cycles() - LOW_MIN_CYCLES;
        assert_eq!(words.step(WAIT_MAX_CYCLES), STEP + loops);
        assert_eq!(words.rest(WAIT_MAX_CYCLES), WAIT_MAX_CYCLES - REST_MIN_CYCLES);
    }
}

/// Never a shorter pulse than was asked for.
#[test]
fn pulses_are_long_enough() {
    for cycles in PULSES {
        assert_eq!(Words::with_pulse(cycles).pulse_cycles(), cycles.max(3));
    }
}
