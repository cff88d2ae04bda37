//! Step ports that share one task, which awaits `Timer::at` and toggles pins.
//!
//! # Design
//! ```text
//! axis task: TimerPort --request, segments, barrier--> TimerBank --> TimerBank::drive: STEP and DIR of all axes
//!                      <---start, count, end-----
//! ```
//! Waking a task costs far more than making a step. So the ports of a machine share a [`TimerBank`], and one task, at a
//! higher priority than the axis tasks, makes the edges of all axes: steps due on the same tick rise together, for one
//! wake-up.
//!
//! The axes of a run wait at the bank's start barrier, with their first steps loaded. When the driving task finds the start
//! barrier open it chooses the start instant: the earliest at which it can make a step.
//!
//! DIR changes when an axis goes on to a segment of the other direction. It changes after the pulse of the last step,
//! which lasts at least as long as DIR has to be held. The next step then waits for the set-up time.
//!
//! # Deadline
//! A step is due at its tick. The driving task wakes up early, by the time that a wake-up takes, and waits for the step
//! without sleeping. So a delayed wake-up delays no edge. If the next step is nearer than a wake-up takes, the task
//! does not sleep at all. What has come for other axes waits until a step that is near is made. A late step makes no
//! later step late, because the next instant comes from the profile. Beyond half a period at the axis's top speed
//! lateness is a fault, because the steps behind would be bunched. So is a step that is not known by then. Where the
//! top speed is more than the processor's time for a step allows, it is half of that time. After a fault no axis of the
//! bank makes another step.
//!
//! # Where the steps are
//! In one critical section the driving task checks whether a step may rise, raises it and counts it. So an inhibit or a
//! dropped run stops the edges at once, and the count is exact. During a run the step counter follows that count at least
//! every [`REPORT_EVERY`].

mod bank;
mod drive;
mod pins;

use core::array;
use core::cell::Cell;
use core::convert::Infallible;
use core::future::pending;

use embassy_futures::select::{Either4, select4};
use embassy_time::{Duration, Timer};

pub use self::bank::TimerBank;
use self::bank::{Flag, Mailbox, RunRequest, WakeSignal};
pub use self::pins::MotorPins;
use crate::clock::TICK_HZ;
use crate::port::{
    Capabilities, DriverTiming, Inhibit, Motors, PortFault, Run, StepCounter, StepPort, StreamItem, StreamQueue,
    ticks_covering,
};
use crate::start_barrier::StartBarrier;

/// Processor time for a step beside its pulse, ns. An RP2040 of 125 MHz needs some 22,000 in long moves (one axis, pulses
/// of 0.1, 2 and 5 us: 46,000, 41,000 and 36,000 steps/s). The rest is for the tasks that feed the port, which need
/// most on ramps. Short moves are slowed by the time for planning them, too.
const CORE_NS: u32 = 26_000;
/// As much more for each axis beyond three: the task that makes the steps looks at all of them. With four axes some
/// 26,000 ns are needed.
const CORE_NS_PER_AXIS: u32 = 5_000;
/// The step counter is at most this much behind.
const REPORT_EVERY: Duration = Duration::from_millis(10);
/// Each axis reports more often than the one before it, by this difference. Otherwise all of their timers would expire
/// at once, again and again, and a step that is due just then would have to wait until all are woken.
const STAGGER: Duration = Duration::from_micros(300);

/// One axis of a [`TimerBank`].
///
/// The quality of its steps is up to the processor and the clock:
/// - An edge is late by up to a tick of the clock, by what interrupts of a higher priority take, and by what is made for
///   other axes that are due within microseconds. A step that is later than half a period at its axis's top speed is a
///   fault ([`PortFault::Late`]). Where steps cannot be as close as that speed asks, because each takes the processor 26 us
///   and its pulse, it is later than half of that.
/// - A pulse lasts at least as long as is asked for ([`Wiring::pulse_ns`](crate::Wiring)), which the processor waits for:
///   long pulses make moves slower. It lasts longer by an interrupt that comes meanwhile, and by steps of other axes.
/// - The processor's time for a step is measured on an RP2040 of 125 MHz. A slower processor is late by it.
pub struct TimerPort<'a> {
    mailbox: &'a Mailbox,
    wake: &'a WakeSignal,
    barrier: &'a Flag,
    capabilities: Capabilities,
    inhibit: Inhibit,
    report_every: Duration,
}

