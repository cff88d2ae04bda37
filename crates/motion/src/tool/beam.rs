//! How strongly a laser shines along the chunks of a run.
//!
//! # Design
//! A level belongs to a move: it begins with the move's plan, half a step before its first step. Where the level
//! follows the speed, a phase of constant acceleration is a stroke whose level changes linearly. A curved ramp is made
//! of short strokes, so that their chords deviate little. Strokes that have been queued are committed, as steps
//! are. In a hold, too, the machine brakes with the level that belongs to the speed.

use embassy_time::{Duration, Instant};
use isostep_profile::SpeedLaw;
use isostep_profile::chain::Chunk;

use super::{Asked, Power, Stroke, Tag};
use crate::axes::AXES;
use crate::chunks::Chunks;
use crate::machine::Machine;

/// The longest stroke of a straight ramp, s.
const STRAIGHT_S: f64 = Asked::CHANGE_MAX.as_micros() as f64 * 1e-6;
/// The longest stroke of a curved ramp, s.
const CURVED_S: f64 = 0.002;
/// The same for a law over displacement, s. For such a law the chip takes milliseconds to compute a speed.
const OVER_DISPLACEMENT_S: f64 = 0.01;
/// Shorter strokes are left out, s: half of the resolution of instants.
const NOTHING_S: f64 = 0.5e-6;

/// Queues a run's strokes for the tool's task.
pub(crate) struct BeamStream<'a> {
    machine: &'a Machine,
    start: Instant,
    longest_s: f64,
    /// The number of the chunk whose strokes it queues.
    chunk: u32,
    /// Up to when strokes have been queued, s from the start of the run.
    queued_s: f64,
}

impl<'a> BeamStream<'a> {
    /// The stream of a run that started at `start`; `None` if there is no laser.
    pub fn new(machine: &'a Machine, start: Instant) -> Option<Self> {
        let config = machine.config();
        let longest_s = match config.speed_law {
            SpeedLaw::Trapezoid => STRAIGHT_S,
            law if law.is_over_displacement() => OVER_DISPLACEMENT_S,
            _ => CURVED_S,
        };
        config.tool.laser.then_some(Self { machine, start, longest_s, chunk: 0, queued_s: 0.0 })
    }

    /// The number of the chunk whose strokes it queues.
    pub fn chunk(&self) -> u32 {
        self.chunk
    }

    /// Queues strokes up to `until_s` from the start of the run, as far as the path is known and there is room.
    pub fn fill_queue(&mut self, chunks: &Chunks, until_s: f64) {
        while let Some(chunk) = chunks.get(self.chunk) {
            while self.queued_s < chunk.until_s {
                if self.queued_s > until_s || self.machine.strokes().is_full() {
                    return;
                }
                self.queue(chunk);
            }
            if !chunks.has_next(self.chunk) {
                return;
            }
            self.chunk += 1;
        }
    }

    fn queue(&mut self, chunk: &Chunk<AXES>) {
        let begin_s = self.queued_s;
        let (end_s, asked) = match Tag::unpack(chunk.tag).power {
            Power::Off => return self.queued_s = chunk.until_s,
            Power::Constant(level) => (chunk.until_s, Asked::even(level)),
            Power::BySpeed(level) => {
                let end_s = self.bend_s(chunk);
                (end_s, Asked::between(level, [begin_s, end_s].map(|t_s| speed_ratio(chunk, t_s))))
            }
        };
        self.queued_s = end_s;
        let [begin, end] = [begin_s, end_s].map(|t_s| self.start + Duration::from_micros((t_s * 1e6 + 0.5) as u64));
        // There is room, and this task is the only sender.
        let _ = self.machine.strokes().try_send(Stroke { begin, end, asked });
    }

    /// Up to when the speed changes linearly, s from the start of the run; the end of the chunk at most.
    fn bend_s(&self, chunk: &Chunk<AXES>) -> f64 {
        let profile = &chunk.plan.profile;
        let slows_s = chunk.plan.end_s() - profile.t_decel_s();
        let speeds_s = slows_s - profile.t_cruise_s();
        let is_ahead = |t_s: &f64| *t_s > self.queued_s + NOTHING_S;
        let bend_s = [speeds_s, slows_s].into_iter().find(is_ahead).unwrap_or(chunk.until_s).min(chunk.until_s);
        let is_cruise = self.queued_s + NOTHING_S > speeds_s && self.queued_s + NOTHING_S < slows_s;
        if is_cruise { bend_s } else { bend_s.min(self.queued_s + self.longest_s) }
    }
}

/// The speed at `t_s`, as a multiple of the one that was asked for.
fn speed_ratio(chunk: &Chunk<AXES>, t_s: f64) -> f32 {
    let plan = &chunk.plan;
    // Computed a little later: rounding must not lead to an instant before the profile, where nothing moves.
    let inside_s = t_s + NOTHING_S;
    let is_end = inside_s > plan.end_s();
    let speed_steps_s = if is_end { plan.profile.exit_speed_steps_s() } else { plan.speed_at(inside_s) };
    (speed_steps_s / chunk.asked_steps_s) as f32
}
