//! Random chains, shaped: each edge is where the weighted sum of the motion has it, and none is too many or missing.

use isostep_profile::chain::{Chunk, ChunkKind, Effort, Plan, Request};
use isostep_profile::shaper::{Combination, Impulses, Shaped, Shaper, ShaperInput, ShaperKind};
use isostep_profile::{AxisCompiler, CountedPhase, IntervalSplit, Limits, SpeedProfile, fit_error_max_ticks};
use isostep_trials::cases;
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

use super::blends::bent;
use super::case::{AXES, Case};
use super::drive::{Event, holds, overrides, pushes};
use super::sees::{Sees, make};

const TICK_HZ: u32 = 125_000_000;
/// The error of fixed point, ticks.
const FIXED_POINT_ERROR_TICKS: f64 = 0.02;
/// The change that rounding may make: steps, near standstill, and s.
const SAME_STEPS: f64 = 3e-6;
const SAME_S: f64 = 1e-9;

/// A run of one axis.
struct AxisRun {
    impulses: Impulses,
    top_steps_s: f64,
    input: Option<ShaperInput>,
    shaped: Box<Shaped<64>>,
    /// The chunk that is read.
    chunk: usize,
    /// Steps from the beginning of the run, and up to when shaped phases have been made.
    made: i32,
    at_s: f64,
}

struct Watch<'a> {
    case: &'a Case,
    axis_runs: [AxisRun; AXES],
    /// The chunks of the run, each with the whole steps from which its places count, from the beginning of the run.
    chunks: Vec<(Chunk<AXES>, [i32; AXES])>,
    /// The steps of all runs.
    made_steps: [i32; AXES],
}

impl<'a> Watch<'a> {
    fn new(case: &'a Case, shapers: &[Shaper; AXES]) -> Self {
        let axis_runs = std::array::from_fn(|axis| AxisRun {
            impulses: shapers[axis].impulses().later(0.001 * axis as f64),
            top_steps_s: case.limits[axis].top_speed_steps_s,
            input: None,
            shaped: Box::new(Shaped::empty()),
            chunk: 0,
            made: 0,
            at_s: 0.0,
        });
        Self { case, axis_runs, chunks: Vec::new(), made_steps: [0; AXES] }
    }

    /// The place where the chain has an axis at `t_s`.
    fn place(&self, axis: usize, t_s: f64) -> f64 {
        let (first, from) = &self.chunks[0];
        let begin = match &first.plan {
            Plan::Line(line) => line.axis_place(axis, line.begin_steps()),
            Plan::Blend(blend) => blend.place_at(axis, blend.begin_s()),
        };
        if t_s <= 0.0 {
            return f64::from(from[axis]) + begin;
        }
        let (chunk, from) = &self.chunks[self.at(t_s)];
        let t_s = t_s.min(chunk.until_s);
        f64::from(from[axis])
            + match &chunk.plan {
                Plan::Line(line) if t_s >= line.end_s() => line.axis_place(axis, line.end_steps()),
                Plan::Line(line) => line.axis_place(axis, line.place_at(t_s)),
                Plan::Blend(blend) => blend.place_at(axis, t_s),
            }
    }

    /// The number of the chunk at `t_s`, or of the last one.
    fn at(&self, t_s: f64) -> usize {
        self.chunks.partition_point(|(chunk, _)| chunk.until_s < t_s).min(self.chunks.len() - 1)
    }

    fn sum(&self, axis: usize, t_s: f64) -> f64 {
        let impulses = &self.axis_runs[axis].impulses;
        if let Some(ends_s) = impulses.box_ends_s() {
            let [to_s, from_s] = ends_s.map(|delay_s| t_s - delay_s);
            return self.integral(axis, from_s, to_s) / (to_s - from_s);
        }
        impulses.iter().map(|(weight, delay_s)| weight * self.place(axis, t_s - delay_s)).sum()
    }

    /// The integral of the place of an axis, exact by Simpson's rule between the instants at which its acceleration changes.
    fn integral(&self, axis: usize, from_s: f64, to_s: f64) -> f64 {
        let mut knots_s = vec![from_s, 0.0, to_s];
        for (chunk, _) in &self.chunks[self.at(from_s)..=self.at(to_s)] {
            let phases = (0..3).filter_map(|index| chunk.plan.phase(axis, index));
            knots_s.extend(phases.map(|(_, end_s)| end_s).chain([chunk.plan.begin_s(), chunk.until_s]));
        }
        knots_s.retain(|t_s| (from_s..=to_s).contains(t_s));
        knots_s.sort_by(f64::total_cmp);
        let of = |pair: &[f64]| {
            // Where the plan jumps to another speed, either side has its own.
            let [from_s, to_s] = [pair[0], pair[1]];
            let middle_s = 0.5 * (from_s + to_s);
            let places = [from_s, middle_s, to_s].map(|t_s| self.place(axis, t_s));
            (to_s - from_s) / 6.0 * (places[0] + 4.0 * places[1] + places[2])
        };
        knots_s.windows(2).map(of).sum()
    }

