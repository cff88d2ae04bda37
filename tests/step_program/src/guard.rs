//! The guard's program: every change of its inputs is reported, in order, and within a bounded number of cycles.

#[path = "../../../boards/pico-gantry/src/guard/program.rs"]
mod program;

use oorandom::Rand32;

pub use self::program::watch;
use self::program::{KNOW_NOTHING, go_to, moved};
use crate::emulator::{Emulator, on_rp2040};
use crate::experiment::{CTRL, Experiment, INSTR, PINCTRL, SHIFTCTRL, SIO_OUT, at_origin, by_hand, clocked};

const INPUTS: u8 = 6;
const FIRST_PIN: u8 = 9;
const ALL: u32 = (1 << INPUTS) - 1;
const CHANGES: usize = 20_000;
/// OUT shifts right, IN left. The RX FIFO has all eight places.
const SHIFTS: u32 = 1 << 31 | 1 << 19;
/// The first look is on cycle 1, and this many cycles later the levels are in the FIFO.
const REPORTED_AFTER_LOOK_CYCLES: u64 = 3;
const ROUND_CYCLES: u64 = 4;
/// From one look at the pins to the next, after a change.
const ROUND_MAX_CYCLES: u32 = 5;
/// From the change of a pad to the first cycle on which a machine sees it.
const SYNC_CYCLES: u64 = 2;

/// A board whose inputs have these levels from these cycles on.
fn experiment(levels: &[(u64, u32)], takes_from: u64, cycles: u64) -> Experiment {
    let watch = watch(INPUTS);
    let setup = at_origin(0, watch.code.iter().copied()).chain(by_hand(FIRST_PIN..FIRST_PIN + INPUTS));
    let setup = setup.chain(clocked(0, watch.wrap, 0)).chain([
        (SHIFTCTRL, SHIFTS),
        (PINCTRL, u32::from(FIRST_PIN) << 15),
        (INSTR, KNOW_NOTHING.into()),
        (INSTR, go_to(watch.wrap.target).into()),
        (CTRL, 1),
    ]);
    let writes = levels.iter().map(|&(cycle, levels)| (cycle, SIO_OUT, levels << FIRST_PIN)).collect();
    Experiment { takes_from, ..Experiment::alone(setup.collect(), writes, cycles) }
}

/// The levels that the machine tells, with the cycle, when nobody lets it wait.
fn reported(levels: &[(u64, u32)], cycles: u64) -> Vec<(u64, u32)> {
    let (mut look, mut known, mut reported) = (1, None, Vec::new());
    let mut ahead = levels.iter().peekable();
    let mut now = 0;
    while look + REPORTED_AFTER_LOOK_CYCLES <= cycles {
        while let Some(&(_, levels)) = ahead.next_if(|change| change.0 + SYNC_CYCLES <= look) {
            now = levels;
        }
        if known.replace(now) == Some(now) {
            look += ROUND_CYCLES;
        } else {
            reported.push((look + REPORTED_AFTER_LOOK_CYCLES, now));
            look += u64::from(ROUND_MAX_CYCLES);
        }
    }
    reported
}

/// Random changes of one input or several, none of which is shorter than the guard promises to see.
fn random_levels() -> Vec<(u64, u32)> {
    let mut random = Rand32::new(4);
    let (mut cycle, mut levels) = (100, 0);
    (0..CHANGES)
        .map(|_| {
            cycle += u64::from(match random.rand_range(0..4) {
                0 => ROUND_MAX_CYCLES,
                1 | 2 => random.rand_range(ROUND_MAX_CYCLES..12),
                _ => random.rand_range(ROUND_MAX_CYCLES..100),
            });
            levels ^= random.rand_range(1..ALL + 1);
            (cycle, levels)
        })
        .collect()
}

fn every_change_is_reported(emulator: Emulator) {
    let levels = random_levels();
    let cycles = levels.last().unwrap().0 + 100;
    let seen = emulator.taken(&experiment(&levels, 0, cycles));
    assert_eq!(seen[0].1, 0, "the levels at the start");
    assert_eq!(seen.len(), 1 + CHANGES);
    for (&(reported_at, reported), &(cycle, levels)) in seen[1..].iter().zip(&levels) {
        let after = reported_at - cycle;
        assert!(reported == levels && (5..=9).contains(&after), "{levels:b} of {cycle}: {reported:b} after {after}");
    }
    assert_eq!(seen, self::reported(&levels, cycles));
}

/// While nobody takes what the machine tells it waits, and then goes on from there.
fn a_full_fifo_keeps_what_it_holds(emulator: Emulator) {
    let levels: Vec<_> = (0..30).map(|change| (100 + 20 * change, change as u32 + 1)).collect();
    let seen = emulator.taken(&experiment(&levels, 1_000, 1_200));
    let reported: Vec<_> = seen.iter().map(|&(_, levels)| levels).collect();
    // Eight in the FIFO, the first of which are the levels at the start, the one that waited for room, and the last.
    assert_eq!(reported, [0, 1, 2, 3, 4, 5, 6, 7, 8, 30]);
}

/// Elsewhere its jumps lead to the same instructions, and all else is as it was.
#[test]
fn a_program_that_is_moved_jumps_within_itself() {
    let code = watch(1).code;
    let moved: Vec<_> = code.iter().map(|&instruction| moved(instruction, 6)).collect();
    let is_jump = |instruction: u16| instruction >> 13 == 0;
    assert_eq!(code.iter().filter(|&&instruction| is_jump(instruction)).count(), 1);
    for (&there, &here) in moved.iter().zip(&code) {
        assert_eq!(there, if is_jump(here) { here + 6 } else { here });
    }
    assert!(code.len() + 6 <= pio::RP2040_MAX_PROGRAM_SIZE);
}

on_rp2040! {
    every_change_of_an_input_is_reported_in_9_cycles: every_change_is_reported;
    a_full_fifo_loses_no_change_that_it_holds: a_full_fifo_keeps_what_it_holds;
}
