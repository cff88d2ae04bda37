//! Counts cycles of the core with SysTick: 24 bits, 134 ms at 125 MHz.

use core::hint::black_box;

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

const RANGE: u32 = 0x00FF_FFFF;

/// Times pieces of work that are shorter than the counter's range.
pub struct Stopwatch {
    /// Cycles that the measurement of no work takes.
    overhead: u32,
}

impl Stopwatch {
    /// Starts the counter. No interrupt may be on while something is timed.
    pub fn start(mut counter: SYST) -> Self {
        counter.set_clock_source(SystClkSource::Core);
        counter.set_reload(RANGE);
        counter.clear_current();
        counter.enable_counter();
        let mut stopwatch = Self { overhead: 0 };
        let (_, overhead) = stopwatch.time((), |()| ());
        stopwatch.overhead = overhead;
        stopwatch
    }

    /// The result of `work` on `input`, and the cycles it took.
    pub fn time<I, R>(&self, input: I, work: impl FnOnce(I) -> R) -> (R, u32) {
        let begin = SYST::get_current();
        // Hidden from the optimiser, so that it moves no part of the work before the first or after the second reading.
        let result = black_box(work(black_box(input)));
        let end = SYST::get_current();
        (result, (begin.wrapping_sub(end) & RANGE) - self.overhead)
    }
}
