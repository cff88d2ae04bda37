//! `isostep profile`: any speed profile, as a table, a file of its steps, and a picture.
//!
//! # Design
//! ```text
//! frequency: Fonseca-Campos's N, p_N, periods ---+
//!                                           +--> curve: steps and phases --> table, files
//! machine: speeds, accelerations, jerk -----+      |
//!    generator: Stoychitch's             kinematics: differences; exact: the closed form
//! ```

mod files;
mod frequency;
mod generator;
mod kinematics;
mod machine;
mod number;
mod table;

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use isostep_profile::SpeedProfile;
use isostep_report::speed_profiles::Curve;

use self::files::PlotKind;
use self::frequency::FrequencyArgs;
use self::kinematics::Derivatives;
use self::machine::MachineArgs;
use self::number::steps;
use crate::files::Files;
use crate::profile_options::speed_profiles;

/// Compare speed profiles: a table, every step as CSV, curves over time
#[derive(clap::Args)]
#[command(after_help = "\
A speed profile is planned either as Fonseca-Campos 2023 does, from periods and steps of a ramp, or as the machine does, from speeds and
accelerations; which one, the options say. Fonseca-Campos's four speed profiles can be either: of frequency over the step index, or of
speed over displacement, as the ramp of a synchronised move (which needs a start speed above 0).

Peaks beside them are means over steps that follow each other, of the instants of the closed form. A port rounds these to its ticks,
which is far more than such a mean can bear at speed; isostep sim measures limits from rounded edges, over longer times.

Several speed profiles, or several generators, stand side by side in the table and one over the other in the picture.

CSV: step,t_us,period_us,frequency_hz, with as many decimals as it takes to lose nothing.
  t_us          the instant of the step's rising edge, the first at 0
  period_us     to the next rising edge. Fonseca-Campos's last step has a period too, of the lowest frequency; of other speed profiles
                the last step has none, and the field is empty
  frequency_hz  1e6/period_us

Examples:
  isostep profile --speed-profile linear --steps 120 --ramp-steps 24 --max-period-us 4000 --min-period-us 1500
  isostep profile --speed-profile linear,quadratic,sinusoidal,logarithmic --steps 120 --ramp-steps 24 \\
      --max-period-us 4000 --min-period-us 1500 --plot profiles.html         Fonseca-Campos 2023, table 1: all four profiles
  isostep profile --speed-profile logarithmic --steps 120 --ramp-steps 24 --max-period-us 4000 --min-period-us 1500 \\
      --truncated --csv steps.csv                                        as the paper's program makes it
  isostep profile --speed-profile trapezoid,s-curve,sine --steps 4000 --top-speed 2400 --accel 2500 --jerk 12500 --plot a.svg
  isostep profile --speed-profile trapezoid --generator exact,time-per-step,time-per-step-corrected,steps-per-time \\
      --steps 4096 --start-speed 326 --top-speed 1304 --accel 1304 --decel 652     Stoychitch's motor")]
pub struct Args {
    /// The speed profile, or several
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = speed_profiles())]
    speed_profile: Vec<SpeedProfile>,
    /// Steps of the move (N)
    #[arg(long, value_name = "N", value_parser = steps, allow_negative_numbers = true)]
    steps: Option<u32>,
    /// Write every step as CSV; of one speed profile
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Draw position, speed, acceleration and jerk over time: a picture, or a page with the table
    #[arg(long, value_name = "OUT.svg|OUT.html")]
    plot: Option<PathBuf>,
    /// Derivatives of the picture
    #[arg(long, value_name = "HOW", default_value = "exact", requires = "plot")]
    derivatives: Derivatives,
    #[command(flatten)]
    frequency: FrequencyArgs,
    #[command(flatten)]
    machine: MachineArgs,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    Files::default().written("--csv", &args.csv).written("--plot", &args.plot).check()?;
    let kind = args.plot.as_deref().map(PlotKind::of).transpose()?;
    let (curves, summary) = plan(&args)?;
    if let (Some(_), 2..) = (&args.csv, curves.len()) {
        bail!("--csv holds the steps of one speed profile, and {} were asked for: name one", curves.len());
    }
    println!("{summary}\n\n{}", table::table(&curves));
    if let (Some(path), [curve]) = (&args.csv, curves.as_slice()) {
        let mut text = Vec::new();
        files::write_csv(curve, &mut text)?;
        crate::files::write(path, &text)?;
    }
    if let (Some(path), Some(kind)) = (&args.plot, &kind) {
        let text = files::plot(kind, &curves, args.derivatives, &summary, &command());
        crate::files::write(path, text.as_bytes())?;
    }
    Ok(())
}

/// All requested curves, and the requested parameters in words.
fn plan(args: &Args) -> Result<(Vec<Curve>, String)> {
    ensure!(
        !args.speed_profile.is_empty(),
        "which speed profile? Name one, such as --speed-profile linear, or several, such as --speed-profile linear,sine"
    );
    let steps = args.steps.context("how many steps? Give --steps N, such as --steps 120")?;
    let (paper, machine) = (args.frequency.given(), args.machine.given());
    if let (Some(paper), Some(machine)) = (paper, machine) {
        bail!(
            "{paper} plans as Fonseca-Campos 2023 does and {machine} as the machine does: give the options of one of them"
        );
    }
    let of_the_paper =
        args.speed_profile.iter().all(|&speed_profile| frequency::frequency_ramp_of_paper(speed_profile).is_some());
    if paper.is_some() || (machine.is_none() && of_the_paper) {
        let curves = args
            .speed_profile
            .iter()
            .map(|&speed_profile| args.frequency.plan(speed_profile, steps))
            .collect::<Result<_>>()?;
        return Ok((curves, args.frequency.summary(steps)));
    }
    args.machine.check(&args.speed_profile)?;
    let curves = args
        .speed_profile
        .iter()
        .map(|&speed_profile| args.machine.plan(speed_profile, steps))
        .collect::<Result<Vec<_>>>()?;
    Ok((curves.into_iter().flatten().collect(), args.machine.summary(steps)))
}

/// The command line that prints this result again.
fn command() -> String {
    let words = std::env::args().skip(1).collect::<Vec<_>>();
    format!("isostep {}", words.join(" "))
}

#[cfg(test)]
mod tests;
