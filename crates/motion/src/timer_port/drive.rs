//! The task that makes the edges of a bank.

use embassy_futures::select::select;
use embassy_time::{Duration, Instant, Timer};
use embedded_hal::delay::DelayNs;
use isostep_profile::Ticks;

use super::bank::{Flag, Mailbox, RunRequest, TimerBank, WakeSignal};
use super::pins::MotorPins;
use crate::port::{Direction, PortFault, StreamItem};

/// Time between two readings of the clock while waiting for a step, ns.
const LOOK_EVERY_NS: u32 = 50;
/// Time between two readings of the clock during a pulse, ns. A tick is a multiple of it.
const PULSE_SLICE_NS: u32 = 250;

/// The next rise of an axis that has no step to make, ticks.
const NEVER: u64 = u64::MAX;
/// The start instant of a run for as long as it waits at the start barrier, ticks. It is so late that no instant of the run
/// comes before the run has started.
const AT_BARRIER: u64 = u64::MAX / 2;

impl<const N: usize> TimerBank<N> {
    /// Makes the edges of all axes on their pins for ever. `delay` blocks for the width of a pulse.
    /// `wake_up` is the time that a wake-up of this task takes, including everything that may delay it; the task wakes
    /// up that long before a step is due. Spawn it at a higher priority than the tasks of the axes and of the tool, for which a
    /// step would wait. While steps are closer together than `wake_up` it does not sleep, and no task of a lower priority runs.
    ///
    /// # Cancellation
    /// Dropping it stops all axes at once. No pulse is cut short, and the counts are exact. The runs then wait for
    /// ever.
    pub async fn drive<P, W>(&self, pins: [P; N], delay: W, wake_up: Duration) -> !
    where
        P: MotorPins,
        W: DelayNs,
    {
        let mut axes = 0..N;
        let drives = pins.map(|pins| AxisDrive::new(&self.mailboxes[axes.next().unwrap_or_default()], pins));
        let wake_up_ticks = wake_up.as_ticks();
        let mut drive =
            Drive { wake: &self.wake, barrier: &self.barrier, wake_up: wake_up_ticks, late_max: NEVER, drives, delay };
        loop {
            drive.look();
            let at = drive.next_rise();
            let wake_at = at.saturating_sub(wake_up_ticks);
            let is_near = || wake_at <= Instant::now().as_ticks();
            if !is_near() {
                if at >= AT_BARRIER {
                    self.wake.wait().await;
                } else {
                    select(Timer::at(Instant::from_ticks(wake_at)), self.wake.wait()).await;
                }
                // What has come is looked at now or behind the step that is near: before it, the step would be late by that.
                if !is_near() {
                    continue;
                }
            }
            drive.step(at);
        }
    }
}

struct Drive<'a, P, W, const N: usize> {
    wake: &'a WakeSignal,
    barrier: &'a Flag,
    /// Time that a wake-up takes, ticks.
    wake_up: u64,
    /// The least lateness that is a fault of some axis, ticks.
    late_max: u64,
    drives: [AxisDrive<'a, P>; N],
    delay: W,
}

/// One axis's pins and what it is to do next. Instants are in ticks since power-up.
struct AxisDrive<'a, P> {
    mailbox: &'a Mailbox,
    pins: P,
    dir_high: bool,
    /// The instants of the segment under way.
    ticks: Option<Ticks>,
    /// The direction of that segment: 1 or -1.
    sign: i32,
    /// The instant from which segments count; [`AT_BARRIER`] until the run starts.
    start: u64,
    /// The instant at which the next step is due; or, while the next item is not there yet, up to when it is known that none is.
    due: u64,
    /// The instant at which the next step rises: when it is due, or as soon as the driver can take it. While the next item is
    /// not there: when its first step would be too late.
    at: u64,
    /// The instant at which STEP may rise.
    ready: u64,
    /// A step later than this is a fault, ticks.
    late_max: u64,
    /// Shortest time from a fall of STEP to its next rise, ticks.
    low_min: u64,
    pulse: Pulse,
    direction_inverted: bool,
    /// Shortest time from a change of DIR to a rise of STEP, ticks.
    setup: u64,
    /// A run is under way, and more items of it are to come.
    has_run: bool,
    /// The next item is not there yet.
    waits: bool,
    level: StepLevel,
}

/// The time for which STEP stays high.
#[derive(Clone, Copy)]
struct Pulse {
    /// The rest of it, ns.
    ns: u32,
    /// No more than so many ticks from its beginning to its end.
    ticks: u64,
}

impl Pulse {
    const NONE: Self = Self { ns: 0, ticks: 0 };

    #[inline(always)]
    fn longer(self, other: Self) -> Self {
        if other.ns > self.ns { other } else { self }
    }
}

/// The level of STEP.
#[derive(Clone, Copy, PartialEq, Eq)]
enum StepLevel {
    Low,
    /// About to rise.
    Due,
    High,
}

