//! The watchdog, and who feeds the output watchdog.
//!
//! # Design
//! The executor of the axes feeds the output watchdog and increments a counter while it runs. A thread-mode task
//! refreshes the watchdog only if the counter has changed. So the watchdog resets the chip when any executor stops:
//! either the axes no longer count, or thread mode no longer refreshes. The output watchdog needs only the executors
//! that the tool depends on, the axes' and those above it, and so it can be fifty times as quick.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_executor::{SendSpawner, Spawner};
use embassy_rp::Peri;
use embassy_rp::peripherals::WATCHDOG;
use embassy_rp::watchdog::Watchdog;
use embassy_time::{Duration, Timer};
use isostep_motion::Machine;

use crate::{chip, fail_still, output_watchdog, tool};

/// Much longer than planning or a full console occupies the thread-mode executor.
const TIMEOUT: Duration = Duration::from_millis(1_000);
/// A quarter of the patience of the output watchdog.
const BEAT: Duration = Duration::from_millis(5);
const CHECK: Duration = Duration::from_millis(250);

static BEATS: AtomicU32 = AtomicU32::new(0);

/// Starts the watchdog over the executors. An executor that stops keeps those with a lower priority from running.
pub fn spawn(axes: SendSpawner, thread: Spawner, machine: &'static Machine, watchdog: Peri<'static, WATCHDOG>) {
    let mut watchdog = Watchdog::new(watchdog);
    watchdog.pause_on_debug(true);
    watchdog.start(TIMEOUT);
    chip::set_watchdog_resets();
    axes.spawn(beat(machine).unwrap());
    thread.spawn(refresh(machine, watchdog).unwrap());
}

#[embassy_executor::task]
async fn beat(machine: &'static Machine) -> ! {
    loop {
        output_watchdog::feed(machine);
        // There is only one writer, so load and store need no atomic read-modify-write.
        BEATS.store(BEATS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
        Timer::after(BEAT).await;
    }
}

#[embassy_executor::task]
async fn refresh(machine: &'static Machine, mut watchdog: Watchdog) -> ! {
    let mut seen = BEATS.load(Ordering::Relaxed);
    loop {
        Timer::after(CHECK).await;
        let config = machine.config();
        fail_still::set_enable_inverted(config.enable_inverted);
        tool::pull_probe_up(config.probe_pulled_up);
        let beats = BEATS.load(Ordering::Relaxed);
        if beats != seen {
            watchdog.feed(TIMEOUT);
            seen = beats;
        }
    }
}
