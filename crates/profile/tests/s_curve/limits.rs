//! Random moves, a million of them in all: they are within their limits, end where they should, and are as short as that allows.

use std::collections::BTreeMap;

use isostep_profile::{Limits, Profile, SpeedProfile};

use super::case::{ALL, Case, count, is_one_case, over_cases};
use super::phases::Phases;
use super::shape::Shape;

/// The change that rounding may make, as a fraction.
const TOLERANCE: f64 = 1e-9;
/// The least number of times that each shape must occur in all moves, and in some of them accordingly.
const OCCURRENCES_MIN: u64 = 100;

#[derive(Default)]
struct Seen {
    shapes: BTreeMap<Shape, u64>,
    ends: BTreeMap<&'static str, u64>,
}

#[test]
fn random_moves_keep_to_their_limits() {
    let seen = over_cases(count(), |seen: &mut Seen, case| {
        let profile = case.s_curve();
        is_right(case, &profile);
        *seen.shapes.entry(Shape::of(&profile, &case.limits)).or_default() += 1;
        *seen.ends.entry(ends_of(case)).or_default() += 1;
    });
    if !is_one_case() {
        every_kind_occurs(&seen);
    }
}

#[test]
fn no_limit_is_a_gain() {
    over_cases(count(), |_: &mut (), case| {
        let profile = case.s_curve();
        is_the_trapezoid_without_limit_of_jerk(case, &profile);
        no_tighter_limit_is_faster(case, &profile);
    });
}

/// Checks that it is the move that was asked for.
pub fn is_right(case: &Case, profile: &Profile) {
    keeps_to_its_limits(case, profile);
    ends_where_it_should(case, profile);
    moves_as_its_phases(case, profile);
}

/// Speed, acceleration and jerk are monotone within a phase, so their extremes are at its ends. The middle is an extra
/// check.
fn keeps_to_its_limits(case: &Case, profile: &Profile) {
    let limits = &case.limits;
    let is_within = |name: &str, value: f64, low: f64, high: f64| {
        let (low, high) = (low * (1.0 + TOLERANCE), high * (1.0 + TOLERANCE));
        assert!((low..=high).contains(&value), "{name} {value} is outside {low} to {high}");
    };
    for t_s in instants_s(&Phases::of(profile, limits), profile.duration_s()) {
        is_within("speed", profile.speed_at(t_s), 0.0, limits.top_speed_steps_s);
        is_within("acceleration", profile.accel_at(t_s), -limits.decel_steps_s2, limits.accel_steps_s2);
        is_within("jerk", profile.jerk_at(t_s), -limits.jerk_steps_s3, limits.jerk_steps_s3);
    }
}

/// Start, middle and end of every phase.
fn instants_s(phases: &Phases, duration_s: f64) -> impl Iterator<Item = f64> {
    let mut start_s = 0.0;
    phases.0.into_iter().flat_map(move |(time_s, _)| {
        let from_s = start_s;
        start_s += time_s;
        [0.0, 0.5, 1.0].map(|ratio| (from_s + ratio * time_s).min(duration_s))
    })
}

/// The ends are exact to the last bit, except the speed at the start if the move begins to decelerate at once.
fn ends_where_it_should(case: &Case, profile: &Profile) {
    let end_s = profile.duration_s();
    assert_eq!(profile.position_at(0.0), 0.0);
    assert_eq!(profile.position_at(end_s), case.distance_steps);
    assert_eq!(profile.speed_at(end_s), case.exit_steps_s);
    assert_eq!(profile.entry_speed_steps_s(), case.entry_steps_s);
    close("speed at the start", profile.speed_at(0.0), case.entry_steps_s, profile.cruise_speed_steps_s());
    if profile.t_decel_s() > 0.0 {
        assert_eq!(profile.accel_at(end_s), 0.0);
    }
    if profile.t_accel_s() > 0.0 {
        assert_eq!(profile.accel_at(0.0), 0.0);
    }
}

