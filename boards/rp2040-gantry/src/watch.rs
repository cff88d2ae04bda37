//! The watchdog, and the LED that shows the machine's state.
//!
//! # Design
//! The motion executor counts up while it runs; a thread-mode task feeds the watchdog only when that count has moved.
//! So it runs out when either executor stands still: the one no longer counts, the other no longer feeds.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_rp::Peri;
use embassy_rp::peripherals::WATCHDOG;
use embassy_rp::watchdog::Watchdog;
use embassy_time::{Duration, Timer};

/// Many times what planning or a full console holds the thread executor for.
const TIMEOUT: Duration = Duration::from_millis(1_000);
const BEAT: Duration = Duration::from_millis(100);
const CHECK: Duration = Duration::from_millis(250);

static BEATS: AtomicU32 = AtomicU32::new(0);

/// Shows that the motion executor runs.
#[embassy_executor::task]
pub async fn beat() -> ! {
    loop {
        // One writer, so load and store need no atomic read-modify-write.
        BEATS.store(BEATS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
        Timer::after(BEAT).await;
    }
}

/// Starts the watchdog and feeds it while the motion executor beats.
#[embassy_executor::task]
pub async fn feed(peripheral: Peri<'static, WATCHDOG>) -> ! {
    let mut watchdog = Watchdog::new(peripheral);
    watchdog.pause_on_debug(true);
    watchdog.start(TIMEOUT);
    let mut seen = BEATS.load(Ordering::Relaxed);
    loop {
        Timer::after(CHECK).await;
        let beats = BEATS.load(Ordering::Relaxed);
        if beats != seen {
            watchdog.feed(TIMEOUT);
            seen = beats;
        }
    }
}