    /// Takes all shaped phases that are known.
    fn go_on(&mut self, axis: usize, is_closed: bool) -> TestCaseResult {
        loop {
            let axis_run = &mut self.axis_runs[axis];
            if let Some(phase) = axis_run.input.and_then(|_| axis_run.shaped.next_phase()) {
                self.makes(axis, &phase)?;
                continue;
            }
            let Some((now, _)) = self.chunks.get(axis_run.chunk) else { return Ok(()) };
            let (impulses, top) = (axis_run.impulses, axis_run.top_steps_s);
            let input = axis_run.input.get_or_insert_with(|| {
                ShaperInput::begin(Combination::Axis(axis), now, &mut axis_run.shaped, impulses, top)
            });
            if input.read(now, &mut axis_run.shaped) {
                continue;
            }
            prop_assert!(axis_run.shaped.has_room(), "more phases than are kept");
            if let Some((next, _)) = self.chunks.get(axis_run.chunk + 1) {
                input.go_on(now, next);
                axis_run.chunk += 1;
            } else if is_closed && !axis_run.shaped.is_over() {
                input.finish(now, &mut axis_run.shaped);
            } else {
                return Ok(());
            }
        }
    }

    /// Checks a shaped phase and its steps.
    fn makes(&mut self, axis: usize, phase: &CountedPhase) -> TestCaseResult {
        let t_s = phase.phase.begin_s;
        prop_assert!((t_s - self.axis_runs[axis].at_s).abs() <= SAME_S, "axis {axis} goes on at {t_s}");
        let [begin, turn, end] = phase.counts;
        let base = self.axis_runs[axis].made - begin;
        let place = |t_s: f64| self.sum(axis, t_s) - f64::from(base);
        let is_off = (phase.phase.place_steps - place(t_s)).abs();
        let slack = SAME_STEPS + SAME_S * self.case.limits[axis].top_speed_steps_s;
        prop_assert!(is_off <= slack, "axis {axis} at {t_s}: {is_off} steps off, {phase:?}");
        let mut compiler = AxisCompiler::empty();
        compiler.begin_phase(phase, TICK_HZ);
        let (steps, out) = phase.step_counts();
        prop_assert_eq!(compiler.steps(), steps);
        let turns = if out > 0 && out < steps { out } else { steps };
        prop_assert_eq!(phase.turns_after(), turns);
        let (hz, mut done, mut count) = (f64::from(TICK_HZ), 0, begin);
        let bound_s = (fit_error_max_ticks(TICK_HZ) + 0.5 + FIXED_POINT_ERROR_TICKS) / hz + SAME_S;
        while let Some(segment) = compiler.next_of_phase() {
            prop_assert!(done >= turns || done + segment.steps() <= turns, "a segment across a turn");
            for tick in segment.ticks() {
                done += 1;
                let direction = phase.direction() * if done > turns { -1 } else { 1 };
                let edge = f64::from(count) + 0.5 * f64::from(direction);
                count += direction;
                let t_s = tick as f64 / hz;
                let beyond_s = (phase.phase.begin_s - t_s).max(t_s - phase.end_s) - bound_s;
                let beyond = beyond_s * phase.phase.speed_steps_s.abs().max(phase.end_speed_steps_s.abs());
                prop_assert!(beyond <= SAME_STEPS, "{t_s}, {beyond} steps beyond {phase:?}");
                // The edge is between the places a little before and a little after, or near to one of them.
                let around = [-bound_s, bound_s].map(|by_s| (place(t_s + by_s) - edge) * f64::from(direction));
                prop_assert!(
                    around[0] <= SAME_STEPS && around[1] >= -SAME_STEPS,
                    "axis {axis} step {done} of {steps}, {edge}: {around:?} around {t_s}, {phase:?}"
                );
            }
        }
        prop_assert_eq!((done, count), (steps, end));
        // What is left out where it turns is less than two steps at top speed, and nothing else is.
        let apart = phase.phase.accel_steps_s2.abs() / (8.0 * self.case.limits[axis].top_speed_steps_s.powi(2));
        let peak = if turn == end || turn == begin { 0.0 } else { apart };
        let left = (place(phase.end_s) - f64::from(end)).abs();
        prop_assert!(left <= 0.5 + peak + SAME_STEPS, "axis {axis}: {left} from its steps, {phase:?}");
        let axis_run = &mut self.axis_runs[axis];
        (axis_run.made, axis_run.at_s) = (base + end, phase.end_s);
        Ok(())
    }

