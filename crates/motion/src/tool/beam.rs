//! The power at which a laser shines along the chunks of a run.
//!
//! # Design
//! A level belongs to a move: it begins with the move's plan, half a step before its first step. If a move is made for
//! several lines of a program, each begins at a mark, at the instant that the plan gives for this place. Where the level
//! follows the speed, a phase of constant acceleration is a stroke whose level changes linearly. A curved ramp is made
//! of short strokes, so that their chords deviate little. Strokes that have been queued are committed, as steps
//! are. In a hold, too, the machine brakes with the level that belongs to the speed.

use embassy_time::Instant;
use isostep_profile::SpeedProfile;
use isostep_profile::chain::Plan;

use super::power::{Asked, Level, Power};
use super::stroke::Stroke;
use crate::axes::AXES;
use crate::chunks::Chunks;
use crate::clock::{TICK_S, instant_near, seconds};
use crate::machine::{Machine, path_speed_mm_s, plan_speed_steps_s};
use crate::marks::{Marks, Walk};
use crate::tag::Chunk;

/// The longest stroke of a straight ramp, s.
const STRAIGHT_S: f64 = seconds(Asked::CHANGE_MAX);
/// The longest stroke of a curved ramp, s.
const CURVED_S: f64 = 0.002;
/// The same for a speed profile over displacement, s. There the chip takes milliseconds to compute a speed.
const OVER_DISPLACEMENT_S: f64 = 0.01;
/// Where a line ends so soon after a chunk, s, its stroke goes on to there: a stroke of its own would be shorter than what
/// the tool's task takes for it, and the next line would begin late. If the machine brakes from the end of that chunk on,
/// the next level comes too early instead, by less than this.
const SLIVER_S: f64 = 50e-6;
/// Shorter strokes are left out, s: half of the resolution of instants.
const NOTHING_S: f64 = 0.5 * TICK_S;

/// Queues a run's strokes for the tool's task.
pub(crate) struct BeamStream<'a> {
    machine: &'a Machine,
    start: Instant,
    longest_s: f64,
    /// The number of the chunk whose strokes it queues.
    chunk: u32,
    /// Up to when strokes have been queued, s from the start of the run; and that instant.
    queued_s: f64,
    queued: Instant,
    /// The speed there, as a multiple of the one that was asked for, once it has been computed by the chunk's plan.
    ratio: Option<f32>,
    /// The line whose power shines there, once the stream has reached that chunk.
    line: Option<LaserLine>,
    /// The power that shone last, and the speed that was asked for there.
    last: (Power, f64),
    steps_per_mm: [f64; AXES],
}

/// The part of the laser's work in a chunk that one line of a program asks for.
#[derive(Clone, Copy)]
struct LaserLine {
    power: Power,
    /// The speed that is asked for, mm/s.
    asked_mm_s: f64,
    /// The instant at which the next line begins by this plan, s from the start of the run; infinite if none does.
    until_s: f64,
    /// The power from then on.
    next: Power,
    /// The instants at which the plan begins to cruise, and to slow down, s from the start of the run.
    cruises_s: f64,
    slows_s: f64,
    /// The speed of the cruise, as a multiple of the one that was asked for.
    cruise_ratio: f32,
    /// The marks after that.
    ahead: Walk,
}

impl<'a> BeamStream<'a> {
    /// The stream of a run that started at `start`; `None` if there is no laser.
    pub fn new(machine: &'a Machine, start: Instant) -> Option<Self> {
        let config = machine.config();
        let longest_s = match config.speed_profile {
            SpeedProfile::Trapezoid => STRAIGHT_S,
            speed_profile if speed_profile.is_over_displacement() => OVER_DISPLACEMENT_S,
            _ => CURVED_S,
        };
        config.tool.laser.then_some(Self {
            machine,
            start,
            longest_s,
            chunk: 0,
            queued_s: 0.0,
            queued: start,
            ratio: None,
            line: None,
            last: (Power::Off, 0.0),
            steps_per_mm: config.motor_steps_per_mm(),
        })
    }

    /// The number of the chunk whose strokes it queues.
    pub fn chunk(&self) -> u32 {
        self.chunk
    }

    /// Queues strokes up to `until_s` from the start of the run, as far as the path is known and there is room.
    pub fn fill_queue(&mut self, chunks: &Chunks, marks: &Marks, until_s: f64) {
        while let Some(chunk) = chunks.get(self.chunk) {
            while self.queued_s < chunk.until_s {
                if self.queued_s > until_s || self.machine.strokes().is_full() {
                    return;
                }
                let mut line = self.line.unwrap_or_else(|| LaserLine::first(chunk, marks, self.last));
                while line.until_s <= self.queued_s + NOTHING_S {
                    let next = line.after(chunk, marks, 0.0);
                    self.ratio = self.ratio.filter(|_| next.asked_mm_s == line.asked_mm_s);
                    line = next;
                }
                self.line = Some(line);
                self.queue(chunk, line);
            }
            if !chunks.has_next(self.chunk) {
                return;
            }
            self.chunk += 1;
            self.last = self.line.map_or(self.last, |line| (line.power, line.asked_mm_s));
            (self.line, self.ratio) = (None, None);
        }
    }

