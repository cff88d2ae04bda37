//! Fonseca-Campos's profiles: frequency over the step index.

use anyhow::{Result, bail};
use isostep_generators::{FrequencyError, FrequencyProfile, FrequencyRamp, TruncatedProfile};
use isostep_profile::SpeedProfile;
use isostep_report::speed_profiles::{Curve, Step};

use super::number::{count, needed};

#[derive(clap::Args, Clone, Copy, Debug, Default)]
#[command(
    next_help_heading = "Fonseca-Campos 2023: frequency over the step index (linear, quadratic, sinusoidal, logarithmic)"
)]
pub struct FrequencyArgs {
    /// Steps of each ramp (p_N), 2 to half of the steps
    #[arg(long, value_name = "P", value_parser = count, allow_negative_numbers = true)]
    ramp_steps: Option<u32>,
    /// Period at the start and the end, us (tau_max)
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    max_period_us: Option<f64>,
    /// Period in between, us (tau_min)
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    min_period_us: Option<f64>,
    /// As the paper's program makes it: half periods of whole us, and no ramps below 20 steps
    #[arg(long)]
    truncated: bool,
}

impl FrequencyArgs {
    /// The name of the first of these options that was given.
    pub fn given(&self) -> Option<&'static str> {
        let given = [
            (self.ramp_steps.is_some(), "--ramp-steps"),
            (self.max_period_us.is_some(), "--max-period-us"),
            (self.min_period_us.is_some(), "--min-period-us"),
            (self.truncated, "--truncated"),
        ];
        given.into_iter().find_map(|(is_given, name)| is_given.then_some(name))
    }

    /// The requested parameters in words.
    pub fn summary(&self, steps: u32) -> String {
        let [ramp, max, min] = [self.ramp_steps.map(f64::from), self.max_period_us, self.min_period_us]
            .map(|value| value.map_or(String::new(), |value| value.to_string()));
        let how = if self.truncated { "as printed: half periods of whole us" } else { "exact" };
        format!("N = {steps}, p_N = {ramp}, periods {max} to {min} us and back; {how} (Fonseca-Campos 2023, eqs 5-8)")
    }

    /// Plans `frequency_ramp`.
    pub fn plan(&self, frequency_ramp: SpeedProfile, steps: u32) -> Result<Curve> {
        let Some(frequency_ramp) = frequency_ramp_of_paper(frequency_ramp) else {
            bail!(
                "--speed-profile {} is a profile of speed over time, without {}: give --top-speed and --accel, such as --top-speed 2400 --accel 2500",
                frequency_ramp.name(),
                self.given().unwrap_or("--ramp-steps"),
            );
        };
        let name = frequency_ramp.name();
        let ramp = needed(self.ramp_steps, name, "--ramp-steps", RAMP, "24")?;
        let max_us =
            needed(self.max_period_us, name, "--max-period-us", "the period at the start and the end", "4000")?;
        let min_us = needed(self.min_period_us, name, "--min-period-us", "the period between the ramps", "1500")?;
        let curve = if self.truncated { truncated } else { exact };
        Ok(curve(frequency_ramp, steps, ramp, max_us, min_us)?)
    }
}

/// The options that the error asks for when none of these options was given.
const RAMP: &str = "the steps of each ramp (or --top-speed and --accel, as a ramp of the machine)";

type Planned = Result<Curve, FrequencyError>;

fn exact(frequency_ramp: FrequencyRamp, n: u32, ramp: u32, max_us: f64, min_us: f64) -> Planned {
    let plan = FrequencyProfile::plan(frequency_ramp, n, ramp, max_us, min_us)?;
    let step = |(edge_s, i): (f64, u32)| {
        let frequency_hz = plan.frequency_hz(i);
        Step { t_us: edge_s * 1e6, period_us: Some(1e6 / frequency_hz), frequency_hz: Some(frequency_hz) }
    };
    let steps = plan.edges_s().zip(1..).map(step).collect();
    Ok(Curve::of_steps(frequency_ramp.name(), steps, plan.step_counts(), Some(plan.duration_s())))
}

