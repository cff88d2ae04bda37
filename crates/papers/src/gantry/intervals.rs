//! Forero's Table 1: the intervals of the staircase, of the staircase on timers, and ours.

use anyhow::Result;
use isostep_generators::{Preload, PreloadTimer, Staircase, TimedStaircase, TimedTread};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};
use isostep_report::pictures::chart::{self, Chart, Curve};
use isostep_report::pictures::document::{Picture, Table};
use isostep_report::pictures::theme::CURVE;

use crate::row::{Paper, Row};

/// t_1, s (eq 6).
pub const T1_S: f64 = 4.5;
/// The longest move, steps (section 3.1).
pub const STEPS: u32 = 20_000;
/// The move across the same workspace of 35 x 40 cm, steps. The paper does not print which move figure 9 shows.
pub const ACROSS_STEPS: u32 = 17_500;
/// f_max, steps/s (eq 3).
const TOP_STEPS_S: f64 = 2_400.0;

/// The staircase of `steps` with t_1 for each interval.
pub fn staircase(steps: u32) -> Result<Staircase> {
    Ok(Staircase::plan(steps, T1_S)?)
}

/// The same staircase on the paper's timers, with `reload_ticks` counts lost at every overflow.
pub fn timed(steps: u32, reload_ticks: u32) -> Result<TimedStaircase> {
    Ok(TimedStaircase::plan(staircase(steps)?, reload_ticks)?)
}

/// Our move with intervals of t_1 (eqs 1 to 7). One profile drives both axes.
pub fn ours() -> Result<SyncMove<2>> {
    let accel = f64::from(STEPS) / (2.0 * T1_S * T1_S);
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: TOP_STEPS_S,
        accel_steps_s2: accel,
        decel_steps_s2: accel,
        jerk_steps_s3: f64::INFINITY,
    };
    Ok(SyncMove::plan(
        [STEPS as i32, ACROSS_STEPS as i32],
        &[limits; 2],
        IntervalSplit::Thirds,
        SpeedProfile::Trapezoid,
        None,
    )?)
}

/// The paper's equations and its Table 1, compared with the staircase on timers and with ours.
pub fn rows() -> Result<Vec<Row>> {
    let (plan, timed, ours) = (staircase(STEPS)?, timed(STEPS, 0)?, ours()?.profile);
    let ask = |place, quantity: &str| Paper::Gantry.asks(place, quantity);
    let shortest_s = f64::from(STEPS) / (2.0 * TOP_STEPS_S);
    let preload = PreloadTimer::TMR0.preload(plan.interval_s())?;
    let (theirs, model, exact) = (
        [4.5, 4.725, 6.8],
        [timed.t_accel_s(), timed.t_cruise_s(), timed.t_decel_s()],
        [ours.t_accel_s(), ours.t_cruise_s(), ours.t_decel_s()],
    );
    let mut rows = vec![
        ask("eq 5", "shortest t_1 at 2,400 steps/s").number("s", 4).printed(4.166, shortest_s),
        ask("eq 12", "staircase: lengthened cruise t_vc").number("s", 3).printed(4.725, plan.t_cruise_s()),
        ask("section 3.2, eq 14", "preload of TMR0 for 0.225 s")
            .number("counts", 0)
            .printed(9_286.0, f64::from(preload)),
    ];
    for (index, name) in ["acceleration", "cruise", "deceleration"].into_iter().enumerate() {
        let ask = |what: &str| ask("Table 1", &format!("{name}, {what}")).number("s", 3);
        rows.push(ask("its staircase on timers (a model)").printed(theirs[index], model[index]));
        rows.push(ask("Isostep, thirds").printed(theirs[index], exact[index]));
    }
    rows.push(lost_steps(&timed));
    Ok(rows)
}

/// "Within the interpolation some steps are lost in each interval."
fn lost_steps(timed: &TimedStaircase) -> Row {
    let moving: Vec<TimedTread> = timed.treads().take(40).filter(|tread| tread.ideal.level > 0).collect();
    let short = moving.iter().filter(|tread| f64::from(tread.steps) < tread.ideal.ideal_steps).count();
    let lost = timed.lost_steps();
    let found = format!("{lost} of {STEPS}, in {short} of {} intervals (a model); Isostep none", moving.len());
    Paper::Gantry.asks("section 4", "steps lost").says("some in each interval", found, short == moving.len())
}

