//! `TimerPort` on this board: the processor drives STEP and DIR, and one task makes the steps of all axes.

use embassy_rp::Peri;
use embassy_rp::gpio::{AnyPin, Level, Output};
use embassy_rp::pac::SIO;
use embassy_time::Duration;
use embedded_hal::delay::DelayNs;
use isostep_motion::{AXES, DriverTiming, GangedMotor, MotorPins, Motors, TimerBank, TimerPort};

use crate::chip::{CLOCK_HZ, DELAY_ROUND_CYCLES};
use crate::pins::{self, StepPins};
use crate::priority;

pub type Port = TimerPort<'static>;

static BANK: TimerBank<AXES> = TimerBank::new();

/// From the timer's alarm to the task's first reading of the clock takes 6 us, plus most of the time for which others
/// mask interrupts. That makes up to 9 us, and more if other tasks' times come just before. A margin that is always enough
/// would leave too little time for everything else.
const WAKE_UP: Duration = Duration::from_micros(10);

/// The ports of all axes, at rest, with STEP and DIR low.
pub fn open(pins: StepPins, timing: DriverTiming) -> [Port; AXES] {
    let (step, dir) = (pins.step, pins.dir);
    let outputs: [[Peri<'static, AnyPin>; 2]; pins::MOTORS] = [
        [step.0.into(), dir.0.into()],
        [step.1.into(), dir.1.into()],
        [step.2.into(), dir.2.into()],
        [step.3.into(), dir.3.into()],
        #[cfg(five_motors)]
        [step.4.into(), dir.4.into()],
    ];
    for pin in outputs.into_iter().flatten() {
        // Never dropped: dropping it would release the pin.
        core::mem::forget(Output::new(pin, Level::Low));
    }
    priority::start_step_executor().spawn(drive(core::array::from_fn(AxisPins::new)).unwrap());
    BANK.ports(timing, INHIBITS)
}

#[embassy_executor::task]
async fn drive(pins: [AxisPins; AXES]) -> ! {
    BANK.drive(pins, CoreDelay, WAKE_UP).await
}

const INHIBITS: [fn(bool); AXES] = [
    inhibit::<0>,
    inhibit::<1>,
    inhibit::<2>,
    #[cfg(feature = "four-axes")]
    inhibit::<3>,
];

fn inhibit<const AXIS: usize>(engaged: bool) {
    BANK.inhibit(AXIS, engaged);
}

/// Engages the inhibits of all axes.
pub fn inhibit_all() {
    (0..AXES).for_each(|axis| BANK.inhibit(axis, true));
}

/// STEP and DIR of an axis's motors, as masks of SIO: one write sets both of a kind.
struct AxisPins {
    axis: usize,
    /// STEP of the motors that move in the run.
    step: u32,
    /// DIR of the motors whose level is that of the words, and of one whose level is the other.
    dir: u32,
    dir_inverted: u32,
    dir_high: bool,
}

impl AxisPins {
    fn new(axis: usize) -> Self {
        Self { axis, step: step(axis), dir: dir(axis), dir_inverted: 0, dir_high: false }
    }
}

impl MotorPins for AxisPins {
    fn begin(&mut self, motors: &Motors) {
        let of = |ganged: GangedMotor, index: usize| if motors.moves(ganged) { step(index) } else { 0 };
        self.step = of(GangedMotor::First, self.axis) | of(GangedMotor::Second, pins::SECOND);
        (self.dir, self.dir_inverted) = match motors.second {
            None => (dir(self.axis), 0),
            Some(_) if motors.is_second_inverted() => (dir(self.axis), dir(pins::SECOND)),
            Some(_) => (dir(self.axis) | dir(pins::SECOND), 0),
        };
        self.set_dir(self.dir_high);
    }

    #[inline(always)]
    fn set_step(&mut self, high: bool) {
        set(self.step, high);
    }

    #[inline(always)]
    fn set_dir(&mut self, high: bool) {
        self.dir_high = high;
        set(self.dir, high);
        set(self.dir_inverted, !high);
    }
}

fn step(motor: usize) -> u32 {
    1 << pins::step(motor)
}

fn dir(motor: usize) -> u32 {
    1 << pins::dir(motor)
}

#[inline(always)]
fn set(mask: u32, high: bool) {
    let latch = SIO.gpio_out(0);
    if high { latch.value_set().write_value(mask) } else { latch.value_clr().write_value(mask) }
}

/// A delay that blocks, for the width of a pulse.
#[derive(Debug)]
struct CoreDelay;

impl DelayNs for CoreDelay {
    fn delay_ns(&mut self, ns: u32) {
        // `delay(n)` makes n + 1 rounds. The rounds of a nanosecond are rounded up in 16 bits behind the point: an RP2040, whose
        // rounds last 24 ns, makes one for each 23.997 ns. So the delay is never too short and needs no division, for which a
        // Cortex-M0+ has no instruction.
        const ROUNDS_PER_NS: u32 = ((CLOCK_HZ / 1_000_000) << 16).div_ceil(1_000 * DELAY_ROUND_CYCLES);
        const LONGEST_NS: u32 = u32::MAX / ROUNDS_PER_NS;
        let mut left_ns = ns;
        while left_ns > LONGEST_NS {
            cortex_m::asm::delay((LONGEST_NS * ROUNDS_PER_NS) >> 16);
            left_ns -= LONGEST_NS;
        }
        cortex_m::asm::delay((left_ns * ROUNDS_PER_NS) >> 16);
    }
}
