//! An arc between two points: its circle, its bounding box and its length. Pure geometry, in mm and radians.

mod chords;
mod polygon;

pub use chords::Chords;
pub use polygon::{Polygon, Within};

use core::f64::consts::{PI, TAU};
use core::fmt;

use crate::axes::{A, Z, of_each};
use crate::{AXES, Coordinate, Error, length};

/// The axes of the planes G17, G18 and G19. The first two span the plane: the quarter turn from first to second is
/// counter-clockwise. The third is perpendicular to it. The fourth, A, goes evenly along, as the third does. Without Z there is G17 alone.
pub(crate) const PLANES: [[usize; AXES]; if AXES > Z { 3 } else { 1 }] = {
    let planes = [of_each([0, 1, Z, A]), of_each([Z, 0, 1, A]), of_each([1, Z, 0, A])];
    *planes.first_chunk().expect("there are three planes at most")
};

/// The amount by which the distances of start and target from the centre may differ, as in Grbl. Up to `MISFIT_MM` is always
/// allowed and more than `MISFIT_MAX_MM` never; in between, up to `MISFIT_OF_RADIUS` of the radius is allowed.
const MISFIT_MM: f64 = 0.005;
const MISFIT_MAX_MM: f64 = 0.5;
const MISFIT_OF_RADIUS: f64 = 0.001;

/// The distance by which rounding may have moved a place in these computations: less than a picometre.
const ROUNDING_MM: f64 = 1e-10;

/// The ends of an arc, and its direction of rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArcEnds {
    /// Start point.
    pub start_mm: [f64; AXES],
    /// End point.
    pub target_mm: [f64; AXES],
    /// 0 for G17, 1 for G18, 2 for G19.
    pub plane: u8,
    /// G2 if true, G3 if false.
    pub clockwise: bool,
}

impl ArcEnds {
    /// The two axes of the plane, then the perpendicular one, then any other.
    fn axes(&self) -> [usize; AXES] {
        PLANES[usize::from(self.plane)]
    }

    /// Signed distance from start to target along `axis`.
    fn distance_mm(&self, axis: usize) -> f64 {
        self.target_mm[axis] - self.start_mm[axis]
    }

    /// The vector from start to target in the plane.
    fn chord_mm(&self) -> [f64; 2] {
        let [first, second, ..] = self.axes();
        [self.distance_mm(first), self.distance_mm(second)]
    }

    /// The vectors to start and target from the centre, which is `offset_mm` from the start.
    fn radii_mm(&self, offset_mm: [f64; 2]) -> [[f64; 2]; 2] {
        let chord_mm = self.chord_mm();
        [offset_mm.map(|mm| -mm), core::array::from_fn(|index| chord_mm[index] - offset_mm[index])]
    }

    /// Signed angle from start to target around the centre that is `offset_mm` from the start. It is a full circle only
    /// where start and target are the same place in the plane.
    fn travel_rad(&self, offset_mm: [f64; 2]) -> f64 {
        let [from, to] = self.radii_mm(offset_mm);
        let full_rad = if self.clockwise { -TAU } else { TAU };
        if self.chord_mm() == [0.0; 2] {
            return full_rad;
        }
        let rad = libm::atan2(cross(from, to), from[0] * to[0] + from[1] * to[1]);
        // Where both are in one direction from the centre, rounding must not decide on a whole turn.
        let wrong_way_mm = -full_rad.signum() * rad * hypotenuse(from);
        if wrong_way_mm > ROUNDING_MM { rad + full_rad } else { rad }
    }
}

/// An arc or a full circle in a plane. It is a helix if start and target differ along the perpendicular axis.
///
/// If the distances of start and target from the centre differ slightly, the radius changes evenly along the arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    ends: ArcEnds,
    /// From the start to the centre.
    offset_mm: [f64; 2],
    radius_mm: f64,
    target_radius_mm: f64,
    /// Positive is counter-clockwise.
    travel_rad: f64,
}

impl Arc {
    /// The arc around the centre that is `offset_mm` from its start. It is a full circle if start and target are the
    /// same.
    ///
    /// # Errors
    /// [`Error::InvalidTarget`]: the distances of start and target from the centre differ too much.
    pub fn around(ends: ArcEnds, offset_mm: [f64; 2]) -> Result<Self, Error> {
        let arc = Self::new(ends, offset_mm, ends.travel_rad(offset_mm));
        if arc.fits() { Ok(arc) } else { Err(Error::InvalidTarget) }
    }

    /// True if start and target are equally far from the centre, as nearly as Grbl demands.
    fn fits(&self) -> bool {
        (self.target_radius_mm - self.radius_mm).abs() <= misfit_max_mm(self.radius_mm)
    }