    fn end(&mut self) -> TestCaseResult {
        let Some((last, from)) = self.chunks.last().copied() else { return Ok(()) };
        for (axis, from) in from.into_iter().enumerate() {
            self.go_on(axis, true)?;
            prop_assert!(self.axis_runs[axis].shaped.is_over());
            let made = match &last.plan {
                Plan::Line(line) => line.steps_before(axis, last.until_steps) as i32 * line.steps[axis].signum(),
                Plan::Blend(blend) => blend.ends_steps(axis)[1],
            };
            prop_assert_eq!(self.axis_runs[axis].made, from + made, "axis {}", axis);
            self.made_steps[axis] += self.axis_runs[axis].made;
        }
        Ok(())
    }
}

impl Sees for Watch<'_> {
    fn see(&mut self, chunk: &Chunk<AXES>) -> TestCaseResult {
        if chunk.kind == ChunkKind::Continuation {
            let (last, _) = self.chunks.last_mut().expect("a chunk");
            (last.until_s, last.until_steps) = (chunk.until_s, chunk.until_steps);
        } else {
            let from = match (self.chunks.last(), &chunk.plan) {
                (None, Plan::Line(line)) => std::array::from_fn(|axis| {
                    -(line.steps_before(axis, line.begin_steps()) as i32) * line.steps[axis].signum()
                }),
                (None, Plan::Blend(blend)) => std::array::from_fn(|axis| -blend.ends_steps(axis)[0]),
                (Some((last, from)), _) if last.tag != chunk.tag => {
                    let steps = self.case.moves[last.tag as usize].steps;
                    std::array::from_fn(|axis| from[axis] + steps[axis])
                }
                (Some((_, from)), _) => *from,
            };
            self.chunks.push((*chunk, from));
        }
        (0..AXES).try_for_each(|axis| self.go_on(axis, false))
    }

    fn restart(&mut self) -> TestCaseResult {
        self.end()?;
        self.chunks.clear();
        for axis_run in &mut self.axis_runs {
            (axis_run.input, axis_run.chunk, axis_run.made, axis_run.at_s) = (None, 0, 0, 0.0);
        }
        Ok(())
    }
}

/// Shapers that are not longer than the phases that are kept.
fn shapers() -> impl Strategy<Value = [Shaper; AXES]> {
    let one = || {
        (prop::sample::select(&ShaperKind::ALL[..]), 30.0..500.0, 0.0..0.5)
            .prop_map(|(kind, natural_hz, damping_ratio)| Shaper { kind, natural_hz, damping_ratio })
    };
    [one(), one(), one()]
}

fn drive(case: &Case, shapers: &[Shaper; AXES], events: &[Event]) -> TestCaseResult {
    let mut watch = Watch::new(case, shapers);
    make::<8>(case, events, &mut watch)?;
    watch.end()?;
    prop_assert_eq!(watch.made_steps, case.all_steps());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(500, 1_500), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn pushes_are_shaped(case in bent(40), shapers in shapers(), events in pushes()) {
        drive(&case, &shapers, &events)?;
    }

    #[test]
    fn holds_are_shaped(case in bent(40), shapers in shapers(), events in holds()) {
        drive(&case, &shapers, &events)?;
    }

    #[test]
    fn overrides_are_shaped(case in bent(40), shapers in shapers(), events in overrides()) {
        drive(&case, &shapers, &events)?;
    }
}

/// No line is left between the blend and the move behind it, which the reader of the chunks must not take for what is left of the
/// move that the blend has led to.
#[test]
fn a_blend_may_take_the_whole_of_a_move() {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 200.0,
        accel_steps_s2: 170.0,
        decel_steps_s2: 170.0,
        jerk_steps_s3: 100.0,
    };
    let to = |steps, tag| Request {
        steps,
        offsets: [0; 3],
        feed_mm_s: None,
        stops: false,
        deviation_mm: 0.0,
        reach_mm: 0.0,
        least_s: 0.0,
        tag,
    };
    // The move is 79 of 128 parts of a step long, and its blend reaches farther.
    let bent = Request { offsets: [0, -49, 0], deviation_mm: 0.3, reach_mm: 0.07, ..to([0, 1, 0], 1) };
    let case = Case {
        limits: [limits; AXES],
        mm_per_step: [0.1; AXES],
        deviation_mm: 0.0,
        interval_split: IntervalSplit::Fastest,
        speed_profile: SpeedProfile::Trapezoid,
        effort: Effort::NONE,
        moves: vec![to([1, 1, 0], 0), bent, to([0, 1, 0], 2)],
    };
    for kind in ShaperKind::ALL {
        drive(&case, &[Shaper { kind, natural_hz: 30.0, damping_ratio: 0.1 }; AXES], &[]).unwrap();
    }
}
