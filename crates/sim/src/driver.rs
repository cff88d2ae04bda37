//! The inputs of a stepper driver. Every edge is checked against its datasheet.

use std::fmt;

use isostep_motion::{Axis, DriverTiming};

/// A requirement of the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// STEP high time.
    StepHigh,
    /// STEP low time.
    StepLow,
    /// STEP period.
    StepPeriod,
    /// DIR steady before STEP rises.
    DirSetup,
    /// DIR steady after STEP rose.
    DirHold,
    /// ENABLE active before STEP rises.
    EnableSetup,
    /// ENABLE active after STEP rose.
    EnableHold,
    /// A step while ENABLE is inactive.
    Enabled,
}

impl Rule {
    /// All rules.
    pub const ALL: [Self; 8] = [
        Self::StepHigh,
        Self::StepLow,
        Self::StepPeriod,
        Self::DirSetup,
        Self::DirHold,
        Self::EnableSetup,
        Self::EnableHold,
        Self::Enabled,
    ];

    /// The least value that `timing` requires, ns.
    fn min_ns(self, timing: &DriverTiming) -> u64 {
        match self {
            Self::StepHigh => timing.step_high_ns.into(),
            Self::StepLow => timing.step_low_ns.into(),
            Self::StepPeriod => timing.period_ns.into(),
            Self::DirSetup | Self::DirHold | Self::EnableSetup | Self::EnableHold => timing.setup_ns.into(),
            Self::Enabled => 0,
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::StepHigh => "STEP high time",
            Self::StepLow => "STEP low time",
            Self::StepPeriod => "STEP period",
            Self::DirSetup => "DIR set-up time",
            Self::DirHold => "DIR hold time",
            Self::EnableSetup => "ENABLE set-up time",
            Self::EnableHold => "ENABLE hold time",
            Self::Enabled => "step while disabled",
        })
    }
}

/// An edge that the driver may misread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct Violation {
    /// Time since power-up.
    pub t_ns: u64,
    /// Index of the axis.
    pub axis: usize,
    /// The broken rule.
    pub rule: Rule,
    /// The measured value.
    pub value_ns: u64,
    /// The required minimum.
    pub min_ns: u64,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { t_ns, axis, rule, value_ns, min_ns } = self;
        write!(f, "{:.6} s: {}: {rule}", *t_ns as f64 * 1e-9, Axis::ALL[*axis])?;
        if *rule != Rule::Enabled {
            write!(f, " {value_ns} ns, needs {min_ns} ns")?;
        }
        Ok(())
    }
}

/// The inputs of one driver.
#[derive(Debug)]
pub(crate) struct DriverInputs {
    axis: usize,
    timing: DriverTiming,
    step_high: bool,
    dir_high: bool,
    enabled: bool,
    rose_ns: Option<u64>,
    fell_ns: Option<u64>,
    dir_changed_ns: Option<u64>,
    enabled_ns: Option<u64>,
}

impl DriverInputs {
    /// Inputs with STEP low, DIR low, disabled.
    pub fn new(axis: usize, timing: DriverTiming) -> Self {
        Self {
            axis,
            timing,
            step_high: false,
            dir_high: false,
            enabled: false,
            rose_ns: None,
            fell_ns: None,
            dir_changed_ns: None,
            enabled_ns: None,
        }
    }

    /// 1 while DIR is high, -1 while it is low.
    pub fn direction(&self) -> i32 {
        if self.dir_high { 1 } else { -1 }
    }

