//! `isostep swarm`: random machines, programs and faults in virtual time, with the checks that must hold in all of
//! them.

mod shard;

use std::num::NonZero;
use std::panic;
use std::thread::available_parallelism;

use anyhow::{Result, bail, ensure};
use isostep_sim::swarm::{Amount, Failure, Scenario, run as carry_out, shrink};

use self::shard::{Line, Shard};
use crate::name::as_called;
use crate::parallel;
use crate::screen::grouped;
use crate::stopwatch::Stopwatch;

/// Number of worlds between two progress lines.
const BATCH: usize = 500;
/// The number of failures that are reduced to a small case.
const MADE_SMALL: usize = 3;
const NS_PER_H: f64 = 3.6e12;

const HELP: &str = "\
Each seed makes a machine (settings, speed profile, step port, one console or two), and what is done to it: lines, arcs, jogs, homing, probing,
bytes that hold, reset and override at any instant and between any two critical sections, switches that bounce, stick, break and
chatter, motors that stall, links that spoil lines, hosts that do not read, power cuts, a processor that is kept from its tasks.
In all of them: drivers are never misled, counts are those of the edges, every edge of a move is where the closed form has it, paths are
straight and axes equal, homed axes are where they say and within their travel, every line is answered once, every wait ends, outputs
are off when they must be, a reset is reported on every console and forgets all that was sent before it, and at last the machine moves where
it is sent. A failure is made small, and printed as the line that shows it again.

Examples:
  isostep swarm                          1,000 worlds
  isostep swarm --minutes 60             as many as come in an hour
  isostep swarm --shard 2/8 --json       the second of eight machines' share, as a line of JSON; see docs/swarm.md
  isostep swarm --seed 17                one of them, and what happens in it
  isostep swarm --seed 17 --keep 0,4,9   the same with these of its acts alone";

/// Random machines, programs and faults in virtual time: none may break a promise
#[derive(clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// Number of worlds
    #[arg(long, value_name = "N", default_value_t = 1_000, conflicts_with = "seed", value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// The first of their seeds
    #[arg(long, value_name = "SEED", default_value_t = 0, conflicts_with = "seed")]
    first: u64,
    /// As many worlds as come in so many minutes, rather than a number of them
    #[arg(long, value_name = "M", conflicts_with_all = ["seeds", "seed"], value_parser = minutes)]
    minutes: Option<f64>,
    /// The I-th of N shares of these worlds: a machine among several takes each N-th seed
    #[arg(long, value_name = "I/N", default_value = "1/1", hide_default_value = true, conflicts_with = "seed")]
    shard: Shard,
    /// Worlds at a time; without it, as many as there are processors
    #[arg(long, value_name = "N", conflicts_with = "seed")]
    jobs: Option<NonZero<usize>>,
    /// One line of JSON in the end rather than words; it has each failure with what shows it again
    #[arg(long, conflicts_with = "seed")]
    json: bool,
    /// One world alone, shown act by act
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,
    /// Of that world these acts alone, by number
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', requires = "seed")]
    keep: Option<Vec<usize>>,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    // A panic of the controller is a finding. It is printed like the other findings.
    panic::set_hook(Box::new(|_| {}));
    match args.seed {
        Some(seed) => one(seed, args.keep),
        None => many(&args),
    }
}

fn one(seed: u64, keep: Option<Vec<usize>>) -> Result<()> {
    let whole = Scenario::new(seed);
    let acts = whole.acts.len();
    let kept = keep.unwrap_or_else(|| (0..acts).collect());
    if let Some(none) = kept.iter().find(|act| **act >= acts) {
        bail!(
            "--keep {none}: world {seed} has {acts} acts, of numbers 0 to {}: `isostep swarm --seed {seed}` lists them",
            acts - 1
        );
    }
    let scenario = whole.keeping(&kept);
    print!("{}", story(&scenario, &kept));
    match carry_out(&scenario) {
        Ok(amount) => {
            println!("no promise broken in {:.3} s of virtual time", amount.virtual_ns as f64 * 1e-9);
            Ok(())
        }
        Err(failure) => bail!("{}", reported(&failure, &kept)),
    }
}

fn minutes(text: &str) -> Result<f64, String> {
    let minutes = text.parse().ok().filter(|minutes: &f64| minutes.is_finite() && *minutes > 0.0);
    minutes.ok_or_else(|| "a number above 0, such as 60".to_owned())
}

/// The machine and the acts of a world, one line per act.
fn story(scenario: &Scenario, kept: &[usize]) -> String {
    let acts = kept.iter().zip(&scenario.acts).map(|(index, act)| format!("{index:>4}  {act}\n"));
    format!("{}\n{}", scenario.machine(), acts.collect::<String>())
}

fn reported(failure: &Failure, kept: &[usize]) -> String {
    let after =
        failure.act.and_then(|act| kept.get(act)).map_or("at the end".to_owned(), |act| format!("in act {act}"));
    format!("{failure} ({after})")
}

