use isostep_console::Settings;

use super::*;
use isostep_sim::{Config, run};

/// All axes have 2,000 mm/s², 80 steps/mm and 200 mm/s.
fn machine() -> Config {
    let mut config = Config::default();
    let settings = &mut config.settings;
    (settings.steps_per_mm, settings.max_rate_mm_min) = ([80.0; AXES], [12_000.0; AXES]);
    (settings.accel_mm_s2, settings.decel_or_0_mm_s2) = ([2_000.0; AXES], [0.0; AXES]);
    (settings.soft_limits, settings.junction_deviation_mm) = (false, 0.01);
    config.only_time = true;
    config
}

fn outcome(program: &str, set: impl FnOnce(&mut Settings)) -> Outcome {
    let mut config = machine();
    set(&mut config.settings);
    run(program.as_bytes(), &config).unwrap()
}

fn pace(program: &str) -> Pace {
    Pace::of(&outcome(program, |_| {}))
}

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1e-3), "{found} for {expected}");
}

/// The time lost at all places except the start and the end, s.
fn lost_s(pace: &Pace) -> f64 {
    pace.slow.kinds.iter().filter(|kind| kind.why != Why::Ends).map(|kind| kind.lost_s).sum()
}

fn assert_sums(pace: &Pace) {
    assert_near(pace.shares.sum_s(), pace.total_s());
    let ramps_s: f64 = pace.axes.iter().map(|axis| axis.ramps_s).sum();
    assert!(ramps_s <= pace.moving_s * (1.0 + 1e-9));
}

/// 40 mm at 100 mm/s: each ramp takes 0.05 s and 2.5 mm, with 35 mm in between.
#[test]
fn one_move_is_a_trapezoid() {
    let pace = pace("G91 G1 F6000 X40\n");
    let shares = Shares { feed_s: 0.35, standstill_s: 0.1, ..Shares::default() };
    assert_near(pace.shares.feed_s, shares.feed_s);
    assert_near(pace.shares.standstill_s, shares.standstill_s);
    assert_near(pace.moving_s, 0.45);
    assert_near(pace.distance_mm, 40.0);
    assert_eq!((pace.moves, pace.standing_s, pace.shares.corners_s, pace.fastest_axis), (1, 0.0, 0.0, Some(0)));
    assert_near(pace.axes[0].share, 0.5);
    assert_near(pace.axes[0].ramps_s, 0.1);
    // The mean speed on a ramp is half the speed.
    let ends = pace.slow.of(Why::Ends);
    assert_eq!(ends.count, 2);
    assert_near(ends.lost_s, 0.05);
    assert!(pace.slow.worst.is_empty() && lost_s(&pace) == 0.0);
    assert_eq!((pace.slowest_second, pace.busiest_second), (None, None));
    assert_sums(&pace);
}

/// v² = a δ s/(1 - s), where a is √2 times the acceleration of one axis.
#[test]
fn a_right_angle_costs_what_its_ramps_take_longer() {
    let pace = pace("G61 G91 G1 F6000 X40\nY40\n");
    let corner_mm_s = (2_000.0 * 0.01 / (1.0 - 0.5_f64.sqrt())).sqrt();
    let ramp_s = (100.0 - corner_mm_s) / 2_000.0;
    let ramp_mm = ramp_s * (100.0 + corner_mm_s) / 2.0;
    let [corner] = pace.slow.worst[..] else { panic!("{:?}", pace.slow.worst) };
    assert!((corner.taken_mm_s / corner_mm_s - 1.0).abs() < 1e-6, "{corner:?}");
    assert!((pace.shares.corners_s / (2.0 * ramp_s) - 1.0).abs() < 1e-6);
    assert!((corner.lost_s / (2.0 * (ramp_s - ramp_mm / 100.0)) - 1.0).abs() < 1e-6);
    assert_eq!((corner.why, corner.moves, corner.lines), (Why::Corner, [0, 1], [Some(1), Some(2)]));
    assert_near(corner.turn_deg, 90.0);
    assert_near(corner.asked_mm_s, 100.0);
    assert_eq!(corner.place_mm, [40.0, 0.0, 0.0]);
    assert_near(pace.shares.standstill_s, 0.1);
    assert_near(lost_s(&pace), corner.lost_s);
    assert_sums(&pace);
}

