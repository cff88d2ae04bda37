//! The acceleration of each axis over whole runs, corners included, as a fraction of its limit.
//!
//! It is measured as within moves ([`limits`]): over two spans between edges that are at least so far apart
//! that the instants resolve 1 % of the limit. An axis that makes no step for longer than two such spans is meanwhile
//! where the closed form has it, so that an axis that begins to move at a corner is seen to do so. Where the speed jumps, the
//! result depends on the span: by the jump over the span. Where it does not, it exceeds no limit that is kept.
//!
//! [`slices`] are the path in short parts, each with the largest acceleration of any axis. Places are those of the plans,
//! accelerations those of the edges, which in a shaped run are late. A slice has the highest ratio of all windows whose middle is in
//! it, and of those that were the last of their axis before it. So no window is lost, however short it is.

use isostep_motion::{AXES, Axis};
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
    outcome.runs().flat_map(move |(_, run)| windows_of(outcome, run))
}

/// The windows of one run, axis by axis.
fn windows_of<'a>(outcome: &'a Outcome, run: &'a [MoveRecord]) -> impl Iterator<Item = Window> + use<'a> {
    (0..AXES).flat_map(move |axis| Samples::of(outcome, run, axis).windows())
}

/// The windows of the axes that crossed belts move: none if each axis has its own motor. Such an axis is where the motor that makes an
/// edge has it, and where the other motor is then by the closed form, which its own edges are compared with. The limits are those at
/// the end of the run.
pub fn windows_of_axes(outcome: &Outcome) -> impl Iterator<Item = Window> + '_ {
    let axes = (0..AXES).filter(|&axis| outcome.kinematics.is_shared(Axis::ALL[axis]));
    axes.flat_map(move |axis| outcome.runs().flat_map(move |(_, run)| Samples::of_axis(outcome, run, axis).windows()))
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

/// The place of an axis in a run.
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
    /// The number of turns of the axis by its last edge up to then, and by its next one.
    turns: [u32; 2],
}

impl Samples {
    fn of(outcome: &Outcome, run: &[MoveRecord], axis: usize) -> Self {
        let own = &outcome.config_of(&run[0]).limits[axis];
        let span_s = span_s(outcome, own);
        let start_ns = run[0].start_ns;
        let (first, last) = (&run[0], &run[run.len() - 1]);
        let edges = outcome.edges_of_run(run).iter().filter(|edge| edge.axis == axis);
        let places = Places::of(run, outcome.kinematics);
        let mut filled = Filled::new(first.begin_s(), span_s, |t_s| places.steps(axis, t_s));
        let (mut at, mut direction) = (f64::from(first.origin_steps[axis]), 0);
        for edge in edges {
            at += f64::from(edge.direction);
            filled.turns += u32::from(edge.direction == -direction);
            direction = edge.direction;
            let t_s = (edge.t_ns as f64 - start_ns as f64) * 1e-9;
            filled.push(t_s, at - 0.5 * f64::from(direction));
        }
        filled.finish(last);
        let own = if first.shaping.is_some() { limits::either_way(own) } else { *own };
        let limits_steps_s2 = [own.accel_steps_s2, own.decel_steps_s2];
        Self { axis, start_ns, span_s, limits_steps_s2, all: filled.all }
    }