fn many(args: &Args) -> Result<()> {
    let jobs = args.jobs.or(available_parallelism().ok()).map_or(1, NonZero::get);
    let stopwatch = Stopwatch::start();
    let is_over = || args.minutes.is_some_and(|minutes| stopwatch.elapsed_s() >= minutes * 60.0);
    let end = if args.minutes.is_some() { u64::MAX } else { args.first + args.seeds };
    let mut left = args.shard.seeds(args.first).take_while(|seed| *seed < end);
    let (mut amount, mut worlds) = (Amount::default(), 0);
    let mut failed = Vec::new();
    while !is_over() {
        let seeds: Vec<u64> = left.by_ref().take(BATCH).collect();
        let Some(last) = seeds.last() else { break };
        for (seed, result) in seeds.iter().zip(parallel::map(&seeds, jobs, |seed| carry_out(&Scenario::new(*seed)))) {
            match result {
                Ok(more) => amount = amount.and(more),
                Err(failure) => failed.push((*seed, failure)),
            }
        }
        worlds += seeds.len() as u64;
        eprintln!("    seeds {} to {last}: {} failed ({:.0} s)", args.first, failed.len(), stopwatch.elapsed_s());
    }
    ensure!(
        worlds > 0,
        "none of these {} worlds is in the share --shard {}: ask for more by --seeds",
        args.seeds,
        args.shard
    );
    let took_s = stopwatch.elapsed_s();
    if args.json {
        println!("{}", serde_json::to_string(&Line::new(args.shard, worlds, amount, took_s, &failed))?);
    } else {
        tell(worlds, amount, took_s, &failed);
    }
    match failed.len() {
        0 => Ok(()),
        failures => bail!("{failures} worlds in which a promise was broken"),
    }
}

/// Says what was simulated and what failed, and the first failures small.
fn tell(worlds: u64, amount: Amount, took_s: f64, failed: &[(u64, Failure)]) {
    println!("{}", summary(worlds, amount, took_s));
    for (seed, failure) in failed {
        println!("seed {seed}: {failure}");
    }
    for (seed, failure) in failed.iter().take(MADE_SMALL) {
        tell_small(*seed, failure);
    }
}

fn summary(worlds: u64, amount: Amount, took_s: f64) -> String {
    let Amount { virtual_ns, faults, lines, steps, sections } = amount;
    let hours = virtual_ns as f64 / NS_PER_H;
    format!(
        "{} worlds: {hours:.1} hours of machine time in {took_s:.0} s, {:.0} times as fast as real time (simulated)\n\
         {} lines, {} steps, {} faults, stops and resets; tasks could interrupt each other at {} critical sections",
        grouped(worlds),
        hours * 3_600.0 / took_s,
        grouped(lines),
        grouped(steps),
        grouped(faults),
        grouped(sections),
    )
}

/// Reduces a failure to a small case and prints it.
fn tell_small(seed: u64, failure: &Failure) {
    let whole = Scenario::new(seed);
    let kept = shrink(&whole, failure);
    let scenario = whole.keeping(&kept);
    let failure = carry_out(&scenario).err().unwrap_or_else(|| failure.clone());
    println!("\nseed {seed}: {}\n{}", reported(&failure, &kept), story(&scenario, &kept));
    println!("again: {}", again(seed, Some(&kept)));
}

/// The command that shows a world again, or some acts of it.
fn again(seed: u64, kept: Option<&[usize]>) -> String {
    let acts = |kept: &[usize]| kept.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
    let keep = kept.map_or(String::new(), |kept| format!(" --keep {}", acts(kept)));
    as_called(&format!("isostep swarm --seed {seed}{keep}")).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_try_nothing_is_refused() {
        let refused = one(17, Some(vec![0, 9_999])).unwrap_err().to_string();
        let acts = Scenario::new(17).acts.len();
        let expected = format!("--keep 9999: world 17 has {acts} acts, of numbers 0 to {}: ", acts - 1);
        assert!(refused.starts_with(&expected), "{refused}");
        assert!(minutes("0").is_err() && minutes("nan").is_err() && minutes("0.5") == Ok(0.5));
        let mut args = Args {
            seeds: 3,
            first: 0,
            minutes: None,
            shard: "5/8".parse().unwrap(),
            jobs: None,
            json: false,
            seed: None,
            keep: None,
        };
        assert!(many(&args).unwrap_err().to_string().starts_with("none of these 3 worlds is in the share --shard 5/8"));
        args.shard = "3/8".parse().unwrap();
        many(&args).unwrap();
    }

    #[test]
    fn a_world_is_reported_act_by_act_under_its_numbers() {
        let whole = Scenario::new(1);
        let text = story(&whole.keeping(&[0, 3]), &[0, 3]);
        let acts: Vec<_> = text.lines().rev().take(2).collect();
        assert_eq!(acts, [format!("   3  {}", whole.acts[3]), format!("   0  {}", whole.acts[0])]);
        assert!(text.starts_with("machine: "), "{text}");
    }
}
