//! A target and the figure that was measured for it.

use serde::Serialize;

/// A measured figure and its target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// What is measured.
    pub what: String,
    /// The measured value, if there is one.
    pub measured: Option<f64>,
    /// The target value.
    pub target: f64,
    /// Whether the value must be at least the target; otherwise at most.
    pub at_least: bool,
    /// The unit of both values.
    pub unit: &'static str,
    /// Whether the target was met.
    pub met: bool,
}

impl Target {
    pub fn at_least(what: String, measured: Option<f64>, target: f64, unit: &'static str) -> Self {
        let met = measured.is_some_and(|measured| measured >= target);
        Self { what, measured, target, at_least: true, unit, met }
    }

    pub fn at_most(what: String, measured: Option<f64>, target: f64, unit: &'static str) -> Self {
        let met = measured.is_some_and(|measured| measured <= target);
        Self { what, measured, target, at_least: false, unit, met }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_met_at_its_limit_and_not_without_a_figure() {
        assert!(Target::at_least(String::new(), Some(5.0), 5.0, "").met);
        assert!(!Target::at_least(String::new(), Some(4.9), 5.0, "").met);
        assert!(!Target::at_most(String::new(), Some(5.1), 5.0, "").met);
        assert!(!Target::at_most(String::new(), None, 5.0, "").met);
    }
}
