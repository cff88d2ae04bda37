//! Measures the cost of the mathematics of a step on the chip, and its accuracy: planning, compiling, replaying, and
//! the generators of the literature over the same ramp.
//!
//! # Design
//! The firmware `rp2040-bench` times the work and prints cycles and checksums. The same work is done here again. Every
//! checksum is compared with the chip's and every interval with the closed form, so cycles and errors are figures of
//! the same arithmetic.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use isostep_profile::{IntervalLaw, Limits, Profile, SpeedLaw};
use rp2040_bench::{Checksum, LIMITS, Peer, STEPS, StandsFor, TICK_HZ, Visitor};
use serde::Serialize;

use super::chip::Chip;
use super::floats::{self, FloatFigures};
use super::flow::{self, FlowFigures};
use super::laws::{self, LawFigures};
use super::lines::{AXES, CompileFigures, Lines};

/// Machine time that the firmware may take, s. It needs a quarter of it.
const PATIENCE_S: u32 = 60;
/// Below this fraction of the top speed, intervals are long, so there are few of them and their errors last only a
/// short part of the move.
const SLOW: f64 = 0.1;

/// The cost of everything, in emulated cycles of the core.
#[derive(Clone, Debug, Serialize)]
pub struct MicroFigures {
    /// The ramp that is compiled and generated: from rest to the top speed and back to rest.
    pub ramp: RampFigures,
    /// The figures of each speed law, over ramps of its own.
    pub laws: Vec<LawFigures>,
    /// The figures of short moves that flow.
    pub flow: Vec<FlowFigures>,
    /// Operations on floats.
    pub floats: Vec<FloatFigures>,
    /// Compiling the segments of one axis, by the phase in which they begin.
    pub compile: Vec<CompileFigures>,
    /// Ticks of motion per cycle of compiling it for three axes, in the segment that contains the least motion. Below 1
    /// the motion of that segment ends before the next segment is ready.
    pub lead_ticks_per_cycle: f64,
    /// The same over a full queue of segments, which can hide a single short one. Below 1 the queues run dry.
    pub queue_lead_ticks_per_cycle: f64,
    /// Cycles per step of the loop that replays segments.
    pub fill_cycles_per_step: f64,
    /// Isostep's generator, then those of the literature.
    pub generators: Vec<GeneratorFigures>,
}

/// The ramp.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RampFigures {
    pub steps: u32,
    pub top_speed_steps_s: f64,
    pub accel_steps_s2: f64,
    pub tick_hz: u32,
}

/// The cost and the accuracy of a generator.
#[derive(Clone, Debug, Serialize)]
pub struct GeneratorFigures {
    pub name: &'static str,
    /// Mean cycles per step. Isostep's include the compiling.
    pub cycles_mean: f64,
    /// Cycles of the slowest step; `None` where many steps are computed ahead at a time.
    pub cycles_max: Option<u64>,
    /// The speed at which the ramp begins, steps/s. Not every method can start from rest.
    pub start_speed_steps_s: f64,
    pub truth: Truth,
}

/// The errors of the intervals relative to the closed form of the limits that they were planned from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Truth {
    /// The largest error of an interval's speed, percent of the exact speed.
    pub speed_error_max_percent: f64,
    /// The same error, only above a tenth of the top speed.
    pub speed_error_max_above_tenth_percent: f64,
    /// How much too late the last step is, counted from the first step, s.
    pub drift_s: f64,
}

/// Runs the firmware `elf` on an emulated board with `chip` and verifies its results. The run's files go to `folder`.
pub fn measure(elf: &Path, emulator: &Path, chip: Chip, folder: &Path) -> Result<MicroFigures> {
    let lines = Lines::parse(&run(elf, emulator, chip, folder)?)?;
    Ok(MicroFigures {
        ramp: RampFigures {
            steps: STEPS,
            top_speed_steps_s: LIMITS.top_speed_steps_s,
            accel_steps_s2: LIMITS.accel_steps_s2,
            tick_hz: TICK_HZ,
        },
        laws: laws::all(&lines)?,
        flow: flow::all(&lines)?,
        floats: floats::all(&lines)?,
        compile: lines.compile("compile", &rp2040_bench::ramp()?)?,
        lead_ticks_per_cycle: lines.of("compile.lead")?.results_per_cycle() / AXES,
        queue_lead_ticks_per_cycle: lines.queue_lead("compile")?,
        fill_cycles_per_step: lines.fill("fill", &rp2040_bench::ramp()?)?,
        generators: generators(&lines)?,
    })
}

/// The output of the firmware on the emulated board.
fn run(elf: &Path, emulator: &Path, chip: Chip, folder: &Path) -> Result<String> {
    let (script, transcript) = (folder.join("micro.script"), folder.join("micro.transcript"));
    fs::write(&script, "expect end\n").with_context(|| format!("cannot write {}", script.display()))?;
    let mut command = Command::new("node");
    command.arg(emulator).arg("--elf").arg(elf);
    command.args(chip.options()).args(["--console", "uart"]).arg(format!("--timeout-s={PATIENCE_S}"));
    command.arg("--script").arg(script).arg("--transcript").arg(&transcript);
    let output = command.output().context("cannot start node")?;
    if !output.status.success() {
        bail!("the benchmark firmware failed:\n{}", String::from_utf8_lossy(&output.stdout).trim());
    }
    fs::read_to_string(&transcript).with_context(|| format!("cannot read {}", transcript.display()))
}

