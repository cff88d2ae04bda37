//! The pads that only a proving image uses: the marker that starts the stampers, and the output that a jumper leads to
//! a switch's input. And what the levels of others are.

use embassy_rp::gpio::{Level, Output};
use embassy_rp::pac::io::vals::Inover;
use embassy_rp::pac::{IO_BANK0, SIO};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Timer};

use super::program::MARKER;
use crate::pins::ProvePins;

/// GP28.
pub const OUT: usize = 28;
/// The time for which a pad's level is sampled. The coordinator waits as long, and is further ahead than that.
const SAMPLED_FOR: Duration = Duration::from_millis(10);
/// A stamper sees a level that lasts 6 cycles. A write takes one at least.
const RELEASED_CYCLES: u32 = 8;
/// The bank has 30.
pub const PADS: u8 = 30;

/// The time after which OUT is to be pulled low.
static PRESS_AFTER: Signal<CriticalSectionRawMutex, Duration> = Signal::new();

/// Prepares the pads: the marker low, and OUT high as a switch at rest.
pub fn start(pins: ProvePins) {
    // Kept for ever: dropped, they would become inputs.
    core::mem::forget([Output::new(pins.marker, Level::Low), Output::new(pins.out, Level::High)]);
    // The stampers stamp what rises, and OUT is pressed when it falls.
    IO_BANK0.gpio(OUT).ctrl().modify(|ctrl| ctrl.set_inover(Inover::INVERT));
}

/// Sets the marker.
pub fn mark(high: bool) {
    let latch = SIO.gpio_out(0);
    let register = if high { latch.value_set() } else { latch.value_clr() };
    register.write_value(1 << MARKER);
}

/// Pulls OUT low at once, in any context. If it is low already it rises before, so that each press is an edge: of two reset
/// bytes the second is the one that is measured.
#[inline(always)]
pub fn press() {
    let latch = SIO.gpio_out(0);
    for _ in 0..RELEASED_CYCLES {
        latch.value_set().write_value(1 << OUT);
    }
    latch.value_clr().write_value(1 << OUT);
}

/// Lets OUT go. What was to press it later still does.
pub fn release() {
    SIO.gpio_out(0).value_set().write_value(1 << OUT);
}

/// Pulls OUT low after some time.
pub fn press_after(time: Duration) {
    PRESS_AFTER.signal(time);
}

/// Presses when it was asked for.
#[embassy_executor::task]
pub async fn press_later() -> ! {
    loop {
        Timer::after(PRESS_AFTER.wait().await).await;
        press();
    }
}

/// The number of times that a pad was high, and that it was read.
pub fn sample(pad: u8) -> [u32; 2] {
    let end = Instant::now() + SAMPLED_FOR;
    let (mut high, mut of) = (0, 0);
    while Instant::now() < end {
        high += SIO.gpio_in(0).read() >> pad & 1;
        of += 1;
    }
    // OUT's input is inverted.
    if usize::from(pad) == OUT { [of - high, of] } else { [high, of] }
}