fn truncated(frequency_ramp: FrequencyRamp, n: u32, ramp: u32, max_us: f64, min_us: f64) -> Planned {
    let plan = TruncatedProfile::plan(frequency_ramp, n, ramp, max_us, min_us)?;
    let step = |(edge_us, i): (u64, u32)| {
        let period_us = f64::from(plan.period_us(i));
        Step { t_us: edge_us as f64, period_us: Some(period_us), frequency_hz: Some(1e6 / period_us) }
    };
    let steps = plan.edges_us().zip(1..).map(step).collect();
    Ok(Curve::of_steps(frequency_ramp.name(), steps, plan.step_counts(), Some(plan.duration_us() as f64 * 1e-6)))
}

/// The profile of frequency in Fonseca-Campos 2023 with the same name, if it is one of the four.
pub fn frequency_ramp_of_paper(frequency_ramp: SpeedProfile) -> Option<FrequencyRamp> {
    FrequencyRamp::ALL.into_iter().find(|of_paper| of_paper.name() == frequency_ramp.name())
}

#[cfg(test)]
mod tests {
    use isostep_profile::StepCounts;

    use super::*;

    fn table_1() -> FrequencyArgs {
        FrequencyArgs {
            ramp_steps: Some(24),
            max_period_us: Some(4000.0),
            min_period_us: Some(1500.0),
            truncated: false,
        }
    }

    /// Values from the equations programmed in another language: 0.2226781672 s exact, 222632 us truncated.
    #[test]
    fn both_ways_of_table_1() {
        let plan = table_1().plan(SpeedProfile::Linear, 120).unwrap();
        assert!((plan.duration_s.unwrap() - 0.222_678_167_2).abs() < 1e-10);
        assert!((plan.phases_s.iter().sum::<f64>() - plan.duration_s.unwrap()).abs() < 1e-12);
        assert_eq!(plan.counts, StepCounts { accel: 24, cruise: 71, decel: 25 });
        assert_eq!(plan.samples.last(), Some(&(plan.duration_s.unwrap(), 120.0)));
        let truncated = FrequencyArgs { truncated: true, ..table_1() }.plan(SpeedProfile::Linear, 120).unwrap();
        assert_eq!(truncated.duration_s, Some(0.222_632));
        assert_eq!(truncated.steps[119].period_us, Some(4000.0));
    }

    #[test]
    fn what_is_missing_is_named_with_an_example() {
        let text = |args: FrequencyArgs, frequency_ramp| args.plan(frequency_ramp, 120).err().unwrap().to_string();
        let none = FrequencyArgs::default();
        assert!(text(none, SpeedProfile::Linear).contains("such as --ramp-steps 24"));
        assert!(
            text(FrequencyArgs { max_period_us: None, ..table_1() }, SpeedProfile::Linear)
                .contains("such as --max-period-us 4000")
        );
        assert!(
            text(FrequencyArgs { min_period_us: None, ..table_1() }, SpeedProfile::Linear)
                .contains("such as --min-period-us 1500")
        );
        assert!(text(table_1(), SpeedProfile::Sine).contains("without --ramp-steps: give --top-speed and --accel"));
    }

    #[test]
    fn what_cannot_be_planned_is_refused_with_its_bound() {
        let text = |args: FrequencyArgs| args.plan(SpeedProfile::Quadratic, 120).err().unwrap().to_string();
        assert!(text(FrequencyArgs { ramp_steps: Some(61), ..table_1() }).contains("at most 60"));
        assert!(text(FrequencyArgs { ramp_steps: Some(1), ..table_1() }).contains("at least 2"));
        assert!(
            text(FrequencyArgs { min_period_us: Some(4001.0), ..table_1() }).contains("above the largest, 4000 us")
        );
        assert!(
            text(FrequencyArgs { max_period_us: Some(f64::NAN), ..table_1() }).contains("NaN us is outside 0.1 to")
        );
        assert!(text(FrequencyArgs { min_period_us: Some(-1.0), ..table_1() }).contains("-1 us is outside 0.1 to"));
    }
}
