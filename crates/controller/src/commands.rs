//! One line at a time: interpret, carry out, answer.

use core::convert::Infallible;
use core::fmt::{self, Write};
use core::pin::pin;

use embassy_futures::yield_now;
use embassy_time::{Duration, Timer};
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::parameters::STARTUP_LINES;
use isostep_console::report::{self, messages};
use isostep_console::{
    Command, Conflict, Coordinates, Error, Fixed, ReportedState, SETTING_TABLE, Setting, SettingError, Settings,
    ToolTable, Unfit,
};
use isostep_motion::{AXES, Axis, Busy, ConfigError, Contact, Motion, Spindle, cold_path};

use crate::config::{Geometry, UNWORKABLE, carries_steps_s, config};
use crate::controller::{Controller, Mode, Program, Unsaved};
use crate::jogs::Fate;
use crate::output::{Message, Output};
use crate::store::{Loss, NotStored};
use crate::vfd::Vfd;

/// The beginning of the line of a jog.
const JOG: &str = "$J=";
/// The word in the line of a probe.
const PROBE: &str = "G38.";

/// The time for which ENABLE of drives in alarm is off, and that in which they are well afterwards if they can be.
const DRIVE_RESET: Duration = Duration::from_millis(500);
/// What is said when something else is to turn the spindle.
const OTHER_SPINDLE: &str = "in force when the board is switched off and on; a VFD has the wires of the console by UART then, so keep USB at hand";

/// The actions after an accepted line.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum After {
    /// The next line.
    NextLine,
    /// What is sent by hand, until the tool has been changed; then the same line once more.
    ToolChange,
    /// The start-up lines, before the line is answered.
    StartUp,
    /// A reset of the console that sent it.
    Restart,
    /// Nothing until a reset.
    Sleep,
    /// Only lines that move nothing and change nothing.
    Boot,
}

