//! What runs for every step, from RAM: flash may stall, and is slower when its cache misses.
#![expect(unsafe_code, reason = "a linker section is chosen by an unsafe attribute")]

use core::sync::atomic::AtomicU32;

use isostep_profile::Intervals;

/// Writes a word per interval, as many as there is room for; how many.
// SAFETY: `.data` is copied to RAM before `main`, and RAM is executable on this chip.
#[unsafe(link_section = ".data.fill")]
#[inline(never)]
pub fn fill(words: &[AtomicU32], intervals: &mut Intervals, bias: u32) -> usize {
    intervals.fill(words, bias)
}