/// The dependence of the deceleration on the cost of a reload.
pub fn reload_table() -> Result<Table> {
    let mut rows = Vec::new();
    for reload_ticks in 0..=3 {
        let timed = timed(STEPS, reload_ticks)?;
        let times = [timed.t_accel_s(), timed.t_cruise_s(), timed.t_decel_s()].map(|s| format!("{s:.3}"));
        let lost = timed.lost_steps().to_string();
        rows.push([reload_ticks.to_string(), lost].into_iter().chain(times).collect());
    }
    let head = ["counts of 2 us lost at each reload", "steps lost", "acceleration, s", "cruise, s", "deceleration, s"];
    let caption = "Table 1 printed 4.5, 4.725 and 6.8 s; the staircase on timers, by what writing a preload costs";
    Ok(Table::new(&head, rows).captioned(caption))
}

/// Every stair of the acceleration, and the cruise.
pub fn tread_table() -> Result<Table> {
    let row = |tread: TimedTread| {
        let preload = |text: fn(&Preload) -> String| tread.preload.as_ref().map_or("-".to_owned(), text);
        vec![
            format!("{}/20", tread.ideal.level),
            format!("{:.3}", tread.ideal.start_s),
            format!("{:.3}", tread.ideal.duration_s),
            preload(|preload| format!("{:.2}", preload.exact)),
            preload(|preload| preload.truncated.to_string()),
            format!("{:.0}", tread.ideal.ideal_steps),
            tread.steps.to_string(),
        ]
    };
    let rows = timed(STEPS, 0)?.treads().take(21).map(row).collect();
    let head = ["speed, of V_c", "from, s", "for, s", "exact preload", "whole preload", "steps due", "steps made"];
    let caption = "Accelerating, and the cruise: preloads of TMR1 by eq 14, and what they cost";
    Ok(Table::new(&head, rows).captioned(caption))
}

/// Figure 2 compared with ours.
pub fn picture() -> Result<Picture> {
    let (plan, ours) = (staircase(STEPS)?, ours()?.profile);
    let stairs = plan.treads().flat_map(|tread| {
        [(tread.start_s, tread.speed_steps_s), (tread.start_s + tread.duration_s, tread.speed_steps_s)]
    });
    let cruise = ours.cruise_speed_steps_s();
    let (accel_s, total_s) = (ours.t_accel_s(), ours.duration_s());
    let corners = vec![(0.0, 0.0), (accel_s, cruise), (total_s - accel_s, cruise), (total_s, 0.0)];
    let chart = Chart {
        bands: chart::intervals([(0.0, accel_s), (accel_s, total_s - accel_s), (total_s - accel_s, total_s)]),
        ..Chart::new("time, s", "speed, steps/s", vec![Curve::line(CURVE[1], stairs), Curve::line(CURVE[0], corners)])
    };
    Ok(Picture::new(
        "forero-2023-figure-2",
        chart::picture(
            "Speed over time: the staircase and ours",
            &[(CURVE[1], "the paper's staircase".to_owned()), (CURVE[0], "Isostep, thirds (shaded)".to_owned())],
            1,
            340,
            &[chart],
        ),
        "Figure 2: 20,000 steps with t_1 = 4.5 s. A stair is as high as the ramp where the ramp is lower, so a ramp of \
         stairs makes 4,750 steps where a straight one makes 5,000, and the cruise goes on for 21/20 t_1 = 4.725 s \
         to make up for both. The first and the last stair stand still. A straight ramp needs none of it: three \
         equal intervals, 13.5 s instead of 13.725 s.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Cell;

    #[test]
    fn ours_keeps_three_equal_intervals() {
        let profile = ours().unwrap().profile;
        for s in [profile.t_accel_s(), profile.t_cruise_s(), profile.t_decel_s()] {
            assert!((s - 4.5).abs() < 1e-9, "{s}");
        }
    }

    #[test]
    fn the_printed_equations_are_met() {
        let rows = rows().unwrap();
        let difference = |index: usize| match rows[index].difference {
            Cell::Number(value) => value,
            ref other => panic!("{other:?}"),
        };
        assert!((0.0..0.001).contains(&difference(0)), "the paper cuts 4.1666 down");
        assert_eq!((difference(1), difference(2)), (0.0, 0.0));
    }

    #[test]
    fn truncation_alone_does_not_explain_6_8_s_and_a_count_or_two_a_reload_does() {
        let decel_s = |reload| timed(STEPS, reload).unwrap().t_decel_s();
        assert!(decel_s(0) < 5.0 && decel_s(1) < 6.8 && decel_s(2) > 6.8);
    }
}
