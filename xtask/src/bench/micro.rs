//! What the mathematics of a step costs on the chip, and what it is worth: planning, compiling, replaying, and the
//! generators of the literature over the same ramp.
//!
//! # Design
//! The firmware `rp2040-bench` times the work and prints cycles and checksums. Here the same work is done again, every
//! checksum held against the chip's, and every interval against the closed form: so that cycles and errors are figures
//! of one and the same arithmetic.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use isostep_profile::{IntervalLaw, Limits, Profile, SpeedLaw, SyncMove};
use rp2040_bench::{Checksum, LIMITS, Peer, STEPS, StandsFor, TICK_HZ, Visitor};
use serde::Serialize;

use super::chip::Chip;
use super::flow::{self, FlowFigures};
use super::laws::{self, LawFigures};
use crate::{build, workspace};

/// Axes that step at once.
pub(super) const AXES: f64 = 3.0;
/// Machine time that the firmware may take, s; it takes a quarter of it.
const PATIENCE_S: u32 = 60;
/// Below this fraction of the top speed an interval is long, and its error short-lived.
const SLOW: f64 = 0.1;

/// What everything costs, in emulated cycles of the core.
#[derive(Clone, Debug, Serialize)]
pub struct MicroFigures {
    /// Of the ramp that is compiled and generated: rest to rest through the top speed.
    pub ramp: RampFigures,
    /// Each speed law's, over ramps of its own.
    pub laws: Vec<LawFigures>,
    /// Short moves that flow.
    pub flow: Vec<FlowFigures>,
    /// Segments of one axis compiled, by the phase they begin in.
    pub compile: Vec<CompileFigures>,
    /// Ticks of motion for each cycle of compiling it for three axes, over the segment that has fewest: below 1, its
    /// motion is over before the next one is there.
    pub lead_ticks_per_cycle: f64,
    /// The same over a full queue of segments, behind which a short one hides: below 1, the queues run dry.
    pub queue_lead_ticks_per_cycle: f64,
    /// The loop that replays segments, cycles a step.
    pub fill_cycles_per_step: f64,
    /// Isostep's, then those of the literature.
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

/// Cycles of a segment.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CompileFigures {
    pub phase: &'static str,
    pub segments: u32,
    pub cycles_mean: f64,
    pub cycles_max: u64,
}

/// What a generator costs, and how true it is.
#[derive(Clone, Debug, Serialize)]
pub struct GeneratorFigures {
    pub name: &'static str,
    /// A step; isostep's with its share of compiling.
    pub cycles_mean: f64,
    /// The slowest step; none where steps are computed ahead, many at a time.
    pub cycles_max: Option<u64>,
    /// Where the ramp begins, steps/s: not every method starts from rest.
    pub start_speed_steps_s: f64,
    pub truth: Truth,
}

/// Intervals against the closed form of the limits they were planned from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Truth {
    /// The worst error of an interval's speed, percent of what it should be.
    pub speed_error_max_percent: f64,
    /// The same above a tenth of the top speed.
    pub speed_error_max_above_tenth_percent: f64,
    /// How much later than it should the last step leaves, counted from the first, s.
    pub drift_s: f64,
}

/// Builds the firmware that is measured.
pub fn build() -> Result<()> {
    build::build_firmware(workspace::BENCH_FIRMWARE, &[]).map(|_| ())
}

/// Runs the firmware on an emulated board with `chip` and proves its results; `folder` takes the run's files.
pub fn measure(chip: Chip, folder: &Path) -> Result<MicroFigures> {
    let lines = Lines::parse(&run(chip, folder)?)?;
    Ok(MicroFigures {
        ramp: RampFigures {
            steps: STEPS,
            top_speed_steps_s: LIMITS.top_speed_steps_s,
            accel_steps_s2: LIMITS.accel_steps_s2,
            tick_hz: TICK_HZ,
        },
        laws: laws::all(&lines)?,
        flow: flow::all(&lines)?,
        compile: lines.compile("compile", &rp2040_bench::ramp()?)?,
        lead_ticks_per_cycle: lines.of("compile.lead")?.results_per_cycle() / AXES,
        queue_lead_ticks_per_cycle: lines.queue_lead("compile")?,
        fill_cycles_per_step: lines.fill("fill", &rp2040_bench::ramp()?)?,
        generators: lines.generators()?,
    })
}

/// What the firmware says, on the emulated board.
fn run(chip: Chip, folder: &Path) -> Result<String> {
    let (script, transcript) = (folder.join("micro.script"), folder.join("micro.transcript"));
    fs::write(&script, "expect end\n").with_context(|| format!("cannot write {}", script.display()))?;
    let mut command = Command::new("node");
    command.arg(workspace::emulator_dir().join("run.mjs")).arg("--elf").arg(workspace::elf(workspace::BENCH_FIRMWARE));
    command.args(chip.options()).args(["--console", "uart"]).arg(format!("--timeout-s={PATIENCE_S}"));
    command.arg("--script").arg(script).arg("--transcript").arg(&transcript);
    let output = command.output().context("cannot start node")?;
    if !output.status.success() {
        bail!("the benchmark firmware failed:\n{}", String::from_utf8_lossy(&output.stdout).trim());
    }
    fs::read_to_string(&transcript).with_context(|| format!("cannot read {}", transcript.display()))
}

