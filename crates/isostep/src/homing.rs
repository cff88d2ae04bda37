//! `isostep homing`: how exactly homing finds the same place each time.

use std::path::PathBuf;

use anyhow::Result;
use isostep_console::Settings;
use isostep_sim::analysis::{deviation, mean};
use isostep_sim::homing::{self, Latch};
use isostep_sim::{Axis, Config};

use crate::sim;

/// Home each axis many times in virtual time: how far apart the places are that become its zero
#[derive(clap::Args)]
#[command(after_help = "\
Each axis is homed again and again ($HX, $HY, $HZ), from another place each time, with its switch at the low end of the axis
(towards negative, $23) and then at the high end. A table says where the latch ended, from which zero is counted, in steps and
mm from the switch's true place, negative being beyond it:
  zero           what comes of switch and controller together
  by controller  what is left of it from where the switch really closed in that approach: what the controller adds
A latch ends a debounce ($26) after the last bounce. So the controller adds the latch speed ($24) times the debounce, the same
each time, and up to the latch speed times the bounce, another time each; in whole steps.
All of it is simulated. Motors follow every step, and a step is as long as the next.

Examples:
  isostep homing                                     switches that bounce, and close at the same place always
  isostep homing --scatter-mm 0.05                   and that close up to 0.05 mm to either side of it
  isostep homing --settings my.txt --bounce-us 5000  your machine, with worse switches")]
pub struct Args {
    /// Number of homings of each axis in each direction
    #[arg(long, value_name = "N", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    latches: u32,
    /// Seed of everything random: bounces, where switches close, and where homing begins
    #[arg(long, value_name = "N", default_value_t = Config::default().seed)]
    seed: u64,
    /// Longest time for which the contacts of a switch bounce
    #[arg(long, value_name = "N", default_value_t = Config::default().bounce_us, value_parser = clap::value_parser!(u32).range(..=1_000_000))]
    bounce_us: u32,
    /// Largest distance from its place at which a switch closes, to either side
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = scatter)]
    scatter_mm: f64,
    /// The machine's settings: $n=v lines (`isostep sim --help`) [default: the parking gantry]
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    let mut config =
        Config { seed: args.seed, bounce_us: args.bounce_us, switch_scatter_mm: args.scatter_mm, ..Config::default() };
    if let Some(path) = &args.settings {
        config.settings = sim::read_settings(path, &config)?;
    }
    config.start_mm = isostep_report::timing::middle_mm(&config.settings);
    println!("{}", head(&args, &config.settings));
    for axis in Axis::ALL {
        for negative in [true, false] {
            let latches = homing::latches(&homing::towards(&config, negative), axis, args.latches)?;
            println!("{}", row(axis, negative, &latches, f64::from(config.settings.steps_per_mm[axis as usize])));
        }
    }
    Ok(())
}

fn head(args: &Args, settings: &Settings) -> String {
    let Args { latches, seed, bounce_us, scatter_mm, .. } = args;
    format!(
        "homing in virtual time, {latches} latches an axis and direction, SEED={seed}: contacts bounce for up to {bounce_us} us, \
         and close within {scatter_mm} mm\nlatch at {:.3} mm/s ($24), debounce {} ms ($26)\n\n\
         {:<17} {:>35}   {:>35}\n{:<17} {COLUMNS}   {COLUMNS}  zero, mm",
        settings.homing_latch_mm_min / 60.0,
        settings.homing_debounce_ms,
        "",
        "zero, steps",
        "by controller, steps",
        "axis, towards",
    )
}

const COLUMNS: &str = "     min      max     mean deviation";

fn row(axis: Axis, negative: bool, latches: &[Latch], steps_per_mm: f64) -> String {
    let zero: Vec<f64> = latches.iter().map(|latch| f64::from(latch.set_steps)).collect();
    let controller: Vec<f64> = latches.iter().map(|latch| f64::from(-latch.late_steps())).collect();
    let (least, most) = range(&zero);
    format!(
        "{:<17} {}   {}  {:.3} to {:.3}, deviation {:.4}",
        format!("{axis} {}", if negative { "negative" } else { "positive" }),
        columns(&zero),
        columns(&controller),
        least / steps_per_mm,
        most / steps_per_mm,
        deviation(&zero) / steps_per_mm,
    )
}

fn columns(steps: &[f64]) -> String {
    let (least, most) = range(steps);
    format!("{least:>8} {most:>8} {:>8.3} {:>9.3}", mean(steps), deviation(steps))
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), &value| (least.min(value), most.max(value)))
}

/// The scatter must be less than the default machine's pull-off, otherwise a switch would never open.
fn scatter(text: &str) -> Result<f64, String> {
    let mm = text.parse().ok().filter(|mm| (0.0..=1.0).contains(mm));
    mm.ok_or_else(|| "give a number of mm from 0 to 1".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_tells_the_switch_from_the_controller() {
        let latches = [(2, 1), (-3, -5)].map(|(closed_steps, set_steps)| Latch { closed_steps, set_steps });
        let row = row(Axis::Y, true, &latches, 50.0);
        let words: Vec<_> = row.split_whitespace().collect();
        assert_eq!(words[..6], ["Y", "negative", "-5", "1", "-2.000", "3.000"]);
        assert_eq!(words[6..10], ["-2", "-1", "-1.500", "0.500"]);
        assert!(row.ends_with("-0.100 to 0.020, deviation 0.0600"), "{row}");
    }
}