    /// True if the motor is energised.
    pub(crate) fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Sets STEP; returns whether it rose.
    pub fn set_step(&mut self, t_ns: u64, high: bool, violations: &mut Vec<Violation>) -> bool {
        if high == self.step_high {
            return false;
        }
        self.step_high = high;
        if !high {
            self.check(Rule::StepHigh, self.rose_ns, t_ns, violations);
            self.fell_ns = Some(t_ns);
            return false;
        }
        self.check(Rule::StepLow, self.fell_ns, t_ns, violations);
        self.check(Rule::StepPeriod, self.rose_ns, t_ns, violations);
        self.check(Rule::DirSetup, self.dir_changed_ns, t_ns, violations);
        if self.enabled {
            self.check(Rule::EnableSetup, self.enabled_ns, t_ns, violations);
        } else {
            violations.push(Violation { t_ns, axis: self.axis, rule: Rule::Enabled, value_ns: 0, min_ns: 0 });
        }
        self.rose_ns = Some(t_ns);
        true
    }

    /// Sets DIR.
    pub fn set_dir(&mut self, t_ns: u64, high: bool, violations: &mut Vec<Violation>) {
        if high != self.dir_high {
            self.dir_high = high;
            self.check(Rule::DirHold, self.rose_ns, t_ns, violations);
            self.dir_changed_ns = Some(t_ns);
        }
    }

    /// Energises or releases the motor.
    pub(crate) fn set_enabled(&mut self, t_ns: u64, enabled: bool, violations: &mut Vec<Violation>) {
        if enabled != self.enabled {
            self.enabled = enabled;
            self.check(Rule::EnableHold, self.rose_ns, t_ns, violations);
            self.enabled_ns = Some(t_ns);
        }
    }

    fn check(&self, rule: Rule, since_ns: Option<u64>, t_ns: u64, violations: &mut Vec<Violation>) {
        let Some(since_ns) = since_ns else { return };
        let (value_ns, min_ns) = (t_ns.saturating_sub(since_ns), rule.min_ns(&self.timing));
        if value_ns < min_ns {
            violations.push(Violation { t_ns, axis: self.axis, rule, value_ns, min_ns });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Bench {
        inputs: DriverInputs,
        seen: Vec<Violation>,
    }

    impl Bench {
        /// A driver that is enabled at 0 ns.
        fn new() -> Self {
            let mut bench = Self { inputs: DriverInputs::new(1, DriverTiming::DRV8825), seen: Vec::new() };
            bench.inputs.set_enabled(0, true, &mut bench.seen);
            bench
        }

        fn pulse(&mut self, rises_ns: u64, falls_ns: u64) {
            assert!(self.inputs.set_step(rises_ns, true, &mut self.seen));
            assert!(!self.inputs.set_step(falls_ns, false, &mut self.seen));
        }

        fn rules(&self) -> Vec<(Rule, u64)> {
            self.seen.iter().map(|violation| (violation.rule, violation.value_ns)).collect()
        }
    }

    #[test]
    fn exactly_the_datasheet_is_enough() {
        let mut bench = Bench::new();
        bench.inputs.set_dir(0, true, &mut bench.seen);
        bench.pulse(650, 2_550);
        bench.inputs.set_dir(2_550, false, &mut bench.seen);
        bench.pulse(4_650, 6_550);
        assert_eq!(bench.rules(), []);
    }

    #[test]
    fn every_rule_is_seen() {
        let mut bench = Bench::new();
        bench.pulse(600, 2_000);
        bench.inputs.set_dir(1_200, true, &mut bench.seen);
        bench.pulse(3_000, 5_000);
        bench.inputs.set_dir(9_999, false, &mut bench.seen);
        bench.pulse(10_000, 12_000);
        bench.inputs.set_enabled(10_500, false, &mut bench.seen);
        bench.pulse(20_000, 22_000);
        let expected = [
            (Rule::EnableSetup, 600),
            (Rule::StepHigh, 1_400),
            (Rule::DirHold, 600),
            (Rule::StepLow, 1_000),
            (Rule::StepPeriod, 2_400),
            (Rule::DirSetup, 1),
            (Rule::EnableHold, 500),
            (Rule::Enabled, 0),
        ];
        assert_eq!(bench.rules(), expected);
        assert_eq!(bench.seen[1].to_string(), "0.000002 s: Y: STEP high time 1400 ns, needs 1900 ns");
    }
}