#[test]
fn a_dwell_is_a_stop_where_the_machine_stands() {
    let pace = pace("G91 G1 F6000 X40\nG4 P0.5\nX40\n");
    let [stop] = pace.slow.worst[..] else { panic!("{:?}", pace.slow.worst) };
    assert_eq!((stop.why, stop.lines, stop.taken_mm_s), (Why::Stop, [Some(1), Some(3)], 0.0));
    assert!((0.5..0.51).contains(&stop.standing_s) && stop.standing_s == pace.standing_s, "{stop:?}");
    assert_near(stop.lost_s, 0.05);
    assert_near(pace.moving_s, 0.9);
    assert_near(pace.shares.standstill_s, 0.2);
    assert_sums(&pace);
}

#[test]
fn an_exact_stop_is_told_from_a_stop_and_from_a_corner() {
    let whys = |program: &str| pace(program).slow.worst.iter().map(|place| place.why).collect::<Vec<_>>();
    assert_eq!(whys("G91 G61.1 G1 F6000 X40\nX40\n"), [Why::ExactStop]);
    assert_eq!(whys("G91 G1 F6000 X40\nX-40\n"), [Why::Corner]);
    assert_eq!(whys("G91 G1 F6000 X40\n$$\nX40\n"), []);
    let thirds = outcome("G91 G1 F6000 X4\nX4\n", |settings| settings.interval_thirds = true);
    let pace = Pace::of(&thirds);
    assert_eq!(pace.slow.worst.iter().map(|place| place.why).collect::<Vec<_>>(), [Why::Thirds]);
    // For a third of the time, only the interval split limits the speed.
    assert_near(pace.shares.standstill_s, pace.moving_s);
    assert_sums(&pace);
}

#[test]
fn a_rapid_is_limited_by_the_axis_that_is_slowest_along_it() {
    let slow_y = outcome("G91 G0 X40 Y40\n", |settings| settings.max_rate_mm_min[1] = 3_000.0);
    let pace = Pace::of(&slow_y);
    // Both accelerate to 50 mm/s at 2,000 mm/s²: each ramp takes 0.025 s and 0.625 mm.
    assert_near(pace.shares.top_speed_s[1], 38.75 / 50.0);
    assert_near(pace.shares.standstill_s, 0.05);
    assert_eq!((pace.shares.feed_s, pace.shares.top_speed_s[0], pace.fastest_axis), (0.0, 0.0, Some(1)));
    assert_near(pace.axes[1].share, 1.0);
    assert_near(pace.axes[0].share, 0.25);
    assert_sums(&pace);
}

/// A ramp between two phases at the speed asked for belongs to the slower one.
#[test]
fn a_change_of_feed_is_no_slow_place() {
    let pace = pace("G91 G1 F6000 X40\nF3000 X40\nF9000 X40\n");
    assert!(pace.slow.worst.is_empty(), "{:?}", pace.slow.worst);
    assert_near(pace.shares.standstill_s, 0.05 + 0.075);
    assert_near(pace.shares.feed_s, pace.moving_s - 0.125);
    assert_sums(&pace);
}

#[test]
fn an_arc_is_one_slow_place() {
    let pace = pace("G91 G1 F12000 X40\nG3 X10 Y10 J10\nG1 Y40\n");
    let [arc, end] = pace.slow.worst[..] else { panic!("{:?}", pace.slow.worst) };
    // Where it ends its last side is not quite a tangent.
    assert!(end.lines == [Some(2), Some(3)] && end.turn_deg < 2.0 && end.lost_s < 0.2 * arc.lost_s, "{end:?}");
    assert_eq!((arc.why, arc.lines, pace.slow.of(Why::Arc).count), (Why::Arc, [Some(2), Some(2)], 1));
    assert!((arc.turn_deg - 90.0).abs() < 12.0, "{arc:?}");
    assert!(arc.taken_mm_s < 180.0 && arc.lost_s > 0.0 && arc.moves[1] > arc.moves[0] + 2, "{arc:?}");
    assert_sums(&pace);
}

