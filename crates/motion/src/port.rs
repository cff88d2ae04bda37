//! Step ports: how an instant becomes an edge.

use core::sync::atomic::{AtomicI32, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::Duration;
use isostep_profile::Segment;

use crate::motor::{GangedMotor, SecondMotor};
use crate::start_barrier::StartBarrier;

/// The direction in which an axis moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// The position grows. DIR is high, unless the axis is inverted.
    Positive,
    /// The position shrinks. DIR is low.
    Negative,
}

impl Direction {
    /// The direction of a signed number of steps; zero counts as positive.
    #[must_use]
    pub fn of(steps: i32) -> Self {
        if steps < 0 { Self::Negative } else { Self::Positive }
    }

    /// The other one.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Positive => Self::Negative,
            Self::Negative => Self::Positive,
        }
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

/// The timing that a stepper driver requires at its inputs, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriverTiming {
    /// STEP stays high at least this long.
    pub step_high_ns: u32,
    /// STEP stays low at least this long.
    pub step_low_ns: u32,
    /// Shortest time from one rise of STEP to the next.
    pub period_ns: u32,
    /// DIR and ENABLE are steady this long before STEP rises, and after.
    pub setup_ns: u32,
}

impl DriverTiming {
    /// TI DRV8825 datasheet (SLVSA73F), timing requirements: t_WH = t_WL = 1.9 us, f_STEP = 250 kHz, t_SU = t_H = 650
    /// ns.
    pub const DRV8825: Self = Self { step_high_ns: 1_900, step_low_ns: 1_900, period_ns: 4_000, setup_ns: 650 };

    /// Trinamic TMC2209 datasheet, STEP/DIR interface timing: STEP is high and low for 100 ns each (the input filter's
    /// time) or for a period of the 12 MHz clock plus 20 ns (104 ns), whichever is longer. DIR is steady 20 ns before
    /// and after.
    pub const TMC2209: Self = Self { step_high_ns: 104, step_low_ns: 104, period_ns: 208, setup_ns: 20 };
}

/// The wiring and configuration of a driver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wiring {
    /// DIR is low for the positive direction.
    pub direction_inverted: bool,
    /// STEP stays high this long, ns, or as long as the driver's own timing requires if that is longer.
    pub pulse_ns: u32,
}

/// The capabilities of a port. Others are made from [`new`](Self::new) by setting fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Capabilities {
    /// Its time resolution, Hz.
    pub tick_hz: u32,
    /// The timing that the driver behind it needs.
    pub timing: DriverTiming,
    /// Time that the port itself needs between two rises, in addition to what the driver needs, ticks.
    pub margin_ticks: u32,
    /// Processor time for a step, ns, in addition to that for its pulse; 0 if hardware makes the steps. Moves are made
    /// so slowly that this time is there.
    pub core_ns: u32,
    /// Longest time from the end of a pulse until the port changes DIR for the next step, ticks. If the port makes a
    /// pulse longer than asked for, the extra time is part of it.
    pub turn_ticks: u32,
}

impl Capabilities {
    /// A port whose edges hardware makes at once: no margin, no time of the processor, none to turn.
    #[must_use]
    pub const fn new(tick_hz: u32, timing: DriverTiming) -> Self {
        Self { tick_hz, timing, margin_ticks: 0, core_ns: 0, turn_ticks: 0 }
    }

    /// The time for which STEP stays high with this wiring, ns. It is never shorter than the driver's minimum or than DIR's hold
    /// time, so DIR may change as soon as a pulse is over.
    #[must_use]
    pub fn pulse_ns(&self, wiring: Wiring) -> u32 {
        self.timing.step_high_ns.max(self.timing.setup_ns).max(wiring.pulse_ns)
    }

    /// Highest step rate with this wiring that leaves room for pulse, low time, period and a reversal, steps/s.
    #[must_use]
    pub fn rate_max_steps_s(&self, wiring: Wiring) -> u32 {
        self.tick_hz / self.period_min_ticks(wiring)
    }

    /// Shortest time from one rise of STEP to the next, in the same direction or the other, ticks.
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
    // The product of two 32-bit numbers fits 64 bits, and the quotient fits 32 bits for every time shorter than a
    // second.
    (u64::from(ns) * u64::from(tick_hz)).div_ceil(1_000_000_000) as u32
}

/// The exact count of an axis's emitted steps: the machine's position.
///
/// Only the port that emits a step counts it, at the rising edge; anyone may read.
#[derive(Debug, Default)]
pub struct StepCounter {
    position_steps: AtomicI32,
}

impl StepCounter {
    /// A step counter at zero.
    #[must_use]
    pub const fn new() -> Self {
        Self { position_steps: AtomicI32::new(0) }
    }

    /// The place where the axis stands, steps.
    #[must_use]
    pub fn position_steps(&self) -> i32 {
        self.position_steps.load(Ordering::Relaxed)
    }

    /// Counts one step. For ports.
    pub fn count(&self, direction: Direction) {
        self.advance(direction.sign());
    }

    /// Adds steps that have risen: those in the positive direction minus those in the negative direction. For ports.
    pub fn advance(&self, steps: i32) {
        // There is one writer only, so a load and a store are enough. An atomic read-modify-write is not needed, and a
        // Cortex-M0+ has none.
        let position = self.position_steps.load(Ordering::Relaxed);
        self.position_steps.store(position.wrapping_add(steps), Ordering::Relaxed);
    }

    /// Makes the place where the motor stands this one.
    pub(crate) fn set(&self, position_steps: i32) {
        self.position_steps.store(position_steps, Ordering::Relaxed);
    }
}

