//! One line at a time: interpret, carry out, answer.

use core::fmt;

use embassy_time::Duration;
use isostep_console::report::{self, messages};
use isostep_console::{Command, Error, SETTING_TABLE, Settings, State as Word, parameters::STARTUP_LINES};
use isostep_motion::{AXES, Busy, ConfigError, Motion, State, Wiring};

use crate::config::{config, pulse_ns};
use crate::controller::{Controller, Mode};
use crate::output::{Output, message};

/// What comes after an accepted line.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum After {
    /// The next line.
    NextLine,
    /// A reset of the console that sent it.
    Restart,
    /// Nothing until a reset.
    Sleep,
}

impl Controller<'_> {
    /// Carries out one line and answers it.
    ///
    /// # Cancellation
    /// Safe: a motion is either in the machine's queue or was never asked for. The caller resets the machine.
    pub(crate) async fn line(&self, line: Result<&str, Error>, out: &Output) -> After {
        let _turn = self.turn.lock().await;
        let answer = match line {
            Ok(line) => self.carry_out(line, out).await,
            Err(error) => Err(error),
        };
        match answer {
            Ok(after) => {
                out.send(report::OK).await;
                if after == After::Sleep {
                    self.sleep(out).await;
                }
                after
            }
            Err(error) => {
                let lack = line.ok().filter(|_| error == Error::Unsupported).and_then(report::lacks);
                if let Some(lack) = lack {
                    self.tell(&lack, out).await;
                }
                out.send(&message(|text| report::error(text, error))).await;
                After::NextLine
            }
        }
    }

    /// Carries out the start-up lines after power-up, a reset or homing, and answers each.
    pub(crate) async fn start_up(&self, out: &Output) {
        for index in 0..STARTUP_LINES {
            let line = self.with(|program| program.interpreter.parameters().startup[index].clone());
            if line.is_empty() {
                continue;
            }
            let answer = match self.with(|program| program.interpreter.gcode(&line)) {
                Ok(block) => self.block(block, out).await,
                Err(error) => Err(error),
            };
            out.send(&message(|text| report::startup_answer(text, &line, answer))).await;
        }
    }

    /// `[MSG:...]`.
    pub(crate) async fn tell(&self, words: &dyn fmt::Display, out: &Output) {
        out.send(&message(|text| report::message(text, words))).await;
    }

    async fn carry_out(&self, line: &str, out: &Output) -> Result<After, Error> {
        let state = self.state();
        let command = self.with(|program| program.interpreter.interpret(line, state, &program.settings))?;
        match command {
            Command::Block(block) => self.block(block, out).await?,
            Command::Jog(jog) => self.jog(jog).await?,
            Command::Home => self.home(out).await?,
            Command::Unlock => self.unlock(out).await?,
            Command::ToggleCheck => return Ok(self.toggle_check(state, out).await),
            Command::Sleep => return Ok(After::Sleep),
            Command::Help => out.send(report::HELP).await,
            Command::ShowBuild => self.show_build(out).await,
            Command::ShowSettings => self.show_settings(out).await,
            Command::SetSetting { number, value } => self.set(number, value, out).await?,
            Command::ShowParameters => self.show_parameters(out).await,
            Command::ShowModal => {
                let modal = self.with(|program| {
                    message(|text| report::modal(text, &program.interpreter, program.settings.report_inches))
                });
                out.send(&modal).await;
            }
            Command::ShowStartup => self.show_startup(out).await,
            Command::SetStartup { index, block, line } => {
                self.block(block, out).await?;
                self.with(|program| {
                    let startup = &mut program.interpreter.parameters_mut().startup[index];
                    startup.clear();
                    // A line is no longer than what it is kept in.
                    let _ = startup.push_str(line);
                });
            }
            Command::Restore { settings, parameters } => {
                self.restore_defaults(settings, parameters, out).await?;
                return Ok(After::Restart);
            }
            Command::ExplainError(error) => self.tell(&error, out).await,
            Command::ExplainAlarm(alarm) => self.tell(&alarm, out).await,
        }
        Ok(After::NextLine)
    }

    async fn home(&self, out: &Output) -> Result<(), Error> {
        self.with(|program| program.mode = Mode::Normal);
        self.submit(Motion::Home, 0).await?;
        let result = self.settled().await;
        self.follow_machine();
        result?;
        self.start_up(out).await;
        Ok(())
    }

    async fn unlock(&self, out: &Output) -> Result<(), Error> {
        if self.state() != Word::Alarm {
            return Ok(());
        }
        self.machine.unlock().map_err(|Busy(_)| Error::Locked)?;
        self.with(|program| program.mode = Mode::Normal);
        self.follow_machine();
        self.tell(&messages::UNLOCKED, out).await;
        Ok(())
    }

    async fn toggle_check(&self, state: Word, out: &Output) -> After {
        if state == Word::Check {
            self.tell(&messages::NOT_CHECKING, out).await;
            return After::Restart;
        }
        self.with(|program| program.mode = Mode::Check);
        self.tell(&messages::CHECKING, out).await;
        After::NextLine
    }

    /// Frees the motors, as the idle delay does, and keeps the turn until a reset.
    async fn sleep(&self, out: &Output) {
        self.woken.reset();
        let mut config = self.machine.config();
        config.idle_delay = Some(Duration::MIN);
        if self.machine.configure(config).is_ok() && self.machine.state() == State::Idle {
            // The coordinator looks at the delay when it has done something.
            let _ = self.submit(Motion::Dwell(Duration::MIN), 0).await;
            let _ = self.settled().await;
        }
        self.with(|program| program.mode = Mode::Sleep);
        self.tell(&messages::SLEEPING, out).await;
        self.woken.wait().await;
    }

    async fn restore_defaults(&self, settings: bool, parameters: bool, out: &Output) -> Result<(), Error> {
        if settings {
            self.adopt(Settings::DEFAULT, out).await?;
        }
        if parameters {
            self.with(|program| *program.interpreter.parameters_mut() = Default::default());
        }
        self.tell(&messages::RESTORING, out).await;
        Ok(())
    }

    async fn show_build(&self, out: &Output) {
        out.send(report::BUILD).await;
        let [x, y, z] = self.machine.faults();
        if [x, y, z] != [0; AXES] {
            self.tell(&format_args!("step ports faulted since power-up: X {x}, Y {y}, Z {z} times"), out).await;
        }
    }

    async fn show_settings(&self, out: &Output) {
        let settings = self.settings();
        for row in SETTING_TABLE {
            out.send(&message(|text| report::setting(text, row, &settings))).await;
        }
    }

    async fn show_parameters(&self, out: &Output) {
        for index in 0..report::PARAMETERS {
            let line = self.with(|program| {
                let inches = program.settings.report_inches;
                message(|text| report::parameter(text, index, &program.interpreter, inches))
            });
            out.send(&line).await;
        }
    }

    async fn show_startup(&self, out: &Output) {
        for index in 0..STARTUP_LINES {
            let line = self.with(|program| {
                message(|text| report::startup(text, index, &program.interpreter.parameters().startup[index]))
            });
            out.send(&line).await;
        }
    }

    async fn set(&self, number: u16, value: f32, out: &Output) -> Result<(), Error> {
        match self.settings().with(number, value, &|pulse_us| self.carries_steps_s(pulse_us)) {
            Ok(settings) => self.adopt(settings, out).await,
            Err(refused) => {
                self.tell(&refused, out).await;
                Err(refused.error())
            }
        }
    }

    async fn adopt(&self, settings: Settings, out: &Output) -> Result<(), Error> {
        if let Err(refused) = self.machine.configure(config(&settings)) {
            self.tell(&words(&refused), out).await;
            return Err(Error::BadNumber);
        }
        self.with(|program| program.settings = settings);
        self.follow_machine();
        Ok(())
    }

    /// The step rate that every axis's port carries with pulses of `pulse_us`, steps/s.
    fn carries_steps_s(&self, pulse_us: u16) -> f32 {
        let wiring = Wiring { pulse_ns: pulse_ns(pulse_us), ..Wiring::default() };
        let ports = self.machine.capabilities();
        ports.iter().flatten().map(|port| port.rate_max_steps_s(wiring) as f32).fold(f32::INFINITY, f32::min)
    }
}

/// A refusal in steps, told by the settings to look at: printing floats would cost the chip kilobytes of flash.
fn words(refused: &ConfigError) -> &'static str {
    match refused {
        ConfigError::Limits { .. } => {
            "speed, acceleration or start speed do not work in steps: see $100-$122, $910-$922"
        }
        ConfigError::Rate { .. } => "the step rate is above what the step port carries: see $100-$102, $110-$112",
        ConfigError::NotPositive { .. } => {
            "a resolution, travel or homing value is not above 0: see $24-$27, $100-$132"
        }
        ConfigError::HomingOrder => "the homing order must name each axis once: see $901",
    }
}
