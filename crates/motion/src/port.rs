//! How an instant becomes an edge.

use core::sync::atomic::{AtomicI32, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::Duration;
use isostep_profile::Segment;

use crate::start_line::StartLine;

/// Which way an axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The position grows. DIR is high, unless the axis is inverted.
    Positive,
    /// The position shrinks. DIR is low.
    Negative,
}

impl Direction {
    /// Of a signed number of steps; zero is positive.
    #[must_use]
    pub fn of(steps: i32) -> Self {
        if steps < 0 { Self::Negative } else { Self::Positive }
    }

    /// 1 or -1.
    #[must_use]
    pub fn sign(self) -> i32 {
        match self {
            Self::Positive => 1,
            Self::Negative => -1,
        }
    }
}

/// What a stepper driver needs of its inputs, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriverTiming {
    /// STEP stays high at least this long.
    pub step_high_ns: u32,
    /// STEP stays low at least this long.
    pub step_low_ns: u32,
    /// From one rise of STEP to the next, at least.
    pub period_ns: u32,
    /// DIR and ENABLE are steady this long before STEP rises, and after.
    pub setup_ns: u32,
}

impl DriverTiming {
    /// TI DRV8825 datasheet (SLVSA73F), timing requirements: t_WH = t_WL = 1.9 us, f_STEP = 250 kHz, t_SU = t_H = 650 ns.
    pub const DRV8825: Self = Self { step_high_ns: 1_900, step_low_ns: 1_900, period_ns: 4_000, setup_ns: 650 };

    /// Trinamic TMC2209 datasheet, STEP/DIR interface timing: 100 ns high and low (the input filter's), or a period of
    /// its 12 MHz clock and 20 ns more: 104 ns; DIR 20 ns before and after.
    pub const TMC2209: Self = Self { step_high_ns: 104, step_low_ns: 104, period_ns: 208, setup_ns: 20 };
}

/// How a driver is wired and configured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wiring {
    /// DIR is low for positive.
    pub direction_inverted: bool,
    /// STEP stays high this long, or as long as the driver's own timing asks if that is longer, ns.
    pub pulse_ns: u32,
}

/// What a port can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// Its time resolution, Hz.
    pub tick_hz: u32,
    /// What the driver behind it needs.
    pub timing: DriverTiming,
    /// What the port itself needs between two rises beyond what the driver does, ticks.
    pub margin_ticks: u32,
    /// From the end of a pulse to a change of DIR that the next step asks for, at most, ticks; what the pulse is longer
    /// than asked for is part of it.
    pub turn_ticks: u32,
}

impl Capabilities {
    /// How long STEP stays high with this wiring, ns: never shorter than the driver needs, and than DIR is to be held, so
    /// that it may change as soon as a pulse is over.
    #[must_use]
    pub fn pulse_ns(&self, wiring: Wiring) -> u32 {
        self.timing.step_high_ns.max(self.timing.setup_ns).max(wiring.pulse_ns)
    }

    /// Highest step rate that pulse, low time, period and a reversal leave room for with this wiring, steps/s.
    #[must_use]
    pub fn rate_max_steps_s(&self, wiring: Wiring) -> u32 {
        self.tick_hz / self.period_min_ticks(wiring)
    }

    /// From one rise of STEP to the next, in the same direction or the other, at least, ticks.
    #[must_use]
    pub fn period_min_ticks(&self, wiring: Wiring) -> u32 {
        let pulse_ns = self.pulse_ns(wiring);
        let period_ns = self.timing.period_ns.max(pulse_ns + self.timing.step_low_ns);
        let ticks = |ns| ticks_covering(ns, self.tick_hz);
        let reversal_ticks = ticks(pulse_ns + self.timing.setup_ns) + self.turn_ticks;
        ticks(period_ns).max(reversal_ticks) + self.margin_ticks
    }
}

/// The fewest ticks of `tick_hz` that cover `ns`.
#[must_use]
pub fn ticks_covering(ns: u32, tick_hz: u32) -> u32 {
    // Of two 32-bit numbers, over 10^9: it fits for whatever is shorter than a second.
    (u64::from(ns) * u64::from(tick_hz)).div_ceil(1_000_000_000) as u32
}

/// The exact count of an axis's emitted steps: the machine's position.
///
/// Only the port that emits a step counts it, at the rising edge; anyone may read.
#[derive(Debug, Default)]
pub struct Odometer {
    position_steps: AtomicI32,
}

