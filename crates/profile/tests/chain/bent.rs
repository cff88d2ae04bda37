//! Properties of a chain whose corners are blends: every axis keeps its limits, the path keeps its deviation, and every step
//! is made once, where it belongs.

use isostep_profile::chain::{Chunk, ChunkKind, Plan, Request};
use isostep_profile::{AxisCompiler, Blend, SyncMove, fit_error_max_ticks};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

use super::case::{AXES, Case};
use super::drive::Event;
use super::sees::{Sees, make};

/// The change that rounding may make, as a fraction.
const SAME: f64 = 1e-6;
/// The error of fixed point, ticks.
const FIXED_POINT_ERROR_TICKS: f64 = 0.02;
const RATES_HZ: [u32; 2] = [1_000_000, 125_000_000];
/// The number of places of a blend that are looked at.
const LOOKS: u32 = 16;

/// The chunks handed out so far.
struct Watch<'a> {
    case: &'a Case,
    /// True if moves that go straight on are one move.
    lengthens: bool,
    /// The moves of the chain.
    moves: Vec<Request<AXES>>,
    has_changed: bool,
    /// The place where the move under way begins, and its tag.
    begin_steps: [i32; AXES],
    tag: u64,
    at_s: f64,
    /// Speeds of the axes at that time, steps/s.
    speeds_steps_s: [f64; AXES],
    places_steps: [f64; AXES],
    /// The steps of each axis, and its last one: the instant, the direction and the plan.
    made_steps: [i32; AXES],
    made_s: [(f64, i32, usize); AXES],
    plans: usize,
    blends: usize,
}

impl<'a> Watch<'a> {
    fn new(case: &'a Case, lengthens: bool) -> Self {
        Self {
            case,
            lengthens,
            moves: Vec::new(),
            has_changed: false,
            begin_steps: [0; AXES],
            tag: 0,
            at_s: 0.0,
            speeds_steps_s: [0.0; AXES],
            places_steps: [0.0; AXES],
            made_steps: [0; AXES],
            made_s: [(f64::NEG_INFINITY, 0, 0); AXES],
            plans: 0,
            blends: 0,
        }
    }

    fn see_chunk(&mut self, chunk: &Chunk<AXES>) -> TestCaseResult {
        prop_assert!(chunk.until_s.is_finite() && chunk.until_s >= self.at_s, "{chunk:?} after {}", self.at_s);
        if chunk.tag != self.tag {
            prop_assert_eq!(chunk.tag, self.tag + 1);
            let before = self.moves[self.tag as usize].steps;
            self.begin_steps = std::array::from_fn(|axis| self.begin_steps[axis] + before[axis]);
            self.tag = chunk.tag;
        }
        self.plans += usize::from(chunk.kind != ChunkKind::Continuation);
        match &chunk.plan {
            Plan::Line(line) => self.see_line(chunk, line)?,
            Plan::Blend(blend) => self.see_blend(chunk, blend)?,
        }
        self.at_s = chunk.until_s;
        Ok(())
    }

    /// Checks that an axis goes on from where it was, as fast as it was.
    fn goes_on(&self, axis: usize, place_steps: f64, speed_steps_s: f64) -> TestCaseResult {
        let was_at = self.places_steps[axis];
        prop_assert!(
            (place_steps - was_at).abs() <= 2e-6,
            "axis {axis} at {place_steps} after {was_at} s {}",
            self.at_s
        );
        self.is_as_fast(axis, speed_steps_s)
    }

    fn is_as_fast(&self, axis: usize, speed_steps_s: f64) -> TestCaseResult {
        let (was, slack) = (self.speeds_steps_s[axis], SAME * self.case.limits[axis].top_speed_steps_s);
        prop_assert!(
            (speed_steps_s - was).abs() <= slack,
            "axis {axis}: {speed_steps_s} steps/s after {was}, move {}",
            self.tag
        );
        Ok(())
    }

    /// True if the corner at which the move under way begins may be a blend.
    fn may_bend(&self) -> bool {
        let has_start_speed = self.case.limits.iter().any(|limits| limits.start_speed_steps_s > 0.0);
        !has_start_speed && self.moves[self.tag as usize].deviation_mm > 0.0
    }

