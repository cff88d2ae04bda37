//! How strongly a laser shines along the chunks of a run.
//!
//! # Design
//! A level belongs to a move: it begins with the move's plan, half a step before its first step. Where it follows the speed, a
//! stretch of constant acceleration is one of evenly changing level; of a curved ramp it is a short one, so that the chord
//! deviates little. What is told is made, as the steps are: a hold brakes with the level that belongs to the speed.

use embassy_time::{Duration, Instant};
use isostep_profile::SpeedLaw;
use isostep_profile::chain::Chunk;

use super::{Level, Power, Stretch, Tag};
use crate::axes::AXES;
use crate::chunks::Chunks;
use crate::machine::Machine;

/// The longest stretch of a curved ramp, s; of a law over displacement, where a speed takes the chip milliseconds.
const CURVED_S: f64 = 0.002;
const OVER_DISPLACEMENT_S: f64 = 0.01;
/// Shorter stretches are none, s: half of what instants are told to.
const NOTHING_S: f64 = 0.5e-6;

/// Tells the tool's task of a run's stretches.
pub(crate) struct BeamStream<'a> {
    machine: &'a Machine,
    start: Instant,
    longest_s: f64,
    /// The number of the chunk that it is told of.
    chunk: u32,
    /// Until when it has been told, s from the start of the run.
    told_s: f64,
}

impl<'a> BeamStream<'a> {
    /// Of a run that started at `start`; none if there is no laser.
    pub fn new(machine: &'a Machine, start: Instant) -> Option<Self> {
        let config = machine.config();
        let longest_s = match config.speed_law {
            SpeedLaw::Trapezoid => f64::INFINITY,
            law if law.is_over_displacement() => OVER_DISPLACEMENT_S,
            _ => CURVED_S,
        };
        config.tool.laser.then_some(Self { machine, start, longest_s, chunk: 0, told_s: 0.0 })
    }

    /// The number of the chunk that it is told of.
    pub fn chunk(&self) -> u32 {
        self.chunk
    }

    /// Tells until `until_s` from the start of the run, as far as it is known and there is room.
    pub fn fill_queue(&mut self, chunks: &Chunks, until_s: f64) {
        while let Some(chunk) = chunks.get(self.chunk) {
            while self.told_s < chunk.until_s {
                if self.told_s > until_s || self.machine.stretches().is_full() {
                    return;
                }
                self.tell(chunk);
            }
            if !chunks.has_next(self.chunk) {
                return;
            }
            self.chunk += 1;
        }
    }

    fn tell(&mut self, chunk: &Chunk<AXES>) {
        let begin_s = self.told_s;
        let (end_s, [from, to]) = match Tag::unpack(chunk.tag).power {
            Power::Off => return self.told_s = chunk.until_s,
            Power::Constant(level) => (chunk.until_s, [level; 2]),
            Power::BySpeed(level) => {
                let end_s = self.bend_s(chunk);
                (end_s, [begin_s, end_s].map(|t_s| level_at(chunk, level, t_s)))
            }
        };
        self.told_s = end_s;
        let [begin, end] = [begin_s, end_s].map(|t_s| self.start + Duration::from_micros((t_s * 1e6 + 0.5) as u64));
        // There is room, and this task is the only sender.
        let _ = self.machine.stretches().try_send(Stretch { begin, end, from, to });
    }

    /// Up to where the speed changes evenly, s from the start of the run.
    fn bend_s(&self, chunk: &Chunk<AXES>) -> f64 {
        let profile = &chunk.plan.profile;
        let slows_s = chunk.plan.end_s() - profile.t_decel_s();
        let speeds_s = slows_s - profile.t_cruise_s();
        let is_ahead = |t_s: &f64| *t_s > self.told_s + NOTHING_S;
        let bend_s = [speeds_s, slows_s].into_iter().find(is_ahead).unwrap_or(chunk.until_s).min(chunk.until_s);
        let is_cruise = self.told_s + NOTHING_S > speeds_s && self.told_s + NOTHING_S < slows_s;
        if is_cruise { bend_s } else { bend_s.min(self.told_s + self.longest_s) }
    }
}

/// Of a move that shines with `level` where it is as fast as was asked for.
fn level_at(chunk: &Chunk<AXES>, level: Level, t_s: f64) -> Level {
    let part = &chunk.plan;
    // A little later: rounding must not lead out of the profile, where nothing moves.
    let inside_s = t_s + NOTHING_S;
    let is_end = inside_s > part.end_s();
    let speed_steps_s = if is_end { part.profile.exit_speed_steps_s() } else { part.speed_at(inside_s) };
    Level::of_ratio((speed_steps_s / chunk.asked_steps_s) as f32 * level.ratio())
}
