//! Derivatives of a speed profile, and how they are taken.

use clap::ValueEnum;
use isostep_report::pictures::profile as picture;
use isostep_report::speed_profiles::{Curve, differences};

/// The ways to take derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Derivatives {
    /// In closed form where the speed profile has one, otherwise by differences
    Exact,
    /// As the paper takes them: second-order differences of the step instants, of those, and of those again
    Paper,
}

/// The curves over time.
pub fn curves(curve: &Curve, derivatives: Derivatives) -> picture::Curve {
    match (&curve.exact, derivatives) {
        (Some(exact), Derivatives::Exact) => exact.curve(&curve.name),
        _ => differences(curve),
    }
}