    fn see_line(&mut self, chunk: &Chunk<AXES>, line: &SyncMove<AXES>) -> TestCaseResult {
        let profile = line.profile;
        let at = |t_s: f64| match t_s {
            _ if t_s >= line.end_s() => (line.end_steps(), profile.exit_speed_steps_s()),
            _ if t_s <= line.end_s() - profile.duration_s() => (line.begin_steps(), profile.entry_speed_steps_s()),
            _ => (line.place_at(t_s), line.speed_at(t_s)),
        };
        let [from, to] = [at(self.at_s), at(chunk.until_s)];
        let is_first = chunk.kind == ChunkKind::Move;
        for axis in 0..AXES {
            let place = |steps: f64| f64::from(self.begin_steps[axis]) + line.axis_place(axis, steps);
            let share = (place(line.distance_steps()) - place(0.0)) / line.distance_steps();
            if !is_first {
                self.goes_on(axis, place(from.0), share * from.1)?;
            } else if self.may_bend() {
                // Where the path may leave a corner, no axis jumps in speed, whether there is a blend or not.
                self.is_as_fast(axis, share * from.1)?;
            }
            (self.places_steps[axis], self.speeds_steps_s[axis]) = (place(to.0), share * to.1);
            self.keeps_limits(axis, share, &profile)?;
            let until = line.steps_before(axis, chunk.until_steps);
            let sign = line.steps[axis].signum();
            let from = (self.made_steps[axis] - self.begin_steps[axis]) * sign;
            for k in from as u32 + 1..=until {
                self.made_steps[axis] += sign;
                self.steps_at(axis, line.step_time_s(axis, k), sign)?;
            }
        }
        Ok(())
    }

    fn keeps_limits(&self, axis: usize, share: f64, profile: &isostep_profile::Profile) -> TestCaseResult {
        let limits = &self.case.limits[axis];
        let rise = profile.cruise_speed_steps_s() - profile.entry_speed_steps_s();
        let fall = profile.cruise_speed_steps_s() - profile.exit_speed_steps_s();
        let slack = 1e-6 * limits.top_speed_steps_s;
        for (change, t_s, most) in
            [(rise, profile.t_accel_s(), limits.accel_steps_s2), (fall, profile.t_decel_s(), limits.decel_steps_s2)]
        {
            prop_assert!(share.abs() * change <= most * t_s * (1.0 + SAME) + slack, "axis {axis}: {change} in {t_s} s");
        }
        let top = profile.cruise_speed_steps_s() * share.abs();
        prop_assert!(top <= limits.top_speed_steps_s * (1.0 + SAME), "axis {axis}: {top} steps/s");
        Ok(())
    }

    fn see_blend(&mut self, chunk: &Chunk<AXES>, blend: &Blend<AXES>) -> TestCaseResult {
        self.blends += 1;
        prop_assert_eq!((chunk.kind, blend.begin_s(), blend.end_s()), (ChunkKind::Move, self.at_s, chunk.until_s));
        prop_assert!(blend.corner_s() > 0.0, "{:?}", blend);
        let request = self.moves[self.tag as usize];
        prop_assert!(request.deviation_mm > 0.0);
        for axis in 0..AXES {
            let begin = f64::from(self.begin_steps[axis]);
            self.goes_on(axis, begin + blend.place_at(axis, blend.begin_s()), blend.speed_at(axis, blend.begin_s()))?;
            self.places_steps[axis] = begin + blend.place_at(axis, blend.end_s());
            self.speeds_steps_s[axis] = blend.speed_at(axis, blend.end_s());
            let (limits, accel) = (&self.case.limits[axis], blend.accel_steps_s2(axis));
            let speeds = [blend.begin_s(), blend.end_s()].map(|t_s| blend.speed_at(axis, t_s));
            let top = limits.top_speed_steps_s;
            let along = speeds.map(|speed| speed * accel.signum());
            if along[1] > SAME * top {
                prop_assert!(
                    accel.abs() <= limits.accel_steps_s2,
                    "axis {axis} speeds up: {accel} for {limits:?}, {speeds:?}, {blend:?}"
                );
            }
            if along[0] < -SAME * top {
                prop_assert!(
                    accel.abs() <= limits.decel_steps_s2,
                    "axis {axis} slows down: {accel}, {limits:?}, {speeds:?} {blend:?}"
                );
            }
            prop_assert!(speeds.iter().all(|speed| speed.abs() <= top * (1.0 + SAME)), "axis {axis}: {speeds:?}");
            self.makes_steps(axis, blend)?;
        }
        self.keeps_deviation(blend, &request)
    }

