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
//! It is followed by a fast estimate, which the next end is expected by, and a slow one, which tells how curved the path is, and so
//! how fast it can be and how long a line.

use crate::axes::AXES;

/// How much of what is wrong with the place where the path is expected is corrected at once.
const PLACE_GAIN: f32 = 0.35;
/// How much of what the last turn was otherwise is expected of the next one; and while nothing is as expected.
const TURN_GAIN: f32 = 0.15;
const SEARCH_GAIN: f32 = 0.5;
/// The same for the slow estimate.
const CURVATURE_GAIN: f32 = 0.15;
/// The same for what lines take the processor.
const MEAN_GAIN: f32 = 0.125;
/// The cosine of a turn that is a corner, behind which another path begins: of half a radian.
const CORNER: f32 = 0.88;

/// A vector on all axes, mm or without a unit.
pub(super) type Vector = [f32; AXES];

/// The direction of the last line and how the path turns.
#[derive(Clone, Copy)]
pub(crate) struct Course {
    /// The length of the last line, mm; 0 if there is none.
    length_mm: f32,
    direction: Vector,
    /// The turn that is expected, and how curved the path is: each is the change of the direction over a millimetre.
    turn_per_mm: Vector,
    curvature_per_mm: Vector,
    /// The radius that follows from that, mm; infinite if nothing is known.
    radius_mm: f32,
    /// What the lines take the processor on average, s, and how long they are, mm.
    mean_s: f32,
    mean_mm: f32,
}

impl Course {
    /// Nothing is known.
    pub(crate) const NONE: Self = Self {
        length_mm: 0.0,
        direction: [0.0; AXES],
        turn_per_mm: [0.0; AXES],
        curvature_per_mm: [0.0; AXES],
        radius_mm: f32::INFINITY,
        mean_s: 0.0,
        mean_mm: 0.0,
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

    /// How far beside the end of this line it is to end, mm; `None` if nothing is known yet.
    #[cold]
    pub(super) fn wanted_mm(&self, line_mm: &Vector, length_mm: f32) -> Option<Vector> {
        if self.length_mm == 0.0 {
            return None;
        }
        let mut ahead = self.direction;
        add(&mut ahead, 0.5 * (self.length_mm + length_mm), &self.turn_per_mm);
        let left = 1.0 - PLACE_GAIN;
        let mut wanted_mm = line_mm.map(|mm| -left * mm);
        add(&mut wanted_mm, left * length_mm / length(&ahead), &ahead);
        add(&mut wanted_mm, -0.125 * PLACE_GAIN * length_mm * length_mm, &self.turn_per_mm);
        Some(wanted_mm)
    }

    /// The time that the next line is to last at least, which takes the processor `own_s`: its share of what the lines before it
    /// take, too. So the speed does not change with the number of moves that happen to be in a line. What lines take that are not
    /// average is in what is known ahead.
    pub(super) fn shared_s(&mut self, own_s: f32, length_mm: f32) -> f32 {
        let gain = if self.mean_mm == 0.0 { 1.0 } else { MEAN_GAIN };
        self.mean_s += gain * (own_s - self.mean_s);
        self.mean_mm += gain * (length_mm - self.mean_mm);
        self.mean_s * length_mm / self.mean_mm
    }

    /// Notes the next line, and whether it ends where it was wanted.
    #[cold]
    pub(super) fn go_on(&mut self, line_mm: &Vector, is_as_wanted: bool) {
        let length_mm = length(line_mm);
        let per_mm = 1.0 / length_mm;
        let direction = line_mm.map(|mm| mm * per_mm);
        let cosine = dot(&self.direction, &direction);
        if self.length_mm > 0.0 && cosine > CORNER {
            let per_mm = 2.0 / (self.length_mm + length_mm);
            let mut turn_per_mm = [0.0; AXES];
            add(&mut turn_per_mm, cosine * per_mm, &direction);
            add(&mut turn_per_mm, -per_mm, &self.direction);
            let gain = if is_as_wanted { TURN_GAIN } else { SEARCH_GAIN };
            let from = &self.direction;
            carry(&mut self.turn_per_mm, [from, &direction], cosine, gain, &turn_per_mm);
            carry(&mut self.curvature_per_mm, [from, &direction], cosine, CURVATURE_GAIN, &turn_per_mm);
        } else {
            (self.turn_per_mm, self.curvature_per_mm) = ([0.0; AXES], [0.0; AXES]);
        }
        (self.length_mm, self.direction) = (length_mm, direction);
        self.radius_mm = 1.0 / length(&self.curvature_per_mm);
    }
}

/// Turns what is across one direction to be across another, and brings it nearer to `new` by a part of the difference.
#[cold]
fn carry(known: &mut Vector, [from, to]: [&Vector; 2], cosine: f32, part: f32, new: &Vector) {
    let along = dot(known, to) / (1.0 + cosine);
    add(known, -along, from);
    add(known, -along, to);
    let before = *known;
    add(known, -part, &before);
    add(known, part, new);
}

// These are called rather than inlined, and take slices: so they are loops, and what is made of them is short.
#[cold]
fn add(to: &mut [f32], times: f32, what: &[f32]) {
    for (to, what) in to.iter_mut().zip(what) {
        *to += times * what;
    }
}

#[inline(never)]
pub(super) fn dot(one: &[f32], other: &[f32]) -> f32 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

fn length(vector: &Vector) -> f32 {
    libm::sqrtf(dot(vector, vector))
}
