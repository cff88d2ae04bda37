//! How an instant becomes an edge.

use core::sync::atomic::{AtomicI32, Ordering};

use embassy_time::{Duration, Instant};
use isostep_profile::Segment;

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
    /// DIR and ENABLE are steady this long before STEP rises, and after.
    pub setup_ns: u32,
}

impl DriverTiming {
    /// TI DRV8825 datasheet (SLVSA73F), timing requirements: t_WH = t_WL = 1.9 us, t_SU = t_H = 650 ns.
    pub const DRV8825: Self = Self { step_high_ns: 1_900, step_low_ns: 1_900, setup_ns: 650 };
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
    /// Highest step rate its pulse and low times leave room for, steps/s.
    pub rate_max_steps_s: u32,
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
        // One writer, so load and store need no atomic read-modify-write, which a Cortex-M0+ lacks.
        let position = self.position_steps.load(Ordering::Relaxed);
        self.position_steps.store(position.wrapping_add(direction.sign()), Ordering::Relaxed);
    }

    /// Makes the place where the axis rests its zero.
    pub(crate) fn zero(&self) {
        self.position_steps.store(0, Ordering::Relaxed);
    }
}

/// Why a port stopped emitting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortFault {
    /// A step would have left so late that catching up would ask for speed the plan does not have.
    Late {
        /// How late it was.
        late: Duration,
        /// The latest that is still emitted.
        max: Duration,
    },
}

/// Makes the step edges of one axis.
#[allow(async_fn_in_trait, reason = "ports stay on the executor that polls them: no Send bound is wanted")]
pub trait StepPort {
    /// What this port can do.
    fn capabilities(&self) -> Capabilities;

    /// Sets DIR and takes over the pulse width; the next step waits for the set-up time.
    fn prepare(&mut self, direction: Direction, wiring: Wiring);

    /// Emits the steps of `segment`, each at its instant from `start`, and counts each in `odometer` as it rises.
    ///
    /// # Errors
    /// A step that is too late is not emitted, nor any after it; the count is exact.
    ///
    /// # Cancellation
    /// Safe: no further step rises, none is cut short, and the count is exact.
    async fn emit(&mut self, start: Instant, segment: Segment, odometer: &Odometer) -> Result<(), PortFault>;
}
