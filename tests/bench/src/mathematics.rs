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
use isostep::measure::{Better, Figure, Findings};
use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile, SyncMove};
use rp2040_bench::{
    Checksum, FIRST_STEPS, FLOAT_AMONG_DIVISION, FLOAT_CASES, FLOAT_DIVIDE, FLOW_CASES, FlowCase, LIMITS, PLAN_CASES,
    Peer, STEPS, Stage, StandsFor, TICK_HZ, Untimed, Visitor,
};

use super::chip::Chip;
use super::lines::{AXES, Lines};

/// The clock of the chip that the firmware is for.
const CLOCK_HZ: u32 = isostep::chip::Chip::Rp2040.clock_hz();
/// Machine time that the firmware may take, s. It needs a quarter of it.
const PATIENCE_S: u32 = 60;
/// Below this fraction of the top speed, intervals are long, so there are few of them and their errors last only a
/// short part of the move.
const SLOW: f64 = 0.1;
/// The longest time that a plan may take, ms.
const PLAN_MAX_MS: f64 = 1.0;

/// The errors of the intervals relative to the closed form of the limits that they were planned from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Truth {
    /// The largest error of an interval's speed, percent of the exact speed.
    speed_error_max_percent: f64,
    /// The same error, only above a tenth of the top speed.
    speed_error_max_above_tenth_percent: f64,
    /// The lateness of the last step, counted from the first step, s.
    drift_s: f64,
}

