//! One line at a time: interpret, check, ask for motion, answer.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::Duration;
use isostep_console::report::{self, messages};
use isostep_console::{Block, Command, Error, Fixed, Interpreter, Motion as Words, Rate, SETTING_TABLE, Settings};
use isostep_motion::{AXES, Alarm, Axis, Busy, ConfigError, Machine, Motion, State, Wiring};

use crate::config::{config, pulse_ns};
use crate::output::Output;
use crate::status::{position_mm, word};

/// Settings, modal state and the machine they move.
///
/// It stays on one executor, so what its consoles share needs no critical section, in which reading a line would hold up
/// every interrupt.
pub struct Controller<'a> {
    pub(crate) machine: &'a Machine,
    program: RefCell<Program>,
    /// Consoles take turns, a line each, so that a move starts where the one before it ends.
    turn: Mutex<NoopRawMutex, ()>,
}

struct Program {
    interpreter: Interpreter,
    settings: Settings,
}

impl<'a> Controller<'a> {
    /// A controller of `machine`, which should have been made with the [`config`] of the same settings.
    #[must_use]
    pub fn new(machine: &'a Machine, settings: Settings) -> Self {
        let program = Program { interpreter: Interpreter::new(), settings };
        Self { machine, program: RefCell::new(program), turn: Mutex::new(()) }
    }

