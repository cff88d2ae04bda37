//! The program of the output watchdog: fed it says nothing, otherwise it runs out to the cycle.

#[path = "../../../boards/pico-gantry/src/output_watchdog/program.rs"]
mod program;

use oorandom::Rand32;

use self::program::{ORIGIN, count_down, forced};
use crate::emulator::{Emulator, on_each};
use crate::experiment::{CTRL, Experiment, INSTR, SHIFTCTRL, at_origin, clocked, txf};
use crate::guard::watch;

const WORD: u32 = 0x321F;
/// The patience of the output watchdog. On the chip it is longer.
const PATIENCE: u32 = 1_000;
/// From the write that feeds it to the word of a machine that is patient for 0 cycles: the round that finds X run out,
/// and the two instructions after it.
const WORD_AFTER_FEED_CYCLES: u64 = 3;
/// From one word to the next.
const ROUND_CYCLES: u64 = 2;
const FEEDS: u32 = 200;
/// OUT and IN shift right, as after a reset.
const SHIFTS: u32 = 3 << 18;
const FIFO_IS_ALL_RX: u32 = 1 << 31;

/// An output watchdog that is set before cycle 0, with these writes.
fn experiment(writes: Vec<(u64, u32, u32)>, cycles: u64) -> Experiment {
    let program = count_down();
    let setup = at_origin(ORIGIN, program.code.iter().copied()).chain(clocked(ORIGIN, program.wrap, 0));
    let words = [(SHIFTCTRL, SHIFTS), (txf(0), WORD), (INSTR, forced::PULL.into()), (INSTR, forced::SET_WORD.into())];
    let setup = setup.chain(words).chain(set(PATIENCE)).chain([(CTRL, 1)]);
    Experiment::alone(setup.collect(), writes, cycles)
}

/// The writes that set an output watchdog, or set it again.
fn set(patience: u32) -> Vec<(u32, u32)> {
    let mut writes = patient(patience);
    writes.push((INSTR, forced::COUNT.into()));
    // Both drop what is in the FIFO.
    writes.extend([(SHIFTCTRL, SHIFTS | FIFO_IS_ALL_RX), (SHIFTCTRL, SHIFTS)]);
    writes
}

fn patient(patience: u32) -> Vec<(u32, u32)> {
    vec![(txf(0), patience), (INSTR, forced::PULL.into()), (INSTR, forced::FEED.into())]
}

/// These writes, one a cycle, from this cycle on.
fn at(cycle: u64, writes: Vec<(u32, u32)>) -> impl Iterator<Item = (u64, u32, u32)> {
    (cycle..).zip(writes).map(|(cycle, (address, value))| (cycle, address, value))
}

fn feed(cycle: u64) -> (u64, u32, u32) {
    (cycle, INSTR, forced::FEED.into())
}

fn words(emulator: Emulator, experiment: &Experiment) -> Vec<u64> {
    let taken = emulator.taken(experiment);
    assert!(taken.iter().all(|&(_, word)| word == WORD), "{taken:?}");
    taken.into_iter().map(|(cycle, _)| cycle).collect()
}

/// The cycles from this one to this one on which words are taken.
fn said(from: u64, to: u64) -> Vec<u64> {
    (from..=to).step_by(ROUND_CYCLES as usize).collect()
}

fn runs_out_to_the_cycle(emulator: Emulator) {
    let mut random = Rand32::new(5);
    let mut fed_at = 0;
    let mut writes = Vec::new();
    for _ in 0..FEEDS {
        fed_at += u64::from(random.rand_range(1..PATIENCE + 1));
        writes.push(feed(fed_at));
    }
    let out = fed_at + u64::from(PATIENCE) + WORD_AFTER_FEED_CYCLES;
    assert_eq!(words(emulator, &experiment(writes, out + 100)), said(out, out + 100));
}

fn stays_out_until_it_is_set(emulator: Emulator) {
    let out = u64::from(PATIENCE) + 2_000;
    let mut writes = vec![feed(out), feed(out + 1), feed(out + 7)];
    writes.extend(at(out + 100, set(PATIENCE)));
    let seen = words(emulator, &experiment(writes, out + 2 * u64::from(PATIENCE)));
    let first_out = seen.iter().take_while(|&&cycle| cycle <= out + 100).count();
    assert!(first_out > 1_000, "it went on while it was fed: {first_out}");
    let set_at = out + 103;
    let silent = seen.windows(2).find(|pair| pair[1] - pair[0] > 10).expect("a time without words");
    assert!(silent[0] <= set_at + 3, "{silent:?}");
    assert!((silent[1] - set_at).abs_diff(u64::from(PATIENCE)) < 10, "{silent:?}, set at {set_at}");
}

fn is_as_patient_as_it_is_told(emulator: Emulator) {
    let mut writes: Vec<_> = at(500, patient(5 * PATIENCE)).collect();
    writes.push(feed(5_000));
    writes.extend(at(9_000, patient(PATIENCE)));
    let out = 9_002 + u64::from(PATIENCE) + WORD_AFTER_FEED_CYCLES;
    assert_eq!(words(emulator, &experiment(writes, out + 20)), said(out, out + 20));
}

on_each! {
    a_watchdog_that_is_fed_says_nothing_and_then_runs_out_to_the_cycle: runs_out_to_the_cycle;
    a_watchdog_that_has_run_out_stays_so_until_it_is_set_again: stays_out_until_it_is_set;
    a_watchdog_is_as_patient_as_it_is_told: is_as_patient_as_it_is_told;
}

#[test]
fn both_programs_of_the_block_fit() {
    assert!(watch(32).code.len() <= usize::from(ORIGIN));
    assert_eq!(usize::from(ORIGIN) + count_down().code.len(), pio::RP2040_MAX_PROGRAM_SIZE);
}