/// Runs the firmware `elf` on an emulated board with `chip` and verifies its results. The run's files go to `folder`.
pub fn measure(elf: &Path, emulator: &Path, chip: Chip, folder: &Path, found: &mut Findings) -> Result<()> {
    let lines = Lines::parse(&run(elf, emulator, chip, folder)?)?;
    compiling(&lines, found)?;
    for case in &FLOAT_CASES {
        let checksum = rp2040_bench::floats(case, |pair, work| work(pair));
        let line = lines.proven(&format!("float.{}", case.name), checksum)?;
        let what = format!("an operation on f64, {}", case.name);
        found.add(cycles(format!("float.{}", case.name), what, line.cycles_per_result()));
    }
    let divided = rp2040_bench::floats(&FLOAT_CASES[FLOAT_DIVIDE], |pair, work| work(pair));
    lines.proven(FLOAT_AMONG_DIVISION, divided)?;
    SpeedProfile::ALL.into_iter().try_for_each(|speed_profile| of_speed_profile(&lines, speed_profile, found))?;
    FLOW_CASES.iter().try_for_each(|case| flow(&lines, case, found))?;
    generators(&lines, found)
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

fn figure(key: impl Into<String>, what: impl Into<String>, unit: &str, value: f64) -> Figure {
    Figure::new(key, what, unit).measured(value, "").compared(Better::Lower, 0.01, 0.0)
}

/// A mean of cycles, to a tenth.
fn cycles(key: impl Into<String>, what: impl Into<String>, cycles: f64) -> Figure {
    figure(key, what, "cycles", (cycles * 10.0).round() / 10.0)
}

/// Segments and steps of the ramp: 50,000 steps to accelerate, 20,000 to cruise, 50,000 to decelerate.
fn compiling(lines: &Lines, found: &mut Findings) -> Result<()> {
    let ramp = rp2040_bench::ramp()?;
    for phase in lines.compile("compile", &ramp)? {
        let (key, what) = (format!("compile.{}", phase.phase), format!("compile a segment, {}", phase.phase));
        let of = format!("of {} segments", phase.segments);
        let mean = cycles(format!("{key}.mean"), format!("{what}, mean"), phase.cycles_mean);
        found.add(Figure { resolution: of, ..mean });
        found.add(cycles(format!("{key}.max"), format!("{what}, at most"), phase.cycles_max as f64));
    }
    lead(found, "compile.lead", "of one segment of 3 axes", lines.of("compile.lead")?.results_per_cycle() / AXES);
    lead(found, "compile.lead.queue", "of a full queue of 3 axes", lines.queue_lead("compile")?);
    found.add(cycles("fill", "replay a step", lines.fill("fill", &ramp)?));
    Ok(())
}

/// Ticks of motion per cycle of compiling it, in the part that has the least. Below 1 the motion ends before the next part is
/// ready.
fn lead(found: &mut Findings, key: &str, of: &str, ticks_per_cycle: f64) {
    let what = format!("moving against compiling, {of}, where it is closest");
    found.add(Figure::new(key, what, "times").measured(ticks_per_cycle, "").compared(Better::Higher, 0.01, 0.0));
}

fn of_speed_profile(lines: &Lines, speed_profile: SpeedProfile, found: &mut Findings) -> Result<()> {
    let (ramp, compile) = (rp2040_bench::speed_profile_ramp(speed_profile)?, format!("compile.{speed_profile}"));
    let ms = |cycles: u64| cycles as f64 / f64::from(CLOCK_HZ) * 1e3;
    for case in &PLAN_CASES {
        let plan = rp2040_bench::plan(speed_profile, case)?;
        let key = format!("plan.{speed_profile}.{}", case.name);
        let planned = lines.proven(&key, rp2040_bench::plan_checksum(&plan))?;
        let what = format!("plan a move of {AXES} axes, {speed_profile}, {}", case.name);
        found.add(figure(key, what, "ms", ms(planned.cycles)).promised(PLAN_MAX_MS));
        let key = format!("begin.{speed_profile}.{}", case.name);
        let begun = lines.proven(&key, rp2040_bench::segments_checksum(rp2040_bench::first_segments(&plan)))?;
        let what = format!("the first segment of each axis of it, {speed_profile}, {}", case.name);
        found.add(figure(key, what, "ms", ms(begun.cycles)));
    }
    let phases = lines.compile(&compile, &ramp)?;
    let ramps = || phases.iter().filter(|phase| phase.phase != "cruise");
    let segments: f64 = ramps().map(|ramp| f64::from(ramp.segments)).sum();
    let all: f64 = ramps().map(|ramp| ramp.cycles_mean * f64::from(ramp.segments)).sum();
    let most = ramps().map(|ramp| ramp.cycles_max).max().unwrap_or(0);
    let of = |what: &str| format!("compile a segment of a ramp, {speed_profile}, {what}");
    found.add(cycles(format!("{compile}.mean"), of("mean"), all / segments));
    found.add(cycles(format!("{compile}.max"), of("at most"), most as f64));
    let first = first_cycles(lines, speed_profile)? as f64;
    found.add(cycles(format!("{compile}.first"), of(&format!("all of the first {FIRST_STEPS} steps")), first));
    lead(
        found,
        &format!("{compile}.lead.queue"),
        &format!("of a full queue of 3 axes, {speed_profile}"),
        lines.queue_lead(&compile)?,
    );
    let fill = format!("fill.{speed_profile}");
    found.add(cycles(&*fill, format!("replay a step, {speed_profile}"), lines.fill(&fill, &ramp)?));
    Ok(())
}

fn first_cycles(lines: &Lines, speed_profile: SpeedProfile) -> Result<u64> {
    let (mut checksum, mut steps) = (Checksum::default(), 0);
    for segment in rp2040_bench::speed_profile_ramp(speed_profile)?.segments(0, TICK_HZ) {
        if steps >= FIRST_STEPS {
            break;
        }
        steps += segment.steps();
        checksum.add(segment.last_ticks() as u32);
    }
    Ok(lines.proven(&format!("compile.{speed_profile}.first"), checksum)?.cycles)
}

/// The cost of a short move that flows, stage by stage, and the number of moves per second that this cost allows.
fn flow(lines: &Lines, case: &FlowCase, found: &mut Findings) -> Result<()> {
    let mut all = 0.0;
    let name = |what: &str| format!("a move of 0.2 mm of 3 axes that flows, {}: {what}", case.name);
    for (stage, checksum) in Stage::ALL.into_iter().zip(rp2040_bench::flow(case, &mut Untimed)) {
        let key = format!("flow.{}.{}", case.name, stage.name());
        let line = lines.proven(&key, checksum)?;
        all += line.cycles_per_result();
        found.add(cycles(key, name(stage.name()), line.cycles_per_result().round()));
    }
    found.add(cycles(format!("flow.{}.all", case.name), name("all"), all.round()));
    let what = name("so many if the core did nothing else");
    found.add(figure(format!("flow.{}.rate", case.name), what, "moves/s", (f64::from(CLOCK_HZ) / all).round()));
    Ok(())
}

/// Isostep's generator, then those of the literature, over the same ramp.
fn generators(lines: &Lines, found: &mut Findings) -> Result<()> {
    let ramp = rp2040_bench::ramp()?;
    let phases = rp2040_bench::phases(&ramp);
    let compiled = phases.iter().map(|(phase, _)| lines.of(&format!("compile.{phase}")).map(|line| line.cycles));
    let compile_cycles: u64 = compiled.sum::<Result<_>>()?;
    let mean = lines.fill("fill", &ramp)? + compile_cycles as f64 / f64::from(STEPS);
    let half = StandsFor::TimeBetweenSteps { first_steps: 0.5 };
    generator(found, "isostep", mean, None, truth(intervals(&ramp), &closed_form(&LIMITS)?, half));
    let mut peers = Peers { lines, found, result: Ok(()) };
    rp2040_bench::generators(&mut peers)?;
    peers.result
}

/// Ticks between the steps of a ramp.
fn intervals(ramp: &SyncMove<1>) -> impl Iterator<Item = u32> {
    let instants: Vec<u64> = ramp.segments(0, TICK_HZ).flat_map(|segment| segment.ticks()).collect();
    (1..instants.len()).map(move |index| (instants[index] - instants[index - 1]) as u32)
}

/// The figures of a generator: its cost and its accuracy. Where many steps are computed ahead at a time, none is the slowest.
fn generator(found: &mut Findings, name: &str, mean: f64, slowest: Option<u64>, truth: Truth) {
    let key = |part: &str| format!("generator.{name}.{part}");
    let what = |part: &str| format!("step generator {name}: {part}");
    found.add(cycles(key("cycles"), what("cycles a step"), mean));
    found.figures.extend(slowest.map(|most| cycles(key("max"), what("slowest step"), most as f64)));
    let percent = |part, what, percent| figure(key(part), what, "%", percent);
    found.add(percent("error", what("worst speed error"), truth.speed_error_max_percent));
    let above = what("worst speed error above a tenth of the top speed");
    found.add(percent("error.fast", above, truth.speed_error_max_above_tenth_percent));
    found.add(figure(key("late"), what("last step late"), "us", truth.drift_s * 1e6));
}

/// Collects the figures of the literature's generators.
struct Peers<'a> {
    lines: &'a Lines,
    found: &'a mut Findings,
    result: Result<()>,
}

