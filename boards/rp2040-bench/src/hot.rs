//! The loop that runs per step, in RAM: there it never waits for the flash.
#![expect(unsafe_code, reason = "a function's section can only be named by an unsafe attribute")]

use core::sync::atomic::AtomicU32;

use isostep_profile::Intervals;

/// As a port does, which adds to each interval what its own edge takes.
// SAFETY: the runtime copies `.data` to RAM before `main`; the function goes nowhere else.
#[unsafe(link_section = ".data.hot")]
#[inline(never)]
pub fn fill(words: &[AtomicU32], intervals: &mut Intervals, bias: u32) -> usize {
    intervals.fill(words, bias)
}
