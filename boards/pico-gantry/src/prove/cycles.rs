//! Counts the core's cycles with SysTick: 24 bits, 134 ms at 125 MHz, 112 ms at 150 MHz.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

const RANGE: u32 = 0x00FF_FFFF;

/// Starts the counter.
pub fn start(mut counter: SYST) {
    counter.set_clock_source(SystClkSource::Core);
    counter.set_reload(RANGE);
    counter.clear_current();
    counter.enable_counter();
}

/// The counter as it is now. It counts down.
#[inline(always)]
pub fn now() -> u32 {
    SYST::get_current()
}

/// Cycles since `begin`.
#[inline(always)]
pub fn since(begin: u32) -> u32 {
    begin.wrapping_sub(now()) & RANGE
}