impl Visitor for Peers<'_> {
    fn visit<I: Iterator<Item = u32> + Clone>(&mut self, peer: Peer, intervals: I) {
        if self.result.is_ok() {
            self.result = self.add(peer, intervals);
        }
    }
}

impl Peers<'_> {
    fn add<I: Iterator<Item = u32> + Clone>(&mut self, peer: Peer, intervals: I) -> Result<()> {
        let mut checksum = Checksum::default();
        intervals.clone().for_each(|interval| checksum.add(interval));
        let mean = self.lines.proven(peer.name, checksum)?.cycles_per_result();
        let slowest = self.lines.proven(&format!("{}.max", peer.name), checksum)?.cycles;
        let truth = truth(intervals, &closed_form(&peer.limits)?, peer.stands_for);
        generator(self.found, peer.name, mean, Some(slowest), truth);
        Ok(())
    }
}

fn closed_form(limits: &Limits) -> Result<Profile> {
    let start = limits.start_speed_steps_s;
    Ok(Profile::plan(f64::from(STEPS), start, start, limits, IntervalSplit::Fastest, SpeedProfile::Trapezoid)?)
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
    use rp2040_bench::Timer;

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

    /// The times that each stage was done.
    #[derive(Debug)]
    struct Counted([u32; Stage::ALL.len()]);

    impl Timer for Counted {
        fn time<I, R>(&mut self, stage: Stage, input: I, work: impl FnOnce(I) -> R) -> R {
            self.0[stage as usize] += 1;
            work(input)
        }
    }

    #[test]
    fn every_stage_is_done_for_every_move_and_few_moves_are_of_several_parts() {
        for case in &FLOW_CASES {
            let mut counted = Counted([0; Stage::ALL.len()]);
            rp2040_bench::flow(case, &mut counted);
            let ([read, push, advance, shape, compile], moves) = (counted.0, rp2040_bench::TIMED_MOVES);
            assert_eq!((read, push), (moves, moves), "{}", case.name);
            // Each axis of a shaped move has some phases.
            let all = if case.is_shaped() { 3 * advance..36 * advance } else { advance..advance + 1 };
            assert!(all.contains(&compile) && (shape > compile) == case.is_shaped(), "{}: {counted:?}", case.name);
            assert!((moves..moves * 2).contains(&advance), "{}: {advance} chunks", case.name);
        }
    }
}