    fn queue(&mut self, chunk: &Chunk, line: LaserLine) {
        let ends_soon = line.until_s < chunk.until_s + SLIVER_S;
        let until_s = if ends_soon { line.until_s } else { chunk.until_s };
        let (end_s, asked) = match line.power {
            Power::Off => (until_s, Asked::NOTHING),
            Power::Constant(level) => (until_s, Asked::even(level)),
            Power::BySpeed(level) => self.by_speed(chunk, line, until_s, level),
        };
        let end = instant_near(self.start, end_s);
        let begin = core::mem::replace(&mut self.queued, end);
        self.queued_s = end_s;
        if line.power != Power::Off {
            // There is room, and this task is the only sender.
            let _ = self.machine.strokes().try_send(Stroke { begin, end, asked });
        }
    }

    /// Up to when the speed changes linearly, s from the start of the run, `until_s` at most; and what is asked for
    /// until then.
    fn by_speed(&mut self, chunk: &Chunk, line: LaserLine, until_s: f64, level: Level) -> (f64, Asked) {
        let LaserLine { cruises_s, slows_s, cruise_ratio, .. } = line;
        let after_s = self.queued_s + NOTHING_S;
        if after_s > cruises_s && after_s < slows_s {
            self.ratio = Some(cruise_ratio);
            return (slows_s.min(until_s), Asked::between(level, [cruise_ratio; 2]));
        }
        let bend_s = [cruises_s, slows_s].into_iter().find(|t_s| *t_s > after_s).unwrap_or(until_s);
        let end_s = bend_s.min(until_s).min(self.queued_s + self.longest_s);
        let from = self.ratio.unwrap_or_else(|| speed_ratio(chunk, &line, self.queued_s, &self.steps_per_mm));
        let to = speed_ratio(chunk, &line, end_s, &self.steps_per_mm);
        self.ratio = Some(to);
        (end_s, Asked::between(level, [from, to]))
    }
}

impl LaserLine {
    /// The line in which the chunk's plan begins. Before it, `last` shone, at that speed.
    fn first(chunk: &Chunk, marks: &Marks, last: (Power, f64)) -> Self {
        let tag = chunk.tag;
        let plan = match &chunk.plan {
            Plan::Line(plan) => plan,
            Plan::Blend(blend) => {
                // The corner is in the middle.
                let middle_s = blend.corner_begins_s() + blend.corner_s() / 2.0;
                let (until_s, ahead) = (middle_s, Walk::along(&tag));
                let [cruises_s, slows_s] = [middle_s; 2];
                let (power, asked_mm_s) = last;
                let (next, cruise_ratio) = (tag.power(), 0.0);
                return Self { power, asked_mm_s, until_s, next, cruises_s, slows_s, cruise_ratio, ahead };
            }
        };
        let profile = &plan.profile;
        let slows_s = plan.end_s() - profile.t_decel_s();
        let line = Self {
            power: tag.power(),
            asked_mm_s: asked_mm_s(chunk),
            until_s: 0.0,
            next: tag.power(),
            cruises_s: slows_s - profile.t_cruise_s(),
            slows_s,
            cruise_ratio: (profile.cruise_speed_steps_s() / chunk.asked_steps_s) as f32,
            ahead: Walk::along(&tag),
        };
        line.after(chunk, marks, plan.begin_steps())
    }

    /// The line that begins where it ends, up to the first mark beyond `place_steps` with another level.
    fn after(self, chunk: &Chunk, marks: &Marks, place_steps: f64) -> Self {
        let mut line = Self { power: self.next, asked_mm_s: asked_mm_s(chunk), until_s: f64::INFINITY, ..self };
        // A line that begins within a blend begins where that ends.
        let Plan::Line(plan) = &chunk.plan else { return line };
        while let Some(mark) = line.ahead.next(marks) {
            let mark_steps = f64::from(mark.place_steps);
            line.next = line.power.with_level(mark.level);
            if mark_steps <= place_steps {
                line.power = line.next;
            } else if line.next != line.power {
                if mark_steps < plan.end_steps() {
                    line.until_s = plan.time_at(mark_steps);
                }
                break;
            }
        }
        line
    }
}

/// The speed along the path that is asked for in a chunk, or behind its corner, mm/s.
fn asked_mm_s(chunk: &Chunk) -> f64 {
    chunk.asked_steps_s * chunk.mm_per_step
}

/// The speed at `t_s`, as a multiple of the one that was asked for.
fn speed_ratio(chunk: &Chunk, line: &LaserLine, t_s: f64, steps_per_mm: &[f64; AXES]) -> f32 {
    let plan = match &chunk.plan {
        Plan::Line(plan) => plan,
        Plan::Blend(blend) => return (path_speed_mm_s(blend, t_s, steps_per_mm) / line.asked_mm_s) as f32,
    };
    // Computed a little later: rounding must not lead to an instant before the profile, where nothing moves.
    (plan_speed_steps_s(plan, t_s + NOTHING_S) / chunk.asked_steps_s) as f32
}