impl Odometer {
    /// At zero.
    #[must_use]
    pub const fn new() -> Self {
        Self { position_steps: AtomicI32::new(0) }
    }

    /// Where the axis stands, steps.
    #[must_use]
    pub fn position_steps(&self) -> i32 {
        self.position_steps.load(Ordering::Relaxed)
    }

    /// Counts one step. For ports.
    pub fn count(&self, direction: Direction) {
        self.advance(direction.sign());
    }

    /// Counts steps that have risen: those in the positive direction, less those in the negative. For ports.
    pub fn advance(&self, steps: i32) {
        // One writer, so load and store need no atomic read-modify-write, which a Cortex-M0+ lacks.
        let position = self.position_steps.load(Ordering::Relaxed);
        self.position_steps.store(position.wrapping_add(steps), Ordering::Relaxed);
    }

    /// Makes the place where the axis rests its zero.
    pub(crate) fn zero(&self) {
        self.position_steps.store(0, Ordering::Relaxed);
    }
}

/// Segments queued per axis: 30 ms of a thousand short moves a second, of which each is a segment.
const QUEUE_SEGMENTS: usize = 32;

/// What a port is given, in order.
#[derive(Clone, Copy, Debug)]
pub enum StreamItem {
    /// The next steps, all in one direction. The first of them rises as long after the step before, whichever way that
    /// went, as [`Capabilities::period_min_ticks`] says, at least.
    Steps {
        /// When.
        segment: Segment,
        /// Which way.
        direction: Direction,
    },
    /// No step until then, ticks from the start of the run: a port that must know what follows need not be told of a step
    /// long before it is due, which then may never come.
    Rest {
        /// Until when; before the next step by as long as a step takes, at least.
        until_ticks: u64,
    },
    /// No step any more: the run ends with those before. Every run ends so, unless it is stopped.
    End,
}

/// An axis's steps on their way to its port.
pub type SegmentQueue = Channel<CriticalSectionRawMutex, StreamItem, QUEUE_SEGMENTS>;

/// An axis's part of a run, from standstill to standstill: it may turn on its way, and may have no step at all.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// How the driver is wired.
    pub wiring: Wiring,
}

/// Why a port stopped before its last step. Every step that rose is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PortFault {
    /// A step would have left so late that catching up would ask for speed the plan does not have.
    Late {
        /// How late it was.
        late: Duration,
        /// The latest that is still emitted.
        max: Duration,
    },
    /// The port had emitted all it was given before it was given more. Nothing was stretched: no step rose after that.
    Underrun,
    /// Steps are closer than pulse and low time allow, ticks. The step did not rise.
    TooFast {
        /// From one step to the next.
        interval: u32,
        /// The shortest that works.
        min: u32,
    },
}

/// Engages (`true`) or releases the brake of a port.
///
/// Engaged, no further step rises, from that instant and for as long as it is; a pulse that has begun is finished. It
/// may be called in any context, interrupts included.
pub type Brake = fn(engaged: bool);

/// Makes the step edges of one axis.
#[allow(async_fn_in_trait, reason = "ports stay on the executor that polls them: no Send bound is wanted")]
pub trait StepPort {
    /// What this port can do.
    fn capabilities(&self) -> Capabilities;

    /// For a port whose edges do not wait for its task; one whose do stops with the task and needs none.
    fn brake(&self) -> Brake {
        |_engaged| {}
    }

    /// Waits for the first of `segments` and gets ready for it. Then it waits at the `start_line`; let go, it begins at an
    /// instant that it can keep, and says which: DIR's set-up time is over before the first step, however soon that is. It
    /// emits the steps as `segments` has them, each at its instant from that start, and turns DIR between those of
    /// different directions: after the hold time, and the set-up time ahead. It returns after [`StreamItem::End`], when the last
    /// has risen. Each is counted in `odometer`; at the latest when this ends the count is exact.
    ///
    /// # Errors
    /// No step rises after a fault.
    ///
    /// # Cancellation
    /// Safe: no further step rises, none is cut short, and the count is exact.
    async fn run(
        &mut self,
        run: Run,
        start_line: &StartLine,
        segments: &SegmentQueue,
        odometer: &Odometer,
    ) -> Result<(), PortFault>;
}
