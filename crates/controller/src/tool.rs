//! Spindle, laser, coolant and probe: from modes and settings to the machine's outputs.

use embassy_futures::yield_now;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::report;
use isostep_console::{Coolant, Error, Modal, Probe, Rate, Realtime, ReportedState, SpindleMode};
use isostep_motion::{Alarm, Level, Motion, Outputs, Power, ProbeMove, Spindle, State};

use crate::controller::{Controller, Program};
use crate::output::Message;
use crate::status::position_pm;

impl Program {
    /// The level of the S in force: zero only for S0, at which a spindle stands.
    fn level(&self) -> Level {
        match self.interpreter.modal().speed_rpm {
            0.0 => Level::ZERO,
            rpm => Level::of_ratio(rpm / self.settings.spindle_max_rpm).max(Level::LEAST),
        }
    }

    /// The power at which a laser shines in a move of this rate.
    pub fn power(&self, rate: Rate) -> Power {
        match self.spindle {
            Spindle::Off => Power::Off,
            _ if !self.settings.laser_mode || rate == Rate::Rapid => Power::Off,
            Spindle::Clockwise => Power::Constant(self.level()),
            Spindle::CounterClockwise => Power::BySpeed(self.level()),
        }
    }

    /// The outputs that the modes in force ask for.
    fn outputs(&self) -> Outputs {
        let Modal { spindle, coolant, .. } = *self.interpreter.modal();
        let (spindle, level) = match spindle {
            SpindleMode::Off => (Spindle::Off, Level::ZERO),
            SpindleMode::Clockwise => (Spindle::Clockwise, self.level()),
            SpindleMode::CounterClockwise => (Spindle::CounterClockwise, self.level()),
        };
        Outputs { spindle, level, flood: coolant.flood(), mist: coolant.mist() }
    }
}

impl<F: NorFlash> Controller<'_, F> {
    /// Sets the outputs to what the modes in force say, once the moves before have ended. A laser does not wait for
    /// these moves, because each move has a level of its own.
    pub(crate) async fn switch_tool(&self, switches_coolant: bool) -> Result<(), Error> {
        if switches_coolant || !self.with(|program| program.settings.laser_mode) {
            self.settled().await?;
        }
        let outputs = self.with(|program| {
            let outputs = program.outputs();
            program.spindle = outputs.spindle;
            outputs
        });
        if outputs.spindle == Spindle::Off && self.machine.outputs().spindle != Spindle::Off {
            self.machine.stop_spindle_at_rest();
            if !switches_coolant {
                return Ok(());
            }
        }
        self.machine.set_outputs(outputs).map_err(|_| Error::Locked)
    }

    /// Refuses, with a message, that a spindle turns whose VFD cannot turn it. Then all outputs are off.
    pub(crate) fn may_turn(&self, text: &mut Message) -> Result<(), Error> {
        let may = self
            .with(|program| program.outputs().spindle == Spindle::Off || self.vfd.may_turn(&program.settings, text));
        if may {
            return Ok(());
        }
        self.stop_tool();
        Err(Error::Unsupported)
    }

    /// Switches all outputs off, in the program's modal state, too.
    pub(crate) fn stop_tool(&self) {
        self.with(|program| {
            program.interpreter.stop_tool();
            program.spindle = Spindle::Off;
        });
        // Switching off is never refused.
        let _ = self.machine.set_outputs(Outputs::OFF);
    }

    /// Obeys a real-time byte about the tool.
    pub(crate) fn override_tool(&self, realtime: Realtime) {
        let takes = matches!(self.state(), ReportedState::Idle | ReportedState::Run | ReportedState::Hold { .. });
        let Outputs { flood, mist, .. } = self.machine.outputs();
        match realtime {
            Realtime::SpindleStop => self.machine.toggle_spindle(),
            Realtime::Flood if takes => self.set_coolant(!flood, mist),
            Realtime::Mist if takes => self.set_coolant(flood, !mist),
            _ => {}
        }
    }

    fn set_coolant(&self, flood: bool, mist: bool) {
        if self.machine.set_coolant(flood, mist).is_ok() {
            self.with(|program| program.interpreter.set_coolant(Coolant::of(flood, mist)));
        }
    }

    /// G38: moves until the probe finds what it looks for, and reports where that was. As in Grbl, the line is accepted
    /// even if the motion ends in an alarm.
    pub(crate) async fn probe(&self, probe: &Probe, line: u32, checks: bool, text: &mut Message) -> Result<(), Error> {
        let &Probe { target_pm, mm_min, away, must } = probe;
        let (target_steps, beyond) = self.target_steps(target_pm, None);
        if let Some(beyond) = beyond {
            return Err(self.refuse_target(beyond, false, text).await);
        }
        if checks {
            return Ok(());
        }
        self.settled().await?;
        let feed_mm_s = f64::from(mm_min) / 60.0;
        self.submit(Motion::Probe(ProbeMove { target_steps, feed_mm_s, away, must, line })).await?;
        let result = self.settled().await;
        self.follow_machine();
        let alarm = match self.machine.state() {
            State::Alarm(alarm) => Some(alarm),
            _ => None,
        };
        if matches!(alarm, None | Some(Alarm::ProbeContact)) {
            self.report_probed(text);
        }
        match alarm {
            Some(Alarm::ProbeInitial | Alarm::ProbeContact) => {
                // `notify` has to report the alarm first.
                yield_now().await;
                Ok(())
            }
            _ => result,
        }
    }

    pub(crate) fn report_probed(&self, text: &mut Message) {
        let probed = self.machine.probed();
        let place_pm = position_pm(probed.position_steps, &self.machine.config());
        self.with(|program| {
            program.interpreter.set_touched(place_pm, probed.touched);
            text.print(|text| report::probed(text, &program.interpreter, &program.settings));
        });
    }
}