    /// Of an axis that several motors move.
    fn of_axis(outcome: &Outcome, run: &[MoveRecord], axis: usize) -> Self {
        let (own, kinematics) = (limits::either_way(&outcome.axis_limits[axis]), outcome.kinematics);
        let (first, last) = (&run[0], &run[run.len() - 1]);
        let (span_s, start_ns, moves) = (span_s(outcome, &own), first.start_ns, kinematics.moves(Axis::ALL[axis]));
        let places = Places::of(run, outcome.kinematics);
        let place = |t_s: f64| std::array::from_fn::<_, AXES, _>(|motor| places.steps(motor, t_s));
        let mut filled = Filled::new(first.begin_s(), span_s, |t_s| kinematics.axes_of(place(t_s))[axis]);
        let mut at_steps = first.origin_steps.map(f64::from);
        for edge in outcome.edges_of_run(run).iter().filter(|edge| moves[edge.axis]) {
            let (t_s, direction) = ((edge.t_ns as f64 - start_ns as f64) * 1e-9, f64::from(edge.direction));
            at_steps[edge.axis] += direction;
            let mut motors = place(t_s);
            motors[edge.axis] = at_steps[edge.axis] - 0.5 * direction;
            filled.push(t_s, kinematics.axes_of(motors)[axis]);
        }
        filled.finish(last);
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
struct Filled<P> {
    /// The place at an instant, s from the start of the run, by the closed form.
    place: P,
    span_s: f64,
    /// The number of turns of the axis.
    turns: u32,
    all: Vec<Sample>,
}

impl<P: Fn(f64) -> f64> Filled<P> {
    fn new(begin_s: f64, span_s: f64, place: P) -> Self {
        let begin = place(begin_s);
        let rest = |spans: f64| Sample { t_s: begin_s - spans * span_s, steps: begin, turns: [0; 2] };
        Self { place, span_s, turns: 0, all: [2.0, 1.0, 0.0].map(rest).into() }
    }

    /// It stands still behind the last move, unless that was stopped.
    fn finish(&mut self, last: &MoveRecord) {
        if last.is_whole() {
            let end = (self.place)(last.plan_s);
            [0.0, 1.0, 2.0].into_iter().for_each(|spans| self.push(last.plan_s + spans * self.span_s, end));
        }
    }

    fn push(&mut self, t_s: f64, steps: f64) {
        let last = self.all[self.all.len() - 1];
        // Up to here the axis has turned as often as by its last edge.
        let turns = [last.turns[1], self.turns];
        let mut before_s = last.t_s;
        if t_s - before_s > 2.0 * self.span_s {
            while t_s - before_s > 1.5 * self.span_s {
                before_s += self.span_s;
                let steps = (self.place)(before_s);
                self.all.push(Sample { t_s: before_s, steps, turns });
            }
        }
        // Edges at one instant do not occur, but a stop may come at that of an edge.
        if t_s > before_s {
            self.all.push(Sample { t_s, steps, turns: [self.turns; 2] });
        }
    }
}

/// The place where the plan of a move is at `t_s` from the start of the run, unshaped, mm.
fn place_mm(outcome: &Outcome, record: &MoveRecord, t_s: f64) -> [f64; AXES] {
    outcome.mm_of_move(record, std::array::from_fn(|motor| record.place_steps(motor, t_s)))
}

/// A ratio up to this is within the limit: the edges resolve 1 %, at either end of a span.
pub const WITHIN: f64 = 1.02;

/// A short part of the path, by time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Index of its move in [`Outcome::moves`].
    pub index: usize,
    /// The place where it begins, mm.
    pub from_mm: [f64; AXES],
    /// The place where it ends, mm.
    pub to_mm: [f64; AXES],
    /// Its duration, s.
    pub span_s: f64,
    /// The axis whose acceleration is nearest to its limit, or most beyond it.
    pub axis: usize,
    /// That acceleration as a fraction of its limit.
    pub ratio: f64,
}

/// All slices of the program, in order. Homing is left out. Each is at most half the shortest span long, and belongs
/// to one move, a blend to the move behind it.
pub fn slices(outcome: &Outcome) -> impl Iterator<Item = Slice> + '_ {
    let [span_s, _] = spans_s(outcome);
    outcome.runs().flat_map(move |(first, run)| {
        let mut windows = Latest::of(outcome, run);
        run.iter().enumerate().flat_map(move |(number, record)| {
            let (begin_s, end_s) = (record.begin_s(), end_s(record, run.get(number + 1)));
            let count = ((end_s - begin_s).max(0.0) / (span_s / 2.0)).ceil().max(1.0);
            let at_s = move |part: usize| begin_s + (end_s - begin_s) * part as f64 / count;
            let mut from_mm = place_mm(outcome, record, begin_s);
            let parts: Vec<_> = (1..=count as usize)
                .map(|part| {
                    let (axis, ratio) = windows.until(at_s(part) + record.delay_s());
                    let to_mm = place_mm(outcome, record, at_s(part));
                    let from_mm = std::mem::replace(&mut from_mm, to_mm);
                    let span_s = at_s(part) - at_s(part - 1);
                    Slice { index: first + number, from_mm, to_mm, span_s, axis, ratio }
                })
                .collect();
            parts
        })
    })
}

/// When a move gives way to the next one of its run, or ends, s from the start of the run.
fn end_s(record: &MoveRecord, next: Option<&MoveRecord>) -> f64 {
    match next {
        Some(next) => next.begin_s(),
        None if record.is_whole() => record.plan_s,
        None => (record.end_ns - record.start_ns) as f64 * 1e-9,
    }
}