/// Segments queued per axis: enough for 30 ms of a thousand short moves a second, each of which is one segment.
const QUEUE_SEGMENTS: usize = 32;

/// An item of the stream that a port is given, in order.
#[derive(Clone, Copy, Debug)]
pub enum StreamItem {
    /// The next steps, all in one direction. The first of them is due at least [`Capabilities::period_min_ticks`] after
    /// the step before, whichever direction that step had.
    Steps {
        /// The instant at which the steps are due.
        segment: Segment,
        /// Their direction.
        direction: Direction,
    },
    /// There is no step until this instant. Some ports must know what comes next. With rests, such a port need not be
    /// given a step long before it is due: a step that it has not been given can still be changed or cancelled.
    Rest {
        /// The instant at which the rest ends, ticks from the start of the run: at least one shortest step period before the
        /// next step.
        until_ticks: u64,
    },
    /// There are no more steps: the run ends with the steps before this item. Every run ends with it, unless it is
    /// stopped.
    End,
}

/// The queue of stream items for an axis's port.
pub type StreamQueue = Channel<CriticalSectionRawMutex, StreamItem, QUEUE_SEGMENTS>;

/// The motors of an axis in a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motors {
    /// The wiring of their drivers.
    pub wiring: Wiring,
    /// The highest speed of the axis by its limits, steps/s, rounded up. A step that is late by less than half a period
    /// at that speed bunches none.
    pub top_speed_steps_s: u32,
    /// The second one, if there is one.
    pub second: Option<SecondMotor>,
}

impl Motors {
    /// True if this ganged motor makes the steps.
    #[must_use]
    pub fn moves(&self, ganged: GangedMotor) -> bool {
        match self.second {
            None => ganged == GangedMotor::First,
            Some(second) => second.held != Some(ganged),
        }
    }

    /// The second motor's DIR has the other level than the first's.
    #[must_use]
    pub fn is_second_inverted(&self) -> bool {
        self.second.is_some_and(|second| second.direction_inverted)
    }
}

/// A run, as one axis's port is asked for it, from standstill to standstill. The axis may reverse in it, and may have
/// no step at all.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Run<'a> {
    /// The motors that make the steps.
    pub motors: Motors,
    /// The line at which the port waits for its start, with those of the other axes.
    pub start_barrier: &'a StartBarrier,
    /// The items that it is to make, in order.
    pub segments: &'a StreamQueue,
    /// The place where it counts the steps.
    pub step_counter: &'a StepCounter,
}

impl<'a> Run<'a> {
    /// A run, for whoever tests a port.
    #[must_use]
    pub fn new(
        motors: Motors,
        start_barrier: &'a StartBarrier,
        segments: &'a StreamQueue,
        step_counter: &'a StepCounter,
    ) -> Self {
        Self { motors, start_barrier, segments, step_counter }
    }
}

/// Why a port stopped before its last step. Every step that rose is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PortFault {
    /// A step would have risen so late that catching up would need a higher speed than the plan has.
    Late {
        /// The delay.
        late: Duration,
        /// The greatest lateness at which a step is still made.
        max: Duration,
    },
    /// The port had made all the steps that it was given before it was given more. No interval was stretched: no step
    /// rose after that.
    Underrun,
    /// Two steps are closer together than pulse and low time allow, ticks. The second one did not rise.
    TooFast {
        /// From one step to the next.
        interval: u32,
        /// The shortest that works.
        min: u32,
    },
    /// It started at another instant than the port of the first axis.
    Apart {
        /// The time between them.
        by: Duration,
    },
}

/// Engages (`true`) or releases the inhibit of a port.
///
/// From the instant at which it is engaged until it is released no further step rises; a pulse that has begun is
/// finished. It may be called in any context, interrupts included.
pub type Inhibit = fn(engaged: bool);

/// Makes the step edges of one axis, for its motor or for both.
#[allow(async_fn_in_trait, reason = "ports stay on the executor that polls them: no Send bound is wanted")]
pub trait StepPort {
    /// The capabilities of this port.
    fn capabilities(&self) -> Capabilities;

    /// The inhibit of this port. It is for a port that makes edges without waiting for its task. A port whose edges wait
    /// for its task stops when the task does, and needs no inhibit.
    fn inhibit(&self) -> Inhibit {
        |_engaged| {}
    }

    /// Waits for the first of the run's segments and gets ready for it, then waits at the start barrier. When it is let go,
    /// it starts at an instant that it can keep, and reports that instant. DIR's set-up time is over before the first
    /// step, however soon that step is due.
    ///
    /// The ports of all axes have to start at the same instant, to the tick of the machine's clock, although their tasks
    /// go on one after the other; otherwise the machine stops with [`PortFault::Apart`]. So the instant comes from one
    /// place: from a flag that the ports have in common, or from the start barrier, which tells all of them when they were
    /// let go ([`StartBarrier::armed`]).
    ///
    /// It makes the steps of `segments`, each at its instant counted from the start. Between steps of different
    /// directions it changes DIR, when the hold time is over and with the set-up time left before the next step. It
    /// returns after [`StreamItem::End`], when the last step has risen. It counts every step in the step counter; when it
    /// returns, at the latest, the count is exact.
    ///
    /// With a second motor, each step rises at the same instant for both, and is one step of the axis. If one motor is
    /// held, its STEP stays low, and its DIR may change.
    ///
    /// # Errors
    /// No step rises after a fault.
    ///
    /// # Cancellation
    /// Safe: no further step rises, no pulse is cut short, and the count is exact.
    async fn run(&mut self, run: Run<'_>) -> Result<(), PortFault>;
}
