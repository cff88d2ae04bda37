//! From G-code blocks and jogs to the machine's motions.

use core::pin::pin;

use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::report::messages;
use isostep_console::{Arc, Block, BlockMove, Error, Jog, Overrides, Rate};
use isostep_motion::{AXES, Axis, Busy, Motion, Move, cold_path};

use crate::beyond::Beyond;
use crate::controller::{Controller, Mode};
use crate::cycles::dwell;
use crate::output::{Message, Output};

/// The number of times that an axis is moved to and fro to check its wiring.
const BUZZES: usize = 10;
/// The speed at which it is moved, mm/s.
const BUZZ_MM_S: f64 = 5.0;
/// The largest deviation from the corners of jogs, mm. A blend that is committed is made to its end, and a cancel must not wait for a
/// long one.
const JOG_DEVIATION_MAX_MM: f32 = 0.05;

impl<F: NorFlash> Controller<'_, F> {
    /// Carries out a G-code block that the interpreter has accepted. `text` is empty; messages that come before the
    /// answer are left in it.
    pub(crate) async fn block(&self, block: &Block, text: &mut Message, out: &Output) -> Result<(), Error> {
        let (checks, offset_pm, has_new_offset) = self.with(|program| {
            program.unsaved.parameters |= block.changes_parameters;
            let offset_pm = program.interpreter.work_offset_pm();
            (program.mode == Mode::Check, offset_pm, offset_pm != program.work_offset_pm)
        });
        if has_new_offset || block.tool_change.is_some() || block.dwell_s.is_some() || self.switches(block) {
            cold_path(pin!(self.before_motion(block, offset_pm, checks, text, out))).await?;
        }
        if let Some(motion) = &block.motion {
            if let Some(via_pm) = &block.via_pm {
                cold_path(pin!(self.go_to(via_pm, motion, block.line_number, checks, text))).await?;
            }
            self.go_to(&motion.target_pm, motion, block.line_number, checks, text).await?;
        }
        if block.drills || block.probe.is_some() || block.pauses || block.ends_program {
            cold_path(pin!(self.after_motion(block, checks, text))).await?;
        }
        Ok(())
    }

    /// Carries out what comes before the motion of a block: a change of the tool, of what it does, a dwell, a new offset.
    async fn before_motion(
        &self,
        block: &Block,
        offset_pm: [i64; AXES],
        checks: bool,
        text: &mut Message,
        out: &Output,
    ) -> Result<(), Error> {
        if let Some(tool) = block.tool_change.filter(|_| !checks) {
            self.change_tool(tool, text, out).await?;
        }
        if !checks && self.switches(block) {
            self.may_turn(text)?;
            self.switch_tool(block.switches_coolant).await?;
        }
        let dwell_s = block.dwell_s.filter(|_| !checks);
        if let Some(dwell_s) = dwell_s {
            self.submit(Motion::Dwell(dwell(dwell_s))).await?;
        }
        if dwell_s.is_some() || offset_pm != self.with(|program| program.work_offset_pm) {
            // A dwell is answered when it is over, because senders use it to wait for the end of motion. A new offset
            // counts only once the moves before it have ended; otherwise their work position would jump.
            self.settled().await?;
            self.with(|program| program.work_offset_pm = offset_pm);
        }
        Ok(())
    }

    /// Carries out what is seldom in a block: holes, a probing, a pause, the end of the program.
    async fn after_motion(&self, block: &Block, checks: bool, text: &mut Message) -> Result<(), Error> {
        if block.drills {
            self.drill(block.line_number, checks, text).await?;
        }
        if let Some(probe) = &block.probe {
            self.probe(probe, block.line_number, checks, text).await?;
        }
        if block.pauses || block.ends_program {
            self.settled().await?;
        }
        if block.pauses && !checks {
            // M0.
            self.pause().await?;
        }
        if block.ends_program {
            self.with(|program| program.overrides = Overrides::DEFAULT);
            self.override_machine();
            if !checks {
                self.stop_tool();
            }
            text.say(messages::PROGRAM_END);
        }
        Ok(())
    }

    /// M6: when the moves before it have ended, holds the machine so that the tool can be put in, and sends a message
    /// about it at once. The answer to the line comes after the resume.
    async fn change_tool(&self, tool: u32, text: &mut Message, out: &Output) -> Result<(), Error> {
        self.settled().await?;
        if self.with(|program| core::mem::take(&mut program.has_changed)) {
            return Ok(());
        }
        match tool {
            0 => text.say(messages::CHANGE_TOOL),
            _ => text.say(format_args!("M6: put in tool {tool}, then resume with ~")),
        }
        out.send(text).await;
        text.clear();
        self.begin_pause();
        // If a reset ends the wait, nobody knows which tool is in.
        self.with(|program| program.interpreter.set_tool_in_spindle(0));
        self.machine.hold_for_tool_change();
        self.settled().await?;
        self.with(|program| program.interpreter.set_tool_in_spindle(tool));
        Ok(())
    }

    /// True for M3 to M5, M7 to M9, and the S of a spindle that turns: that of one that stands still waits for M3, and the S
    /// of a laser belongs to each move.
    fn switches(&self, block: &Block) -> bool {
        block.switches_spindle || block.switches_coolant || block.changes_speed && self.spindle_turns()
    }

    /// Holds until a resume, or a reset.
    async fn pause(&self) -> Result<(), Error> {
        self.begin_pause();
        self.machine.hold();
        self.settled().await
    }

    /// Notes that a line holds the machine: jogs that have come before the resume are not made after it.
    fn begin_pause(&self) {
        self.pauses.set(self.pauses.get().wrapping_add(1));
    }

    /// Begins a jog. A jog to a place outside the travel does not begin, and locks nothing.
    pub(crate) async fn jog(&self, jog: &Jog) -> Result<(), Error> {
        self.closed_door()?;
        let target_steps = self.steps(jog.target_pm);
        if self.beyond_travel(target_steps).is_some() {
            return Err(Error::TravelExceeded);
        }
        // Its corners are taken by `$904`, and not by path modes: G61 and G64 are a program's.
        let one = self.with(|program| {
            let deviation_mm = program.settings.blend_deviation_mm.min(JOG_DEVIATION_MAX_MM);
            let offsets = if deviation_mm > 0.0 { program.geometry.offsets(jog.target_pm) } else { [0; AXES] };
            let (feed_mm_s, source) = (f64::from(jog.mm_min) / 60.0, program.source);
            Move { feed_mm_s, source, deviation_mm, offsets, ..Move::to(target_steps) }
        });
        self.submit(Motion::Jog(one)).await?;
        self.with(|program| {
            program.interpreter.set_position_pm(jog.target_pm);
            program.jogged = true;
        });
        Ok(())
    }

    /// Refuses if the safety door is open, because somebody may be reaching into the machine.
    pub(crate) fn closed_door(&self) -> Result<(), Error> {
        if self.machine.door().is_open { Err(Error::DoorOpen) } else { Ok(()) }
    }

    /// Asks for a motion. It refuses until a reset is complete, so that no motion from before the reset is made after
    /// it.
    pub(crate) async fn submit(&self, motion: Motion) -> Result<(), Error> {
        if self.is_restarting() {
            return Err(Error::Locked);
        }
        self.machine.submit(motion).await.map_err(|Busy(_)| {
            self.follow_machine();
            Error::Locked
        })
    }

    pub(crate) async fn settled(&self) -> Result<(), Error> {
        self.machine.settled().await.map_err(|_| {
            self.follow_machine();
            Error::Locked
        })
    }

    /// Moves an axis by 1 mm and back, ten times; away from the end of its travel. It ends where it began.
    pub(crate) async fn buzz(&self, axis: Axis, text: &mut Message) -> Result<(), Error> {
        let (from, millimetre) = (self.machine.position_steps(), self.machine.config().steps(axis, 1.0));
        let to = |steps: i32| {
            let mut target_steps = from;
            target_steps[axis as usize] += steps;
            target_steps
        };
        let away = if self.beyond_travel(to(millimetre)).is_some() { to(-millimetre) } else { to(millimetre) };
        for target_steps in [away, from].into_iter().cycle().take(2 * BUZZES) {
            let (feed_mm_s, source) = (BUZZ_MM_S, self.source());
            self.submit(Motion::Move(Move { feed_mm_s, source, exact_stop: true, ..Move::to(target_steps) })).await?;
        }
        self.settled().await?;
        text.say(format_args!("{axis} should have moved 1 mm to and fro {BUZZES} times: if not, see docs/bring-up.md"));
        Ok(())
    }

    /// Goes to a target, that of `like` or one on the way to it, as `like` is to be made.
    async fn go_to(
        &self,
        target_pm: &[i64; AXES],
        like: &BlockMove,
        line: u32,
        checks: bool,
        text: &mut Message,
    ) -> Result<(), Error> {
        let (target_steps, beyond) = self.target_steps(*target_pm, like.arc.as_ref());
        if let Some(beyond) = beyond {
            return Err(cold_path(pin!(self.refuse_target(beyond, like.arc.is_some(), text))).await);
        }
        if checks {
            return Ok(());
        }
        let mut one = self.like(like, target_steps, line);
        match &like.arc {
            Some(arc) => cold_path(pin!(self.follow(arc, &one))).await,
            None => {
                if one.deviation_mm > 0.0 {
                    one.offsets = self.with(|program| program.geometry.offsets(*target_pm));
                }
                self.submit(Motion::Move(one)).await
            }
        }
    }

    /// A move to a place, to be made as `like`, without the place's offsets.
    pub(crate) fn like(&self, like: &BlockMove, target_steps: [i32; AXES], line: u32) -> Move {
        let BlockMove { rate, arc, path, .. } = like;
        let deviation_mm = |setting_mm| match arc {
            Some(_) => path.chords_deviation_mm(setting_mm),
            None => path.deviation_mm(setting_mm),
        };
        let feed_mm_s = match rate {
            Rate::Rapid => f64::INFINITY,
            Rate::Feed { mm_min } => f64::from(*mm_min) / 60.0,
        };
        let exact_stop = path.stops();
        let together_mm = |setting_mm| if arc.is_some() { 0.0 } else { path.together_mm(setting_mm) };
        self.with(|program| Move {
            feed_mm_s,
            exact_stop,
            deviation_mm: deviation_mm(program.settings.blend_deviation_mm),
            together_mm: together_mm(program.settings.blend_deviation_mm),
            power: program.power(*rate),
            line,
            source: program.source,
            ..Move::to(target_steps)
        })
    }

    /// The number of the line that is carried out.
    pub(crate) fn source(&self) -> u32 {
        self.with(|program| program.source)
    }

    /// A target in steps, and a place on the path to it that is outside the travel, if there is one.
    pub(crate) fn target_steps(&self, target_pm: [i64; AXES], arc: Option<&Arc>) -> ([i32; AXES], Option<Beyond>) {
        let target_steps = self.steps(target_pm);
        let beyond = |place_steps: [i32; AXES]| {
            self.beyond_travel(place_steps).map(|axis| Beyond { axis, place_steps: place_steps[axis as usize] })
        };
        // A straight move is within the travel if its end is, an arc if its bounding box is.
        let beyond = match arc {
            None => beyond(target_steps),
            Some(arc) => self.bounds_steps(arc).into_iter().find_map(beyond),
        };
        (target_steps, beyond)
    }

    pub(crate) fn steps(&self, target_pm: [i64; AXES]) -> [i32; AXES] {
        self.with(|program| program.geometry.steps(target_pm))
    }

    /// The first homed axis whose target is outside its travel. Without homing nobody knows where the travel is.
    pub(crate) fn beyond_travel(&self, target_steps: [i32; AXES]) -> Option<Axis> {
        if !self.with(|program| program.settings.soft_limits) {
            return None;
        }
        let homed = self.machine.homed();
        self.with(|program| {
            let travels = &program.geometry.travel_steps;
            let outside = |axis: &Axis| {
                let axis = *axis as usize;
                homed[axis] && !travels[axis].contains(&target_steps[axis])
            };
            Axis::ALL.into_iter().find(outside)
        })
    }
}