/// The jerk of the phases, integrated from the entry on, leads to the places and speeds of the profile, and to its end.
fn moves_as_its_phases(case: &Case, profile: &Profile) {
    let limits = &case.limits;
    let ends = Phases::of(profile, limits).ends(case);
    for at in ends {
        // Rounding may put the end of a phase a little beyond the end of the profile.
        let t_s = at.t_s.min(profile.duration_s());
        close("position", profile.position_at(t_s), at.steps, case.distance_steps);
        close("speed", profile.speed_at(t_s), at.speed_steps_s, profile.cruise_speed_steps_s());
    }
    let [_, _, peak, cruise_end, _, _, last] = ends;
    close("duration", profile.duration_s(), last.t_s, last.t_s);
    close("end", last.steps, case.distance_steps, case.distance_steps);
    close("exit speed", last.speed_steps_s, case.exit_steps_s, profile.cruise_speed_steps_s());
    for at in [peak, cruise_end, last] {
        close("acceleration", at.accel_steps_s2, 0.0, limits.accel_steps_s2.max(limits.decel_steps_s2));
    }
}

/// Checks that it is the trapezoid if the jerk has no limit, and is no faster than the trapezoid otherwise.
fn is_the_trapezoid_without_limit_of_jerk(case: &Case, profile: &Profile) {
    let trapezoid = case.plan(SpeedProfile::Trapezoid).expect("it needs no more way than the S-curve");
    assert!(profile.duration_s() >= trapezoid.duration_s() * (1.0 - TOLERANCE), "faster than the trapezoid");
    let limits = Limits { jerk_steps_s3: f64::INFINITY, ..case.limits };
    let free = Case { limits, ..*case }.s_curve();
    close("duration", free.duration_s(), trapezoid.duration_s(), trapezoid.duration_s());
    close("peak", free.cruise_speed_steps_s(), trapezoid.cruise_speed_steps_s(), trapezoid.cruise_speed_steps_s());
    let middle_s = trapezoid.duration_s() / 2.0;
    close("middle", free.position_at(middle_s), trapezoid.position_at(middle_s), case.distance_steps);
}

/// Halving a limit does not make the move shorter. It may be refused, because an end speed may be too fast for the
/// limit.
fn no_tighter_limit_is_faster(case: &Case, profile: &Profile) {
    let limits = case.limits;
    let tighter = [
        Limits { top_speed_steps_s: limits.top_speed_steps_s / 2.0, ..limits },
        Limits { accel_steps_s2: limits.accel_steps_s2 / 2.0, ..limits },
        Limits { decel_steps_s2: limits.decel_steps_s2 / 2.0, ..limits },
        Limits { jerk_steps_s3: limits.jerk_steps_s3 / 2.0, ..limits },
    ];
    for limits in tighter {
        if let Ok(slower) = (Case { limits, ..*case }).plan(SpeedProfile::SCurve) {
            let (slower_s, duration_s) = (slower.duration_s(), profile.duration_s());
            assert!(slower_s >= duration_s * (1.0 - TOLERANCE), "{slower_s} s with {limits:?}, {duration_s} s without");
        }
    }
}

fn close(name: &str, got: f64, wanted: f64, scale: f64) {
    assert!((got - wanted).abs() <= TOLERANCE * scale, "{name}: {got} is not {wanted}");
}

fn ends_of(case: &Case) -> &'static str {
    match case.entry_steps_s.total_cmp(&case.exit_steps_s) {
        _ if case.entry_steps_s == 0.0 && case.exit_steps_s == 0.0 => "from rest to rest",
        std::cmp::Ordering::Equal => "as fast at its end as at its start",
        std::cmp::Ordering::Greater => "slower at its end",
        std::cmp::Ordering::Less => "faster at its end",
    }
}

fn every_kind_occurs(seen: &[Seen]) {
    for shape in Shape::all() {
        let occurs: u64 = seen.iter().filter_map(|seen| seen.shapes.get(&shape)).sum();
        println!("{occurs:>7} {shape:?}");
        assert!(occurs * ALL >= OCCURRENCES_MIN * count(), "{shape:?} occurs {occurs} times");
    }
    let kinds: Vec<_> = seen[0].ends.keys().collect();
    assert_eq!(kinds.len(), 4, "{kinds:?}");
}
