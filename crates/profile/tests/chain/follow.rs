//! Follows the chunks of a chain, and checks what must hold for all of them.

use isostep_profile::chain::{Chunk, ChunkKind};
use isostep_profile::{IntervalSplit, Profile, ProfileError, SpeedProfile, SyncMove};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

use super::case::{AXES, Case, line};
use super::model::{Move, OverrideRatios, corner};

/// The change that rounding may make, as a fraction.
const SAME: f64 = 1e-6;
const LIMIT_SLACK: f64 = 1.0 + 1e-6;
/// The number of instants of a chunk that are checked.
const LOOKS: u32 = 5;
/// The number of its first steps that are checked, and of its last.
const STEPS_LOOKED_AT: u32 = 4;

/// The chunks handed out so far.
pub struct Follower {
    pub case: Case,
    /// Overrides in force.
    pub ratios: OverrideRatios,
    /// True if it was asked to hold.
    pub is_held: bool,
    /// True if the overrides have changed: then it may be faster than its nominal speed.
    pub has_changed: bool,
    /// The approximate resolution of speeds that are kept as squares, mm/s.
    unit_mm_s: f64,
    last: Option<Chunk<AXES>>,
    at_s: f64,
    /// True if the next chunk begins from rest.
    is_at_rest: bool,
    made: [u32; AXES],
    made_s: [f64; AXES],
}

impl Follower {
    pub fn new(case: &Case) -> Self {
        let tops = case.limits.iter().zip(case.mm_per_step).map(|(limits, mm)| limits.top_speed_steps_s * mm);
        let fastest = tops.map(|top| top * top).sum::<f64>().sqrt();
        Self {
            case: case.clone(),
            ratios: OverrideRatios::ALL,
            is_held: false,
            has_changed: false,
            unit_mm_s: 1e-8 * fastest,
            last: None,
            at_s: 0.0,
            is_at_rest: true,
            made: [0; AXES],
            made_s: [f64::NEG_INFINITY; AXES],
        }
    }

    /// The move with that tag.
    pub fn one(&self, tag: u64) -> Move {
        Move::new(&self.case, self.case.moves[tag as usize], self.ratios)
    }

    /// The speed at the end of the last chunk, mm/s.
    pub fn speed_mm_s(&self) -> f64 {
        self.last.as_ref().map_or(0.0, |chunk| end_speed(chunk) * chunk.mm_per_step)
    }

    /// The speed that may be lost by the resolution of squares, mm/s.
    pub fn unit_mm_s(&self) -> f64 {
        self.unit_mm_s
    }

    /// When the last chunk ends, s.
    pub fn at_s(&self) -> f64 {
        self.at_s
    }

    /// Checks that it rests. It goes on from there on a new clock.
    pub fn restart(&mut self) -> TestCaseResult {
        self.rests()?;
        self.is_at_rest = true;
        self.is_held = false;
        self.at_s = 0.0;
        self.made_s = [f64::NEG_INFINITY; AXES];
        Ok(())
    }

    /// Checks that the last chunk ends at rest.
    pub fn rests(&self) -> TestCaseResult {
        if let Some(last) = &self.last {
            // It may also rest at the start speed of the next move: it could have taken the corner at that speed, but
            // does not go on.
            let next = (last.tag + 1).min(self.case.moves.len() as u64 - 1);
            let start_mm_s = self.one(last.tag).free_mm_s.max(self.one(next).free_mm_s);
            prop_assert!(self.speed_mm_s() <= start_mm_s * LIMIT_SLACK + self.unit_mm_s, "{}", self.speed_mm_s());
        }
        Ok(())
    }

    /// Checks that all moves up to the one with that tag have been made.
    pub fn ends(&self, tag: usize) -> TestCaseResult {
        prop_assert_eq!(self.last.as_ref().map(|chunk| chunk.tag as usize), Some(tag));
        self.rests()?;
        self.has_made_all()
    }

    fn has_made_all(&self) -> TestCaseResult {
        if let Some(last) = &self.last {
            prop_assert_eq!(self.made, line(last).steps.map(i32::unsigned_abs), "move {}", last.tag);
        }
        Ok(())
    }

