//! A polygon round an arc, whose blends make it.
//!
//! # Design
//! Each side touches the circle in its middle, and the blend at each vertex reaches from there to where the next side touches it. Such
//! a blend is a parabola which is the arc within r θ⁴/256, where θ is the angle between the sides; its vertex is r θ²/8 outside. So
//! few sides are enough.
//!
//! The path that leads to the arc, and the one that goes on from it, may meet it at any angle, and a blend there needs room. So the
//! first side is as much longer than half of one as half a chord is long, and so is the last: they are inside the circle by the
//! tolerance there, as chords are, and the two blends next to it turn a little more than others, by 2 % at most.

use super::chords::{Chords, cos_sin, count, half_rad, is_even};
use super::{Arc, hypotenuse};

/// The greatest angle between sides.
const STEP_MAX_RAD: f64 = core::f64::consts::FRAC_PI_6;
/// The part of the deviation by which vertices are outside, so that rounding does not make blends shorter.
const DEVIATION_SHARE: f64 = 0.9;
/// The part of a side, at most, by which the first and the last are longer than half of one.
const LEAD_OF_STEP: f64 = 0.25;
/// The first and the last vertex are inside of their place by this times the radius times the square of the angle of what their sides
/// are longer. Then the blend next to each turns as much more than others as its own does.
const EVEN: f64 = 0.3;
/// The least number of vertices.
const VERTICES_MIN: f64 = 2.0;

/// The distances within which a polygon has to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Within {
    /// Of the path from the arc, mm, above 0: that of its [chords](Arc::chords).
    pub tolerance_mm: f64,
    /// Of the vertices from the arc, and of the blends from the vertices, mm.
    pub deviation_mm: f64,
    /// The longest side, mm, unless a chord is longer.
    pub side_mm: f64,
}

/// See [`Arc::polygon`].
#[derive(Debug, Clone)]
pub struct Polygon {
    /// Its vertices, and then the target itself.
    pub vertices: Chords,
    /// The length of the first side, mm, that is for the blend where the arc begins. The last side has as much for the one where it
    /// ends.
    pub lead_mm: f64,
    /// The length of every other side, mm, that is for the blend where it begins: to where it touches the arc.
    pub reach_mm: f64,
}