/// A line of the firmware.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) cycles: u64,
    count: u32,
    checksum: u32,
}

impl Line {
    /// `cycles,count,checksum`.
    fn parse(text: &str) -> Option<Self> {
        let mut numbers = text.split(',');
        let line = Self {
            cycles: numbers.next()?.parse().ok()?,
            count: numbers.next()?.parse().ok()?,
            checksum: numbers.next()?.parse().ok()?,
        };
        numbers.next().is_none().then_some(line)
    }

    pub(super) fn cycles_per_result(&self) -> f64 {
        self.cycles as f64 / f64::from(self.count)
    }

    fn results_per_cycle(&self) -> f64 {
        f64::from(self.count) / self.cycles as f64
    }
}

/// The firmware's lines by name.
pub(super) struct Lines(BTreeMap<String, Line>);

impl Lines {
    /// From a transcript of the emulated board: `<time> < <line>`.
    fn parse(transcript: &str) -> Result<Self> {
        let said = transcript.lines().filter_map(|line| line.split_once(" < ")).map(|(_, said)| said);
        let figures = said.take_while(|said| *said != "end").map(|said| {
            let (name, figure) = said.split_once(',').unwrap_or((said, ""));
            let line =
                Line::parse(figure).with_context(|| format!("the firmware said `{said}`, which is no figure"))?;
            Ok((name.to_owned(), line))
        });
        figures.collect::<Result<_>>().map(Self)
    }

    fn of(&self, name: &str) -> Result<&Line> {
        self.0.get(name).with_context(|| format!("the firmware said nothing of {name}"))
    }

    /// The line, if its results are those that were found here.
    pub(super) fn proven(&self, name: &str, checksum: Checksum) -> Result<&Line> {
        let line = self.of(name)?;
        ensure!(line.checksum == checksum.value(), "{name}: the chip's results are not this computer's");
        Ok(line)
    }

    /// Of a full queue's segments; `name` begins the lines' names.
    pub(super) fn queue_lead(&self, name: &str) -> Result<f64> {
        Ok(self.of(&format!("{name}.lead.queue"))?.results_per_cycle() / AXES)
    }

    /// Cycles a step.
    pub(super) fn fill(&self, name: &str, ramp: &SyncMove<1>) -> Result<f64> {
        let mut checksum = Checksum::default();
        for interval in ramp.segments(0, TICK_HZ).flat_map(|segment| segment.intervals()) {
            checksum.add(interval);
        }
        Ok(self.proven(name, checksum)?.cycles_per_result())
    }

    /// By phase; `name` begins the lines' names.
    pub(super) fn compile(&self, name: &str, ramp: &SyncMove<1>) -> Result<Vec<CompileFigures>> {
        let mut segments = ramp.segments(0, TICK_HZ);
        let phases = rp2040_bench::phases(ramp).into_iter().map(|(phase, steps)| {
            let mut checksum = Checksum::default();
            let mut left = steps;
            while left > 0 {
                let Some(segment) = segments.next() else { break };
                left = left.saturating_sub(segment.steps());
                checksum.add(segment.steps());
            }
            let sum = self.proven(&format!("{name}.{phase}"), checksum)?;
            let slowest = self.of(&format!("{name}.{phase}.max"))?;
            let cycles_mean = sum.cycles_per_result();
            Ok(CompileFigures { phase, segments: sum.count, cycles_mean, cycles_max: slowest.cycles })
        });
        phases.collect()
    }

    fn generators(&self) -> Result<Vec<GeneratorFigures>> {
        let mut found = Found { lines: self, figures: vec![self.isostep()] };
        rp2040_bench::generators(&mut found)?;
        found.figures.into_iter().collect()
    }

    fn isostep(&self) -> Result<GeneratorFigures> {
        let ramp = rp2040_bench::ramp()?;
        let fill_cycles = self.fill("fill", &ramp)?;
        let phases = rp2040_bench::phases(&ramp);
        let compiled = phases.iter().map(|(phase, _)| self.of(&format!("compile.{phase}")).map(|line| line.cycles));
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
}

/// The literature's, as they come.
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

/// Holds `intervals`, ticks, against `profile`.
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

    #[test]
    fn lines_are_read_from_a_transcript_up_to_the_end() {
        let lines =
            Lines::parse("    0.0 # expect end\n    0.1 < fill,700,20,5\n    0.2 < end\n    0.3 < noise").unwrap();
        assert_eq!(*lines.of("fill").unwrap(), Line { cycles: 700, count: 20, checksum: 5 });
        assert!((lines.of("fill").unwrap().cycles_per_result() - 35.0).abs() < 1e-12);
        assert!(lines.of("avr446").is_err());
        assert!(Lines::parse("0.1 < panicked at").is_err());
        assert!(Lines::parse("0.1 < fill,1,2,3,4").is_err());
    }

    /// 120,000 steps from rest, top 1e6 steps/s, 1e7 steps/s2: a tick late in each interval of 125 is 0.8 %.
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
