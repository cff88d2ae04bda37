//! The step ports: `TimerPort`, whose steps one task makes.

use embassy_executor::SendSpawner;
use embassy_time::{Duration, Instant};
use embedded_hal::delay::DelayNs;
use isostep_motion::{AXES, DriverTiming, TimerBank, TimerPort};

use crate::pins::AxisPins;

static BANK: TimerBank<AXES> = TimerBank::new();

/// From the alarm to the task's first reading of the clock.
const WAKE_UP: Duration = Duration::from_micros(20);

/// The ports of all axes.
pub fn open(spawner: SendSpawner) -> [TimerPort<'static>; AXES] {
    spawner.spawn(drive().unwrap());
    BANK.ports(DriverTiming::DRV8825, INHIBITS)
}

#[embassy_executor::task]
async fn drive() -> ! {
    BANK.drive(core::array::from_fn(AxisPins::new), Delay, WAKE_UP).await
}

const INHIBITS: [fn(bool); AXES] = {
    let of_four: [fn(bool); 4] = [inhibit::<0>, inhibit::<1>, inhibit::<2>, inhibit::<3>];
    *of_four.first_chunk().unwrap()
};

fn inhibit<const AXIS: usize>(engaged: bool) {
    BANK.inhibit(AXIS, engaged);
}

/// A delay that blocks, by the clock.
struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        // A tick is 50 ns. What is asked for is a constant mostly, and the division is one by a constant.
        let end = Instant::now() + Duration::from_ticks(u64::from(ns / 50 + 1));
        while Instant::now() < end {}
    }
}