    /// Checks that no place is further from the path round the corner than was asked for.
    fn keeps_deviation(&self, blend: &Blend<AXES>, request: &Request<AXES>) -> TestCaseResult {
        let mm = |steps: [f64; AXES]| -> [f64; AXES] {
            std::array::from_fn(|axis| steps[axis] * self.case.mm_per_step[axis])
        };
        let sum = |a: [f64; AXES], b: [f64; AXES]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let speeds =
            [blend.begin_s(), blend.end_s()].map(|t_s| mm(std::array::from_fn(|axis| blend.speed_at(axis, t_s))));
        let lines = [speeds[0].map(|speed| -speed), speeds[1]];
        // The corner is as far as the first speed leads in half of the time.
        let corner = |axis: usize| {
            blend.place_at(axis, blend.corner_begins_s())
                + blend.speed_at(axis, blend.begin_s()) * blend.corner_s() / 2.0
        };
        let place = |ratio: f64| {
            let t_s = blend.corner_begins_s() + blend.corner_s() * ratio;
            mm(std::array::from_fn(|axis| blend.place_at(axis, t_s) - corner(axis)))
        };
        for look in 0..=LOOKS {
            let place = place(f64::from(look) / f64::from(LOOKS));
            let off = lines.map(|line| {
                let along = if sum(line, line) > 0.0 { (sum(place, line) / sum(line, line)).max(0.0) } else { 0.0 };
                let rest: [f64; AXES] = std::array::from_fn(|axis| place[axis] - along * line[axis]);
                sum(rest, rest).sqrt()
            });
            let off = off[0].min(off[1]);
            prop_assert!(off <= f64::from(request.deviation_mm) * (1.0 + 1e-5) + 1e-9, "{off} mm off");
        }
        // How near it comes to the corner itself.
        let (mut from, mut to) = (0.0, 1.0);
        let off = |ratio: f64| sum(place(ratio), place(ratio)).sqrt();
        for _ in 0..100 {
            let third = (to - from) / 3.0;
            *if off(from + third) > off(to - third) { &mut from } else { &mut to } =
                if off(from + third) > off(to - third) { from + third } else { to - third };
        }
        let least = off(from);
        prop_assert!(least <= f64::from(request.deviation_mm) * (1.0 + 1e-5) + 1e-9, "{least} mm from the corner");
        Ok(())
    }

    /// Checks the steps of an axis in a blend, by the closed form and in ticks.
    fn makes_steps(&mut self, axis: usize, blend: &Blend<AXES>) -> TestCaseResult {
        let (steps, out) = blend.step_counts(axis);
        let mut direction = blend.direction(axis);
        let mut count = self.made_steps[axis] - self.begin_steps[axis];
        for k in 1..=steps {
            if k == out + 1 && out > 0 {
                direction = -direction;
            }
            let t_s = blend.step_time_s(axis, k);
            let edge = f64::from(count) + 0.5 * f64::from(direction);
            let place = blend.place_at(axis, t_s);
            // Near standstill an instant is as exact as its root.
            prop_assert!(
                (place - edge).abs() <= 3e-6,
                "axis {axis} step {k} of {steps}: {place}, not {edge}, {blend:?}"
            );
            let beyond_s = (blend.begin_s() - t_s).max(t_s - blend.end_s()).max(0.0);
            let beyond = beyond_s * blend.speed_at(axis, t_s).abs();
            prop_assert!(beyond <= 3e-6, "axis {axis} step {k}: at {t_s} s, {beyond} steps beyond {blend:?}");
            count += direction;
            self.steps_at(axis, t_s, direction)?;
        }
        self.made_steps[axis] = self.begin_steps[axis] + count;
        let end = blend.place_at(axis, blend.end_s());
        prop_assert!((f64::from(count) - end).abs() <= 0.5 + 3e-6, "axis {axis}: {count} steps made at {end}");
        self.leaves_out_little(axis, blend, steps)?;
        for tick_hz in RATES_HZ {
            compiles(blend, axis, tick_hz)?;
        }
        Ok(())
    }

    /// Checks that only edges that would be too near to each other are left out where an axis turns.
    fn leaves_out_little(&self, axis: usize, blend: &Blend<AXES>, steps: u32) -> TestCaseResult {
        let [begin, from, to] =
            [blend.begin_s(), blend.corner_begins_s(), blend.end_s()].map(|t_s| blend.place_at(axis, t_s));
        let (speed, accel) = (blend.speed_at(axis, blend.begin_s()), blend.accel_steps_s2(axis));
        let turns = speed * blend.speed_at(axis, blend.end_s()) < 0.0;
        let peak = if turns { from - speed * speed / (2.0 * accel) } else { to };
        let round = |place: f64| (place + 0.5).floor();
        let all = (round(peak) - round(begin)).abs() + (round(to) - round(peak)).abs();
        let top = self.case.limits[axis].top_speed_steps_s;
        let hidden = if turns { accel.abs() / (8.0 * top * top) } else { 0.0 };
        let missing = all - f64::from(steps);
        // A place exactly on an edge may be rounded either way.
        prop_assert!(
            missing <= 2.0 * (hidden + 1e-6).ceil() + 2.0 && missing >= -2.0,
            "axis {axis}: {missing} left out, {hidden}"
        );
        Ok(())
    }

