//! The step ports: `TimerPort`, whose steps one task makes.

use embassy_executor::SendSpawner;
use embassy_time::Duration;
use embedded_hal::delay::DelayNs;
use isostep_motion::{AXES, DriverTiming, TimerBank, TimerPort};

use crate::clock::CORE_MHZ;
use crate::pins::StepDir;
use crate::wake_up;

static BANK: TimerBank<AXES> = TimerBank::new();

/// The longest time from the alarm of the clock to the first reading of the clock by the task that makes the steps.
/// A guess, until somebody has measured it on the chip: README.md says how.
pub const WAKE_UP: Duration = Duration::from_micros(20);
/// A task measures that time, in place of the one that makes the steps: nothing moves.
const IS_MEASURED: bool = false;

/// The ports of all axes, for drivers of this timing. The task that makes their steps is spawned with `spawner`, which has
/// to be above the tasks of the axes.
///
/// # Panics
/// When it is called twice.
pub fn open(spawner: SendSpawner, motors: [StepDir; AXES]) -> [TimerPort<'static>; AXES] {
    if IS_MEASURED {
        spawner.spawn(wake_up::measure().expect("it is spawned once"));
    } else {
        spawner.spawn(drive(motors).expect("it is spawned once"));
    }
    BANK.ports(DriverTiming::DRV8825, [inhibit::<0>, inhibit::<1>, inhibit::<2>])
}

#[embassy_executor::task]
async fn drive(motors: [StepDir; AXES]) -> ! {
    BANK.drive(motors, Delay, WAKE_UP).await
}

fn inhibit<const AXIS: usize>(engaged: bool) {
    BANK.inhibit(AXIS, engaged);
}

/// A delay that blocks, by the processor's cycles. It is never shorter than asked for: it makes the pulses.
pub struct Delay;

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        cortex_m::asm::delay(ns.div_ceil(1_000) * CORE_MHZ);
    }
}
