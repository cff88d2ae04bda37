//! How strongly a laser shines along the legs of a run.
//!
//! # Design
//! A level belongs to a move: it begins with the move's plan, half a step before its first step. Where it follows the speed, a
//! stretch of constant acceleration is one of evenly changing level; of a curved ramp it is a short one, so that the chord
//! strays little. What is told is made, as the steps are: a hold brakes with the level that belongs to the speed.

use embassy_time::{Duration, Instant};
use isostep_profile::SpeedLaw;
use isostep_profile::chain::Leg;

use super::{Level, Power, Stretch, Tag};
use crate::axes::AXES;
use crate::legs::Legs;
use crate::machine::Machine;

/// The longest stretch of a curved ramp, s; of a law over displacement, where a speed takes the chip milliseconds.
const CURVED_S: f64 = 0.002;
const OVER_DISPLACEMENT_S: f64 = 0.01;
/// Shorter stretches are none, s: half of what instants are told to.
const NOTHING_S: f64 = 0.5e-6;

/// Tells the tool's task of a run's stretches.
pub(crate) struct BeamFeeder<'a> {
    machine: &'a Machine,
    start: Instant,
    longest_s: f64,
    /// The number of the leg that it is told of.
    leg: u32,
    /// Until when it has been told, s from the start of the run.
    told_s: f64,
}

impl<'a> BeamFeeder<'a> {
    /// Of a run that started at `start`; none if there is no laser.
    pub fn new(machine: &'a Machine, start: Instant) -> Option<Self> {
        let config = machine.config();
        let longest_s = match config.speed_law {
            SpeedLaw::Trapezoid => f64::INFINITY,
            law if law.is_over_displacement() => OVER_DISPLACEMENT_S,
            _ => CURVED_S,
        };
        config.tool.laser.then_some(Self { machine, start, longest_s, leg: 0, told_s: 0.0 })
    }

    /// The number of the leg that it is told of.
    pub fn leg(&self) -> u32 {
        self.leg
    }

    /// Tells until `until_s` from the start of the run, as far as it is known and there is room.
    pub fn feed(&mut self, legs: &Legs, until_s: f64) {
        while let Some(leg) = legs.get(self.leg) {
            while self.told_s < leg.until_s {
                if self.told_s > until_s || self.machine.stretches().is_full() {
                    return;
                }
                self.tell(leg);
            }
            if !legs.has_next(self.leg) {
                return;
            }
            self.leg += 1;
        }
    }

    fn tell(&mut self, leg: &Leg<AXES>) {
        let begin_s = self.told_s;
        let (end_s, [from, to]) = match Tag::unpack(leg.tag).power {
            Power::Off => return self.told_s = leg.until_s,
            Power::Constant(level) => (leg.until_s, [level; 2]),
            Power::BySpeed(level) => {
                let end_s = self.bend_s(leg);
                (end_s, [begin_s, end_s].map(|t_s| level_at(leg, level, t_s)))
            }
        };
        self.told_s = end_s;
        let [begin, end] = [begin_s, end_s].map(|t_s| self.start + Duration::from_micros((t_s * 1e6 + 0.5) as u64));
        // There is room, and this task is the only sender.
        let _ = self.machine.stretches().try_send(Stretch { begin, end, from, to });
    }

    /// Up to where the speed changes evenly, s from the start of the run.
    fn bend_s(&self, leg: &Leg<AXES>) -> f64 {
        let profile = &leg.part.profile;
        let slows_s = leg.part.end_s() - profile.t_decel_s();
        let speeds_s = slows_s - profile.t_cruise_s();
        let is_ahead = |t_s: &f64| *t_s > self.told_s + NOTHING_S;
        let bend_s = [speeds_s, slows_s].into_iter().find(is_ahead).unwrap_or(leg.until_s).min(leg.until_s);
        let is_cruise = self.told_s + NOTHING_S > speeds_s && self.told_s + NOTHING_S < slows_s;
        if is_cruise { bend_s } else { bend_s.min(self.told_s + self.longest_s) }
    }
}

/// Of a move that shines with `level` where it is as fast as was asked for.
fn level_at(leg: &Leg<AXES>, level: Level, t_s: f64) -> Level {
    let part = &leg.part;
    // A little later: rounding must not lead out of the profile, where nothing moves.
    let inside_s = t_s + NOTHING_S;
    let is_end = inside_s > part.end_s();
    let speed_steps_s = if is_end { part.profile.exit_speed_steps_s() } else { part.speed_at(inside_s) };
    Level::of_share((speed_steps_s / leg.asked_steps_s) as f32 * level.share())
}
