//! The machine's speed profiles: speed over time or over displacement.

use anyhow::{Context, Result, bail, ensure};
use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile};
use isostep_report::speed_profiles::{Curve, steps_at};

use super::generator::{Clocks, Generator};
use super::number::needed;

#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "The machine: speed over time or displacement (every speed profile)")]
pub struct MachineArgs {
    /// Speed at the start and the end, steps/s [default: 0]
    #[arg(long, value_name = "STEPS/S", allow_negative_numbers = true)]
    start_speed: Option<f64>,
    /// Speed never exceeded, steps/s
    #[arg(long, value_name = "STEPS/S", allow_negative_numbers = true)]
    top_speed: Option<f64>,
    /// Acceleration never exceeded, steps/s2
    #[arg(long, value_name = "STEPS/S2", allow_negative_numbers = true)]
    accel: Option<f64>,
    /// Deceleration never exceeded, steps/s2 [default: the acceleration]
    #[arg(long, value_name = "STEPS/S2", allow_negative_numbers = true)]
    decel: Option<f64>,
    /// Jerk never exceeded, steps/s3: of the s-curve
    #[arg(long, value_name = "STEPS/S3", allow_negative_numbers = true)]
    jerk: Option<f64>,
    /// Accelerate, cruise and decelerate for a third of the time each (Forero 2023)
    #[arg(long)]
    thirds: bool,
    /// Generator of a trapezoid's steps [default: exact]
    #[arg(long, value_name = "GENERATOR", value_delimiter = ',')]
    generator: Vec<Generator>,
    /// Clock of the time-per-step generators, Hz: intervals are whole ticks [default: 1000000]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..))]
    tick_hz: Option<u32>,
    /// Rate at which steps-per-time adds up, Hz [default: 10000, the paper's]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..))]
    service_hz: Option<u32>,
}

const TICK_HZ: u32 = 1_000_000;
const SERVICE_HZ: u32 = 10_000;

impl MachineArgs {
    /// The name of the first of these options that was given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            (self.start_speed.is_some(), "--start-speed"),
            (self.top_speed.is_some(), "--top-speed"),
            (self.accel.is_some(), "--accel"),
            (self.decel.is_some(), "--decel"),
            (self.jerk.is_some(), "--jerk"),
            (self.thirds, "--thirds"),
            (!self.generator.is_empty(), "--generator"),
            (self.tick_hz.is_some(), "--tick-hz"),
            (self.service_hz.is_some(), "--service-hz"),
        ];
        given.into_iter().find_map(|(is_given, name)| is_given.then_some(name))
    }

    /// The requested parameters in words.
    pub fn summary(&self, steps: u32) -> String {
        let shown = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let jerk = self.jerk.map_or(String::new(), |jerk| format!(", jerk {jerk} steps/s3"));
        let thirds = if self.thirds { ", three equal intervals" } else { "" };
        format!(
            "N = {steps}, from {} to at most {} steps/s; acceleration {}, deceleration {} steps/s2{jerk}{thirds}",
            self.start_speed.unwrap_or(0.0),
            shown(self.top_speed),
            shown(self.accel),
            shown(self.decel.or(self.accel)),
        )
    }

    /// Refuses options that would have no effect on any of `speed_profiles`.
    pub fn check(&self, speed_profiles: &[SpeedProfile]) -> Result<()> {
        if self.jerk.is_some() && !speed_profiles.contains(&SpeedProfile::SCurve) {
            bail!("--jerk limits the s-curve alone: add --speed-profile s-curve, or leave it out");
        }
        let inexact = self.generator.iter().find(|generator| **generator != Generator::Exact);
        if let (Some(generator), false) = (inexact, speed_profiles.contains(&SpeedProfile::Trapezoid)) {
            bail!("--generator {} makes a trapezoid alone: add --speed-profile trapezoid", generator.name());
        }
        if let (Some(generator), true) = (inexact, self.thirds) {
            bail!("--generator {} cannot split a move into thirds: leave out --thirds", generator.name());
        }
        let uses = |wanted: &[Generator]| self.generator.iter().any(|generator| wanted.contains(generator));
        ensure!(
            self.tick_hz.is_none() || uses(&[Generator::TimePerStep, Generator::TimePerStepCorrected]),
            "--tick-hz is the clock of --generator time-per-step and time-per-step-corrected alone"
        );
        ensure!(
            self.service_hz.is_none() || uses(&[Generator::StepsPerTime]),
            "--service-hz is the rate of --generator steps-per-time alone"
        );
        Ok(())
    }

    /// Plans `speed_profile`: the trapezoid with every requested generator, any other speed profile exactly.
    pub fn plan(&self, speed_profile: SpeedProfile, steps: u32) -> Result<Vec<Curve>> {
        let limits = self.limits(speed_profile)?;
        let intervals = if self.thirds { IntervalSplit::Thirds } else { IntervalSplit::Fastest };
        let start = limits.start_speed_steps_s;
        let profile = Profile::plan(f64::from(steps), start, start, &limits, intervals, speed_profile)?;
        if speed_profile != SpeedProfile::Trapezoid || self.generator.is_empty() {
            return Ok(vec![Curve::exact(speed_profile.name(), profile, steps)]);
        }
        let clocks =
            Clocks { tick_hz: self.tick_hz.unwrap_or(TICK_HZ), service_hz: self.service_hz.unwrap_or(SERVICE_HZ) };
        let curve = |&generator: &Generator| {
            Ok(match generator.edges_us(steps, &limits, clocks).with_context(|| generator.remedy())? {
                None => Curve::exact(speed_profile.name(), profile, steps),
                Some(edges_us) => Curve::of_steps(generator.name(), steps_at(&edges_us), profile.step_counts(), None),
            })
        };
        self.generator.iter().map(curve).collect()
    }

    fn limits(&self, speed_profile: SpeedProfile) -> Result<Limits> {
        let name = speed_profile.name();
        let top = needed(self.top_speed, name, "--top-speed", "in steps/s", "2400")?;
        let accel = needed(self.accel, name, "--accel", "in steps/s2", "2500")?;
        let jerk = match speed_profile {
            SpeedProfile::SCurve => needed(self.jerk, name, "--jerk", "in steps/s3", "25000")?,
            _ => f64::INFINITY,
        };
        Ok(Limits {
            start_speed_steps_s: self.start_speed.unwrap_or(0.0),
            top_speed_steps_s: top,
            accel_steps_s2: accel,
            decel_steps_s2: self.decel.unwrap_or(accel),
            jerk_steps_s3: jerk,
        })
    }
}