impl Polygon {
    pub(super) fn new(arc: &Arc, within: &Within) -> Option<Self> {
        let &Within { tolerance_mm, deviation_mm, side_mm } = within;
        let radius_mm = arc.radius_mm.max(arc.target_radius_mm);
        if radius_mm <= tolerance_mm || !is_even(arc) {
            return None;
        }
        let outside_mm = DEVIATION_SHARE * deviation_mm;
        // The vertices are to the circle as the circle is to the middles of chords.
        let by_deviation_rad = 2.0 * half_rad(radius_mm + outside_mm, outside_mm);
        // Half of the tolerance is for the first and the last blend, which differ.
        let by_tolerance_rad = libm::sqrt(libm::sqrt(0.5 * 256.0 * tolerance_mm / radius_mm));
        let half_chord_rad = half_rad(radius_mm, tolerance_mm);
        let by_side_rad = (side_mm / radius_mm).max(2.0 * half_chord_rad);
        let most_rad = by_deviation_rad.min(by_tolerance_rad).min(by_side_rad).min(STEP_MAX_RAD);
        let lead_rad = half_chord_rad.min(LEAD_OF_STEP * most_rad);
        let travel_rad = arc.travel_rad.abs() - 2.0 * lead_rad;
        let vertices = libm::ceil(travel_rad / most_rad);
        if vertices < VERTICES_MIN || vertices + 1.0 > f64::from(count(arc, tolerance_mm)) {
            return None;
        }
        let step_rad = travel_rad / vertices;
        let half_step_rad = 0.5 * step_rad;
        let along_mm = |around_mm: f64, rad: f64| {
            let rises_mm = arc.axes().into_iter().skip(2).map(|axis| arc.ends.distance_mm(axis) * rad / arc.travel_rad);
            rises_mm.fold(around_mm, |along_mm, rise_mm| hypotenuse([along_mm, rise_mm]))
        };
        let [cos, sin] = cos_sin(half_step_rad);
        let turns_rad = [lead_rad + half_step_rad, step_rad].map(|rad| libm::copysign(rad, arc.travel_rad));
        Some(Self {
            vertices: Chords::vertices(arc, vertices as u32, turns_rad, [1.0 / cos, 1.0 - EVEN * lead_rad * lead_rad]),
            lead_mm: along_mm(radius_mm * lead_rad, lead_rad),
            reach_mm: along_mm(radius_mm * sin / cos, half_step_rad),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::tests::{Drawn, drawn};
    use super::*;
    use crate::AXES;

    fn within(tolerance_mm: f64, deviation_mm: f64) -> Within {
        Within { tolerance_mm, deviation_mm, side_mm: f64::INFINITY }
    }

    fn towards(from_mm: [f64; AXES], to_mm: [f64; AXES], by_mm: f64) -> [f64; AXES] {
        let length_mm = distance_mm(from_mm, to_mm);
        core::array::from_fn(|axis| from_mm[axis] + (to_mm[axis] - from_mm[axis]) * by_mm / length_mm)
    }

    fn distance_mm(from_mm: [f64; AXES], to_mm: [f64; AXES]) -> f64 {
        (0..AXES).fold(0.0, |mm, axis| hypotenuse([mm, to_mm[axis] - from_mm[axis]]))
    }

    /// The path that blends make of these places, and lines between them.
    fn path(places: &[[f64; AXES]], reach_mm: f64) -> std::vec::Vec<[f64; AXES]> {
        let mut path = std::vec![places[0]];
        for corner in places.windows(3) {
            let [begin, end] = [corner[0], corner[2]].map(|other| towards(corner[1], other, reach_mm));
            path.extend([0.0, 0.25, 0.5, 0.75, 1.0].map(|t| {
                core::array::from_fn::<_, AXES, _>(|axis| {
                    let [one, other] = [[begin, corner[1]], [corner[1], end]]
                        .map(|[from, to]| from[axis] + t * (to[axis] - from[axis]));
                    one + t * (other - one)
                })
            }));
        }
        path.extend(places.last());
        path
    }

    fn turn(drawn: Drawn) -> Drawn {
        Drawn { travel_rad: drawn.travel_rad.abs().max(0.3).copysign(drawn.travel_rad), ..drawn }
    }

    proptest! {
        #[test]
        fn blends_of_the_polygon_are_the_arc(
            drawn in drawn().prop_map(turn),
            tolerance_mm in 2e-4..0.005f64,
            deviation_mm in 0.002..0.1f64,
        ) {
            let arc = drawn.arc();
            let chords = arc.chords(tolerance_mm).len();
            let Some(Polygon { vertices, lead_mm, reach_mm }) = arc.polygon(&within(tolerance_mm, deviation_mm)) else {
                // There are few chords, or the deviation is hardly more than theirs.
                prop_assert!(chords < 14 || deviation_mm < 2.0 * tolerance_mm, "{chords} chords");
                return Ok(());
            };
            prop_assert!((3..=chords).contains(&vertices.len()), "{} sides, {chords} chords", vertices.len());
            let places: std::vec::Vec<_> = [arc.start_mm()].into_iter().chain(vertices).collect();
            let [first, second, across] = arc.axes();
            let out_mm = |place: &[f64; AXES]| {
                hypotenuse([place[first] - drawn.centre_mm[0], place[second] - drawn.centre_mm[1]]) - drawn.radius_mm
            };
            let ends = drawn.ends();
            prop_assert_eq!(places.last(), Some(&ends.target_mm));
            let (inner, rounding_mm) = (&places[1..places.len() - 1], 1e-7);
            for vertex in inner {
                prop_assert!((0.0..deviation_mm).contains(&out_mm(vertex)), "{}", out_mm(vertex));
            }
            for place in path(&places, reach_mm) {
                prop_assert!(out_mm(&place).abs() < 1.001 * tolerance_mm + rounding_mm, "{} mm", out_mm(&place));
            }
            // Rooms for blends add up to sides, and rise evenly.
            let [rise_mm, lead_rise_mm] = [places[2][across] - places[1][across], places[1][across] - places[0][across]];
            for (index, side) in places.windows(2).enumerate() {
                let is_end = index == 0 || index + 2 == places.len();
                let wanted_mm = if is_end { lead_mm + reach_mm } else { 2.0 * reach_mm };
                let found_mm = distance_mm(side[0], side[1]);
                prop_assert!((found_mm / wanted_mm - 1.0).abs() < 0.02, "side {index}: {found_mm}, not {wanted_mm}");
                let wanted_mm = if is_end { lead_rise_mm } else { rise_mm };
                prop_assert!((side[1][across] - side[0][across] - wanted_mm).abs() < rounding_mm);
            }
        }

        /// If the centre was rounded, the radius changes evenly.
        #[test]
        fn a_spiral_goes_evenly_from_one_radius_to_the_other(drawn in drawn().prop_map(turn), wrong in -0.0009..0.0009f64) {
            if drawn.radius_mm < 5.0 || drawn.travel_rad.abs() < 1.0 {
                return Ok(());
            }
            let offset_mm = drawn.offset_mm().map(|mm| mm * (1.0 + wrong));
            let Ok(arc) = Arc::around(drawn.ends(), offset_mm) else { return Ok(()) };
            let Some(polygon) = arc.polygon(&within(0.001, 0.01)) else { return Ok(()) };
            let (centre_mm, [first, second, _]) = (arc.centre_mm(), arc.axes());
            let radius_mm = |place: &[f64; AXES]| hypotenuse([place[first] - centre_mm[0], place[second] - centre_mm[1]]);
            let places: std::vec::Vec<_> = polygon.vertices.clone().collect();
            for (index, place) in places[..places.len() - 1].iter().enumerate() {
                let along = (polygon.lead_mm + polygon.reach_mm * (2 * index + 1) as f64)
                    / (2.0 * (polygon.lead_mm + polygon.reach_mm * (places.len() - 1) as f64));
                let wanted_mm = arc.radius_mm + along * (arc.target_radius_mm - arc.radius_mm);
                prop_assert!((0.0..0.011).contains(&(radius_mm(place) - wanted_mm)), "{}", radius_mm(place) - wanted_mm);
            }
        }
    }

    #[test]
    fn few_sides_are_enough() {
        for (radius_mm, tolerance_mm, side_mm, wanted) in [
            (10.0, 0.002, f64::INFINITY, Some(75)),
            (10.0, 0.00025, f64::INFINITY, Some(75)),
            (0.2, 0.00025, f64::INFINITY, Some(13)),
            // Slow: chords are 0.4 mm.
            (10.0, 0.002, 0.1, Some(158)),
            (10.0, 0.00025, 0.5, Some(127)),
            (0.01, 0.002, f64::INFINITY, None),
        ] {
            let ends = super::super::tests::ends([3.0; 3], [3.0; 3], true);
            let circle = Arc::around(ends, [radius_mm, 0.0]).unwrap();
            let polygon = circle.polygon(&Within { tolerance_mm, deviation_mm: 0.01, side_mm });
            assert_eq!(polygon.map(|polygon| polygon.vertices.len()), wanted, "{radius_mm} {tolerance_mm} {side_mm}");
            assert!(circle.polygon(&within(tolerance_mm, 0.0)).is_none());
        }
    }
}