    /// The arc with this radius: the shorter one, or with a negative radius that of more than half a circle.
    ///
    /// # Errors
    /// [`Error::InvalidTarget`]: start and target are the same, so the circle is undefined. [`Error::RadiusTooSmall`]:
    /// half the distance between them is longer than the radius, by more than the ends of an arc may differ from a circle.
    pub fn of_radius(ends: ArcEnds, radius_mm: f64) -> Result<Self, Error> {
        let chord_mm @ [first_mm, second_mm] = ends.chord_mm();
        let length_mm = hypotenuse(chord_mm);
        if length_mm == 0.0 {
            return Err(Error::InvalidTarget);
        }
        if is_too_small(radius_mm, length_mm) {
            return Err(Error::RadiusTooSmall);
        }
        let diameter_mm = 2.0 * radius_mm.abs();
        // Twice the distance of the centre from the middle of the chord.
        let aside_mm = libm::sqrt(((diameter_mm - length_mm) * (diameter_mm + length_mm)).max(0.0));
        let to_the_left = ends.clockwise == (radius_mm < 0.0);
        let aside = if to_the_left { aside_mm } else { -aside_mm } / length_mm;
        let offset_mm = [0.5 * (first_mm - aside * second_mm), 0.5 * (second_mm + aside * first_mm)];
        // The radius says which of the two arcs it is. Seen from the centre, a short chord is less than rounding.
        let shorter_rad = 2.0 * libm::atan2(length_mm, aside_mm);
        let turn_rad = if radius_mm < 0.0 { TAU - shorter_rad } else { shorter_rad };
        Ok(Self::new(ends, offset_mm, if ends.clockwise { -turn_rad } else { turn_rad }))
    }

    fn new(ends: ArcEnds, offset_mm: [f64; 2], travel_rad: f64) -> Self {
        let [from_mm, to_mm] = ends.radii_mm(offset_mm);
        let (radius_mm, target_radius_mm) = (hypotenuse(from_mm), hypotenuse(to_mm));
        Self { ends, offset_mm, radius_mm, target_radius_mm, travel_rad }
    }

    /// The chords that replace the arc. None deviates from it by more than `tolerance_mm`, which is above 0.
    #[must_use]
    pub fn chords(&self, tolerance_mm: f64) -> Chords {
        Chords::new(self, tolerance_mm)
    }

    /// The polygon round the arc whose blends make it; `None` if that has no fewer sides than there are [chords](Self::chords).
    #[must_use]
    pub fn polygon(&self, within: &Within) -> Option<Polygon> {
        Polygon::new(self, within)
    }

    /// The two axes of the plane, then the perpendicular one and any other, along which the motion is linear.
    #[must_use]
    pub fn axes(&self) -> [usize; AXES] {
        self.ends.axes()
    }

    /// Start point.
    #[must_use]
    pub fn start_mm(&self) -> [f64; AXES] {
        self.ends.start_mm
    }

    /// Length of the path, including the rise of a helix. A degree of A counts as a millimetre.
    #[must_use]
    pub fn length_mm(&self) -> f64 {
        self.axes()
            .get(3..)
            .unwrap_or_default()
            .iter()
            .fold(self.linear_mm(), |length_mm, &axis| hypotenuse([length_mm, self.ends.distance_mm(axis)]))
    }

    /// Length of the path without what A turns.
    pub(crate) fn linear_mm(&self) -> f64 {
        let around_mm = 0.5 * (self.radius_mm + self.target_radius_mm) * self.travel_rad.abs();
        let across_mm = self.axes().get(2).map_or(0.0, |&across| self.ends.distance_mm(across));
        hypotenuse([around_mm, across_mm])
    }

    /// The least and the greatest coordinate on the arc, axis by axis.
    #[must_use]
    pub fn bounds_mm(&self) -> [[f64; 2]; AXES] {
        let ArcEnds { start_mm, target_mm, .. } = self.ends;
        let mut bounds_mm = core::array::from_fn(|axis| {
            let (start_mm, target_mm) = (start_mm[axis], target_mm[axis]);
            [start_mm.min(target_mm), start_mm.max(target_mm)]
        });
        let radius_mm = self.radius_mm.max(self.target_radius_mm);
        for (index, centre_mm) in self.centre_mm().into_iter().enumerate() {
            let [least_mm, most_mm] = &mut bounds_mm[self.axes()[index]];
            let mut outwards = [0.0; 2];
            outwards[index] = 1.0;
            if self.passes(outwards) {
                *most_mm = most_mm.max(centre_mm + radius_mm);
            }
            if self.passes(outwards.map(|part| -part)) {
                *least_mm = least_mm.min(centre_mm - radius_mm);
            }
        }
        bounds_mm
    }

