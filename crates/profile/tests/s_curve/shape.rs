//! The phases, of seven, that an S-curve has.

use isostep_profile::{Limits, Profile};

/// A ramp whose rise is less than this fraction of the speed counts as none.
const RISE_MIN: f64 = 1e-9;
/// A shorter cruise, as a fraction of the duration, is left over from the search for the peak and counts as none.
const CRUISE_MIN: f64 = 1e-9;

/// The shape of a ramp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RampShape {
    /// There is none.
    None,
    /// Two jerks: the acceleration is not reached.
    TwoPhases,
    /// Two jerks with constant acceleration between them.
    ThreePhases,
}

/// The shape of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shape {
    pub accel: RampShape,
    pub cruises: bool,
    pub decel: RampShape,
}

impl Shape {
    /// Every shape except that of a move without any phase.
    pub fn all() -> impl Iterator<Item = Self> {
        let ramps = [RampShape::None, RampShape::TwoPhases, RampShape::ThreePhases];
        let pairs = ramps.into_iter().flat_map(move |accel| ramps.map(|decel| (accel, decel)));
        let shapes = pairs.flat_map(|(accel, decel)| [true, false].map(|cruises| Self { accel, cruises, decel }));
        shapes.filter(|shape| shape.cruises || (shape.accel, shape.decel) != (RampShape::None, RampShape::None))
    }

    pub fn of(profile: &Profile, limits: &Limits) -> Self {
        let peak = profile.cruise_speed_steps_s();
        let ramp = |slow: f64, accel: f64| match peak - slow {
            rise if rise <= RISE_MIN * peak => RampShape::None,
            rise if limits.jerk_steps_s3 * rise <= accel * accel => RampShape::TwoPhases,
            _ => RampShape::ThreePhases,
        };
        Self {
            accel: ramp(profile.entry_speed_steps_s(), limits.accel_steps_s2),
            cruises: profile.t_cruise_s() > CRUISE_MIN * profile.duration_s(),
            decel: ramp(profile.exit_speed_steps_s(), limits.decel_steps_s2),
        }
    }
}