    pub fn follow(&mut self, chunk: Chunk<AXES>) -> TestCaseResult {
        prop_assert!(chunk.until_s.is_finite() && chunk.until_steps.is_finite(), "{chunk:?}");
        let one = self.one(chunk.tag);
        prop_assert_eq!(line(&chunk).steps, one.request.steps);
        prop_assert!((chunk.mm_per_step / one.mm_per_step - 1.0).abs() <= 1e-12);
        let from_steps = match chunk.kind {
            ChunkKind::Move => self.begins(&chunk, &one)?,
            ChunkKind::Replan | ChunkKind::Continuation => self.goes_on(&chunk)?,
        };
        prop_assert!(chunk.until_s >= self.at_s && chunk.until_steps >= from_steps, "{} {}", self.at_s, from_steps);
        // Days after the last rest, what an instant is rounded by is a distance at high speed.
        let rounding_steps = f64::EPSILON * chunk.until_s * end_speed(&chunk);
        let off_steps = (line(&chunk).place_at(chunk.until_s) - chunk.until_steps).abs();
        prop_assert!(off_steps <= 1e-6 + 1e-12 * chunk.until_steps + rounding_steps, "{off_steps} steps off");
        prop_assert!(chunk.until_steps <= one.distance_steps + 1e-5);
        if chunk.kind != ChunkKind::Continuation {
            self.could_be_planned(&chunk, &one)?;
        }
        if chunk.kind == ChunkKind::Move && from_steps == 0.0 {
            self.lasts_long_enough(&chunk, &one)?;
        }
        self.keeps_limits(&chunk, &one)?;
        self.makes_steps(&chunk, &one)?;
        self.at_s = chunk.until_s;
        self.is_at_rest = false;
        self.last = Some(chunk);
        Ok(())
    }

    /// Checks the beginning of another move, or of the same move from rest. Returns where it begins, steps.
    fn begins(&mut self, chunk: &Chunk<AXES>, one: &Move) -> Result<f64, TestCaseError> {
        prop_assert_eq!(line(chunk).begin_s(), self.at_s);
        let speed_mm_s = begin_speed(chunk, self.at_s) * chunk.mm_per_step;
        let goes_on = self.last.is_some_and(|last| last.tag == chunk.tag);
        let start_mm_s = one.start_mm_s * LIMIT_SLACK + self.unit_mm_s;
        if goes_on {
            prop_assert!(self.is_at_rest && speed_mm_s <= start_mm_s, "{speed_mm_s}");
            let place_steps = self.last.map_or(0.0, |last| last.until_steps);
            prop_assert_eq!(line(chunk).begin_steps(), place_steps);
            return Ok(place_steps);
        }
        prop_assert_eq!(line(chunk).begin_steps(), 0.0);
        prop_assert_eq!(chunk.tag, self.last.map_or(0, |last| last.tag + 1));
        self.has_made_all()?;
        self.made = [0; AXES];
        let corner = match chunk.tag.checked_sub(1) {
            Some(before) if !self.is_at_rest => corner(&self.case, &self.one(before), one),
            _ => None,
        };
        let before_mm_s = self.speed_mm_s();
        let is_same = (speed_mm_s - before_mm_s).abs() <= SAME * before_mm_s + self.unit_mm_s;
        match corner {
            Some(corner) if is_same => {
                let before = self.one(chunk.tag - 1);
                let nominal = before.nominal_mm_s.min(one.nominal_mm_s);
                // What was committed at a faster feed may be as fast as a stop would allow.
                let (nominal, start) = match self.has_changed {
                    true => (f64::INFINITY, one.free_mm_s.min(before.free_mm_s)),
                    false => (nominal, one.start_mm_s.min(before.start_mm_s)),
                };
                let most = corner.sqrt().min(nominal).max(start);
                prop_assert!(
                    speed_mm_s <= most * LIMIT_SLACK + self.unit_mm_s,
                    "{speed_mm_s} round a corner for {most}"
                );
            }
            _ => {
                self.rests()?;
                prop_assert!(speed_mm_s <= start_mm_s, "{speed_mm_s} from rest after {before_mm_s}");
            }
        }
        Ok(0.0)
    }

    /// Checks that the same move goes on. Returns from which place, steps.
    fn goes_on(&self, chunk: &Chunk<AXES>) -> Result<f64, TestCaseError> {
        let Some(last) = self.last else { return Err(TestCaseError::fail("a move has not begun")) };
        prop_assert_eq!(last.tag, chunk.tag);
        prop_assert!(!self.is_at_rest);
        if chunk.kind == ChunkKind::Continuation {
            prop_assert_eq!(last.plan, chunk.plan);
        } else {
            prop_assert_eq!(line(chunk).begin_steps(), last.until_steps);
            let (before, speed) = (end_speed(&last), begin_speed(chunk, self.at_s));
            // A place is known to a rounding. At a speed near standstill that is a while.
            let rounding_s = if before > 0.0 { f64::EPSILON * last.until_steps / before } else { 0.0 };
            let off_s = (line(chunk).begin_s() - self.at_s).abs();
            prop_assert!(off_s <= 1e-9 * (self.at_s + 1.0) + rounding_s, "{off_s} s off at {} s", self.at_s);
            let unit = self.unit_mm_s / chunk.mm_per_step;
            prop_assert!((speed - before).abs() <= SAME * before + unit, "{speed} after {before} steps/s");
        }
        Ok(last.until_steps)
    }

