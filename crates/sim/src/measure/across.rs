//! The acceleration of each axis over whole runs, corners included, as a fraction of its limit.
//!
//! It is measured as within moves ([`limits`]): over two spans between edges that are at least so far apart
//! that the instants resolve 1 % of the limit. An axis that makes no step for longer than two such spans is meanwhile
//! where the closed form has it, so that an axis that begins to move at a corner is seen to do so. Where the speed jumps, the
//! result depends on the span: by the jump over the span. Where it does not, it exceeds no limit that is kept.

use isostep_motion::{AXES, Finish};
use isostep_profile::Limits;

use super::limits::{self, accel_span_s};
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::places::Places;

/// The mean acceleration of an axis over two spans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Index of the axis.
    pub axis: usize,
    /// The instant between both spans, ns since power-up.
    pub at_ns: u64,
    /// The acceleration as a fraction of its limit, or of that of the deceleration where the axis slows down.
    pub ratio: f64,
}

/// All windows of the program, run by run, and axis by axis in the order of their instants. Homing is left out.
pub fn windows(outcome: &Outcome) -> impl Iterator<Item = Window> + '_ {
    runs(outcome).flat_map(move |(_, run)| windows_of(outcome, run))
}

/// The windows of one run, axis by axis.
pub(super) fn windows_of<'a>(outcome: &'a Outcome, run: &'a [MoveRecord]) -> impl Iterator<Item = Window> + use<'a> {
    (0..AXES).flat_map(move |axis| Samples::of(outcome, run, axis).windows())
}

/// The moves of each run of the program, with the index of the first.
pub fn runs(outcome: &Outcome) -> impl Iterator<Item = (usize, &[MoveRecord])> {
    let mut end = 0;
    let runs = outcome.moves.chunk_by(|one, next| one.run == next.run).map(move |run| {
        end += run.len();
        (end - run.len(), run)
    });
    runs.filter(|(_, run)| !run[0].homing)
}

/// The highest fraction of a limit, and where it is; `None` without a move.
pub fn highest(outcome: &Outcome) -> Option<Window> {
    windows(outcome).max_by(|one, other| one.ratio.total_cmp(&other.ratio))
}

/// The shortest and the longest span over which the axes of this outcome are measured, s.
pub fn spans_s(outcome: &Outcome) -> [f64; 2] {
    let spans_s = outcome.limits.iter().map(|limits| span_s(outcome, limits));
    spans_s.fold([f64::INFINITY, 0.0], |[least, most], span_s| [least.min(span_s), most.max(span_s)])
}

/// The span over which an axis with these limits is measured, s. A jump of its speed counts as one over that time.
pub fn span_s(outcome: &Outcome, limits: &Limits) -> f64 {
    accel_span_s(limits, outcome.config.port.tolerance_ns() * 1e-9)
}

/// Where an axis is in a run.
struct Samples {
    axis: usize,
    start_ns: u64,
    span_s: f64,
    /// Accelerating and decelerating, steps/s².
    limits_steps_s2: [f64; 2],
    all: Vec<Sample>,
}

#[derive(Clone, Copy)]
struct Sample {
    /// s from the start of the run.
    t_s: f64,
    steps: f64,
    /// How often the axis has turned by its last edge up to then, and by its next one.
    turns: [u32; 2],
}

impl Samples {
    fn of(outcome: &Outcome, run: &[MoveRecord], axis: usize) -> Self {
        let own = &outcome.config_of(&run[0]).limits[axis];
        let span_s = span_s(outcome, own);
        let start_ns = run[0].start_ns;
        let (first, last) = (&run[0], &run[run.len() - 1]);
        let edges = outcome.edges[first.edges.start..last.edges.end].iter().filter(|edge| edge.axis == axis);
        let mut filled = Filled { places: Places::of(run), axis, span_s, turns: 0, all: Vec::new() };
        let begin_s = first.begin_s();
        let begin = filled.places.steps(axis, begin_s);
        for spans in [2.0, 1.0, 0.0] {
            filled.all.push(Sample { t_s: begin_s - spans * span_s, steps: begin, turns: [0; 2] });
        }
        let (mut at, mut direction) = (f64::from(first.origin_steps[axis]), 0);
        for edge in edges {
            at += f64::from(edge.direction);
            filled.turns += u32::from(edge.direction == -direction);
            direction = edge.direction;
            let t_s = (edge.t_ns as f64 - start_ns as f64) * 1e-9;
            filled.push(t_s, at - 0.5 * f64::from(direction));
        }
        if matches!(last.finish, Finish::Done | Finish::Held) {
            let end = filled.places.steps(axis, last.plan_s);
            [0.0, 1.0, 2.0].into_iter().for_each(|spans| filled.push(last.plan_s + spans * span_s, end));
        }
        let own = if first.shaping.is_some() { limits::either_way(own) } else { *own };
        let limits_steps_s2 = [own.accel_steps_s2, own.decel_steps_s2];
        Self { axis, start_ns, span_s, limits_steps_s2, all: filled.all }
    }

