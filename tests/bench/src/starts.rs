//! Measures how soon a move begins: the time from the arrival of its line to its first edge, minus the time that the
//! plan takes to its first step.
//!
//! The rest is the delay added by the machine: reading the line, planning, compiling the first segments, arming the
//! ports, and the lead to the start instant that they choose.

use anyhow::Result;
use oorandom::Rand32;
use serde::Serialize;

use super::board::{Board, Summary};
use super::edges::{Edge, NS_PER_CYCLE};
use super::effort::Effort;
use super::follow::follow;
use super::measured::Measured;
use super::port::Port;
use super::progress::Case;
use super::trial::{AXES, Machine, Trial, UNIT_STEPS};

/// How long the machine rests before a line is sent, us.
const REST_US: std::ops::Range<f64> = 1_000.0..100_000.0;
/// The distance of an axis in a move, in [`UNIT_STEPS`].
const WAY_UNITS: std::ops::Range<u32> = 1..40;
/// A fixed seed, so that every run has the same moves and rests.
const SEED: u64 = 1;

/// The content of flash's cache when the line arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cache {
    /// The cache is empty.
    Cold,
    /// The cache holds what the previous move and the status reports since then have left there.
    Warm,
}

/// The results for one state of the cache.
#[derive(Clone, Debug, Serialize)]
pub struct StartMeasurement {
    /// The state of the cache when the line arrived.
    pub cache: Cache,
    /// The delay that the machine adds to the plan.
    pub delay: Measured<Delay>,
}

/// The delays of some starts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Delay {
    /// Number of starts.
    pub starts: usize,
    /// The median, us.
    pub median_us: f64,
    /// The longest, us.
    pub max_us: f64,
}

impl Cache {
    /// The states in the order in which the script makes them.
    const TURNS: [Self; 2] = [Self::Cold, Self::Warm];

    pub fn name(self) -> &'static str {
        match self {
            Self::Cold => "cache cold",
            Self::Warm => "cache warm",
        }
    }
}

/// Measures moves of three axes from rest on a machine with steep ramps. In each pair, the first move has a cold cache,
/// and the second is the move back right after it.
pub fn measure(board: &Board, port: Port, effort: &Effort) -> Result<Vec<StartMeasurement>> {
    if effort.starts == 0 {
        return Ok(Vec::new());
    }
    let what = format!("{} starts, cold and warm", effort.starts);
    let case = Case::begin(board.chip, port, AXES, port.start_steps_s_and_s2().0, &what);
    let (script, trial) = moves(port, effort.starts);
    let run = board.run_for_edges(&script, trial.duration_s()?)?;
    let delays_us = match run {
        Measured::Figure((summary, edges)) => Measured::from(delays_us(&trial, &summary, &edges)?),
        Measured::Missing { why_not } => Measured::Missing { why_not },
    };
    let measured = Cache::TURNS.into_iter().enumerate().map(|(turn, cache)| {
        let delays_us = delays_us.clone();
        StartMeasurement { cache, delay: delays_us.map(|all| delay(all.into_iter().skip(turn).step_by(2))) }
    });
    let measured: Vec<_> = measured.collect();
    let words = measured.iter().map(|one| format!("{} {}", one.cache.name(), one.delay.words(Delay::words)));
    case.end(&words.collect::<Vec<_>>().join("; "));
    Ok(measured)
}

/// The script for the sender, and the moves that the firmware should make of it.
fn moves(port: Port, starts: u32) -> (String, Trial) {
    let (rate_steps_s, accel_steps_s2) = port.start_steps_s_and_s2();
    let machine = Machine::new(rate_steps_s, f64::from(rate_steps_s) / accel_steps_s2);
    let mut random = Rand32::new(SEED);
    let (mut script, mut moves) = (machine.set_up(), Vec::new());
    for _ in 0..starts {
        let there: [i32; AXES] = std::array::from_fn(|_| random.rand_range(WAY_UNITS) as i32 * UNIT_STEPS);
        for (cache, steps) in Cache::TURNS.into_iter().zip([there, there.map(|n| -n)]) {
            let rest_us = REST_US.start + f64::from(random.rand_float()) * (REST_US.end - REST_US.start);
            let cold = if cache == Cache::Cold { "cold-cache\n" } else { "" };
            let line = machine.rapid(steps);
            script += &format!("wait-us {rest_us:.3}\n{cold}send G91 {line}\nexpect ok\nwait-idle\n");
            moves.push(steps);
        }
    }
    (script, Trial::of(machine, moves))
}

