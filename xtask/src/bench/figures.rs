//! All that was measured, as `--json` writes it.

use serde::Serialize;

use super::accuracy::AccuracyFigures;
use super::candidate;
use super::laws;
use super::load::LoadFigures;
use super::micro::MicroFigures;
use super::progress::grouped;
use super::rates::{self, RateFigures};
use super::stops::{Input, StopMeasurement};
use super::trial::AXES;
use crate::variant::Port;

/// A whole run of the benchmark.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// How they were come by.
    pub conditions: Conditions,
    /// Each port's.
    pub ports: Vec<PortFigures>,
    /// What the mathematics of a move costs on the chip; null if only one port was asked for.
    pub mathematics: Option<MicroFigures>,
    /// What was aimed at.
    pub targets: Vec<Target>,
}

/// What every figure depends on.
#[derive(Clone, Debug, Serialize)]
pub struct Conditions {
    /// The command that prints them.
    pub command: String,
    /// Where the firmware ran.
    pub board: &'static str,
    /// Of the core, Hz.
    pub clock_hz: u32,
    /// How it was built.
    pub build: String,
    /// Whose least times every edge was held to.
    pub driver: &'static str,
    /// Status reports asked for over USB meanwhile, Hz.
    pub poll_hz: u32,
    /// From rest to the rate, s, unless that took more than the highest acceleration.
    pub ramp_s: f64,
    /// The highest acceleration, steps/s2.
    pub accel_max_steps_s2: f64,
}

/// What was measured of a port.
#[derive(Clone, Debug, Serialize)]
pub struct PortFigures {
    #[serde(serialize_with = "candidate::serialize_port")]
    pub port: Port,
    pub rates: Vec<RateFigures>,
    pub accuracy: AccuracyFigures,
    pub load: Vec<LoadFigures>,
    pub stops: Vec<StopMeasurement>,
}

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

    /// Met only under a condition, such as at the rate that was meant.
    fn if_also(self, condition: bool) -> Self {
        Self { met: self.met && condition, ..self }
    }
}

impl PortFigures {
    /// What is aimed at with this port.
    pub fn targets(&self) -> Vec<Target> {
        vec![self.rate_target(), self.accuracy_target(), self.stop_target()]
    }

    fn rate_target(&self) -> Target {
        let highest = rates::highest_steps_s(&self.rates, AXES).map(f64::from);
        let what = format!("{}, {AXES} axes at once, each", self.port.name());
        Target::at_least(what, highest, self.port.target_steps_s().into(), "steps/s")
    }

    fn accuracy_target(&self) -> Target {
        let errors = self.accuracy.edges.figure().map(|edges| edges.errors);
        let (which, error_ns) = match self.port {
            Port::Pio => ("max", errors.map(|errors| errors.max_ns)),
            Port::Timer => ("p99", errors.map(|errors| errors.p99_ns)),
        };
        let rate_steps_s = self.accuracy.rate_steps_s;
        let what = format!("{}, edge error at {}, {which}", self.port.name(), together(rate_steps_s));
        Target::at_most(what, error_ns, self.port.error_bound_ns(), "ns")
            .if_also(rate_steps_s >= self.port.target_steps_s())
    }

    fn stop_target(&self) -> Target {
        let by_switch = self.stops.iter().find(|stop| stop.input == Input::LimitSwitch);
        let max_us = by_switch.and_then(|stop| stop.latency.figure()).map(|latency| latency.max_us);
        Target::at_most(format!("{}, limit switch to the last edge, max", self.port.name()), max_us, 10.0, "us")
    }

    /// Whether anything at all was sustained.
    pub fn moved(&self) -> bool {
        self.rates.iter().any(|rates| rates.highest_steps_s.is_some())
    }
}

/// What is aimed at on the chip.
pub fn mathematics_targets(figures: &MicroFigures) -> Vec<Target> {
    laws::targets(&figures.laws).collect()
}

/// A rate of all axes at once.
pub fn together(rate_steps_s: u32) -> String {
    format!("{AXES} x {} steps/s", grouped(rate_steps_s.into()))
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