    /// The settings in force.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.with(|program| program.settings)
    }

    /// The modal state of power-up, at the place where the machine stands.
    pub(crate) fn restart_program(&self) {
        self.with(|program| program.interpreter.reset());
        self.follow_machine();
    }

    /// Carries out one line and answers it.
    ///
    /// # Cancellation
    /// Safe: a motion is either in the machine's queue or was never asked for. The caller resets the machine.
    pub(crate) async fn line(&self, line: Result<&str, Error>, out: &Output) {
        let answer = match line {
            Ok(line) => self.carry_out(line, out).await,
            Err(error) => Err(error),
        };
        match answer {
            Ok(()) => out.text(report::OK).await,
            Err(error) => out.send(|text| report::error(text, error)).await,
        }
    }

    async fn carry_out(&self, line: &str, out: &Output) -> Result<(), Error> {
        let _turn = self.turn.lock().await;
        let state = word(self.machine.state());
        let command = self.with(|program| program.interpreter.interpret(line, state, &program.settings))?;
        match command {
            Command::Block(block) => self.block(block, out).await?,
            Command::Home => self.home().await?,
            Command::Unlock => self.unlock(out).await?,
            Command::Help => out.text(report::HELP).await,
            Command::ShowBuild => self.show_build(out).await,
            Command::ShowSettings => self.show_settings(out).await,
            Command::SetSetting { number, value } => self.set(number, value, out).await?,
            Command::ShowModal => {
                let (modal, inches) =
                    self.with(|program| (*program.interpreter.modal(), program.settings.report_inches));
                out.send(|text| report::modal(text, &modal, inches)).await;
            }
        }
        Ok(())
    }

    async fn block(&self, block: Block, out: &Output) -> Result<(), Error> {
        if let Some(dwell_s) = block.dwell_s {
            // Answered when it is over: senders use a dwell to wait for the end of motion.
            self.submit(Motion::Dwell(Duration::from_micros((f64::from(dwell_s) * 1e6) as u64))).await?;
            self.settled().await?;
        }
        match block.motion {
            Some(Words::Move { target_mm, rate }) => self.go_to(target_mm, rate, out).await?,
            Some(Words::GoHome { via_mm, target_mm }) => {
                if let Some(via_mm) = via_mm {
                    self.go_to(via_mm, Rate::Rapid, out).await?;
                }
                self.go_to(target_mm, Rate::Rapid, out).await?;
            }
            None => {}
        }
        if block.ends_program {
            self.settled().await?;
            out.send(|text| report::message(text, messages::PROGRAM_END)).await;
        }
        Ok(())
    }

    async fn go_to(&self, target_mm: [f32; AXES], rate: Rate, out: &Output) -> Result<(), Error> {
        let config = self.machine.config();
        let target_steps = Axis::ALL.map(|axis| config.steps(axis, target_mm[axis as usize].into()));
        if let Some(axis) = self.beyond_travel(target_steps) {
            return Err(self.refuse_target(axis, target_steps[axis as usize], out).await);
        }
        let feed_mm_s = match rate {
            Rate::Rapid => None,
            Rate::Feed { mm_min } => Some(f64::from(mm_min) / 60.0),
        };
        self.submit(Motion::Move { target_steps, feed_mm_s }).await
    }

    /// Locks the machine once the moves before the refused one have ended: they are good, and so no step is lost.
    async fn refuse_target(&self, axis: Axis, target_steps: i32, out: &Output) -> Error {
        if let Err(error) = self.settled().await {
            return error;
        }
        self.machine.raise(Alarm::SoftLimit { axis });
        self.follow_machine();
        let config = self.machine.config();
        let range = config.travel_steps(axis);
        let mm = |steps: i32| Fixed { value: config.mm(axis, steps) as f32, decimals: 3 };
        let (asked, min, max) = (mm(target_steps), mm(*range.start()), mm(*range.end()));
        let words =
            format_args!("{axis}{asked} is outside the travel, {min} to {max} mm: correct the program, then $X");
        out.send(|text| report::message(text, words)).await;
        Error::Locked
    }

    /// The first homed axis whose target is outside its travel. Without homing nobody knows where the travel is.
    fn beyond_travel(&self, target_steps: [i32; AXES]) -> Option<Axis> {
        let homed = self.machine.status().homed;
        let config = self.machine.config();
        let outside = |axis: &Axis| !config.travel_steps(*axis).contains(&target_steps[*axis as usize]);
        let checked = self.settings().soft_limits;
        Axis::ALL.into_iter().filter(|&axis| checked && homed[axis as usize]).find(outside)
    }

    async fn home(&self) -> Result<(), Error> {
        self.submit(Motion::Home).await?;
        let result = self.settled().await;
        self.follow_machine();
        result
    }

    async fn unlock(&self, out: &Output) -> Result<(), Error> {
        if !matches!(self.machine.state(), State::Alarm(_)) {
            return Ok(());
        }
        self.machine.unlock().map_err(|Busy(_)| Error::Locked)?;
        self.follow_machine();
        out.send(|text| report::message(text, messages::UNLOCKED)).await;
        Ok(())
    }

    async fn show_build(&self, out: &Output) {
        out.text(report::BUILD).await;
        let [x, y, z] = self.machine.faults();
        if [x, y, z] != [0; AXES] {
            let words = format_args!("step ports faulted since power-up: X {x}, Y {y}, Z {z} times");
            out.send(|text| report::message(text, words)).await;
        }
    }

    async fn show_settings(&self, out: &Output) {
        let settings = self.settings();
        for row in SETTING_TABLE {
            out.send(|text| report::setting(text, row, &settings)).await;
        }
    }

    async fn set(&self, number: u16, value: f32, out: &Output) -> Result<(), Error> {
        let refused = match self.settings().with(number, value, &|pulse_us| self.carries_steps_s(pulse_us)) {
            Err(refused) => refused,
            Ok(settings) => {
                if let Err(refused) = self.machine.configure(config(&settings)) {
                    out.send(|text| report::message(text, words(&refused))).await;
                    return Err(Error::BadNumber);
                }
                self.with(|program| program.settings = settings);
                self.follow_machine();
                return Ok(());
            }
        };
        out.send(|text| report::message(text, refused)).await;
        Err(refused.error())
    }

    /// The step rate that every axis's port carries with pulses of `pulse_us`, steps/s.
    fn carries_steps_s(&self, pulse_us: u16) -> f32 {
        let wiring = Wiring { pulse_ns: pulse_ns(pulse_us), ..Wiring::default() };
        let ports = self.machine.capabilities();
        ports.iter().flatten().map(|port| port.rate_max_steps_s(wiring) as f32).fold(f32::INFINITY, f32::min)
    }

    async fn submit(&self, motion: Motion) -> Result<(), Error> {
        self.machine.submit(motion).await.map_err(|Busy(_)| {
            self.follow_machine();
            Error::Locked
        })
    }

    async fn settled(&self) -> Result<(), Error> {
        self.machine.settled().await.map_err(|_| {
            self.follow_machine();
            Error::Locked
        })
    }

    /// After anything but a finished move the program goes on from where the machine stands.
    fn follow_machine(&self) {
        let position = position_mm(self.machine.position_steps(), &self.machine.config());
        self.with(|program| program.interpreter.set_position_mm(position));
    }

    fn with<R>(&self, f: impl FnOnce(&mut Program) -> R) -> R {
        f(&mut self.program.borrow_mut())
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