/// The delay of each move in order; an error if the edges do not match the plans.
fn delays_us(trial: &Trial, summary: &Summary, edges: &[Edge]) -> Result<Result<Vec<f64>, String>> {
    let plans = trial.plans()?;
    if let Err(astray) = follow(edges.iter().copied().map(Ok), &plans) {
        return Ok(Err(astray.to_string()));
    }
    let arrivals_ns =
        summary.replies.iter().filter(|line| line.text.starts_with("G91")).filter_map(|line| line.arrived_ns);
    let delays = arrivals_ns.zip(&plans).map(|(arrived_ns, plan)| {
        let next = edges.partition_point(|edge| (edge.cycle as f64) * NS_PER_CYCLE < arrived_ns);
        let first_ns = edges.get(next).map_or(f64::NAN, |edge| edge.cycle as f64 * NS_PER_CYCLE);
        let planned_s = (0..AXES).map(|axis| plan.step_time_s(axis, 1)).fold(f64::INFINITY, f64::min);
        (first_ns - arrived_ns) * 1e-3 - planned_s * 1e6
    });
    Ok(Ok(delays.collect()))
}

fn delay(delays_us: impl Iterator<Item = f64>) -> Delay {
    let mut sorted: Vec<f64> = delays_us.collect();
    sorted.sort_by(f64::total_cmp);
    let at = |index: usize| sorted.get(index).copied().unwrap_or(f64::NAN);
    Delay {
        starts: sorted.len(),
        median_us: at(sorted.len().saturating_sub(1) / 2),
        max_us: at(sorted.len().saturating_sub(1)),
    }
}

impl Delay {
    pub fn words(&self) -> String {
        let Self { starts, median_us, max_us } = self;
        format!("median {median_us:.0} us, max {max_us:.0} us of {starts} starts")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_other_start_is_cold() {
        let (script, trial) = moves(Port::Pio, 3);
        let lines: Vec<&str> =
            script.lines().filter(|line| line.starts_with("cold") || line.starts_with("send G91")).collect();
        assert_eq!(
            lines.iter().map(|line| line.starts_with("cold")).collect::<Vec<_>>(),
            [true, false, false].repeat(3)
        );
        assert!(script.contains("send $120=5000\n"), "steep: {script}");
        let plans = trial.plans().unwrap();
        assert!(plans.len() == 6 && plans[1].steps == plans[0].steps.map(|n| -n));
    }

    #[test]
    fn a_delay_is_what_the_plan_does_not_take() {
        let (_, trial) = moves(Port::Pio, 1);
        let plans = trial.plans().unwrap();
        let (mut edges, mut replies) = (Vec::new(), Vec::new());
        for (plan, (arrived_ns, delay_ns)) in plans.iter().zip([(1e9, 800_000.0), (2e9, 600_000.0)]) {
            replies.push(format!(r#"{{"text": "G91 G0", "arrived_ns": {arrived_ns}}}"#));
            let mut of: Vec<Edge> = (0..AXES)
                .flat_map(|axis| (1..=plan.steps[axis].unsigned_abs()).map(move |k| (axis, k)))
                .map(|(axis, k)| {
                    let t_ns = arrived_ns + delay_ns + plan.step_time_s(axis, k) * 1e9;
                    Edge { cycle: (t_ns / NS_PER_CYCLE).round() as u64, axis, direction: plan.steps[axis].signum() }
                })
                .collect();
            of.sort_by_key(|edge| edge.cycle);
            edges.extend(of);
        }
        let summary = Summary::of_replies(&replies.join(","));
        let delays = delays_us(&trial, &summary, &edges).unwrap().unwrap();
        assert!((delays[0] - 800.0).abs() < 0.01 && (delays[1] - 600.0).abs() < 0.01, "{delays:?}");
        assert!(delays_us(&trial, &summary, &edges[1..]).unwrap().is_err(), "a lost step");
    }

    #[test]
    fn the_median_is_one_of_them() {
        assert_eq!(delay([5.0, 1.0, 9.0, 3.0].into_iter()), Delay { starts: 4, median_us: 3.0, max_us: 9.0 });
    }
}