/// The windows of a run in the order of their middles, and the latest of each axis.
struct Latest {
    start_ns: u64,
    windows: std::iter::Peekable<std::vec::IntoIter<Window>>,
    ratios: [f64; AXES],
}

impl Latest {
    fn of(outcome: &Outcome, run: &[MoveRecord]) -> Self {
        let mut windows: Vec<_> = windows_of(outcome, run).collect();
        windows.sort_unstable_by_key(|window| (window.at_ns, window.axis));
        Self { start_ns: run[0].start_ns, windows: windows.into_iter().peekable(), ratios: [0.0; AXES] }
    }

    /// The highest ratio, with its axis, from where this was asked last until `t_s` from the start of the run.
    fn until(&mut self, t_s: f64) -> (usize, f64) {
        let end_ns = self.start_ns + (t_s * 1e9).ceil() as u64;
        let mut highest = self.ratios;
        while let Some(window) = self.windows.next_if(|window| window.at_ns <= end_ns) {
            self.ratios[window.axis] = window.ratio;
            highest[window.axis] = highest[window.axis].max(window.ratio);
        }
        highest.into_iter().enumerate().max_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((0, 0.0))
    }
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

    /// All that the windows find, a slice has; and together the slices are the path and its time.
    #[test]
    fn slices_lose_no_window_no_time_and_no_place() {
        for program in ["G1 X10 F1200\nY10\nX3 Y3\n", "G64 P0.5\nG1 X10 F1200\nY10\nG2 X14 I2\nG4 P1\nX0 Y0\n"] {
            let outcome = made(Port::Pio, program);
            let all: Vec<_> = slices(&outcome).collect();
            let most = all.iter().map(|slice| slice.ratio).fold(0.0, f64::max);
            assert_eq!(most, highest(&outcome).unwrap().ratio, "{program}");
            let moving_s: f64 = outcome.moves.iter().map(|record| record.plan_s - record.begin_s()).sum();
            let early_s: f64 = outcome
                .moves
                .windows(2)
                .filter(|pair| pair[0].run == pair[1].run)
                .map(|pair| pair[0].plan_s - pair[1].begin_s())
                .sum();
            let found_s: f64 = all.iter().map(|slice| slice.span_s).sum();
            assert!((found_s - (moving_s - early_s)).abs() < 1e-9, "{program}: {found_s} of {moving_s} - {early_s}");
            for pair in all.windows(2) {
                let apart_mm = (0..AXES).map(|axis| (pair[1].from_mm[axis] - pair[0].to_mm[axis]).abs());
                assert!(apart_mm.fold(0.0, f64::max) < 1e-6, "{program}: {pair:?}");
            }
            let end_mm = all.last().unwrap().to_mm;
            assert!(
                (0..AXES).all(|axis| (end_mm[axis] - outcome.position_mm[axis]).abs() < 1e-6),
                "{program}: {end_mm:?}"
            );
        }
    }

    /// A window between two others counts for the slice that has its middle, and the last one for the next slice too.
    #[test]
    fn a_short_window_is_not_lost() {
        let window = |at_ns, ratio| Window { axis: 1, at_ns, ratio };
        let windows = vec![window(1, 0.5), window(2, 9.0), window(3, 1.0), window(8, 0.2)];
        let mut latest = Latest { start_ns: 0, windows: windows.into_iter().peekable(), ratios: [0.0; AXES] };
        assert_eq!([4e-9, 6e-9, 9e-9, 1.0].map(|t_s| latest.until(t_s)), [(1, 9.0), (1, 1.0), (1, 1.0), (1, 0.2)]);
    }

    /// A right angle by `$11` jumps at the corner: it is loud within two spans of it, and quiet elsewhere.
    #[test]
    fn what_is_above_the_limit_is_where_the_speed_jumps() {
        let outcome = made(Port::Pio, "G61 G1 X10 F1200\nY10\n");
        let [_, span_s] = spans_s(&outcome);
        let above: Vec<_> = slices(&outcome).filter(|slice| slice.ratio > WITHIN).collect();
        assert!(!above.is_empty());
        for slice in above {
            let far_mm = (slice.from_mm[0] - 10.0).hypot(slice.from_mm[1]);
            assert!(far_mm < 2.0 * span_s * 20.0, "{slice:?}");
        }
    }
}