    /// Checks that [`Profile::plan`] accepts the plan, too, if it is one between two speeds.
    fn could_be_planned(&self, chunk: &Chunk<AXES>, one: &Move) -> TestCaseResult {
        let profile = line(chunk).profile;
        let is_easing = line(chunk).end_steps() - profile.distance_steps() < line(chunk).begin_steps() - 1e-9;
        if is_easing || self.case.interval_split == IntervalSplit::Thirds {
            return Ok(());
        }
        let (entry, exit) = (profile.entry_speed_steps_s(), profile.exit_speed_steps_s());
        let nominal = one.nominal_mm_s / chunk.mm_per_step;
        let top = nominal.max(entry).max(exit).max(profile.cruise_speed_steps_s());
        let limits = one.limits(top * chunk.mm_per_step);
        let speed_profile = self.case.speed_profile;
        // Places far along the path are rounded.
        let distance_steps = profile.distance_steps() + 1e-15 * one.distance_steps;
        // A hold rests in a move if its squared speed there would be less than 2^-24 of that at which it begins.
        let rounding = if self.is_held && exit == 0.0 { 0.5_f64.powi(25) } else { 1e-9 };
        match Profile::plan(distance_steps, entry, exit, &limits, IntervalSplit::Fastest, speed_profile) {
            Ok(_) => Ok(()),
            Err(ProfileError::EntrySpeed { asked, max } | ProfileError::ExitSpeed { asked, max })
                if asked <= max * (1.0 + rounding) + 1e-2 * self.unit_mm_s / chunk.mm_per_step =>
            {
                Ok(())
            }
            // A move may last as long as that without overrides. A low one makes it longer.
            Err(ProfileError::TooLong { asked, max }) if asked * self.ratios.feed.min(1.0) <= max => Ok(()),
            Err(error) => Err(TestCaseError::fail(format!("{error} {entry} {exit} {}", profile.distance_steps()))),
        }
    }

    /// Checks that the plan of a move lasts as long as the caller needs for it.
    fn lasts_long_enough(&self, chunk: &Chunk<AXES>, one: &Move) -> TestCaseResult {
        let profile = line(chunk).profile;
        let speeds = [profile.entry_speed_steps_s(), profile.cruise_speed_steps_s(), profile.exit_speed_steps_s()];
        let (low, high) = (speeds.into_iter().fold(f64::INFINITY, f64::min), speeds.into_iter().fold(0.0, f64::max));
        let is_whole = profile.distance_steps() >= one.distance_steps * (1.0 - SAME);
        let changes = high > low * (1.0 + 1e-3) + 10.0 * self.unit_mm_s / chunk.mm_per_step;
        let [cruise_s, change_s] = one.least_s;
        // The square up to which it may change its speed is kept in steps of 2^-28 of the fastest.
        let mean_mm_s = one.length_mm / profile.duration_s();
        let rounding = (1e-4 * self.unit_mm_s * 1e8 / mean_mm_s).powi(2);
        let least_s = if changes { change_s } else { cruise_s } * (1.0 - 1e-3 - rounding);
        prop_assert!(!is_whole || profile.duration_s() >= least_s, "{} s for {least_s} s", profile.duration_s());
        Ok(())
    }

    fn keeps_limits(&self, chunk: &Chunk<AXES>, one: &Move) -> TestCaseResult {
        let profile = line(chunk).profile;
        let origin_s = line(chunk).end_s() - profile.duration_s();
        let limits = one.limits(one.top_mm_s);
        let nominal = one.nominal_mm_s / chunk.mm_per_step;
        let is_trapezoid = self.case.speed_profile == SpeedProfile::Trapezoid;
        // Thirds of a speed profile over displacement are found to 1e-5.
        let slack = if self.case.interval_split == IntervalSplit::Thirds { 1.0 + 1e-5 } else { LIMIT_SLACK };
        for look in 0..LOOKS {
            let ratio = (f64::from(look) + 0.5) / f64::from(LOOKS);
            let t_s = self.at_s + (chunk.until_s - self.at_s) * ratio - origin_s;
            let (speed, accel) = (profile.speed_at(t_s), profile.accel_at(t_s));
            prop_assert!(speed <= limits.top_speed_steps_s * LIMIT_SLACK, "{speed} steps/s");
            prop_assert!(accel <= limits.accel_steps_s2 * slack, "{accel} steps/s2");
            prop_assert!(-accel <= limits.decel_steps_s2 * slack, "{accel} steps/s2");
            let jerk = profile.jerk_at(t_s).abs();
            let has_jerk = self.case.speed_profile == SpeedProfile::SCurve;
            prop_assert!(!has_jerk || jerk <= limits.jerk_steps_s3 * LIMIT_SLACK, "{jerk} steps/s3");
            let brakes = -accel >= limits.decel_steps_s2 * (1.0 - SAME);
            // A chunk of no length contains only rounding errors.
            // So does one of less than `NOTHING_STEPS`, for which no other plan is made.
            let is_nothing = |last: Chunk<AXES>| last.tag == chunk.tag && chunk.until_steps - last.until_steps <= 1e-6;
            let is_short = chunk.until_s - self.at_s <= 1e-9 * self.at_s
                || profile.distance_steps() < 1e-4
                || self.last.is_some_and(is_nothing);
            if is_trapezoid && self.is_held && !is_short {
                prop_assert!(brakes, "held, {speed} steps/s, {accel} steps/s2");
            }
            if speed > nominal * LIMIT_SLACK {
                prop_assert!(self.has_changed, "{speed} steps/s for {nominal}");
                prop_assert!(!is_trapezoid || brakes || is_short, "{speed} for {nominal} steps/s, {accel} steps/s2");
                prop_assert!(has_jerk || accel <= 0.0, "{speed} for {nominal} steps/s, {accel} steps/s2");
            }
        }
        Ok(())
    }

