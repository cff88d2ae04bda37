//! M6 by `$341`: up and away before hands come near, the length of the new tool measured, and back to where it was.
//!
//! The line with M6 is answered when the machine waits for the new tool, as in grblHAL; so a sender goes on and its next lines wait. Then
//! the line is put back before them. When the tool has been changed it is read once more, and what else it asks for is done.

use embassy_futures::yield_now;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::report::messages;
use isostep_console::{AXES, Coordinate, Error, ReportedState, ToolChange, length};
use isostep_motion::{Motion, Move, Outputs, ProbeMove, Spindle, State};

use crate::commands::After;
use crate::controller::Controller;
use crate::jogs::Fate;
use crate::output::{Message, Output};
use crate::status::position_pm;

/// The index of Z, which firmware for two axes has not.
const Z: usize = 2;
/// The way up from the first contact with a tool, before the slow one, as in grblHAL; and twice that behind the slow one.
const RETRACT_PM: i64 = 2_000_000_000;

/// A change of the tool that is under way.
#[derive(Clone, Copy)]
pub(crate) struct Changing {
    /// The tool to put in; 0 if it has no number.
    tool: u32,
    /// Where the program goes on, in machine coordinates.
    back_pm: [i64; AXES],
    /// Work zero of Z there.
    zero_pm: i64,
    progress: ChangeProgress,
    /// The start button is pressed.
    is_pressed: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ChangeProgress {
    /// Nobody has said that the tool is in.
    Waits,
    /// Its length is known.
    Measured,
    /// Somebody has said that the tool is in, but its length is not known; a console is to say so.
    Warns,
    /// A console has said so.
    Warned,
    /// The program goes on.
    Over,
}

/// What a console that waits behind M6 does next.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Awaited {
    Nothing,
    /// Says that the length is not known.
    Warning,
    /// Reads the line with M6 once more.
    Line,
}