    /// True if the arc has a point in this direction from its centre, between its ends.
    fn passes(&self, direction: [f64; 2]) -> bool {
        let turn_rad = self.travel_rad.abs();
        let [from, to] = self.radii_mm();
        // The arc runs counter-clockwise from `first` to `last`.
        let (first, last) = if self.travel_rad < 0.0 { (to, from) } else { (from, to) };
        if turn_rad <= PI {
            cross(first, direction) > 0.0 && cross(direction, last) > 0.0
        } else {
            !(cross(last, direction) > 0.0 && cross(direction, first) > 0.0)
        }
    }

    /// The centre, in the plane.
    fn centre_mm(&self) -> [f64; 2] {
        core::array::from_fn(|index| self.ends.start_mm[self.axes()[index]] + self.offset_mm[index])
    }

    /// The vectors from the centre to start and target.
    fn radii_mm(&self) -> [[f64; 2]; 2] {
        self.ends.radii_mm(self.offset_mm)
    }
}

/// Why an arc was refused whose ends are on no circle of those that its words allow. Displays as the text of a
/// `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Misfit {
    /// Start and target are not equally far from the centre.
    Centre {
        /// The distance of the start from the centre.
        start_radius_mm: f64,
        /// The distance of the target from the centre.
        target_radius_mm: f64,
        /// They would be equally far from it if I, J and K were its place.
        fits_as_place: bool,
    },
    /// The target is farther away than twice the radius.
    Radius {
        /// The radius, without its sign.
        radius_mm: f64,
        /// The distance of the target from the start, in the plane.
        chord_mm: f64,
    },
}

impl Misfit {
    /// `None` if start and target are equally far from the centre, as nearly as Grbl demands. The other offset is the one
    /// that leads to the centre if I, J and K are its place.
    pub(crate) fn of_centre(ends: ArcEnds, offset_mm: [f64; 2], other_mm: Option<[f64; 2]>) -> Option<Self> {
        let arc = Arc::new(ends, offset_mm, 0.0);
        let Arc { radius_mm: start_radius_mm, target_radius_mm, .. } = arc;
        let fits_as_place = other_mm.is_some_and(|other_mm| Arc::new(ends, other_mm, 0.0).fits());
        (!arc.fits()).then_some(Self::Centre { start_radius_mm, target_radius_mm, fits_as_place })
    }

    /// `None` if the radius is long enough.
    pub(crate) fn of_radius(ends: ArcEnds, radius_mm: f64) -> Option<Self> {
        let chord_mm = hypotenuse(ends.chord_mm());
        is_too_small(radius_mm, chord_mm).then_some(Self::Radius { radius_mm: radius_mm.abs(), chord_mm })
    }
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |mm: f64| Coordinate { pm: length::from_mm(mm), inches: false };
        match *self {
            Self::Centre { start_radius_mm, target_radius_mm, fits_as_place } => {
                let (start, target) = (mm(start_radius_mm), mm(target_radius_mm));
                write!(f, "the start is {start} mm from the arc's centre, the target {target} mm: ")?;
                f.write_str(match fits_as_place {
                    true => "it fits if I, J, K are absolute (G90.1): have them written from the start (G91.1)",
                    false => "correct the target or I, J, K",
                })
            }
            Self::Radius { radius_mm, chord_mm } => {
                let (radius, chord, least) = (mm(radius_mm), mm(chord_mm), mm(0.5 * chord_mm));
                write!(
                    f,
                    "the target is {chord} mm from the start, more than twice R {radius} mm: correct it, or make R {least} mm"
                )
            }
        }
    }
}

/// The amount by which the distances of the ends of an arc of this radius from its centre may differ.
fn misfit_max_mm(radius_mm: f64) -> f64 {
    (MISFIT_OF_RADIUS * radius_mm).clamp(MISFIT_MM, MISFIT_MAX_MM)
}

/// True if no circle of this radius reaches both ends of a chord, as nearly as they must be on it.
fn is_too_small(radius_mm: f64, chord_mm: f64) -> bool {
    0.5 * chord_mm - radius_mm.abs() > misfit_max_mm(radius_mm.abs())
}

/// The cross product: positive if `b` is to the left of `a`.
fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn hypotenuse([a, b]: [f64; 2]) -> f64 {
    libm::sqrt(a * a + b * b)
}

#[cfg(test)]
mod tests;