/// 400 moves of 0.1 mm. With braking over the 64 known moves, the speed is √(2 · 2,000 · 6.4) mm/s at most.
#[test]
fn short_moves_on_a_straight_line_wait_for_what_follows() {
    let pace = pace(&format!("G91 G61 G1 F12000\n{}", "X0.1\n".repeat(400)));
    assert!(pace.shares.feed_s == 0.0 && pace.shares.corners_s == 0.0, "{:?}", pace.shares);
    assert!(pace.axes[0].highest_mm_s < 161.0);
    assert!(pace.slow.kinds.iter().all(|kind| kind.count == 0 || matches!(kind.why, Why::LookAhead | Why::Ends)));
    assert_sums(&pace);
}

/// Each bend allows the full feed, which the trapezoid reaches.
#[test]
fn a_curved_speed_profile_is_slow_over_short_moves() {
    let program = format!("G91 G1 F1500 X2 Y2\n{}Y2\nX2\n", "X0.4 Y0.1\nX0.4\n".repeat(30));
    let by = |speed_profile: u16| {
        let outcome = outcome(&program, |settings| {
            (settings.speed_profile, settings.jerk_or_0_mm_s3) = (speed_profile, [20_000.0; AXES]);
        });
        Pace::of(&outcome)
    };
    let (trapezoid, curved) = (by(0), by(1));
    assert_eq!(trapezoid.slow.of(Why::SpeedProfile).count + trapezoid.slow.of(Why::LookAhead).count, 0);
    assert!(
        curved.shares.speed_profile_s > 0.0 && curved.slow.of(Why::LookAhead).count == 0,
        "{:?}",
        curved.slow.kinds
    );
    assert_sums(&curved);
}

#[test]
fn homing_is_left_out() {
    let homed = Pace::of(&run(b"$H\nG90 G1 F600 X20\nG4 P0.1\n$H\nG1 X20\n", &Config::default()).unwrap());
    assert_eq!((homed.moves, homed.standing_s, homed.slow.of(Why::Ends).count), (2, 0.0, 4));
    assert!(homed.total_s() < 10.0, "{homed:?}");
    assert_sums(&homed);
    let none = Pace::of(&run(b"$H\n", &Config::default()).unwrap());
    assert_eq!((none.moves, none.total_s(), none.fastest_axis), (0, 0.0, None));
}

#[test]
fn the_slowest_and_the_busiest_second_are_found() {
    let program = format!("G91 G1 F6000 X200\nF600 X20\nF6000 X200\n{}G1 X200\n", "X0.5\n".repeat(400));
    let pace = pace(&program);
    let slowest = pace.slowest_second.unwrap();
    assert_near(slowest.mean_mm_s, 10.0);
    assert_eq!((slowest.lines, slowest.moves_begun), ([Some(2), Some(2)], 0));
    assert!((2.0..3.1).contains(&slowest.start_s), "{slowest:?}");
    let busiest = pace.busiest_second.unwrap();
    assert!((199..=201).contains(&busiest.moves_begun), "{busiest:?}");
    assert!((6.0..7.2).contains(&busiest.start_s), "{busiest:?}");
}