    /// Notes a step: two of them are as far apart as at the top speed, across a turn, too. Only if they are of different
    /// plans may they be nearer to each other where an axis turns just beyond an edge: whoever makes them, keeps them
    /// apart.
    fn steps_at(&mut self, axis: usize, t_s: f64, direction: i32) -> TestCaseResult {
        let (before_s, before, plan) = self.made_s[axis];
        let top = self.case.limits[axis].top_speed_steps_s;
        let apart = (t_s - before_s) * top;
        let is_jump = self.case.limits[axis].start_speed_steps_s > 0.0 && before != direction;
        let turns_between = before != direction && plan != self.plans;
        let least = if is_jump || turns_between { 0.0 } else { 1.0 };
        prop_assert!(apart >= least - 1e-5 - 1e-9 * top * (1.0 + t_s), "axis {axis}: {apart} of a period at {t_s}");
        self.made_s[axis] = (t_s, direction, self.plans);
        Ok(())
    }
}

/// Checks an axis of a blend in ticks against the closed form.
fn compiles(blend: &Blend<AXES>, axis: usize, tick_hz: u32) -> TestCaseResult {
    let (steps, out) = blend.step_counts(axis);
    let turns = if out > 0 { out } else { steps };
    let hz = f64::from(tick_hz);
    let bound = fit_error_max_ticks(tick_hz) + 0.5 + FIXED_POINT_ERROR_TICKS;
    let slack = 64.0 * f64::EPSILON * (blend.end_s() + blend.corner_s()) * hz;
    let mut compiler = AxisCompiler::empty();
    let mut done = 0;
    for phase in (0..).map_while(|index| blend.counted_phase(axis, index)).filter(|phase| phase.step_counts().0 > 0) {
        let direction = blend.direction(axis) * if done < turns { 1 } else { -1 };
        prop_assert_eq!(phase.direction(), direction, "step {} of {}, {:?}", done, turns, blend);
        compiler.begin_phase(&phase, tick_hz);
        prop_assert_eq!(compiler.steps(), phase.step_counts().0);
        let end = done + phase.turns_after();
        while let Some(segment) = compiler.next_of_phase() {
            prop_assert!(done >= end || done + segment.steps() <= end, "a segment across a turn");
            prop_assert!(done >= turns || done + segment.steps() <= turns, "a segment across the turn of the blend");
            for tick in segment.ticks() {
                done += 1;
                let wanted = blend.step_time_s(axis, done) * hz;
                let error = (tick as f64 - wanted).abs();
                prop_assert!(
                    error <= bound + slack,
                    "axis {axis} step {done} of {steps}: {error} ticks off, {blend:?}"
                );
            }
        }
    }
    prop_assert_eq!(done, steps);
    Ok(())
}

impl Sees for Watch<'_> {
    fn see(&mut self, chunk: &Chunk<AXES>) -> TestCaseResult {
        self.see_chunk(chunk)
    }

    fn restart(&mut self) -> TestCaseResult {
        (self.at_s, self.speeds_steps_s) = (0.0, [0.0; AXES]);
        self.made_s = [(f64::NEG_INFINITY, 0, 0); AXES];
        Ok(())
    }

    fn is_overridden(&mut self) {
        self.has_changed = true;
    }

    fn lengthens(&self) -> bool {
        self.lengthens
    }

    fn is_pushed(&mut self, request: &Request<AXES>, lengthens: bool) {
        match self.moves.last_mut().filter(|_| lengthens) {
            Some(last) => last.steps = std::array::from_fn(|axis| last.steps[axis] + request.steps[axis]),
            None => self.moves.push(*request),
        }
    }
}

/// Makes the moves of the case with these events, and then all moves that are left. Returns how many blends there were.
pub fn drive<const LEN: usize>(case: &Case, events: &[Event]) -> Result<usize, TestCaseError> {
    watched::<LEN>(case, events, false)
}

/// The same, but a move that goes straight on lengthens the one before it, if it can.
pub fn drive_lengthened<const LEN: usize>(case: &Case, events: &[Event]) -> Result<usize, TestCaseError> {
    watched::<LEN>(case, events, true)
}

fn watched<const LEN: usize>(case: &Case, events: &[Event], lengthens: bool) -> Result<usize, TestCaseError> {
    let mut watch = Watch::new(case, lengthens);
    make::<LEN>(case, events, &mut watch)?;
    prop_assert_eq!(watch.made_steps, case.all_steps());
    Ok(watch.blends)
}
