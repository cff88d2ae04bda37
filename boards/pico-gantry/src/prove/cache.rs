//! The cost of a read of flash: in the cache, not in it, and by the alias that does without it.
#![expect(unsafe_code, reason = "flash is read by address")]

use embassy_rp::pac::XIP_CTRL;

use super::cycles;
use crate::chip::prove::{UNCACHED_FLASH, empty_cache};

/// The beginning of the image, which stays as it is.
const CACHED: usize = 0x1000_0000;
/// A line of the cache. Each read is of another.
const LINE_BYTES: usize = 8;
const READS: usize = 256;

/// The mean cost of a read in hundredths of a cycle: in the cache, not in it, without it. A loop's own instructions are
/// in all of them. It masks interrupts for some hundred microseconds.
// Not inlined, so that it does not wait for its own code while interrupts are masked.
#[inline(never)]
pub fn read_cost_hundredths() -> [u32; 3] {
    cortex_m::interrupt::free(|_| {
        empty_cache();
        let cold = read(CACHED);
        let hit = read(CACHED);
        [hit, cold, read(UNCACHED_FLASH)].map(|cycles| cycles * 100 / READS as u32)
    })
}

/// Hits of the cache and accesses to it since the last call.
#[inline(never)]
pub fn take_counters() -> [u32; 2] {
    cortex_m::interrupt::free(|_| {
        let counted = [XIP_CTRL.ctr_hit().read(), XIP_CTRL.ctr_acc().read()];
        XIP_CTRL.ctr_hit().write_value(0);
        XIP_CTRL.ctr_acc().write_value(0);
        counted
    })
}

/// Cycles of the reads from `start` on.
#[inline(never)]
fn read(start: usize) -> u32 {
    let begin = cycles::now();
    for line in 0..READS {
        // SAFETY: the address is a multiple of 4 in the image, which is larger than what is read.
        unsafe { ((start + LINE_BYTES * line) as *const u32).read_volatile() };
    }
    cycles::since(begin)
}