    /// Checks that every step is made once, and in order.
    fn makes_steps(&mut self, chunk: &Chunk<AXES>, one: &Move) -> TestCaseResult {
        // Near standstill a rounding error of a place is a long time.
        let slack_s = 1e-9 * self.at_s + 2.0 * (1e-8 * one.mm_per_step / one.accel_mm_s2.min(one.decel_mm_s2)).sqrt();
        for axis in 0..AXES {
            let last = line(chunk).steps_before(axis, chunk.until_steps);
            let first = self.made[axis] + 1;
            prop_assert!(last + 1 >= first, "axis {axis}: {last} after {first}");
            if chunk.kind != ChunkKind::Continuation {
                prop_assert_eq!(line(chunk).step_numbers(axis).start, first, "axis {}", axis);
            }
            prop_assert!(last < line(chunk).step_numbers(axis).end);
            let early = first..(first + STEPS_LOOKED_AT).min(last + 1);
            let late = early.end.max((last + 1).saturating_sub(STEPS_LOOKED_AT))..last + 1;
            for k in early.chain(late) {
                let t_s = line(chunk).step_time_s(axis, k);
                prop_assert!(t_s > self.made_s[axis], "axis {axis} step {k}: {t_s} after {}", self.made_s[axis]);
                let slack_s = slack_s + rest_slack_s(chunk, one, axis, k);
                prop_assert!(
                    t_s >= self.at_s - slack_s && t_s <= chunk.until_s + slack_s,
                    "axis {axis} step {k} at {t_s} s is not within {} to {} s, by {slack_s}",
                    self.at_s,
                    chunk.until_s
                );
                self.made_s[axis] = t_s;
            }
            self.made[axis] = last;
        }
        Ok(())
    }
}

/// A step that is nearer to an end of its plan than `NEAREST_STEPS` counts as being so far from it. If the plan is at
/// rest there, that takes so long.
fn rest_slack_s(chunk: &Chunk<AXES>, one: &Move, axis: usize, k: u32) -> f64 {
    let stride = one.distance_steps / f64::from(one.request.steps[axis].unsigned_abs());
    let (place_steps, nearest_steps) = ((f64::from(k) - 0.5) * stride, 1e-6 * stride);
    let ends = [line(chunk).begin_steps(), line(chunk).end_steps()];
    if ends.iter().all(|end| (place_steps - end).abs() > nearest_steps) {
        return 0.0;
    }
    let profile = &line(chunk).profile;
    let from_end = profile.duration_s() - profile.time_at(profile.distance_steps() - nearest_steps);
    profile.time_at(nearest_steps).max(from_end)
}

fn begin_s(part: &SyncMove<AXES>) -> f64 {
    part.end_s() - part.profile.duration_s()
}

/// The speed at the end of a chunk, steps/s.
fn end_speed(chunk: &Chunk<AXES>) -> f64 {
    if chunk.until_s >= line(chunk).end_s() {
        line(chunk).profile.exit_speed_steps_s()
    } else {
        line(chunk).speed_at(chunk.until_s)
    }
}

/// The speed at the beginning of a chunk that begins at `at_s`, steps/s.
fn begin_speed(chunk: &Chunk<AXES>, at_s: f64) -> f64 {
    let begins = (begin_s(line(chunk)) - at_s).abs() <= 1e-12 * (at_s + line(chunk).profile.duration_s());
    if begins { line(chunk).profile.entry_speed_steps_s() } else { line(chunk).speed_at(at_s) }
}
