//! A motion as points over time, to be drawn.

/// A motion and its derivatives over time. One without points is not drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// The name of the motion.
    pub name: String,
    /// Instants, s, and positions, steps.
    pub position: Vec<(f64, f64)>,
    /// Instants, s, and speeds, steps/s.
    pub speed: Vec<(f64, f64)>,
    /// Instants, s, and accelerations, steps/s².
    pub accel: Vec<(f64, f64)>,
    /// Instants, s, and jerks, steps/s³.
    pub jerk: Vec<(f64, f64)>,
}
