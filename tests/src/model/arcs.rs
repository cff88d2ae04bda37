//! Arcs: which fit, and how far they reach.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::block::{Block, Refused};
use super::machine::{Model, Place};
use super::words::ONE;

/// Two radii that differ by no more are the same, angstroms; and by more than this they never are.
const SAME_RADIUS_ANGSTROM: [f64; 2] = [ONE as f64 / 200.0, ONE as f64 / 2.0];
/// The share of a radius by which another may differ.
const SAME_RADIUS_RATIO: f64 = 1e-3;

/// The least and the greatest place of each axis, angstroms.
pub type Reach = [(f64, f64); 3];

/// The reach of places.
pub fn reach_of(places: &[Place]) -> Reach {
    std::array::from_fn(|axis| {
        let values = places.iter().map(|place| place[axis] as f64);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    })
}

/// Both together.
pub fn joined(one: Reach, other: Reach) -> Reach {
    std::array::from_fn(|axis| (one[axis].0.min(other[axis].0), one[axis].1.max(other[axis].1)))
}

/// The centre of an arc, angstroms from its start, and the difference of its radii.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Centre {
    at: [f64; 2],
    misfit: f64,
}

impl Model {
    /// The reach of an arc from the program's place to a target, and the difference of its radii.
    ///
    /// # Errors
    /// The number of the error.
    pub(super) fn arc_reach(&self, block: &Block, target: Place) -> Result<(Reach, f64), Refused> {
        let axes = match self.modes.plane {
            17 => [0, 1],
            18 => [2, 0],
            _ => [1, 2],
        };
        let by = axes.map(|axis| (target[axis] - self.position[axis]) as f64);
        let clockwise = self.modes.motion == 20;
        let length = |letter| block.get(letter).map(|value| self.modes.length(value) as f64);
        let centre = match length('R') {
            Some(radius) => centre_by_radius(by, radius, clockwise)?,
            None => centre_by_offsets(by, axes.map(|axis| length(['I', 'J', 'K'][axis]).unwrap_or(0.0)))?,
        };
        let mut reach = reach_of(&[self.position, target]);
        for (index, axis) in axes.into_iter().enumerate() {
            let radius = centre.at[0].hypot(centre.at[1]);
            for side in [0.0, 2.0] {
                // The angle at which the arc is farthest along this axis.
                let angle = FRAC_PI_2 * (side + index as f64);
                if passes(angle, by, centre.at, clockwise) {
                    let to = self.position[axis] as f64 + centre.at[index] + radius * (1.0 - side);
                    reach[axis] = (reach[axis].0.min(to), reach[axis].1.max(to));
                }
            }
        }
        Ok((reach, centre.misfit))
    }
}

/// True if two radii differ by more than is allowed.
fn differ(misfit: f64, radius: f64) -> bool {
    let [least, most] = SAME_RADIUS_ANGSTROM;
    misfit > most || misfit > least && misfit > radius * SAME_RADIUS_RATIO
}

fn centre_by_offsets(by: [f64; 2], at: [f64; 2]) -> Result<Centre, Refused> {
    let (radius, end) = (at[0].hypot(at[1]), (by[0] - at[0]).hypot(by[1] - at[1]));
    let misfit = (end - radius).abs();
    if differ(misfit, radius) { Err(33) } else { Ok(Centre { at, misfit }) }
}

/// R below 0 is the longer of two arcs.
fn centre_by_radius(by: [f64; 2], radius: f64, clockwise: bool) -> Result<Centre, Refused> {
    let half = by[0].hypot(by[1]) / 2.0;
    let misfit = (half - radius.abs()).max(0.0);
    if differ(misfit, radius.abs()) {
        return Err(34);
    }
    let aside = (radius * radius - half * half).max(0.0).sqrt();
    // From the start towards the target the shorter arc has its centre on the right if it is clockwise.
    let to_right = if (radius > 0.0) == clockwise { aside } else { -aside };
    let direction = by.map(|by| by / (2.0 * half));
    Ok(Centre { at: [by[0] / 2.0 + to_right * direction[1], by[1] / 2.0 - to_right * direction[0]], misfit })
}

/// True if an arc has a place at this angle, seen from its centre.
fn passes(angle: f64, by: [f64; 2], centre: [f64; 2], clockwise: bool) -> bool {
    let start = (-centre[1]).atan2(-centre[0]);
    let end = (by[1] - centre[1]).atan2(by[0] - centre[0]);
    let turned = |to: f64| if clockwise { (start - to).rem_euclid(TAU) } else { (to - start).rem_euclid(TAU) };
    by == [0.0, 0.0] || turned(angle) <= turned(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passed(by: [f64; 2], centre: [f64; 2], clockwise: bool) -> [bool; 4] {
        [0.0, 1.0, 2.0, 3.0].map(|quarters| passes(quarters * FRAC_PI_2, by, centre, clockwise))
    }

    #[test]
    fn an_arc_passes_the_quarters_that_it_turns_through() {
        assert_eq!(passed([2.0, 0.0], [1.0, 1.0], true), [true, true, true, false]);
        assert_eq!(passed([2.0, 0.0], [1.0, 1.0], false), [false, false, false, true]);
        assert_eq!(passed([0.0, 0.0], [1.0, 0.0], false), [true; 4]);
    }

    #[test]
    fn a_radius_has_its_centre_where_the_shorter_arc_turns_by_less() {
        let half = 0.5_f64.sqrt();
        let near = |centre: Centre, x: f64, y: f64| (centre.at[0] - x).abs() + (centre.at[1] - y).abs() < 1e-9;
        let by = [2.0 * half, 0.0];
        assert!(near(centre_by_radius(by, 1.0, true).unwrap(), half, -half));
        assert!(near(centre_by_radius(by, 1.0, false).unwrap(), half, half));
        assert!(near(centre_by_radius(by, -1.0, true).unwrap(), half, half));
    }

    #[test]
    fn an_arc_that_does_not_fit_is_refused() {
        let mm = ONE as f64;
        assert_eq!(centre_by_offsets([2.0 * mm, 0.0], [1.01 * mm, 0.0]), Err(33));
        assert!(centre_by_offsets([2.0 * mm, 0.0], [1.002 * mm, 0.0]).is_ok());
        assert_eq!(centre_by_radius([2.02 * mm, 0.0], 1.0 * mm, true), Err(34));
    }
}