impl<F: NorFlash> Controller<'_, F> {
    /// Carries out one line and answers it, after the message that it has for the operator, if there is one. If it is a jog,
    /// `fate` says what becomes of it.
    ///
    /// # Cancellation
    /// Safe: a motion is either in the machine's queue or was never asked for.
    pub(crate) async fn line(&self, line: Result<&str, Error>, message: &str, fate: Fate, out: &Output) -> After {
        let number = self.with(|program| {
            program.lines = program.lines.wrapping_add(1);
            program.lines
        });
        let is_jog = line.is_ok_and(|line| line.starts_with(JOG));
        if is_jog && fate == Fate::Refused || self.is_held() && self.may_not_wait(line) {
            cold_path(pin!(self.refuse(Error::NotIdle, out))).await;
            return After::NextLine;
        }
        let pauses = self.pauses.get();
        let _turn = self.turn.lock().await;
        let has_to_catch_up = self.begin_line(number);
        let mut text = Message::new();
        let before = if has_to_catch_up || !message.is_empty() || self.may_change_tool(fate) {
            cold_path(pin!(self.before_line(line, message, fate, has_to_catch_up, &mut text, out))).await
        } else {
            Ok(None)
        };
        let answer = match (line, before) {
            (_, Err(error)) | (Err(error), _) => Err(error),
            (_, Ok(Some(after))) => Ok(after),
            (Ok(_), _) if is_jog && self.pauses.get() != pauses => Err(Error::NotIdle),
            (Ok(_), _) if is_jog && fate == Fate::Cancelled => Ok(After::NextLine),
            (Ok(line), _) => self.carry_out(line, &mut text, out).await,
        };
        let after = if answer == Ok(After::NextLine) && fate != Fate::SentAgain && !self.has_changes() {
            text.answer(Ok(()));
            out.send(&text).await;
            After::NextLine
        } else {
            cold_path(pin!(self.after_line(line, answer, fate, &mut text, out))).await
        };
        self.with(|program| program.in_line = false);
        after
    }

    /// What comes before a few lines: the program follows the machine, the line's comment is told, a tool is changed. Returns what
    /// follows if that is all of the line.
    async fn before_line(
        &self,
        line: Result<&str, Error>,
        message: &str,
        fate: Fate,
        has_to_catch_up: bool,
        text: &mut Message,
        out: &Output,
    ) -> Result<Option<After>, Error> {
        if has_to_catch_up {
            self.catch_up().await;
        }
        if !message.is_empty() {
            self.tell(message, out).await;
        }
        match line {
            Ok(line) if self.may_change_tool(fate) => self.change_around(line, fate, text, out).await,
            _ => Ok(None),
        }
    }

    /// True if a line that has been carried out may have changed what is stored, or what drivers are to know.
    fn has_changes(&self) -> bool {
        #[cfg(feature = "trinamic")]
        let sets_drivers = self.sets_drivers();
        #[cfg(not(feature = "trinamic"))]
        let sets_drivers = false;
        sets_drivers || self.with(|program| program.unsaved.any())
    }

    /// What follows a line that was not simply accepted, and its answer.
    async fn after_line(
        &self,
        line: Result<&str, Error>,
        answer: Result<After, Error>,
        fate: Fate,
        text: &mut Message,
        out: &Output,
    ) -> After {
        if answer == Ok(After::StartUp) {
            // Here and not in `carry_out`: a command is large, and need not be kept meanwhile.
            self.start_up(text, out).await;
        }
        if let (&Err(error), Ok(line)) = (&answer, line) {
            self.explain(line, error, text);
        }
        let saved = if self.with(|program| program.unsaved.any()) { self.save(text).await } else { Ok(()) };
        // No move may begin with drivers that are set to other microsteps than it was planned for.
        #[cfg(feature = "trinamic")]
        if self.sets_drivers() {
            self.drivers_set().await;
        }
        let answer = answer.and_then(|after| saved.map(|()| after));
        if answer == Ok(After::Boot) {
            self.say_booting(text);
        }
        if fate == Fate::SentAgain {
            self.with(|program| program.has_changed = false);
        } else {
            text.answer(answer.map(|_| ()));
        }
        let after = answer.unwrap_or(After::NextLine);
        if after == After::Sleep {
            text.say(messages::SLEEPING);
        }
        out.send(text).await;
        match after {
            After::Sleep => match self.sleep().await {},
            After::Boot => self.boot(),
            After::NextLine | After::StartUp | After::Restart | After::ToolChange => {}
        }
        after
    }

    /// True if a line that somebody sends by hand would have to wait, in a hold, for the line of another console: that
    /// one waits for the resume, and nobody expects this one to move then.
    // Not inlined, so that the lines of a program run through less code in flash.
    #[cold]
    #[inline(never)]
    fn may_not_wait(&self, line: Result<&str, Error>) -> bool {
        self.turn.try_lock().is_err() && line.is_ok_and(|line| line.starts_with(JOG) || line.contains(PROBE))
    }

    /// Prints the message of a line's comment.
    async fn tell(&self, message: &str, out: &Output) {
        let mut text = Message::new();
        text.print(|text| report::program_message(text, message));
        out.send(&text).await;
    }

    async fn refuse(&self, error: Error, out: &Output) {
        let mut text = Message::new();
        text.answer(Err(error));
        out.send(&text).await;
    }

    /// Says of a refused line what its error does not.
    // Not inlined, so that the other lines run through less code in flash.
    #[cold]
    #[inline(never)]
    fn explain(&self, line: &str, error: Error, text: &mut Message) {
        // What has been said already is what is wrong.
        if !text.is_empty() {
            return;
        }
        if matches!(error, Error::Locked | Error::NotIdle) && self.fit(text).is_err() {
            return;
        }
        let why = self.with(|program| program.interpreter.explain(line, error, &program.settings));
        if let Some(why) = why {
            text.say(why);
        }
    }

    /// Begins a line. Returns whether it has to catch up with the machine first: if the line before it was dropped, if
    /// a reset has come, or while a cancelled jog brakes, the meaning of the line is not known until that is over.
    fn begin_line(&self, number: u32) -> bool {
        self.with(|program| {
            program.source = number;
            let was_dropped = core::mem::replace(&mut program.in_line, true);
            was_dropped || program.restarting || program.jogged && self.machine.is_cancelling_jogs()
        })
    }

    /// Waits until the machine has done what it was asked for before, and has the program go on from where it stands.
    async fn catch_up(&self) {
        self.end_restart().await;
        self.follow_machine();
        self.with(|program| program.in_line = true);
    }

    /// Carries out the start-up lines after power-up, a reset or homing, and answers each. `text` is empty before and after.
    pub(crate) async fn start_up(&self, text: &mut Message, out: &Output) {
        for index in 0..STARTUP_LINES {
            let unlocked = self.state().takes_gcode();
            let block = self.with(|Program { startup, interpreter, settings, .. }| {
                let line = &startup[index];
                (!line.is_empty()).then(|| unlocked.and_then(|()| interpreter.gcode(line, settings)))
            });
            let answer = match block {
                None => continue,
                Some(Ok(block)) => self.block(&block, text, out).await,
                Some(Err(error)) => Err(error),
            };
            self.with(|program| text.print(|text| write!(text, ">{}:", program.startup[index])));
            text.answer(answer);
            out.send(text).await;
            text.clear();
        }
    }

    /// Carries out a line. Messages that come before `ok` or the error are left in `text`.
    async fn carry_out(&self, line: &str, text: &mut Message, out: &Output) -> Result<After, Error> {
        let state = self.state();
        if state != ReportedState::Jog && self.with(|program| program.jogged) {
            self.follow_if_elsewhere();
        }
        let command = self.with(|program| program.interpreter.interpret(line, state, &program.settings));
        // By reference: a command is large.
        match &command {
            Ok(Command::Block(block)) => self.block(block, text, out).await.map(|()| After::NextLine),
            Ok(command) => cold_path(pin!(self.other(command, state, text, out))).await,
            Err(error) => Err(*error),
        }
    }

    /// Carries out a line that is not G-code.
    async fn other(
        &self,
        command: &Command<'_>,
        state: ReportedState,
        text: &mut Message,
        out: &Output,
    ) -> Result<After, Error> {
        match *command {
            // It has been carried out, beside what is seldom sent.
            Command::Block(_) => {}
            Command::Jog(ref jog) => self.jog(jog).await?,
            Command::Home { axis } => return self.home(axis, state, text).await,
            Command::Buzz { axis } => self.buzz(Axis::ALL[axis], text).await?,
            #[cfg(feature = "trinamic")]
            Command::MeasureStall { axis } => self.measure_stall(Axis::ALL[axis], text).await?,
            Command::Unlock => self.unlock(state, text).await?,
            Command::MeasureTool => self.measure_tool(text).await?,
            Command::SetToolReference => self.set_tool_reference(),
            Command::ToggleCheck => return Ok(self.toggle_check(state, text)),
            Command::Sleep => return Ok(After::Sleep),
            Command::Boot if !self.boot_drive.is_empty() => return Ok(After::Boot),
            Command::Boot => {
                text.say(messages::NO_BOOT_LOADER);
                return Err(Error::UnknownStatement);
            }
            Command::Prove { words } => self.prove(words, text, out).await?,
            Command::Help => text.print(|text| text.push_str(report::HELP)),
            Command::ShowSettings => {
                let show = |program: &Program, index: usize, text: &mut Message| {
                    let setting = &SETTING_TABLE[index];
                    if self.has(setting) {
                        text.print(|text| report::setting(text, setting, &program.settings));
                    }
                };
                self.show(SETTING_TABLE.len(), show, text, out).await;
            }
            Command::ShowCatalogue(catalogue) => {
                let show = |program: &Program, index: usize, text: &mut Message| {
                    if catalogue.setting(index).is_none_or(|setting| self.has(setting)) {
                        text.print(|text| catalogue.print(text, index, &program.settings));
                    }
                };
                self.show(catalogue.lines(), show, text, out).await;
            }
            Command::DescribeSetting { number } => {
                self.check_drivers(number).map_err(|_| Error::UnknownStatement)?;
                text.print(|text| report::description(text, number));
            }
            Command::ShowParameters => {
                let show = |program: &Program, index: usize, text: &mut Message| {
                    text.print(|text| report::parameter(text, index, &program.interpreter, &program.settings));
                };
                self.show(report::PARAMETERS, show, text, out).await;
            }
            #[cfg(feature = "trinamic")]
            Command::ShowDrivers => self.show_drivers(text, out).await?,
            Command::ShowVfd => {
                let parts = [Vfd::show, Vfd::show_failed];
                self.show(
                    parts.len(),
                    |program, part, text| parts[part](&self.vfd, &program.settings, text),
                    text,
                    out,
                )
                .await;
            }
            Command::ShowModal => self.with(|program| {
                text.print(|text| report::modal(text, &program.interpreter, &program.settings));
            }),
            Command::ShowStartup => {
                let show = |program: &Program, index: usize, text: &mut Message| {
                    text.print(|text| report::startup(text, index, &program.startup[index]));
                };
                self.show(STARTUP_LINES, show, text, out).await;
            }
            Command::ShowBuild { is_extended } => self.show_build(is_extended, text, out).await,
            Command::SetSetting { number, value } => self.set(number, value, text)?,
            Command::SetStartup { index, ref block, line } => {
                self.block(block, text, out).await?;
                self.with(|program| {
                    // There is room: a line is no longer than a stored line.
                    program.startup[index] = line.try_into().unwrap_or_default();
                    program.unsaved.parameters = true;
                });
            }
            Command::SetBuild { text: line } => self.with(|program| {
                program.build_text = line.try_into().unwrap_or_default();
                program.unsaved.parameters = true;
            }),
            Command::Restore { settings, parameters } => return self.restore(settings, parameters, text),
            Command::ExplainError(error) => text.say(error),
            Command::ExplainAlarm(alarm) => text.say(alarm),
        }
        Ok(After::NextLine)
    }

    /// Sends a long reply, a message for each index below `count`.
    async fn show(
        &self,
        count: usize,
        write: impl Fn(&Program, usize, &mut Message),
        text: &mut Message,
        out: &Output,
    ) {
        for index in 0..count {
            self.with(|program| write(program, index, text));
            out.send(text).await;
            text.clear();
        }
    }

    #[cfg(feature = "trinamic")]
    async fn show_drivers(&self, text: &mut Message, out: &Output) -> Result<(), Error> {
        let drivers = self.drivers.as_ref().ok_or(Error::Unsupported)?;
        for page in 0.. {
            let Some(line) = self.with(|program| drivers.line(page, &program.settings)) else { break };
            text.say(line);
            out.send(text).await;
            text.clear();
        }
        Ok(())
    }

    /// Leaves an alarm without homing; does nothing in any other state.
    async fn unlock(&self, state: ReportedState, text: &mut Message) -> Result<(), Error> {
        if state != ReportedState::Alarm {
            return Ok(());
        }
        self.ready_to_unlock(state, text).await?;
        self.machine.unlock().map_err(|Busy(_)| Error::Locked)?;
        self.with(|program| (program.mode, program.changing) = (Mode::Normal, None));
        self.stop_tool();
        self.follow_machine();
        text.say(messages::UNLOCKED);
        Ok(())
    }

    /// Lets `notify` report an alarm before it is left: the line may have waited when the alarm was raised. Then does what has to be
    /// done before it may be left.
    ///
    /// # Errors
    /// That of what keeps the machine from it.
    async fn ready_to_unlock(&self, state: ReportedState, text: &mut Message) -> Result<(), Error> {
        if state == ReportedState::Alarm {
            yield_now().await;
        }
        self.closed_door()?;
        self.fit(text)?;
        self.reset_drives(text).await
    }

    /// Has drives that are in alarm forget it, by their ENABLE. Nothing holds the axes meanwhile, so it is not done where the machine
    /// would stay locked nevertheless.
    ///
    /// # Errors
    /// [`Error::Locked`], with a message, if one is in alarm still.
    ///
    /// # Cancellation
    /// The motors stay free until the next motion, or until it is done again.
    async fn reset_drives(&self, text: &mut Message) -> Result<(), Error> {
        if self.machine.status().emergency_stop || !self.machine.is_drive_in_alarm() {
            return Ok(());
        }
        self.machine.energise(false);
        Timer::after(DRIVE_RESET).await;
        self.machine.energise(true);
        Timer::after(DRIVE_RESET).await;
        if self.machine.is_drive_in_alarm() {
            text.say(messages::DRIVE_IN_ALARM);
            return Err(Error::Locked);
        }
        Ok(())
    }

    fn toggle_check(&self, state: ReportedState, text: &mut Message) -> After {
        if state == ReportedState::Check {
            text.say(messages::NOT_CHECKING);
            return After::Restart;
        }
        self.with(|program| {
            (program.mode, program.tool_before_check) = (Mode::Check, program.interpreter.tool_in_spindle())
        });
        text.say(messages::CHECKING);
        After::NextLine
    }

    fn restore(&self, settings: bool, parameters: bool, text: &mut Message) -> Result<After, Error> {
        if settings {
            self.adopt(Settings::DEFAULT, text)?;
        }
        if parameters {
            self.with(|program| {
                program.interpreter.set_coordinates(Coordinates::default());
                program.interpreter.set_tools(&ToolTable::default());
                program.startup = Default::default();
                if settings {
                    program.build_text.clear();
                }
                program.unsaved.parameters = true;
            });
        }
        text.say(messages::RESTORING);
        Ok(After::Restart)
    }

    /// Homes every axis, or one. The start-up lines are for a machine of which all axes are homed.
    async fn home(&self, axis: Option<usize>, state: ReportedState, text: &mut Message) -> Result<After, Error> {
        self.ready_to_unlock(state, text).await?;
        let axes = core::array::from_fn(|index| axis.is_none_or(|axis| axis == index));
        #[cfg(feature = "trinamic")]
        let looking = cold_path(pin!(self.look_for_stalls(axes, text))).await?;
        if self.state() == ReportedState::Alarm {
            self.stop_tool();
        }
        self.with(|program| program.mode = Mode::Normal);
        self.submit(Motion::Home { axes }).await?;
        let result = self.settled().await;
        self.follow_machine();
        self.forget_tool_reference(axes);
        #[cfg(feature = "trinamic")]
        if looking.is_some() && result.is_ok() {
            self.say_stalls(axes, text);
        }
        result.map(|()| if axis.is_none() { After::StartUp } else { After::NextLine })
    }

    /// Frees the motors and keeps the turn until a reset ends the line.
    async fn sleep(&self) -> Infallible {
        self.stop_tool();
        self.machine.energise(false);
        self.with(|program| program.mode = Mode::Sleep);
        core::future::pending().await
    }

    async fn show_build(&self, is_extended: bool, text: &mut Message, out: &Output) {
        self.with(|program| text.print(|text| report::build(text, &program.build_text, is_extended)));
        if is_extended {
            out.send(text).await;
            text.clear();
            self.with(|program| text.print(|text| report::extended_build(text, &program.settings)));
        }
        self.say_board(text);
    }

    /// What the board says of itself.
    fn say_board(&self, text: &mut Message) {
        if !self.board.is_empty() {
            // As grblHAL says it.
            text.print(|text| write!(text, "[BOARD:{}]\r\n", self.board));
        }
        text.say(match self.machine.emergency_contact() {
            Contact::NormallyOpen => "Emergency stop: normally open",
            Contact::NormallyClosed => "Emergency stop: normally closed",
        });
        let faults = self.machine.faults();
        if faults != [0; AXES] {
            text.say(format_args!("step ports faulted since power-up: {} times", Faults(faults)));
        }
    }

    fn set(&self, number: u16, value: f32, text: &mut Message) -> Result<(), Error> {
        if Vfd::is_about(number) && self.machine.outputs().spindle != Spindle::Off {
            text.say("the VFD would not be stopped any more: stop the spindle by M5, then set this");
            return Err(Error::NotIdle);
        }
        let before = self.settings();
        let changed = self.check_drivers(number).and_then(|()| before.with(number, value));
        match changed.and_then(|settings| self.check_pins(settings)) {
            Ok(settings) => {
                self.adopt(settings, text)?;
                for axis in 0..AXES {
                    let (steps, is_asked) = (settings.steps_per_mm[axis], usize::from(number) == 100 + axis);
                    if steps != before.steps_per_mm[axis] && !is_asked {
                        let (number, value) = (100 + axis, Fixed { value: steps, decimals: 3 });
                        text.say(format_args!("${number}={value} now, as the microsteps ask for"));
                    }
                }
                // There is room for one of the two.
                if self.fit(text).is_ok() && settings.spindle_type != before.spindle_type {
                    text.say(OTHER_SPINDLE);
                }
                Ok(())
            }
            Err(refused) => {
                text.say(refused);
                Err(refused.error())
            }
        }
    }

    fn adopt(&self, settings: Settings, text: &mut Message) -> Result<(), Error> {
        let before = self.machine.homed();
        self.put_in_force(settings).map_err(|_| {
            text.say(UNWORKABLE);
            Error::BadNumber
        })?;
        self.with(|program| program.unsaved.settings = true);
        #[cfg(feature = "trinamic")]
        if let Some(drivers) = &self.drivers {
            drivers.settings_changed();
        }
        let homed = self.machine.homed();
        let lost = core::array::from_fn(|axis| before[axis] && !homed[axis]);
        if lost.contains(&true) {
            text.say(format_args!("what the position of{} means has changed: home again with $H", Axes(lost)));
        }
        Ok(())
    }

    /// Puts settings in force whose values have been checked. The machine is configured by them if they work together; it
    /// checks them again, and a test makes sure that it refuses nothing that has passed.
    fn put_in_force(&self, settings: Settings) -> Result<(), ConfigError> {
        let fits = self.check_together(&settings).is_ok();
        if fits {
            let config = config(&settings);
            self.machine.configure(config)?;
            self.with(|program| program.geometry = Geometry::of(&config));
        }
        if !fits || settings.laser_mode != self.with(|program| program.settings.laser_mode) {
            // What switches a laser on in moves only would switch a spindle on at once.
            self.stop_tool();
        }
        self.with(|program| (program.settings, program.fits) = (settings, fits));
        self.follow_if_elsewhere();
        Ok(())
    }

    fn check_together<'s>(&self, settings: &'s Settings) -> Result<(), Conflict<'s>> {
        settings.check(&|pulse_us| carries_steps_s(self.machine.capabilities(), pulse_us))
    }

    /// Refuses with a message while settings do not work together.
    pub(crate) fn fit(&self, text: &mut Message) -> Result<(), Error> {
        self.check_together(&self.settings()).map_err(|why| {
            text.say(Unfit(why));
            why.error()
        })
    }

    /// True if the board has what the setting is about.
    fn has(&self, setting: &Setting) -> bool {
        #[cfg(feature = "trinamic")]
        let has_drivers = self.drivers.is_some();
        #[cfg(not(feature = "trinamic"))]
        let has_drivers = false;
        has_drivers || !setting.is_trinamic()
    }

    /// Refuses a setting of drivers that the board does not have.
    fn check_drivers(&self, number: u16) -> Result<(), SettingError> {
        let mut settings = SETTING_TABLE.iter().filter(|setting| setting.numbers().contains(&number));
        if settings.all(|setting| self.has(setting)) { Ok(()) } else { Err(SettingError::NoTrinamic { number }) }
    }

    /// Refuses settings that need outputs or inputs which the board does not have.
    fn check_pins(&self, settings: Settings) -> Result<Settings, SettingError> {
        let (mask, inputs) = (settings.drive_alarm_mask, self.drive_alarm_inputs);
        match settings.second_motor() {
            Some(_) if !self.has_second_motor => Err(SettingError::NoSecondMotor),
            _ if mask & !inputs != 0 => Err(SettingError::NoDriveAlarm { mask, inputs }),
            _ => Ok(settings),
        }
    }

    /// Puts stored settings in force, if their values may be.
    pub(crate) fn put_back(&self, settings: Settings) -> Result<(), Loss> {
        settings.check_ranges().map_err(Loss::Refused)?;
        let settings = self.check_pins(settings).map_err(Loss::Refused)?;
        self.put_in_force(settings).map_err(|_| Loss::Unworkable)
    }

    /// Stores what has changed, as soon as nothing moves, because programming the flash stops the core. The caller has
    /// the turn, so that nothing begins to move meanwhile.
    ///
    /// # Errors
    /// [`Error::NotStored`], with a message in `text`.
    ///
    /// # Cancellation
    /// Safe: what is not stored stays marked, and the next line stores it, or the welcome after the reset.
    pub(crate) async fn save(&self, text: &mut Message) -> Result<(), Error> {
        self.machine.emptied().await;
        let settings = self.with(|program| program.unsaved.settings);
        let saved = self.store.lock().await.save(settings, |item| self.with(|program| program.value(item))).await;
        self.with(|program| {
            // If the flash has refused, it is not asked again with every line that follows.
            program.unsaved = Unsaved::default();
            program.loss.take_if(|loss| saved.is_ok() && (settings || !loss.is_of_settings()));
        });
        saved.map_err(|NotStored| {
            text.say(Error::NotStored);
            Error::NotStored
        })
    }
}

/// The number of times that the ports have faulted. Prints `X 0, Y 2, Z 1`.
struct Faults([u32; AXES]);

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Axis::ALL.into_iter().try_for_each(|axis| {
            let comma = if axis == Axis::X { "" } else { ", " };
            write!(f, "{comma}{axis} {}", self.0[axis as usize])
        })
    }
}

/// Some of the axes. Prints their letters, each after a space.
struct Axes([bool; AXES]);

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut named = Axis::ALL.into_iter().filter(|&axis| self.0[axis as usize]);
        named.try_for_each(|axis| write!(f, " {axis}"))
    }
}