    fn windows(self) -> impl Iterator<Item = Window> {
        let (mut middle, mut last) = (0, 0);
        (0..self.all.len()).map_while(move |first| {
            let later = |from: usize, than: usize| {
                (from..self.all.len()).find(|&at| self.all[at].t_s >= self.all[than].t_s + self.span_s)
            };
            middle = later(middle.max(first), first)?;
            last = later(last.max(middle), middle)?;
            let samples = [first, middle, last].map(|at| self.all[at]);
            let mean = limits::mean_accel(samples.map(|sample| (sample.t_s, sample.steps)));
            let [accel, decel] = self.limits_steps_s2;
            // Where an axis turns it slows down, and then speeds up. It may stop before its next edge would tell.
            let [out_steps, back_steps] = [0, 1].map(|at| samples[at + 1].steps - samples[at].steps);
            let way_steps = out_steps + back_steps;
            let may_turn = out_steps * back_steps < 0.0 || way_steps.abs() < 1.0;
            let limit = match mean * way_steps {
                _ if samples[0].turns[0] != samples[2].turns[1] || may_turn => accel.max(decel),
                along if along < 0.0 => decel,
                _ => accel,
            };
            let at_ns = (self.start_ns as f64 + samples[1].t_s * 1e9).max(0.0) as u64;
            Some(Window { axis: self.axis, at_ns, ratio: mean.abs() / limit })
        })
    }
}

/// Samples in order, where gaps are filled.
struct Filled<'a> {
    places: Places<'a>,
    axis: usize,
    span_s: f64,
    /// How often the axis has turned.
    turns: u32,
    all: Vec<Sample>,
}

impl Filled<'_> {
    fn push(&mut self, t_s: f64, steps: f64) {
        let last = self.all[self.all.len() - 1];
        // Up to here the axis has turned as often as by its last edge.
        let turns = [last.turns[1], self.turns];
        let mut before_s = last.t_s;
        if t_s - before_s > 2.0 * self.span_s {
            while t_s - before_s > 1.5 * self.span_s {
                before_s += self.span_s;
                let steps = self.places.steps(self.axis, before_s);
                self.all.push(Sample { t_s: before_s, steps, turns });
            }
        }
        // Edges at one instant do not occur, but a stop may come at that of an edge.
        if t_s > before_s {
            self.all.push(Sample { t_s, steps, turns: [self.turns; 2] });
        }
    }
}

/// Where the plan of a move is at `t_s` from the start of the run, unshaped, mm.
pub(super) fn place_mm(outcome: &Outcome, record: &MoveRecord, t_s: f64) -> [f64; AXES] {
    std::array::from_fn(|axis| record.place_steps(axis, t_s) / outcome.steps_per_mm[axis])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Config, Port, run};

    fn made(port: Port, program: &str) -> Outcome {
        run(program.as_bytes(), &Config { port, ..Config::default() }).unwrap()
    }

    /// From rest to rest along one axis there is no more than the limit, and no less.
    #[test]
    fn a_straight_move_comes_to_its_limit() {
        for port in Port::ALL {
            let outcome = made(port, "$120=80\n$920=40\nG1 X10 F1200\n");
            let ratio = highest(&outcome).unwrap().ratio;
            assert!((0.99..1.01).contains(&ratio), "{port}: {ratio}");
        }
    }

    /// By `$11` both axes of a right angle jump by the speed of the corner; a span divides this.
    #[test]
    fn a_corner_by_the_jump_rule_exceeds_the_limit_by_its_jump() {
        let outcome = made(Port::Pio, "G61 G1 X10 F1200\nY10\n");
        let [span_s, _] = spans_s(&outcome);
        let jump_mm_s2 = (50.0 * 0.01 / (1.0 - 0.5_f64.sqrt())).sqrt() / span_s;
        for axis in 0..2 {
            let most = windows(&outcome).filter(|window| window.axis == axis).map(|window| window.ratio);
            let most = most.fold(0.0, f64::max);
            assert!((0.8..1.3).contains(&(most * 50.0 / jump_mm_s2)), "axis {axis}: {most} of 50 for {jump_mm_s2}");
        }
    }

    /// Blends keep the limits everywhere, if an axis turns in them too.
    #[test]
    fn a_corner_by_a_blend_keeps_the_limit() {
        for port in Port::ALL {
            let outcome = made(port, "G64 P0.5\nG1 X10 F1200\nY10\nX3 Y3\nG2 X10 I3.5\nG1 X20 Y3.1\nX0 Y0\n");
            assert!(outcome.moves.iter().filter(|record| record.blend.is_some()).count() > 10);
            let window = highest(&outcome).unwrap();
            assert!((0.97..1.02).contains(&window.ratio), "{port}: {window:?}");
        }
    }
}