impl<P, W, const N: usize> Drive<'_, P, W, N>
where
    P: MotorPins,
    W: DelayNs,
{
    /// Takes new run requests, goes on with runs that had no segment, and starts the runs at the start barrier once it opens.
    #[inline(always)]
    fn look(&mut self) {
        if self.wake.take() {
            self.drives.iter_mut().for_each(AxisDrive::look);
            self.late_max = self.drives.iter().fold(NEVER, |least, drive| least.min(drive.late_max));
            if self.barrier.take() {
                self.start();
            }
        }
    }

    /// Starts all runs that wait at the start barrier, at the first instant at which this task and all their drivers can make a
    /// step.
    #[inline(never)]
    fn start(&mut self) {
        let soonest = Instant::now().as_ticks() + self.wake_up;
        let start =
            self.drives.iter().filter(|drive| drive.is_at_barrier()).fold(soonest, |at, drive| at.max(drive.ready));
        self.drives.iter_mut().for_each(|drive| drive.start(start));
    }

    #[inline(always)]
    fn next_rise(&self) -> u64 {
        self.drives.iter().fold(NEVER, |earliest, drive| earliest.min(drive.at))
    }

    /// Waits until `at`, and makes the steps that are to rise then. A step that comes due during a pulse does not wait
    /// for the end of that pulse.
    #[inline(always)]
    fn step(&mut self, at: u64) {
        let oldest = self.call(at);
        let mut now = self.wait_until(at);
        let mut pulse = self.raise(now, oldest);
        loop {
            let slice_ns = if self.is_alone(pulse, now) { pulse.ns } else { PULSE_SLICE_NS };
            self.delay.delay_ns(slice_ns);
            pulse.ns -= slice_ns;
            if pulse.ns == 0 {
                return self.lower();
            }
            now = Instant::now().as_ticks();
            if self.next_rise() <= now {
                let oldest = self.call(now);
                pulse = pulse.longer(self.raise(now, oldest));
            }
        }
    }

    /// True if no step comes due before the end of a pulse that begins now. Then the clock is not looked at during the
    /// pulse: that takes several times as long as a slice, and would make a pulse of 2 us one of 9 us.
    #[inline(always)]
    fn is_alone(&self, pulse: Pulse, now: u64) -> bool {
        pulse.ns <= PULSE_SLICE_NS || self.next_rise() > now + pulse.ticks
    }

    /// Marks the axes whose step is to rise at `at` or before. Returns the earliest instant at which one of these steps
    /// was due.
    #[inline(always)]
    fn call(&mut self, at: u64) -> u64 {
        let mut oldest = at;
        for drive in &mut self.drives {
            if drive.at <= at {
                oldest = oldest.min(drive.due);
                drive.at = NEVER;
                drive.level = StepLevel::Due;
            }
        }
        oldest
    }

    #[inline(always)]
    fn wait_until(&mut self, at: u64) -> u64 {
        loop {
            let now = Instant::now().as_ticks();
            if now >= at {
                return now;
            }
            // The delay also lets time pass where it would stand still otherwise.
            self.delay.delay_ns(LOOK_EVERY_NS);
        }
    }

    /// Raises STEP of the marked axes; returns the longest of their pulses.
    #[inline(always)]
    fn raise(&mut self, now: u64, oldest: u64) -> Pulse {
        if now - oldest > self.late_max {
            self.refuse_late(now);
        }
        let mut pulse = Pulse::NONE;
        // One critical section for all axes: with one for each, the last axis would wait for all of them.
        critical_section::with(|section| {
            for drive in self.drives.iter_mut().filter(|drive| drive.level == StepLevel::Due) {
                let AxisDrive { mailbox, pins, sign, .. } = drive;
                let risen = mailbox.step(section, *sign, || pins.set_step(true));
                drive.level = if risen { StepLevel::High } else { StepLevel::Low };
                pulse = pulse.longer(drive.pulse);
            }
        });
        pulse
    }

    /// A step comes too late, which is a fault. No axis makes another step, from here on: the tasks of the axes, which hear
    /// of it, may get no time while steps are due. It has the port's deadline, so it is not `#[cold]`, which would lay it into flash.
    #[inline(never)]
    fn refuse_late(&mut self, now: u64) {
        let mut is_fault = false;
        for drive in &mut self.drives {
            // A run that was stopped meanwhile has no fault.
            is_fault |= drive.refuse_late(now);
        }
        if is_fault {
            self.drives.iter().for_each(|drive| drive.mailbox.cut_off());
        }
    }

    /// Ends the pulses and goes on to the steps that follow.
    #[inline(always)]
    fn lower(&mut self) {
        for drive in &mut self.drives {
            if drive.level == StepLevel::High {
                drive.pins.set_step(false);
            }
        }
        let now = Instant::now().as_ticks();
        for drive in &mut self.drives {
            if drive.level == StepLevel::High {
                drive.level = StepLevel::Low;
                drive.ready = now + drive.low_min;
                if !drive.advance() {
                    drive.refill();
                }
            }
        }
    }
}