/// For any program, the sums equal the total, and the total is the time from the first start to the last end.
#[test]
fn random_programs_are_accounted_for() {
    for seed in 1..=6 {
        let mut random = oorandom::Rand32::new(seed);
        let mut program = "G91\n".to_owned();
        for _ in 0..60 {
            let mut mm = || (random.rand_float() - 0.5) * 8.0;
            let [x, y, z] = [mm(), mm(), mm()];
            let feed_mm_min = random.rand_range(200..15_000);
            program += &match random.rand_range(0..9) {
                0 => format!("G0 X{x:.3} Z{z:.3}\n"),
                1 => "G4 P0.05\n".to_owned(),
                2 => format!("G61.1 G1 X{x:.3} Y{y:.3} F{feed_mm_min}\nG61\n"),
                3 => format!("G2 X0 Y0 I{x:.3} J{y:.3} F{feed_mm_min}\n"),
                _ => format!("G1 X{x:.3} Y{y:.3} Z{z:.3} F{feed_mm_min}\n"),
            };
        }
        for speed_profile in [0, 1, 2] {
            let outcome = outcome(&program, |settings| {
                settings.speed_profile = speed_profile;
                settings.jerk_or_0_mm_s3 = [50_000.0; AXES];
                settings.start_rate_mm_min = [if seed % 2 == 0 { 120.0 } else { 0.0 }; AXES];
            });
            let pace = Pace::of(&outcome);
            assert_sums(&pace);
            let (first, last) = (outcome.moves.first().unwrap(), outcome.moves.last().unwrap());
            let total_s = (last.start_ns - first.start_ns) as f64 * 1e-9 + last.plan_s - first.plan.begin_s();
            assert!((pace.total_s() / total_s - 1.0).abs() < 1e-8, "{} for {total_s}", pace.total_s());
            assert!(pace.slow.kinds.iter().all(|kind| kind.lost_s >= -1e-9 && kind.lost_s <= kind.ramps_s));
            let counted: usize = pace.slow.kinds.iter().map(|kind| kind.count).sum();
            assert!(counted > 20 && pace.slow.worst.len() == 10, "{:?} {pace:?}", outcome.refusals);
            assert!(pace.slow.worst.is_sorted_by(|one, other| one.lost_s >= other.lost_s));
            assert!(pace.axes.iter().all(|axis| axis.share <= 1.0 + 1e-9));
        }
    }
}

/// True if limits changed, after a check of the results that are available in any case.
fn limits_changed(program: &str) -> bool {
    let pace = pace(program);
    assert_sums(&pace);
    assert!(pace.moving_s > 0.0 && pace.axes.iter().all(|axis| axis.share <= 1.0 + 1e-9), "{pace:?}");
    assert!(pace.slow.kinds.iter().all(|kind| kind.lost_s >= -1e-9), "{pace:?}");
    assert_eq!(pace.shares.unknown_s, if pace.limits_changed { pace.moving_s } else { 0.0 });
    assert_eq!(pace.fastest_axis.is_none(), pace.limits_changed);
    assert!(!pace.limits_changed || pace.slow.kinds.iter().all(|kind| kind.count == 0) && pace.slow.worst.is_empty());
    pace.limits_changed
}

#[test]
fn what_limits_a_program_that_sets_limits_on_the_way_is_not_reported() {
    assert!(limits_changed("G21 F600\nG1 X10\nG4 P0\n$110=100\nG1 X20\nM2\n"));
    assert!(limits_changed("$100=100\nG0 X150\nG4 P0\n$100=50\nG0 X0\n"));
    assert!(limits_changed("G2 X0 I5 F6000\nG4 P0\n$11=0.1\nG0 X5\n"));
    assert!(!limits_changed("G21\nG0 X0\n$100=100\n$110=600\n$120=10\nG0 X15\nG1 X1 F60\n"));
    assert!(!limits_changed("G0 X10\nG4 P0\n$10=3\n$$\nG0 X0\n"), "no limit");
    assert!(!limits_changed("G0 X50\n$110=100\nG0 X0\n"), "refused in motion");
}

/// X slows down worst and Y speeds up worst: each is the one that limits its own ramp.
#[test]
fn an_axis_limits_the_slowing_by_its_own_setting() {
    let outcome = outcome("G91 G1 F6000 X40 Y40\n", |settings| {
        (settings.accel_mm_s2, settings.decel_or_0_mm_s2) = ([4_000.0, 1_000.0, 1_000.0], [500.0, 2_000.0, 1_000.0]);
    });
    let pace = Pace::of(&outcome);
    // Along the path 100 mm/s; along an axis less by √2.
    let axis_mm_s = 100.0 / 2.0_f64.sqrt();
    assert_near(pace.axes[0].ramps_s, axis_mm_s / 500.0);
    assert_near(pace.axes[1].ramps_s, axis_mm_s / 1_000.0);
    assert_sums(&pace);
}

/// The time from the start of the first move to the end of the last, from the moves themselves.
fn from_first_to_last_s(outcome: &Outcome) -> f64 {
    let (first, last) = (outcome.moves.first().unwrap(), outcome.moves.last().unwrap());
    (last.start_ns - first.start_ns) as f64 * 1e-9 + last.plan_s - first.begin_s()
}

