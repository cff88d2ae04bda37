//! Measures how long a wake-up of the task that makes the steps takes, with all that may delay it.
//!
//! It stands in the place of that task, at its priority, so nothing moves. Everything else is at work: press switches, send
//! lines, and ask for a move, which gets ready and then waits for ever.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_time::{Duration, Instant, Timer};

/// The longest so far, ticks of the clock. Read it with a debugger.
#[used]
static LONGEST_TICKS: AtomicU32 = AtomicU32::new(0);

/// No multiple of anything else that is periodic, so that in time it meets everything.
const PERIOD: Duration = Duration::from_micros(997);

#[embassy_executor::task]
pub async fn measure() -> ! {
    loop {
        let due = Instant::now() + PERIOD;
        Timer::at(due).await;
        let late = Instant::now() - due;
        // One more: the clock may have been almost a tick further than it reads.
        LONGEST_TICKS.fetch_max(late.as_ticks() as u32 + 1, Ordering::Relaxed);
    }
}
