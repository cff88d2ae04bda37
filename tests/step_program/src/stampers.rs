//! The stampers' programs: every edge is stamped within the two cycles that they promise, however many are skipped.

#[path = "../../../boards/pico-gantry/src/prove/program.rs"]
mod program;

use oorandom::Rand32;

use self::program::{EARLY, LATE, LATE_CYCLES, MARKER, SHORT_ORIGIN, SKIPPING_ORIGIN, forced, moved};
use crate::emulator::{Emulator, on_each};
use crate::experiment::{CTRL, Experiment, INSTR, SHIFTCTRL, SIO_OUT, at_origin, by_hand, clocked, txf};

const PIN: u8 = 2;
/// A push at every IN, and all places of the FIFO for what is pushed.
const STAMPS_ONLY: u32 = 1 << 31 | 1 << 16;
const AUTOPUSH: u32 = 1 << 16;
/// The cycle on which the marker rises.
const MARKED_AT: u64 = 20;
const EDGES: usize = 2_000;
/// The shortest pulse of a driver that is planned for is 13 cycles.
const HIGH_MIN_CYCLES: u32 = 6;
const LOW_MIN_CYCLES: u32 = 6;
const SPREAD_CYCLES: u32 = 40;
/// After so many cycles the last stamp has been taken.
const AFTERWARDS_CYCLES: u64 = 60;
/// A stamp is that of the edge's cycle or the next one.
const LOOKS_EVERY_CYCLES: u32 = 2;

/// A stamper with one of the programs.
#[derive(Clone, Copy)]
struct Stamper {
    is_short: bool,
    entry: u8,
    skip: u32,
}

impl Stamper {
    fn experiment(self, rises: &[(u64, u64)]) -> Experiment {
        let (origin, program) =
            if self.is_short { (SHORT_ORIGIN, program::short()) } else { (SKIPPING_ORIGIN, program::skipping()) };
        let code = program.code.iter().map(|&instruction| moved(instruction, origin));
        let setup = at_origin(origin, code).chain(by_hand([PIN, MARKER])).chain(clocked(origin, program.wrap, PIN));
        let setup = setup.chain([
            (SHIFTCTRL, AUTOPUSH),
            (txf(0), self.skip),
            (INSTR, forced::PULL.into()),
            (SHIFTCTRL, STAMPS_ONLY),
            (INSTR, forced::STAMP_FIRST.into()),
            (INSTR, forced::BEGIN.into()),
            (INSTR, forced::go_to(origin + self.entry).into()),
            (CTRL, 1),
        ]);
        let mark = 1 << MARKER;
        let mut writes = vec![(MARKED_AT, SIO_OUT, mark)];
        for &(rise, fall) in rises {
            writes.extend([(rise, SIO_OUT, mark | 1 << PIN), (fall, SIO_OUT, mark)]);
        }
        let cycles = rises.last().expect("some").1 + AFTERWARDS_CYCLES;
        Experiment::alone(setup.collect(), writes, cycles)
    }

    /// The edges, from 0, that it stamps.
    fn stamped(self, edges: usize) -> Vec<usize> {
        (0..edges).filter(|&edge| self.is_short || edge == 0 || edge > self.skip as usize).collect()
    }

    fn seen_cycles(self, index: usize, x: u32) -> u32 {
        let late = if self.entry == LATE { LATE_CYCLES } else { 0 };
        late + if self.is_short {
            program::short_seen_cycles(x, index as u32)
        } else {
            program::seen_cycles(x, index as u32, self.skip)
        }
    }

    /// The lateness of each stamp after its edge, a constant aside.
    fn latenesses(self, emulator: Emulator, rises: &[(u64, u64)]) -> Vec<i64> {
        let taken = emulator.taken(&self.experiment(rises));
        let stamped = self.stamped(rises.len());
        assert_eq!(taken.len(), stamped.len(), "every edge once");
        let stamps = taken.iter().enumerate().map(|(index, &(_, x))| i64::from(self.seen_cycles(index, x)));
        stamps.zip(stamped).map(|(seen, edge)| seen - rises[edge].0 as i64).collect()
    }
}

/// When the pad rises and falls.
fn pulses(seed: u64) -> Vec<(u64, u64)> {
    let mut random = Rand32::new(seed);
    let mut now = MARKED_AT + 30;
    let mut pulse = || {
        now += u64::from(LOW_MIN_CYCLES + random.rand_range(0..SPREAD_CYCLES));
        let rise = now;
        now += u64::from(HIGH_MIN_CYCLES + random.rand_range(0..SPREAD_CYCLES));
        (rise, now)
    };
    (0..EDGES).map(|_| pulse()).collect()
}

fn stamps_within_two_cycles(emulator: Emulator) {
    let rises = pulses(7);
    let all = [(false, EARLY, 0), (false, EARLY, 999), (false, LATE, 0), (false, LATE, 17), (true, EARLY, 0)];
    let latenesses = all.map(|(is_short, entry, skip)| Stamper { is_short, entry, skip }.latenesses(emulator, &rises));
    // They look in the same cycles, whatever their program and what they skip, or, if they begin late, in those between.
    let least = *latenesses[0].iter().min().expect("some");
    for (stamper, latenesses) in latenesses.iter().enumerate() {
        let within = least..least + i64::from(LOOKS_EVERY_CYCLES);
        let beyond = latenesses.iter().position(|lateness| !within.contains(lateness));
        assert_eq!(beyond, None, "stamper {stamper}: {:?}", beyond.map(|edge| latenesses[edge] - least));
    }
}

/// Of two stampers on one pad, one of which begins late, the earlier stamp is always the edge's own cycle.
fn two_stamp_to_the_cycle(emulator: Emulator) {
    let rises = pulses(11);
    let [early, late] =
        [EARLY, LATE].map(|entry| Stamper { is_short: false, entry, skip: 0 }.latenesses(emulator, &rises));
    let sooner: Vec<i64> = early.iter().zip(&late).map(|(early, late)| *early.min(late)).collect();
    assert!(sooner.iter().all(|lateness| *lateness == sooner[0]), "{sooner:?}");
    assert!(early != sooner, "one alone does not know");
}

on_each! {
    the_stampers_stamp_within_two_cycles: stamps_within_two_cycles;
    two_stampers_stamp_to_the_cycle: two_stamp_to_the_cycle;
}