/// Isostep's generator and those of the literature.
fn generators(lines: &Lines) -> Result<Vec<GeneratorFigures>> {
    let mut found = Found { lines, figures: vec![isostep(lines)] };
    rp2040_bench::generators(&mut found)?;
    found.figures.into_iter().collect()
}

fn isostep(lines: &Lines) -> Result<GeneratorFigures> {
    let ramp = rp2040_bench::ramp()?;
    let fill_cycles = lines.fill("fill", &ramp)?;
    let phases = rp2040_bench::phases(&ramp);
    let compiled = phases.iter().map(|(phase, _)| lines.of(&format!("compile.{phase}")).map(|line| line.cycles));
    let compile_cycles: u64 = compiled.sum::<Result<_>>()?;
    let instants: Vec<u64> = ramp.segments(0, TICK_HZ).flat_map(|segment| segment.ticks()).collect();
    let intervals = instants.windows(2).map(|pair| (pair[1] - pair[0]) as u32);
    let half = StandsFor::TimeBetweenSteps { first_steps: 0.5 };
    Ok(GeneratorFigures {
        name: "isostep",
        cycles_mean: fill_cycles + compile_cycles as f64 / f64::from(STEPS),
        cycles_max: None,
        start_speed_steps_s: LIMITS.start_speed_steps_s,
        truth: truth(intervals, &closed_form(&LIMITS)?, half),
    })
}

/// Collects the figures of the literature's generators.
struct Found<'a> {
    lines: &'a Lines,
    figures: Vec<Result<GeneratorFigures>>,
}

impl Visitor for Found<'_> {
    fn visit<I: Iterator<Item = u32> + Clone>(&mut self, peer: Peer, intervals: I) {
        self.figures.push(self.figure(peer, intervals));
    }
}

impl Found<'_> {
    fn figure<I: Iterator<Item = u32> + Clone>(&self, peer: Peer, intervals: I) -> Result<GeneratorFigures> {
        let mut checksum = Checksum::default();
        intervals.clone().for_each(|interval| checksum.add(interval));
        let sum = self.lines.proven(peer.name, checksum)?;
        let slowest = self.lines.proven(&format!("{}.max", peer.name), checksum)?;
        Ok(GeneratorFigures {
            name: peer.name,
            cycles_mean: sum.cycles_per_result(),
            cycles_max: Some(slowest.cycles),
            start_speed_steps_s: peer.limits.start_speed_steps_s,
            truth: truth(intervals, &closed_form(&peer.limits)?, peer.stands_for),
        })
    }
}

fn closed_form(limits: &Limits) -> Result<Profile> {
    let start = limits.start_speed_steps_s;
    Ok(Profile::plan(f64::from(STEPS), start, start, limits, IntervalLaw::Fastest, SpeedLaw::Trapezoid)?)
}

/// Compares `intervals`, in ticks, with `profile`.
fn truth(intervals: impl Iterator<Item = u32>, profile: &Profile, stands_for: StandsFor) -> Truth {
    let first_steps = match stands_for {
        StandsFor::SpeedAtStep => 0.0,
        StandsFor::TimeBetweenSteps { first_steps } => first_steps,
    };
    let slow_steps_s = SLOW * profile.cruise_speed_steps_s();
    let (mut truth, mut ticks, mut steps) = (Truth::default(), 0_u64, first_steps);
    for interval in intervals {
        let exact_steps_s = match stands_for {
            StandsFor::SpeedAtStep => profile.speed_at(profile.time_at(steps)),
            StandsFor::TimeBetweenSteps { .. } => 1.0 / (profile.time_at(steps + 1.0) - profile.time_at(steps)),
        };
        let speed_steps_s = f64::from(TICK_HZ) / f64::from(interval);
        let error_percent = 100.0 * (speed_steps_s / exact_steps_s - 1.0).abs();
        truth.speed_error_max_percent = truth.speed_error_max_percent.max(error_percent);
        if exact_steps_s >= slow_steps_s {
            let max = truth.speed_error_max_above_tenth_percent.max(error_percent);
            truth.speed_error_max_above_tenth_percent = max;
        }
        ticks += u64::from(interval);
        steps += 1.0;
    }
    truth.drift_s = ticks as f64 / f64::from(TICK_HZ) - (profile.time_at(steps) - profile.time_at(first_steps));
    truth
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 120,000 steps from rest, top speed 1e6 steps/s, 1e7 steps/s2: a delay of one tick in each interval of 125 is 0.8
    /// %.
    #[test]
    fn a_late_cruise_shows_as_speed_error_and_drift() {
        let profile = closed_form(&LIMITS).unwrap();
        let stands_for = StandsFor::TimeBetweenSteps { first_steps: 60_000.0 };
        let exact = truth([125; 1_000].into_iter(), &profile, stands_for);
        assert!(exact.speed_error_max_percent < 1e-6 && exact.drift_s.abs() < 1e-12);
        let late = truth([126; 1_000].into_iter(), &profile, stands_for);
        assert!((late.speed_error_max_percent - 100.0 / 126.0).abs() < 1e-6);
        assert!((late.drift_s - 1_000.0 / 125e6).abs() < 1e-12);
    }
}