impl<F: NorFlash> Controller<'_, F> {
    /// True for a line that was put back until the tool had been changed, and for any if M6 goes away to measure tools.
    pub(crate) fn may_change_tool(&self, fate: Fate) -> bool {
        fate == Fate::SentAgain || self.with(|program| program.settings.tool_change_mode != 0)
    }

    /// Begins or ends the change of the tool that a line asks for. Returns what follows, if the line itself does not.
    pub(crate) async fn change_around(
        &self,
        line: &str,
        fate: Fate,
        text: &mut Message,
        out: &Output,
    ) -> Result<Option<After>, Error> {
        if fate == Fate::SentAgain {
            let is_over = self.end_change(text, out).await?;
            return Ok((!is_over).then_some(After::ToolChange));
        }
        match self.tool_to_change(line) {
            None => Ok(None),
            Some(tool) => {
                self.begin_change(tool?, text).await?;
                Ok(Some(After::ToolChange))
            }
        }
    }

    /// The tool for which a line asks to go away, wait and measure; `None` if the line does not, or if it will be refused.
    ///
    /// # Errors
    /// [`Error::ToolChangePending`], [`Error::HomingNeeded`].
    fn tool_to_change(&self, line: &str) -> Option<Result<u32, Error>> {
        let names_m6 = line.split('M').skip(1).any(|word| word.trim_start_matches('0').starts_with('6'));
        let state = self.state();
        let measures = self.with(|program| program.settings.tool_change().measures());
        if !measures || !names_m6 || state.takes_gcode().is_err() || state == ReportedState::Check || AXES <= Z {
            return None;
        }
        let tool = self.with(|program| {
            let mut at_line = program.interpreter;
            at_line.gcode(line, &program.settings).ok().and_then(|block| block.tool_change)
        })?;
        let homed = self.machine.homed();
        let is_placed = match self.with(|program| program.settings.tool_change()) {
            ToolChange::Manual => homed.get(Z) == Some(&true),
            _ => homed.iter().take(Z + 1).all(|&is_homed| is_homed),
        };
        Some(match self.with(|program| program.changing.is_some()) {
            true => Err(Error::ToolChangePending),
            false if !is_placed => Err(Error::HomingNeeded),
            false => Ok(tool),
        })
    }

    /// Brings the machine to where the tool can be changed, when the moves before have ended: spindle and coolant off, Z up, and with
    /// `$341=2` to G59.3.
    ///
    /// # Cancellation
    /// Safe: the moves that were asked for go on. Which tool is in the spindle is not known then.
    async fn begin_change(&self, tool: u32, text: &mut Message) -> Result<(), Error> {
        self.settled().await?;
        let (mode, back_pm, zero_pm, setter_pm) = self.with(|program| {
            let interpreter = &program.interpreter;
            let zero_pm = along_z(&interpreter.work_offset_pm());
            (program.settings.tool_change(), interpreter.position_pm(), zero_pm, interpreter.tool_setter_pm())
        });
        if mode != ToolChange::Manual
            && let Some(beyond) = self.target_steps(setter_pm, None).1
        {
            return Err(self.refuse_target(beyond, false, text).await);
        }
        self.machine.set_outputs(Outputs::OFF).map_err(|_| Error::Locked)?;
        self.with(|program| {
            program.spindle = Spindle::Off;
            program.interpreter.set_tool_in_spindle(0);
        });
        let up_pm = self.top_pm();
        self.rapid(with_z(back_pm, up_pm)).await?;
        if mode == ToolChange::ManualAtSetter {
            self.rapid(with_z(setter_pm, up_pm)).await?;
            self.rapid(setter_pm).await?;
        }
        self.settled().await?;
        let changing = Changing { tool, back_pm, zero_pm, progress: ChangeProgress::Waits, is_pressed: true };
        self.with(|program| program.changing = Some(changing));
        match tool {
            0 => text.say(messages::CHANGE_TOOL),
            _ => text.say(format_args!("M6: put in tool {tool}, {}", what_next(mode))),
        }
        Ok(())
    }

    /// Somebody says that the tool is in.
    #[cold]
    pub(crate) fn resume_change(&self) {
        let is_ready = self.machine.state() == State::Idle && !self.machine.door().is_open;
        self.with(|program| {
            let by_itself = program.settings.tool_change() == ToolChange::AutomaticAtSetter;
            let zero_pm = along_z(&program.interpreter.work_offset_pm());
            if let Some(changing) = program.changing.as_mut().filter(|_| is_ready) {
                let is_known = by_itself || zero_pm != changing.zero_pm;
                changing.progress = match changing.progress {
                    ChangeProgress::Waits if !is_known => ChangeProgress::Warns,
                    ChangeProgress::Warns => ChangeProgress::Warns,
                    _ => ChangeProgress::Over,
                };
            }
        });
        self.machine.announce();
    }

    /// The state that reports name where the machine itself is at rest or runs. Senders take Run for the end of the change, and count
    /// no `ok` as one of the program's before: so it is Run from when the program goes on, and not before.
    #[cold]
    pub(crate) fn state_in_change(&self, state: ReportedState) -> ReportedState {
        match self.with(|program| program.changing.map(|changing| changing.progress)) {
            None => state,
            Some(ChangeProgress::Over) => ReportedState::Run,
            Some(_) => ReportedState::Tool,
        }
    }

    /// What a console that waits behind M6 does next. An alarm ends the change.
    #[cold]
    pub(crate) fn awaited(&self) -> Awaited {
        let is_pressed = self.machine.status().buttons[1];
        let was_pressed = self.with(|program| {
            let changing = program.changing.as_mut();
            changing.is_none_or(|changing| core::mem::replace(&mut changing.is_pressed, is_pressed))
        });
        if is_pressed && !was_pressed {
            self.resume_change();
        }
        let is_locked = self.state() == ReportedState::Alarm;
        self.with(|program| {
            program.changing.take_if(|_| is_locked);
            match &mut program.changing {
                None | Some(Changing { progress: ChangeProgress::Over, .. }) => Awaited::Line,
                Some(changing) if changing.progress == ChangeProgress::Warns => {
                    changing.progress = ChangeProgress::Warned;
                    Awaited::Warning
                }
                Some(_) => Awaited::Nothing,
            }
        })
    }

    /// Goes back to where the program goes on, by Z up, with spindle and coolant as they were; with `$341=3` the tool is measured before.
    /// Z is where the end of the new tool is as high as that of the old one was, if the travel allows. Returns false if the change is
    /// not over, because the tool was not measured.
    ///
    /// # Errors
    /// [`Error::Locked`]: an alarm has ended the change.
    ///
    /// # Cancellation
    /// As [`begin_change`](Self::begin_change).
    async fn end_change(&self, text: &mut Message, out: &Output) -> Result<bool, Error> {
        let Some(Changing { tool, back_pm, zero_pm, .. }) = self.with(|program| program.changing) else {
            return Err(Error::Locked);
        };
        self.settled().await?;
        self.follow_if_elsewhere();
        let mode = self.with(|program| program.settings.tool_change());
        if mode == ToolChange::AutomaticAtSetter && self.measure_at_setter(text).await.is_err() {
            self.settled().await?;
            self.rise().await?;
            self.settled().await?;
            self.with(|program| {
                program.changing.iter_mut().for_each(|changing| changing.progress = ChangeProgress::Waits);
            });
            return Ok(false);
        }
        // The way back takes its time.
        out.send(text).await;
        text.clear();
        let up_pm = self.rise().await?;
        self.rapid(with_z(back_pm, up_pm)).await?;
        self.switch_tool(true).await?;
        let lower_pm = self.with(|program| along_z(&program.interpreter.work_offset_pm())) - zero_pm;
        self.rapid(with_z(back_pm, self.within_travel_pm(along_z(&back_pm) + lower_pm))).await?;
        self.settled().await?;
        self.with(|program| {
            program.changing = None;
            program.has_changed = true;
            program.interpreter.set_tool_in_spindle(tool);
        });
        Ok(true)
    }

    async fn measure_at_setter(&self, text: &mut Message) -> Result<(), Error> {
        let up_pm = self.rise().await?;
        let setter_pm = self.with(|program| program.interpreter.tool_setter_pm());
        self.rapid(with_z(setter_pm, up_pm)).await?;
        self.rapid(setter_pm).await?;
        self.measure_tool(text).await
    }

    /// `$TPW`: goes straight down from where the machine stands until the probe touches, once fast and once slowly, and up again. The
    /// first tool counts as of length 0, and others by how much farther they reach down.
    ///
    /// # Errors
    /// [`Error::ToolNotMeasured`], after a message; [`Error::Locked`].
    ///
    /// # Cancellation
    /// Safe: the motion that was asked for goes on to its end.
    pub(crate) async fn measure_tool(&self, text: &mut Message) -> Result<(), Error> {
        self.settled().await?;
        self.follow_machine();
        let touched_pm = match self.touch_off().await? {
            Ok(touched_pm) => touched_pm,
            Err(why) => {
                text.say(why);
                return Err(Error::ToolNotMeasured);
            }
        };
        self.report_probed(text);
        self.take_length(touched_pm, text)
    }

    /// The height of Z at a slow contact, or why there is none.
    async fn touch_off(&self) -> Result<Result<i64, &'static str>, Error> {
        let (from_pm, settings) = self.with(|program| (program.interpreter.position_pm(), program.settings));
        let seek_mm_s = f64::from(settings.tool_seek_mm_min) / 60.0;
        let low_pm = along_z(&from_pm) - length::from_mm(settings.tool_probe_mm.into());
        let Some(first_pm) = self.touch(low_pm, seek_mm_s).await? else {
            self.feed(from_pm, seek_mm_s).await?;
            self.settled().await?;
            return Ok(Err(if self.machine.status().probe_touches {
                messages::PROBE_TOUCHES
            } else {
                messages::PROBE_MISSED
            }));
        };
        self.feed(with_z(from_pm, first_pm + RETRACT_PM), seek_mm_s).await?;
        let touched_pm = self.touch(first_pm - RETRACT_PM, f64::from(settings.tool_latch_mm_min) / 60.0).await?;
        let up_pm = touched_pm.unwrap_or(first_pm) + 2 * RETRACT_PM;
        self.feed(with_z(from_pm, self.within_travel_pm(up_pm)), seek_mm_s).await?;
        self.settled().await?;
        self.follow_machine();
        Ok(touched_pm.ok_or(messages::PROBE_TOUCHES))
    }

    /// Goes down until the probe touches. Returns the height of Z there; `None` if it touches before, or does not.
    async fn touch(&self, low_pm: i64, feed_mm_s: f64) -> Result<Option<i64>, Error> {
        self.settled().await?;
        if self.machine.status().probe_touches {
            return Ok(None);
        }
        let from_pm = position_pm(self.machine.position_steps(), &self.machine.config());
        let target_steps = self.steps(with_z(from_pm, self.within_travel_pm(low_pm)));
        self.submit(Motion::Probe(ProbeMove { target_steps, feed_mm_s, away: false, must: false, line: 0 })).await?;
        self.settled().await?;
        let probed = self.machine.probed();
        let place_pm = position_pm(probed.position_steps, &self.machine.config());
        Ok(probed.touched.then(|| along_z(&place_pm)))
    }

    fn take_length(&self, touched_pm: i64, text: &mut Message) -> Result<(), Error> {
        let taken = self.with(|program| {
            let reference_pm = program.reference_pm;
            let length_pm = touched_pm - reference_pm.unwrap_or(touched_pm);
            program.reference_pm = Some(reference_pm.unwrap_or(touched_pm));
            let tool = program.changing.map_or(program.interpreter.tool_in_spindle(), |changing| changing.tool);
            let before = *program.interpreter.tools();
            let result = program.interpreter.set_measured_length_pm(tool, length_pm);
            program.unsaved.parameters |= before != *program.interpreter.tools();
            program.work_offset_pm = program.interpreter.work_offset_pm();
            program.changing.iter_mut().for_each(|changing| changing.progress = ChangeProgress::Measured);
            result.map(|()| reference_pm.map(|_| Coordinate { pm: length_pm, inches: program.settings.report_inches }))
        })?;
        match taken {
            None => text.say(messages::REFERENCE),
            Some(length) => text.say(format_args!("The length of this tool is {length}")),
        }
        Ok(())
    }

    /// `$TLR`: the last contact of the probe was that of a tool of length 0; without one, no tool has length 0.
    pub(crate) fn set_tool_reference(&self) {
        self.with(|program| {
            let (place_pm, touched) = program.interpreter.touched();
            program.reference_pm = touched.then(|| along_z(&place_pm));
        });
    }

    /// Z has been homed: the height at which a tool of length 0 touches is another.
    pub(crate) fn forget_tool_reference(&self, homed: [bool; AXES]) {
        if homed.get(Z) == Some(&true) {
            self.with(|program| program.reference_pm = None);
        }
    }

    /// The highest place of Z.
    fn top_pm(&self) -> i64 {
        self.within_travel_pm(i64::MAX)
    }

    /// The place of Z that is nearest to this and within the travel.
    fn within_travel_pm(&self, z_pm: i64) -> i64 {
        let config = self.machine.config();
        let Some(&axis) = isostep_motion::Axis::ALL.get(Z) else { return z_pm };
        let travel = config.travel_steps(axis);
        let [low_pm, high_pm] = [*travel.start(), *travel.end()].map(|steps| length::from_mm(config.mm(axis, steps)));
        z_pm.clamp(low_pm, high_pm)
    }

    /// Goes up from where the program is. Returns how high that is.
    async fn rise(&self) -> Result<i64, Error> {
        let (from_pm, up_pm) = (self.with(|program| program.interpreter.position_pm()), self.top_pm());
        self.rapid(with_z(from_pm, up_pm)).await?;
        Ok(up_pm)
    }

    /// Goes straight to a place, as fast as the axes allow, and stops there.
    async fn rapid(&self, target_pm: [i64; AXES]) -> Result<(), Error> {
        self.feed(target_pm, f64::INFINITY).await
    }

    async fn feed(&self, target_pm: [i64; AXES], feed_mm_s: f64) -> Result<(), Error> {
        let one = Move { feed_mm_s, source: self.source(), exact_stop: true, ..Move::to(self.steps(target_pm)) };
        self.submit(Motion::Move(one)).await?;
        self.with(|program| program.interpreter.set_position_pm(target_pm));
        // The ports' queues are filled between moves.
        yield_now().await;
        Ok(())
    }
}

/// What a person does when the tool is in.
fn what_next(mode: ToolChange) -> &'static str {
    match mode {
        ToolChange::Manual => "jog onto the plate and measure it ($TPW), or set Z by hand; then ~",
        ToolChange::ManualAtSetter => "measure it ($TPW), then ~",
        _ => "then ~: it is measured at G59.3",
    }
}

fn along_z(place_pm: &[i64; AXES]) -> i64 {
    place_pm.get(Z).copied().unwrap_or_default()
}

fn with_z(mut place_pm: [i64; AXES], z_pm: i64) -> [i64; AXES] {
    place_pm.iter_mut().skip(Z).take(1).for_each(|z| *z = z_pm);
    place_pm
}
