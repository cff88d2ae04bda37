//! The Pico's LED. Idle: a short flash each second; in motion: on; held: blinks slowly; alarm: blinks fast.

use core::pin::pin;

use embassy_rp::gpio::{Level, Output};
use embassy_time::{Duration, Ticker};
use isostep_motion::{Machine, State, cold_path};

const TICK: Duration = Duration::from_millis(100);

/// Shows the machine's state.
#[embassy_executor::task]
pub async fn show(machine: &'static Machine, led: Output<'static>) -> ! {
    cold_path(pin!(blink(machine, led))).await
}

async fn blink(machine: &Machine, mut led: Output<'static>) -> ! {
    let mut ticker = Ticker::every(TICK);
    let mut tick = 0;
    loop {
        let lit = match machine.state() {
            State::Idle => tick == 0,
            State::Run | State::Jog | State::Home => true,
            // Lit for half of each second.
            State::Hold { .. } => tick < 5,
            State::Alarm(_) => tick % 2 == 0,
        };
        led.set_level(Level::from(lit));
        tick = (tick + 1) % 10;
        ticker.next().await;
    }
}
