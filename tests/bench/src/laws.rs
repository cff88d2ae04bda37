//! The cost of each speed law on the chip: planning a move, compiling its ramps, replaying its steps.

use anyhow::Result;
use isostep_profile::SpeedLaw;
use rp2040_bench::{Checksum, FIRST_STEPS, PLAN_CASES, PlanCase, TICK_HZ};
use serde::Serialize;

use super::board::CLOCK_HZ;
use super::lines::{AXES, CompileFigures, Lines};
use super::target::Target;
use isostep::screen::grouped;

/// The longest time that a plan may take, ms.
const PLAN_MAX_MS: f64 = 1.0;

/// The cost of one law, in emulated cycles of the core.
#[derive(Clone, Debug, Serialize)]
pub struct LawFigures {
    pub law: &'static str,
    /// Planning a move of three axes.
    pub plan: Vec<PlanFigures>,
    /// Compiling the segments of one axis, by the phase in which they begin.
    pub compile: Vec<CompileFigures>,
    /// Compiling the segments of the first few steps of one axis.
    pub first_cycles: u64,
    /// Ticks of motion per cycle of compiling it for three axes, in the full queue of segments that contains the least
    /// motion. Below 1 the queues run dry.
    pub queue_lead_ticks_per_cycle: f64,
    /// Cycles per step of the loop that replays segments.
    pub fill_cycles_per_step: f64,
}

/// The cost of one of the [`PLAN_CASES`].
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PlanFigures {
    pub case: &'static str,
    pub cycles: u64,
    /// Cycles for the first segment of each axis, which computes the constants of its ramp.
    pub begin_cycles: u64,
}

/// The columns of [`LawFigures::cells`].
pub const HEAD: [&str; 9] = [
    "plan",
    "plan, thirds",
    "short",
    "short, thirds",
    "begin, at most",
    "a segment, mean",
    "at most",
    "moving/compiling",
    "replay a step",
];

impl LawFigures {
    /// Milliseconds of each plan and of the slowest first segments, then cycles per segment of a ramp, the lead of
    /// compiling over the motion, and cycles per step.
    pub fn cells(&self) -> [String; 9] {
        let words = |cycles| format!("{:.2} ms", milliseconds(cycles));
        let [a, b, c, d] = std::array::from_fn(|case| words(self.plan[case].cycles));
        let begin = words(self.plan.iter().map(|plan| plan.begin_cycles).max().unwrap_or(0));
        let ramps = || self.compile.iter().filter(|phase| phase.phase != "cruise");
        let mean = ramps().map(|ramp| ramp.cycles_mean * f64::from(ramp.segments)).sum::<f64>()
            / ramps().map(|ramp| f64::from(ramp.segments)).sum::<f64>();
        let most = ramps().map(|ramp| ramp.cycles_max).max().unwrap_or(0);
        let lead = format!("{:.2}", self.queue_lead_ticks_per_cycle);
        [a, b, c, d, begin, grouped(mean as u64), grouped(most), lead, format!("{:.1}", self.fill_cycles_per_step)]
    }

    fn slowest_plan_ms(&self) -> Option<f64> {
        self.plan.iter().map(|plan| milliseconds(plan.cycles)).reduce(f64::max)
    }
}

fn milliseconds(cycles: u64) -> f64 {
    cycles as f64 / f64::from(CLOCK_HZ) * 1e3
}

/// The targets: every law plans a move in a millisecond at most.
pub fn targets(laws: &[LawFigures]) -> impl Iterator<Item = Target> {
    laws.iter().map(|one| {
        Target::at_most(format!("plan a move of {AXES} axes, {}", one.law), one.slowest_plan_ms(), PLAN_MAX_MS, "ms")
    })
}

/// The figures of every law. The checksum of each result is verified.
pub fn all(lines: &Lines) -> Result<Vec<LawFigures>> {
    SpeedLaw::ALL.into_iter().map(|law| of(lines, law)).collect()
}

fn of(lines: &Lines, law: SpeedLaw) -> Result<LawFigures> {
    let ramp = rp2040_bench::law_ramp(law)?;
    let name = format!("compile.{law}");
    Ok(LawFigures {
        law: law.name(),
        plan: PLAN_CASES.iter().map(|case| plan(lines, law, case)).collect::<Result<_>>()?,
        compile: lines.compile(&name, &ramp)?,
        first_cycles: first_cycles(lines, law)?,
        queue_lead_ticks_per_cycle: lines.queue_lead(&name)?,
        fill_cycles_per_step: lines.fill(&format!("fill.{law}"), &ramp)?,
    })
}

fn plan(lines: &Lines, law: SpeedLaw, case: &PlanCase) -> Result<PlanFigures> {
    let plan = rp2040_bench::plan(law, case)?;
    let planned = lines.proven(&format!("plan.{law}.{}", case.name), rp2040_bench::plan_checksum(&plan))?;
    let segments = rp2040_bench::segments_checksum(rp2040_bench::first_segments(&plan));
    let begun = lines.proven(&format!("begin.{law}.{}", case.name), segments)?;
    Ok(PlanFigures { case: case.name, cycles: planned.cycles, begin_cycles: begun.cycles })
}

fn first_cycles(lines: &Lines, law: SpeedLaw) -> Result<u64> {
    let (mut checksum, mut steps) = (Checksum::default(), 0);
    for segment in rp2040_bench::law_ramp(law)?.segments(0, TICK_HZ) {
        if steps >= FIRST_STEPS {
            break;
        }
        steps += segment.steps();
        checksum.add(segment.last_ticks() as u32);
    }
    Ok(lines.proven(&format!("compile.{law}.first"), checksum)?.cycles)
}
