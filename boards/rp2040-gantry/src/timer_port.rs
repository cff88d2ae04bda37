//! `TimerPort` on this board: the processor drives STEP and DIR, and one task makes the steps of all axes.

use embassy_rp::Peri;
use embassy_rp::gpio::{AnyPin, Level, Output};
use embassy_time::Duration;
use embedded_hal::delay::DelayNs;
use isostep_motion::{AXES, DriverTiming, TimerBank, TimerPort};

use crate::pins::StepPins;
use crate::priority;

pub type Port = TimerPort<'static>;

static BANK: TimerBank<AXES> = TimerBank::new();

/// From the timer's alarm to the task's first reading of the clock takes 6 us, plus most of the time for which others
/// mask interrupts. That makes up to 9 us, and more if several timers expire at once. A margin that is always enough
/// would leave too little time for everything else.
const WAKE_UP: Duration = Duration::from_micros(10);

/// The ports of all axes, at rest, with STEP and DIR low.
pub fn open(pins: StepPins, timing: DriverTiming) -> [Port; AXES] {
    let pins: [[Peri<'static, AnyPin>; 2]; AXES] =
        [[pins.x.into(), pins.x_dir.into()], [pins.y.into(), pins.y_dir.into()], [pins.z.into(), pins.z_dir.into()]];
    let pins = pins.map(|[step, dir]| (Output::new(step, Level::Low), Output::new(dir, Level::Low)));
    priority::start_step_executor().spawn(drive(pins).unwrap());
    BANK.ports(timing, [brake::<0>, brake::<1>, brake::<2>])
}

#[embassy_executor::task]
async fn drive(pins: [(Output<'static>, Output<'static>); AXES]) -> ! {
    BANK.drive(pins, CoreDelay, WAKE_UP).await
}

fn brake<const AXIS: usize>(engaged: bool) {
    BANK.brake(AXIS, engaged);
}

/// A delay that blocks, for the width of a pulse.
#[derive(Debug)]
struct CoreDelay;

impl DelayNs for CoreDelay {
    fn delay_ns(&mut self, ns: u32) {
        // `delay(n)` runs n + 1 times through a loop of 3 cycles, 24 ns at 125 MHz. 2,731 / 65,536 gives one loop per
        // 23.997 ns. So the delay is never too short and needs no division, for which this core has no instruction.
        const LONGEST_NS: u32 = u32::MAX / 2_731;
        let mut left_ns = ns;
        while left_ns > LONGEST_NS {
            cortex_m::asm::delay((LONGEST_NS * 2_731) >> 16);
            left_ns -= LONGEST_NS;
        }
        cortex_m::asm::delay((left_ns * 2_731) >> 16);
    }
}
