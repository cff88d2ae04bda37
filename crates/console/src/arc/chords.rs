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
        }
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
        end_mm[first] = self.centre_mm[0] + self.radius_mm[0];
        end_mm[second] = self.centre_mm[1] + self.radius_mm[1];
        others.into_iter().zip(self.others_mm).for_each(|(axis, mm)| end_mm[axis] = mm);
        Some(end_mm)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left as usize, Some(self.left as usize))
    }
}

impl ExactSizeIterator for Chords {}

/// The least number of equal chords that stay within the tolerance.
fn count(arc: &Arc, tolerance_mm: f64) -> u32 {
    let radius_mm = arc.radius_mm.max(arc.target_radius_mm);
    if 2.0 * radius_mm <= tolerance_mm {
        return 1;
    }
    // Half the chord and the distance from the centre to the chord are the sine and the cosine of half its angle, times
    // the radius.
    let half_mm = libm::sqrt(tolerance_mm * (2.0 * radius_mm - tolerance_mm));
    let half_rad = libm::atan2(half_mm, radius_mm - tolerance_mm);
    (libm::ceil(arc.travel_rad.abs() / (2.0 * half_rad)) as u32).max(1)
}

/// The relative change of the radius from start to target.
fn change(arc: &Arc) -> f64 {
    let change_mm = arc.target_radius_mm - arc.radius_mm;
    if change_mm.abs() < EVEN_CHANGE_MAX * arc.radius_mm { change_mm / arc.radius_mm } else { 0.0 }
}

/// Cosine and sine by their power series, which need few terms for the small angle of a chord.
fn cos_sin(rad: f64) -> [f64; 2] {
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
