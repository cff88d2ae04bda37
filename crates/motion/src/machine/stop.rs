//! Stops, and how an alarm is left: calls and inputs become triggers of the life cycle (`life`), which decides.

use embassy_futures::select::select;
use embassy_time::{Instant, Timer};

use super::{Busy, Cause, Machine, Trigger};
use crate::axes::{AXES, Axis};
use crate::config::Config;
use crate::event::{Alarm, State};
use crate::motor::{LimitInput, Motor};
use crate::port::{Direction, PortFault};

impl Machine {
    /// Forgets the waiting motions, and brakes the move under way on its path, as a [`hold`](Self::hold) does. Then the
    /// machine is idle, its position trusted. A second reset before that, or a reset while homing, stops everything
    /// within one pulse, and an alarm says that the position is not trusted. At rest a reset ends a hold, and nothing
    /// else. The tool's outputs are off at once.
    pub fn reset(&self) {
        self.cut();
        self.on(Trigger::Reset);
    }

    /// Locks the machine with `alarm`, unless it is locked already. It is for what is found before anything moves.
    pub fn raise(&self, alarm: Alarm) {
        self.on(Trigger::Raise(alarm));
    }

    /// Leaves an alarm; the position is as trusted as the alarm left it.
    ///
    /// # Errors
    /// [`Busy`]: the machine stays in the alarm while the emergency stop is pressed or a drive is in alarm, and until the motions
    /// that waited when the alarm came have been passed over, which takes the coordinator a moment.
    pub fn unlock(&self) -> Result<(), Busy> {
        self.ask(Trigger::Unlock).map(|_| ())
    }
}

/// For an interrupt of the board that notices a switch, or a byte, before the task that handles it does.
impl Machine {
    /// A reset byte has been heard, which [`reset`](Self::reset) will report later. The tool's outputs are off at once.
    /// If the machine still brakes for an earlier reset byte, or that one has not been reported yet, the machine stops
    /// at once. Call it once for each byte, from any context.
    pub fn reset_heard(&self) {
        self.on(Trigger::ResetHeard);
        self.cut();
    }

    /// The board has switched the tool off by itself, because the processor was held up for too long to be trusted with
    /// it. A machine that moves stops at once; an alarm says why. Call it once the processor is back, from any context,
    /// before the board lets go of the tool's outputs: they are off at once here too.
    pub fn tool_cut_off(&self) {
        self.on(Trigger::ToolCutOff);
        self.cut();
    }

    /// The driver of `motor` has failed: it does not answer, has lost its settings, or has switched its motor off. The
    /// machine stops at once, and an alarm says which; the position is not trusted, at rest neither. Safe from any context.
    pub fn driver_failed(&self, motor: Motor) {
        self.on(Trigger::DriverFailed(motor));
    }

    /// A limit input has changed, and is now low or high. The first edge of a press stops a running machine at once, if
    /// hard limits are on and the axis has an end. Where the input is a driver's it means, but in homing, that the
    /// [driver has failed](Self::driver_failed); an alarm of drives means so always, also at rest. It may be called any number of times, from any context. Before the task of
    /// the input has read it for the first time no edge counts.
    pub fn limit_edge(&self, input: LimitInput, is_low: bool) {
        if let Some(trigger) = self.with(|inner| inner.pressed(input, is_low)) {
            self.on(trigger);
        }
    }

    /// The emergency-stop input has changed, and is now low or high. The first edge of a press stops the machine at
    /// once, however short it is: the task that watches the input takes it back when the input has been steady. It may
    /// be called any number of times, from any context.
    pub fn emergency_stop_edge(&self, is_low: bool) {
        if is_low == self.emergency_contact.pressed_is_low() {
            self.set_emergency(true);
            self.emergency.signal(());
        }
    }
}

/// For the tasks of this crate.
impl Machine {
    /// The cause of a stop that was asked for and that the coordinator has not answered yet.
    pub(crate) fn cause(&self) -> Option<Cause> {
        self.life().cause
    }

    /// The first motor that these steps of the axes would take further onto its switch. The switch has closed already, so no edge would
    /// report it.
    pub(crate) fn onto_switch(&self, steps: [i32; AXES]) -> Option<Motor> {
        self.with(|inner| {
            let Config { hard_limits, homing, squared, is_endless, .. } = &inner.config;
            let is_towards = |motor: &Motor| {
                let steps = steps[motor.axis as usize];
                steps != 0
                    && !is_endless[motor.axis as usize]
                    && !homing.by_stall[motor.axis as usize]
                    && Direction::of(steps) == homing.towards[motor.axis as usize]
            };
            let second = squared.map(|squared| Motor::second(squared.axis));
            let mut motors = Axis::ALL.into_iter().map(Motor::first).chain(second);
            motors.find(|motor| *hard_limits && self.switch_of(*motor).may_be_pressed() && is_towards(motor))
        })
    }

    /// The port of `axis` has faulted, and is not inhibited yet: everything stops at once, in the context of its task. In
    /// every fault a step could not be made at its instant in the middle of a move, so the position is not trusted.
    pub(crate) fn fail(&self, axis: Axis, fault: PortFault) {
        self.on(Trigger::Fault(match fault {
            PortFault::Late { .. } | PortFault::TooFast { .. } | PortFault::Apart { .. } => Alarm::LateStep { axis },
            PortFault::Underrun => Alarm::Underrun { axis },
        }));
        self.with(|inner| inner.faults[axis as usize] += 1);
    }

    /// Another coordinator takes over. A fault of the one before it, which has gone, ends no motion of the new one.
    pub(crate) fn take_over(&self) {
        self.change(Trigger::TakenOver);
        self.halt();
    }

    pub(crate) fn set_emergency(&self, pressed: bool) {
        self.on(Trigger::EmergencyStop(pressed));
    }

    /// Waits until the emergency stop is pressed, as far as the machine knows. Only the task that watches it may wait.
    pub(crate) async fn wait_emergency(&self) {
        while !self.life().emergency {
            self.emergency.wait().await;
        }
    }

    /// Stops the axes within one pulse. Safe at any priority. Not inlined: see `Machine::with`.
    #[inline(never)]
    pub(crate) fn halt(&self) {
        for link in &self.links {
            link.inhibit(true);
        }
        for link in &self.links {
            link.halt.signal(());
        }
    }

    /// Ends `motions` motions with `result`, and returns the state that the machine is in then. No stop that comes
    /// meanwhile is lost, because state and cause change in one critical section.
    pub(crate) fn conclude(&self, result: Result<(), Alarm>, motions: usize) -> State {
        self.change(Trigger::Ended(result, motions)).1.state
    }

    /// Waits until `end`, or until everything is stopped; true if it was stopped.
    pub(crate) async fn is_stopped_before(&self, end: Instant) -> bool {
        while self.cause().is_none() {
            if select(self.stopped.wait(), Timer::at(end)).await.is_second() {
                return false;
            }
        }
        true
    }

    pub(crate) fn forget_stopped(&self) {
        self.stopped.reset();
    }
}
