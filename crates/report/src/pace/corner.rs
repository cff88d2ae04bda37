//! The limit of the speed at a corner, and so what would make it faster.
//!
//! By Grbl's rule it is `$11` and the axis whose acceleration allows least across the corner. In a blend it is the axis that
//! comes nearest to its acceleration there, and how far the blend reaches: as far as the deviation allows, which is
//! 4 δ/|u' - u| for the directions u and u', or half of the shorter move.

use isostep_motion::AXES;
use isostep_profile::{Blend, SpeedProfile};
use serde::Serialize;

use super::asked::Asked;
use isostep_sim::Outcome;

/// A corner counts as taken at full speed if its speed is at least this fraction of the allowed one.
const FULL: f64 = 0.98;
/// A blend limits the speed if an axis has this fraction of its acceleration in it. Where the speed changes round a curve, no
/// axis may come nearer to its own.
const BENT: f64 = 0.75;

/// By which rule a corner is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// Grbl's: the path goes to the corner, and `$11` bounds its speed.
    Junction,
    /// A blend as far as its deviation allows.
    Deviation,
    /// A blend as far as the moves have room.
    Room,
    /// A stop, because no blend was possible: its moves are too short for so sharp a corner, or the next move was known too
    /// late.
    NoBlend,
    /// A stop, because the path goes back.
    Reversal,
}

/// The limit of the speed at a corner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CornerLimit {
    /// The rule.
    pub rule: Rule,
    /// Index of the axis whose acceleration limits it.
    pub axis: usize,
    /// The deviation that is asked for: `$11`, or that of the blend, mm.
    pub deviation_mm: f64,
}

/// A corner as planned.
#[derive(Clone, Copy, Debug)]
pub struct Corner<'a> {
    pub outcome: &'a Outcome,
    /// The demands of the moves before and after it.
    pub sides: [&'a Asked; 2],
    /// Index of the move after it.
    pub after: usize,
    /// The distance by which a blend may leave it, mm.
    pub deviation_mm: f64,
    /// The speed at which it is taken, mm/s.
    pub taken_mm_s: f64,
    /// True if the machine comes to rest there.
    pub is_rest: bool,
}

impl Corner<'_> {
    /// The limit of the speed; `None` if the corner would allow more.
    pub fn limit(&self) -> Option<CornerLimit> {
        let Self { outcome, sides: [from, to], deviation_mm, .. } = *self;
        if self.is_rest && from.is_back(to) {
            let axis = from.weakest_axis(outcome, false);
            return Some(CornerLimit { rule: Rule::Reversal, axis, deviation_mm });
        }
        if outcome.moves[self.after].blend.is_some() {
            return self.blend();
        }
        let (corner_mm_s, axis) = from.corner(to, outcome);
        if self.taken_mm_s >= FULL * corner_mm_s {
            let deviation_mm = outcome.junction_deviation_mm;
            return Some(CornerLimit { rule: Rule::Junction, axis, deviation_mm });
        }
        let blends = deviation_mm > 0.0 && outcome.speed_profile == SpeedProfile::Trapezoid;
        (blends && self.is_rest && corner_mm_s.is_finite()).then_some(CornerLimit {
            rule: Rule::NoBlend,
            axis,
            deviation_mm,
        })
    }

    fn blend(&self) -> Option<CornerLimit> {
        let Self { outcome, sides: [from, to], deviation_mm, .. } = *self;
        let blend = outcome.moves[self.after].blend?;
        let share = |blend: &Blend<AXES>, axis: usize| {
            let limits = outcome.limits[axis];
            blend.accel_steps_s2(axis).abs() / limits.accel_steps_s2.min(limits.decel_steps_s2)
        };
        let axis = (0..AXES).max_by(|&one, &other| share(&blend, one).total_cmp(&share(&blend, other)))?;
        let is_full = |index: usize| {
            let blend = outcome.moves.get(index).and_then(|record| record.blend);
            blend.is_some_and(|blend| (0..AXES).any(|axis| share(&blend, axis) >= BENT))
        };
        let fastest_mm_s = [blend.corner_begins_s(), blend.end_s()].map(|t_s| outcome.blend_mm_s(&blend, t_s));
        let reach_mm = blend.corner_s() * fastest_mm_s[0].max(fastest_mm_s[1]) / 2.0;
        // The deviation at the corner is a quarter of the reach times the difference of the directions.
        let is_by_deviation = reach_mm * from.half_difference(to) / 2.0 >= FULL * deviation_mm;
        let rule = if is_by_deviation { Rule::Deviation } else { Rule::Room };
        // On the way between two corners a blend may be one that the next of them, or the last, has slowed down.
        let beside = self.after.saturating_sub(1)..=self.after + 1;
        beside.into_iter().any(is_full).then_some(CornerLimit { rule, axis, deviation_mm })
    }
}
