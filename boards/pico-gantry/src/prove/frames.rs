//! The frames of the USB host, by which the chip's crystal can be checked.

use embassy_rp::pac::USB;

use crate::chip::TIMER;

/// A frame lasts a millisecond. Without a host there is none.
const PATIENCE_US: u32 = 3_000;

/// Waits for the beginning of a frame. Returns its number, modulo 2048, and the time, us; `None` if none comes.
pub fn next() -> Option<[u32; 2]> {
    let number = || u32::from(USB.sof_rd().read().count());
    let (before, begin_us) = (number(), TIMER.timerawl().read());
    loop {
        // First the time, which is then at most as late as one round of this loop takes.
        let (now_us, frame) = (TIMER.timerawl().read(), number());
        if frame != before {
            return Some([frame, now_us]);
        }
        if now_us.wrapping_sub(begin_us) > PATIENCE_US {
            return None;
        }
    }
}