/// Blends belong to the moves that they join: nothing of the time or of the path is left out.
#[test]
fn blends_are_accounted_for() {
    let star =
        "G91 G1 F6000\nX8 Y1\nX-3 Y4\nX-2 Y-6\nX0.3\nY0.3\nX-0.3 Y-0.1\nX5\nG3 X6 Y6 J6\nF9000 X9 Y-9\nF900 X4\n";
    let read = |name: &str| std::fs::read_to_string(format!("{}/../../programs/{name}", env!("CARGO_MANIFEST_DIR")));
    for program in [star.to_owned(), read("arcs.nc").unwrap().replace("$H", ""), read("diagonal.nc").unwrap()] {
        let of = |deviation_mm: f32| outcome(&program, |settings| settings.blend_deviation_mm = deviation_mm);
        let (bent, sharp) = (of(0.02), of(0.0));
        assert!(bent.moves.iter().filter(|record| record.blend.is_some()).count() > 1, "{program}");
        let pace = Pace::of(&bent);
        assert_sums(&pace);
        let total_s = from_first_to_last_s(&bent);
        assert!((pace.total_s() / total_s - 1.0).abs() < 1e-8, "{} for {total_s}", pace.total_s());
        let distance_mm = Pace::of(&sharp).distance_mm;
        assert!((pace.distance_mm / distance_mm - 1.0).abs() < 1e-3, "{} for {distance_mm}", pace.distance_mm);
        assert!(pace.slow.kinds.iter().all(|kind| kind.lost_s >= -1e-9 && kind.lost_s <= kind.ramps_s + 1e-9));
    }
}

/// Round a curve no axis has all of its acceleration where the speed changes. The look-ahead has nothing to do with it.
#[test]
fn ramps_round_curves_belong_to_the_curves() {
    let pace = pace("G91 G1 F6000 X10\nG2 X20 I10\nG1 X-10\nG3 X0.01 Y20 J10\nG2 X8 Z9 I4\nX-12\n");
    assert_eq!(pace.slow.of(Why::LookAhead).count, 0, "{:?}", pace.slow.kinds);
    assert!(pace.slow.of(Why::Arc).count > 0, "{:?}", pace.slow.kinds);
}

/// A right angle between two axes by a blend: v² = 2 h a, where h is 4 d/√2. The time is lost on both ramps and in the blend,
/// whose lines are h long.
#[test]
fn a_blend_is_the_corner_that_it_bends_round() {
    let pace = pace("G91 G64 P0.02 G1 F6000 X40\nY40\n");
    let reach_mm = 4.0 * 0.02 / 2.0_f64.sqrt();
    let corner_mm_s = (2.0 * reach_mm * 2_000.0).sqrt();
    let ramp_s = (100.0 - corner_mm_s) / 2_000.0;
    let ramps_s = 2.0 * ramp_s + 2.0 * reach_mm / corner_mm_s;
    let distance_mm = ramp_s * (100.0 + corner_mm_s) + 2.0 * reach_mm;
    let [corner] = pace.slow.corners[..] else { panic!("{:?}", pace.slow) };
    assert!((corner.taken_mm_s / corner_mm_s - 1.0).abs() < 1e-3, "{corner:?} for {corner_mm_s}");
    assert!((pace.shares.corners_s / ramps_s - 1.0).abs() < 1e-3, "{:?} for {ramps_s}", pace.shares);
    assert!((corner.lost_s / (ramps_s - distance_mm / 100.0) - 1.0).abs() < 1e-3, "{corner:?}");
    assert_eq!((corner.why, corner.moves, corner.lines), (Why::Corner, [0, 1], [Some(1), Some(2)]));
    assert_eq!(corner.place_mm, [40.0, 0.0, 0.0]);
    assert_near(corner.turn_deg, 90.0);
    assert_sums(&pace);
}

