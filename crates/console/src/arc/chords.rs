//! Splits an arc into chords, one after the other.

use super::Arc;
use crate::AXES;

/// The series of sine and cosine end at the first term that is too small to change the sum.
const NEGLIGIBLE: f64 = 1e-18;
/// If the radius changes by more than this fraction, the arc is so small that the last chord may absorb the change.
const EVEN_CHANGE_MAX: f64 = 0.1;
/// The number of axes that a plane has not.
const OTHERS: usize = AXES - 2;

/// Iterates over the end points of the chords. The last one is the target itself. See [`Arc::chords`].
///
/// The radius vector is turned by the same angle for each chord: nine operations per chord, and no sine.
#[derive(Debug, Clone)]
pub struct Chords {
    left: u32,
    axes: [usize; AXES],
    centre_mm: [f64; 2],
    radius_mm: [f64; 2],
    /// Cosine and sine of the angle of a chord, both times the factor by which the radius grows per chord.
    turn: [f64; 2],
    /// Of the axes that are not in the plane.
    others_mm: [f64; OTHERS],
    rise_mm: [f64; OTHERS],
    target_mm: [f64; AXES],
    /// The number of chords in all, and the factor by which the first place and the one before the last are farther from the centre.
    count: u32,
    at_ends: f64,
}

impl Chords {
    pub(super) fn new(arc: &Arc, tolerance_mm: f64) -> Self {
        let (left, axes) = (count(arc, tolerance_mm), arc.axes());
        let (chords, [_, _, others @ ..]) = (f64::from(left), axes);
        let [radius_mm, _] = arc.radii_mm();
        let change = 1.0 + change(arc) / chords;
        Self {
            left,
            axes,
            centre_mm: arc.centre_mm(),
            radius_mm,
            turn: cos_sin(arc.travel_rad / chords).map(|part| part * change),
            others_mm: others.map(|axis| arc.ends.start_mm[axis]),
            rise_mm: others.map(|axis| arc.ends.distance_mm(axis) / chords),
            target_mm: arc.ends.target_mm,
            count: left,
            at_ends: 1.0,
        }
    }

    /// The vertices of a polygon, a turn of `step_rad` apart, which are farther from the centre by the factor `outside`; then the
    /// target. The first is `first_rad` after the start. By another factor that one and the last are so, too.
    pub(super) fn vertices(
        arc: &Arc,
        vertices: u32,
        [first_rad, step_rad]: [f64; 2],
        [outside, at_ends]: [f64; 2],
    ) -> Self {
        let chords = Self::new(arc, f64::INFINITY);
        let [before, step] = [first_rad - step_rad, step_rad].map(|rad| rad / arc.travel_rad);
        let grown = |share: f64| 1.0 + change(arc) * share;
        let mut polygon = Self {
            left: vertices + 1,
            count: vertices + 1,
            at_ends,
            turn: cos_sin(first_rad - step_rad).map(|part| part * outside * grown(before)),
            rise_mm: chords.rise_mm.map(|rise_mm| rise_mm * before),
            ..chords
        };
        polygon.turn();
        polygon.turn = cos_sin(step_rad).map(|part| part * grown(step));
        polygon.rise_mm = chords.rise_mm.map(|rise_mm| rise_mm * step);
        polygon
    }

    fn turn(&mut self) {
        let ([cos, sin], [first_mm, second_mm]) = (self.turn, self.radius_mm);
        self.radius_mm = [cos * first_mm - sin * second_mm, sin * first_mm + cos * second_mm];
        for (mm, rise_mm) in self.others_mm.iter_mut().zip(self.rise_mm) {
            *mm += rise_mm;
        }
    }
}

impl Iterator for Chords {
    type Item = [f64; AXES];

    fn next(&mut self) -> Option<[f64; AXES]> {
        self.left = self.left.checked_sub(1)?;
        if self.left == 0 {
            return Some(self.target_mm);
        }
        self.turn();
        let [first, second, others @ ..] = self.axes;
        let mut end_mm = [0.0; AXES];
        let is_at_end = self.left == 1 || self.left + 1 == self.count;
        let radius_mm = if is_at_end { self.radius_mm.map(|mm| mm * self.at_ends) } else { self.radius_mm };
        end_mm[first] = self.centre_mm[0] + radius_mm[0];
        end_mm[second] = self.centre_mm[1] + radius_mm[1];
        others.into_iter().zip(self.others_mm).for_each(|(axis, mm)| end_mm[axis] = mm);
        Some(end_mm)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left as usize, Some(self.left as usize))
    }
}

impl ExactSizeIterator for Chords {}

/// The least number of equal chords that stay within the tolerance.
pub(super) fn count(arc: &Arc, tolerance_mm: f64) -> u32 {
    let radius_mm = arc.radius_mm.max(arc.target_radius_mm);
    if 2.0 * radius_mm <= tolerance_mm {
        return 1;
    }
    (libm::ceil(arc.travel_rad.abs() / (2.0 * half_rad(radius_mm, tolerance_mm))) as u32).max(1)
}

/// Half the angle of a chord whose middle is so far inside a circle.
pub(super) fn half_rad(radius_mm: f64, inside_mm: f64) -> f64 {
    // Half the chord and the distance from the centre to the chord are the sine and the cosine of half its angle, times
    // the radius.
    let half_mm = libm::sqrt(inside_mm * (2.0 * radius_mm - inside_mm));
    libm::atan2(half_mm, radius_mm - inside_mm)
}

/// The relative change of the radius from start to target.
fn change(arc: &Arc) -> f64 {
    if is_even(arc) { (arc.target_radius_mm - arc.radius_mm) / arc.radius_mm } else { 0.0 }
}

/// True if the radius changes so little that it does so evenly.
pub(super) fn is_even(arc: &Arc) -> bool {
    (arc.target_radius_mm - arc.radius_mm).abs() < EVEN_CHANGE_MAX * arc.radius_mm
}

/// Cosine and sine by their power series, which need few terms for the small angle of a chord.
pub(super) fn cos_sin(rad: f64) -> [f64; 2] {
    let (mut cos, mut sin) = (0.0, 0.0);
    let (mut term, mut power) = (1.0, 0.0);
    while f64::abs(term) > NEGLIGIBLE {
        cos += term;
        term *= rad / (power + 1.0);
        sin += term;
        term *= -rad / (power + 2.0);
        power += 2.0;
    }
    [cos, sin]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arc::hypotenuse;

    #[test]
    fn the_series_are_cosine_and_sine() {
        for rad in (-6_283..=6_283).map(|thousandths| f64::from(thousandths) * 1e-3).chain([1e-9, -1e-5, 0.0]) {
            let [cos, sin] = cos_sin(rad);
            assert!(hypotenuse([cos - rad.cos(), sin - rad.sin()]) < 1e-13, "{rad}");
            let near = if rad.abs() < 0.5 { 4e-16 } else { 1e-13 };
            assert!((hypotenuse([cos, sin]) - 1.0).abs() < near, "{rad}");
        }
    }
}
