//! What is aimed at, beside what was measured.

use serde::Serialize;

/// A figure beside what was aimed at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    /// What it is.
    pub what: String,
    /// What was measured, if it was.
    pub measured: Option<f64>,
    /// What was aimed at.
    pub target: f64,
    /// Whether more is better, rather than less.
    pub at_least: bool,
    /// Of both.
    pub unit: &'static str,
    /// Whether it was reached.
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