impl<'a, P: MotorPins> AxisDrive<'a, P> {
    /// Drives STEP and DIR low.
    fn new(mailbox: &'a Mailbox, mut pins: P) -> Self {
        pins.set_step(false);
        pins.set_dir(false);
        Self {
            mailbox,
            pins,
            dir_high: false,
            ticks: None,
            sign: 1,
            start: 0,
            due: NEVER,
            at: NEVER,
            ready: Instant::now().as_ticks(),
            late_max: NEVER,
            low_min: 0,
            pulse: Pulse::NONE,
            direction_inverted: false,
            setup: 0,
            has_run: false,
            waits: false,
            level: StepLevel::Low,
        }
    }

    #[inline(always)]
    fn look(&mut self) {
        if self.mailbox.has_news() {
            self.take_news();
        }
    }

    #[inline(never)]
    fn take_news(&mut self) {
        if let Some(request) = self.mailbox.take_request() {
            self.begin(&request);
        }
        if self.waits {
            self.refill();
        }
    }

    /// Takes up a run, which then waits at the start barrier.
    fn begin(&mut self, request: &RunRequest) {
        self.pulse = Pulse { ns: request.pulse_ns, ticks: request.pulse.as_ticks() };
        (self.late_max, self.low_min) = (request.late_max.as_ticks(), request.low_min.as_ticks());
        (self.direction_inverted, self.setup) = (request.motors.wiring.direction_inverted, request.setup.as_ticks());
        self.pins.begin(&request.motors);
        if request.motors.second.is_some() {
            self.ready = self.ready.max(Instant::now().as_ticks() + self.setup);
        }
        (self.start, self.due, self.at, self.has_run, self.waits) = (AT_BARRIER, AT_BARRIER, NEVER, true, true);
    }

    /// Sets DIR. If DIR changes, the next step waits for the set-up time.
    fn face(&mut self, direction: Direction) {
        self.sign = direction.sign();
        let high = (direction == Direction::Positive) != self.direction_inverted;
        if high != self.dir_high {
            self.dir_high = high;
            // The last pulse is over, so DIR's hold time is too.
            self.pins.set_dir(high);
            self.ready = self.ready.max(Instant::now().as_ticks() + self.setup);
        }
    }

    fn is_at_barrier(&self) -> bool {
        self.start == AT_BARRIER
    }

    /// If the run waits at the start barrier, it starts: its segments count from `start`.
    fn start(&mut self, start: u64) {
        if !self.is_at_barrier() {
            return;
        }
        self.start = start;
        self.due = self.due - AT_BARRIER + start;
        if self.waits {
            self.await_item();
        } else if self.at != NEVER {
            self.at = self.due.max(self.ready);
        }
        self.mailbox.begin(Instant::from_ticks(start));
        if !self.has_run && self.at == NEVER {
            // The run has no step to make.
            self.mailbox.conclude(Ok(()));
        }
    }

    /// At the end of a segment: takes the next one, if it is there, or ends the run. No run ends before it has started.
    #[inline(never)]
    fn refill(&mut self) {
        self.waits = false;
        loop {
            match self.mailbox.take() {
                Some(StreamItem::Steps { segment, direction }) => {
                    self.face(direction);
                    self.ticks = Some(segment.ticks());
                    self.advance();
                    return;
                }
                Some(StreamItem::Rest { until_ticks }) => self.due = self.start + until_ticks,
                Some(StreamItem::End) => {
                    (self.has_run, self.at) = (false, NEVER);
                    if !self.is_at_barrier() {
                        self.mailbox.conclude(Ok(()));
                    }
                    return;
                }
                None => return self.await_item(),
            }
        }
    }

    /// The next item is not there. If it has not come when a first step of it would be too late, this is a fault.
    fn await_item(&mut self) {
        self.waits = self.has_run;
        self.at = if self.is_at_barrier() || !self.has_run { NEVER } else { self.due + self.late_max + 1 };
    }

    /// Goes on to the next step of the segment; false if there is none.
    #[inline(always)]
    fn advance(&mut self) -> bool {
        let Some(ticks) = self.ticks.as_mut().and_then(Iterator::next) else { return false };
        self.due = self.start + ticks;
        self.at = self.due.max(self.ready);
        true
    }

    /// True if its run ends because its step is too late, or because no item has come.
    fn refuse_late(&mut self, now: u64) -> bool {
        let is_due = self.level == StepLevel::Due;
        if is_due && self.waits {
            // The item may have come since this task has looked.
            self.level = StepLevel::Low;
            self.refill();
        }
        let is_late =
            is_due && (self.waits || self.level == StepLevel::Due) && now.saturating_sub(self.due) > self.late_max;
        if is_late {
            (self.level, self.has_run, self.waits) = (StepLevel::Low, false, false);
        }
        let fault = || {
            let [late, max] = [now - self.due, self.late_max].map(Duration::from_ticks);
            PortFault::Late { late, max }
        };
        is_late && self.mailbox.conclude(Err(fault()))
    }
}