impl<const N: usize> TimerBank<N> {
    /// The ports, for drivers that need `timing`. Each inhibit has to call [`TimerBank::inhibit`] for its axis. It may do
    /// nothing if no edge can be made between a stop and the axis task's answer to it.
    pub fn ports(&self, timing: DriverTiming, inhibits: [Inhibit; N]) -> [TimerPort<'_>; N] {
        // A reading of the clock may be almost a tick old, hence the margin of one tick. DIR changes when the pulse
        // ends.
        let core_ns = CORE_NS + CORE_NS_PER_AXIS * (N as u32).saturating_sub(3);
        let capabilities = Capabilities { margin_ticks: 1, core_ns, ..Capabilities::new(TICK_HZ, timing) };
        let (wake, barrier) = (&self.wake, &self.barrier);
        let mut report_every = REPORT_EVERY;
        array::from_fn(|axis| {
            report_every -= STAGGER;
            TimerPort {
                mailbox: &self.mailboxes[axis],
                wake,
                barrier,
                capabilities,
                inhibit: inhibits[axis],
                report_every,
            }
        })
    }
}

impl TimerPort<'_> {
    fn request(&self, motors: Motors) -> RunRequest {
        let Capabilities { timing, margin_ticks, core_ns, .. } = self.capabilities;
        let ticks = |ns| Duration::from_ticks((ticks_covering(ns, TICK_HZ) + margin_ticks).into());
        let pulse_ns = self.capabilities.pulse_ns(motors.wiring);
        let period_ns = (1_000_000_000 / motors.top_speed_steps_s.max(1)).max(core_ns + pulse_ns);
        RunRequest {
            motors,
            setup: ticks(timing.setup_ns),
            pulse_ns,
            pulse: ticks(pulse_ns),
            late_max: Duration::from_ticks(ticks_covering(period_ns / 2, TICK_HZ).into()),
            low_min: ticks(timing.step_low_ns.max(timing.period_ns.saturating_sub(pulse_ns))),
        }
    }
}

impl StepPort for TimerPort<'_> {
    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    fn inhibit(&self) -> Inhibit {
        self.inhibit
    }

    async fn run(&mut self, run: Run<'_>) -> Result<(), PortFault> {
        let Run { motors, start_barrier, segments, step_counter } = run;
        let active = ActiveRun::new(self, motors, step_counter);
        let first = segments.receive().await;
        self.hand_over(first).await;
        // The start is polled first: a short run may have ended before that poll.
        match select4(self.start(start_barrier), self.mailbox.end(), self.hand_over_all(segments), active.report())
            .await
        {
            Either4::Second(result) => result,
            Either4::First(never) | Either4::Third(never) | Either4::Fourth(never) => match never {},
        }
    }
}

impl TimerPort<'_> {
    /// Waits to start with the other axes, and reports the start instant.
    async fn start(&self, start_barrier: &StartBarrier) -> Infallible {
        start_barrier.armed().await;
        // Another axis may have opened the start barrier for all.
        if !self.mailbox.has_begun() {
            self.barrier.set();
            self.wake.ring();
        }
        start_barrier.begun(self.mailbox.begun().await);
        pending().await
    }

    /// Hands over the stream items of the run, until it ends.
    async fn hand_over_all(&self, segments: &StreamQueue) -> Infallible {
        loop {
            self.hand_over(segments.receive().await).await;
        }
    }

    async fn hand_over(&self, item: StreamItem) {
        loop {
            let (taken, wanted) = self.mailbox.offer(item);
            if wanted {
                self.wake.ring();
            }
            if taken {
                return;
            }
            self.mailbox.room().await;
        }
    }
}

/// A run that the driving task makes. When this is dropped the run is over: no further step rises, and all that rose
/// are counted.
struct ActiveRun<'a> {
    mailbox: &'a Mailbox,
    step_counter: &'a StepCounter,
    report_every: Duration,
    /// Steps of the run that the step counter has counted, positive minus negative.
    counted: Cell<i32>,
}

impl<'a> ActiveRun<'a> {
    fn new(port: &TimerPort<'a>, motors: Motors, step_counter: &'a StepCounter) -> Self {
        port.mailbox.ask(port.request(motors));
        port.wake.ring();
        Self { mailbox: port.mailbox, step_counter, report_every: port.report_every, counted: Cell::new(0) }
    }

    async fn report(&self) -> Infallible {
        loop {
            Timer::after(self.report_every).await;
            self.count();
        }
    }

    fn count(&self) {
        let travelled = self.mailbox.travelled();
        self.step_counter.advance(travelled.wrapping_sub(self.counted.replace(travelled)));
    }
}

impl Drop for ActiveRun<'_> {
    fn drop(&mut self) {
        self.mailbox.close();
        self.count();
    }
}
