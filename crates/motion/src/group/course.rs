//! How a path of short moves goes on, and so where it is smooth.
//!
//! # Design
//! The ends of short moves are noisy: a line from one to the next shakes the machine. And on a curve such lines are inside it, and
//! the blends between them cut the corners off on the same side. So the end of a line is not a programmed one but beside it: where
//! the path comes to if it goes on turning as it does, corrected by a part of the way to where it is wanted. That is the programmed
//! end, or on a curve so far outside of it that the lines touch the curve, and the blends, too, which reach to the middle of the
//! lines: a polygon round the curve, whose blends are as a quadratic B-spline, within r θ⁴/256 of a circle with the radius r and
//! the turn θ at a corner.
//!
//! The turn is a vector across the direction, so that it holds for any number of axes; it is carried along as the direction turns.
//! The gains are such that what is wrong with the place decays by an eighth a line.

use super::vector::{Vector, add, dot, inverse_root};
use crate::axes::AXES;

/// How much of what is wrong with the place where the path is expected is corrected at once.
const PLACE_GAIN: f32 = 0.35;
/// How much of what the last turn was otherwise is expected of the next one; and while nothing is as expected.
const TURN_GAIN: f32 = 0.15;
const SEARCH_GAIN: f32 = 0.5;
/// The same for what lines take the processor.
const MEAN_GAIN: f32 = 0.125;
/// By what part of it the pace may be off.
const PACE_OFF_MAX: f32 = 0.06;
/// The cosine of a turn that is a corner, behind which another path begins: of half a radian.
const CORNER: f32 = 0.88;

/// The direction of the last line and how the path turns.
#[derive(Clone, Copy)]
pub(crate) struct Course {
    /// The length of the last line, mm; 0 if there is none.
    length_mm: f32,
    direction: Vector,
    /// The change of the direction over a millimetre, and its square.
    turn_per_mm: Vector,
    turn_per_mm2: f32,
    /// The radius that follows from it, mm; infinite if the path is straight, or nothing is known.
    radius_mm: f32,
    /// What the lines take the processor on average, s, and how long they are, mm.
    mean_s: f32,
    mean_mm: f32,
    /// The time for a millimetre that follows from that, s.
    pace_s_mm: f32,
}

/// A line for a course.
pub(super) struct Line {
    pub(super) lengths_mm: Vector,
    pub(super) length_mm: f32,
    per_mm: f32,
}

impl Line {
    #[cold]
    pub(super) fn of(lengths_mm: Vector) -> Self {
        let square_mm2 = dot(&lengths_mm, &lengths_mm);
        let per_mm = inverse_root(square_mm2);
        Self { lengths_mm, length_mm: square_mm2 * per_mm, per_mm }
    }
}

impl Course {
    /// Nothing is known.
    pub(crate) const NONE: Self = Self {
        length_mm: 0.0,
        direction: [0.0; AXES],
        turn_per_mm: [0.0; AXES],
        turn_per_mm2: 0.0,
        radius_mm: f32::INFINITY,
        mean_s: 0.0,
        mean_mm: 0.0,
        pace_s_mm: 0.0,
    };

    /// The radius of the path, mm; infinite if it is straight or not known.
    pub(crate) fn radius_mm(&self) -> f32 {
        self.radius_mm
    }

    /// The direction of the last line; 0 if nothing is known.
    pub(super) fn direction(&self) -> &Vector {
        &self.direction
    }

    /// True if a line is known.
    pub(super) fn is_known(&self) -> bool {
        self.length_mm > 0.0
    }

    /// How far beside the end of this line it is to end, mm.
    #[cold]
    pub(super) fn wanted_mm(&self, line: &Line) -> Vector {
        let length_mm = line.length_mm;
        let between_mm = 0.5 * (self.length_mm + length_mm);
        // The turn is across the direction, so this is as long as the line, but for the fourth power of the angle.
        let stretch_mm = length_mm - 0.5 * length_mm * self.turn_per_mm2 * between_mm * between_mm;
        let mut wanted_mm = [0.0; AXES];
        let left = 1.0 - PLACE_GAIN;
        add(&mut wanted_mm, left * stretch_mm, &self.direction);
        add(&mut wanted_mm, -left, &line.lengths_mm);
        let outside_mm = 0.125 * PLACE_GAIN * length_mm * length_mm;
        add(&mut wanted_mm, left * stretch_mm * between_mm - outside_mm, &self.turn_per_mm);
        wanted_mm
    }

    /// The time that the next line is to last at least, which takes the processor `own_s`: its share of what the lines before it
    /// take, too, which changes only if it is wrong by a good deal. So the speed does not change with the number of moves that happen
    /// to be in a line. What lines take that are not average is in what is known ahead.
    #[cold]
    pub(super) fn shared_s(&mut self, own_s: f32, length_mm: f32) -> f32 {
        if length_mm == 0.0 {
            return own_s;
        }
        let gain = if self.mean_mm == 0.0 { 1.0 } else { MEAN_GAIN };
        self.mean_s += gain * (own_s - self.mean_s);
        self.mean_mm += gain * (length_mm - self.mean_mm);
        let off_s = self.pace_s_mm * self.mean_mm - self.mean_s;
        if off_s.abs() > PACE_OFF_MAX * self.mean_s {
            self.pace_s_mm = self.mean_s / self.mean_mm;
        }
        self.pace_s_mm * length_mm
    }

    /// Notes the next line, and whether it ends where it was wanted.
    #[cold]
    pub(super) fn go_on(&mut self, line: &Line, is_as_wanted: bool) {
        let direction = line.lengths_mm.map(|mm| mm * line.per_mm);
        let cosine = dot(&self.direction, &direction);
        if self.is_known() && cosine > CORNER {
            let per_mm = 2.0 / (self.length_mm + line.length_mm);
            let gain = if is_as_wanted { TURN_GAIN } else { SEARCH_GAIN };
            // What was across the last direction is turned to be across this one.
            let along = dot(&self.turn_per_mm, &direction) / (1.0 + cosine);
            // And brought nearer to the new turn, which is (cos(turn) direction - last direction)/(distance).
            let before = self.turn_per_mm;
            add(&mut self.turn_per_mm, -gain, &before);
            add(&mut self.turn_per_mm, -along * (1.0 - gain) - gain * per_mm, &self.direction);
            add(&mut self.turn_per_mm, gain * cosine * per_mm - along * (1.0 - gain), &direction);
        } else {
            self.turn_per_mm = [0.0; AXES];
        }
        self.turn_per_mm2 = dot(&self.turn_per_mm, &self.turn_per_mm);
        self.radius_mm = if self.turn_per_mm2 > 0.0 { inverse_root(self.turn_per_mm2) } else { f32::INFINITY };
        (self.length_mm, self.direction) = (line.length_mm, direction);
    }
}