/// A curve of moves of 0.05 mm is as fast as the board plans them, and the look-ahead has nothing to do with it.
#[test]
fn short_moves_with_blends_last_as_long_as_the_board_takes() {
    let curve: String = (0..400).map(|k| format!("X0.05 Y{}\n", 1e-4 * f64::from(k % 3))).collect();
    let pace = pace(&format!("G91 G64 P0.02 Q0 G1 F6000\n{curve}"));
    let fastest_mm_s = 0.05 / machine().least_times.blend_s;
    let distance_s = pace.distance_mm / fastest_mm_s;
    let shares = pace.shares;
    assert!(shares.short_moves_s > 0.8 * distance_s && shares.look_ahead_s < 0.1 * distance_s, "{shares:?}");
    assert!(pace.slow.of(Why::ShortMoves).lost_s > 0.4 * distance_s, "{:?}", pace.slow);
    assert_sums(&pace);
}

/// Moves that another board would not keep up with are as short as they are for it.
#[test]
fn what_is_short_is_up_to_the_board() {
    let program = format!("G91 G61 G1 F6000\nX8\n{}X8\n", "X0.1\n".repeat(400));
    let short_moves = |straight_s: f64| {
        let mut config = machine();
        config.least_times.straight_s = straight_s;
        let pace = Pace::of(&run(program.as_bytes(), &config).unwrap());
        assert_sums(&pace);
        (pace.slow.of(Why::ShortMoves).count, pace.shares.short_moves_s)
    };
    // 0.1 mm takes 1 ms at the feed asked for; 2 ms are half as fast, with a ramp before and after.
    assert_eq!(short_moves(machine().least_times.straight_s), (0, 0.0));
    let (places, lasts_s) = short_moves(2e-3);
    assert_eq!(places, 1);
    assert_near(lasts_s, 400.0 * 2e-3 + 2.0 * 50.0 / 2_000.0);
}

/// The same straight on, where no blend leads to them.
#[test]
fn short_moves_without_blends_last_as_long_as_the_board_takes() {
    let pace = pace(&format!("G91 G61 G1 F6000\n{}", "X0.03\n".repeat(400)));
    let distance_s = pace.distance_mm / 0.03 * machine().least_times.straight_s;
    let shares = pace.shares;
    assert!(shares.short_moves_s > 0.8 * distance_s && shares.look_ahead_s < 0.1 * distance_s, "{shares:?}");
    assert_sums(&pace);
}

#[test]
fn what_limits_a_corner_is_reported() {
    let limit = |program: &str| {
        let outcome = outcome(program, |settings| settings.accel_mm_s2[1] = 500.0);
        let pace = Pace::of(&outcome);
        assert_sums(&pace);
        let limit = pace.slow.corners.first().unwrap_or_else(|| panic!("{:?}", pace.slow)).limit.unwrap();
        (limit.rule, limit.axis, (limit.deviation_mm * 1e6).round() as u32)
    };
    assert_eq!(limit("G91 G61 G1 F6000 X40\nY40\n"), (Rule::Junction, 1, 10_000));
    assert_eq!(limit("G91 G64 P0.02 G1 F6000 X40\nY40\n"), (Rule::Deviation, 1, 20_000));
    assert_eq!(limit("G91 G64 P9 G1 F6000 X4\nY4\n"), (Rule::Room, 1, 9_000_000));
    assert_eq!(limit("G91 G61 G1 F6000 X40\nX-40\n"), (Rule::Reversal, 0, 0));
}

/// A line that is so long on the wire that the move before it already brakes when it comes: there is no room for a blend.
#[test]
fn a_corner_known_too_late_for_its_blend_is_reported() {
    let limit = |comment: usize| {
        let program = format!("G91 G64 P0.02 G1 F6000 X40\n({:comment$}) Y40\n", "");
        let config = Config { baud: Some(1_200), ..machine() };
        let pace = Pace::of(&run(program.as_bytes(), &config).unwrap());
        assert_sums(&pace);
        let corner = pace.slow.corners.first().unwrap_or_else(|| panic!("{:?}", pace.slow));
        (corner.limit.unwrap().rule, corner.taken_mm_s < 1e-6)
    };
    // A character takes 8.3 ms, and the move 450 ms, of which it brakes for 50.
    assert_eq!(limit(20), (Rule::Deviation, false));
    assert_eq!(limit(39), (Rule::NoBlend, true));
}
