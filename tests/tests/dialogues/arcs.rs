//! Arcs: where they end, how fine their chords are without blends, and what interrupts them.

use std::f64::consts::PI;

use embassy_time::Duration;
use isostep_motion::State;
use isostep_sim::{Config, Sim};

use crate::talk::{begin, field, homed, powered_up, say, status};

/// The default machine's resolution.
const STEPS_PER_MM: f64 = 50.0;

/// The place where each move after the first `skip` moves ended, mm.
fn corners_mm(sim: &mut Sim, skip: usize) -> Vec<[f64; 3]> {
    let outcome = sim.outcome();
    outcome.moves[skip..]
        .iter()
        .map(|record| record.next_corner_steps().map(|steps| f64::from(steps) / STEPS_PER_MM))
        .collect()
}

/// Number of moves so far.
fn moves(sim: &mut Sim) -> usize {
    sim.outcome().moves.len()
}

/// Follows an arc around a centre in the plane of two axes. Every chord must end on the arc, apart from rounding to
/// whole steps.
fn follow(sim: &mut Sim, line: &str, plane: [usize; 2], centre_mm: [f64; 2], radius_mm: f64) -> Vec<[f64; 3]> {
    let before = moves(sim);
    assert_eq!(say(sim, line), ["ok"], "{line}");
    let corners_mm = corners_mm(sim, before);
    for corner_mm in &corners_mm {
        let far_mm = (corner_mm[plane[0]] - centre_mm[0]).hypot(corner_mm[plane[1]] - centre_mm[1]);
        assert!((far_mm - radius_mm).abs() <= 0.5_f64.sqrt() / STEPS_PER_MM + 1e-3, "{line}: {corner_mm:?}");
    }
    corners_mm
}

#[test]
fn arcs_of_every_kind_end_where_they_should() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G61 G0 X100 Y100 Z20"), ["ok"]);
    say(&mut sim, "F2400");
    let quarter = follow(&mut sim, "G2 X110 Y110 I10", [0, 1], [110.0, 100.0], 10.0);
    assert_eq!(quarter.last(), Some(&[110.0, 110.0, 20.0]));
    // A chord that deviates by 0.002 mm from a circle of 10 mm has a length of 0.4 mm.
    assert_eq!(quarter.len(), (5.0 * PI / 0.4_f64).ceil() as usize);
    assert!(quarter.iter().all(|[x, y, _]| (100.0..=110.0).contains(x) && (100.0..=110.0).contains(y)));
    let long_way = follow(&mut sim, "G2 X100 Y100 R-10", [0, 1], [110.0, 100.0], 10.0);
    assert_eq!(long_way.last(), Some(&[100.0, 100.0, 20.0]));
    assert!(long_way.iter().any(|[x, y, _]| *x > 119.9 && *y < 100.0), "by way of the far side");
    let circle = follow(&mut sim, "G3 X100 Y100 J-5", [0, 1], [100.0, 95.0], 5.0);
    assert_eq!(circle.last(), Some(&[100.0, 100.0, 20.0]));
    let helix = follow(&mut sim, "G3 X100 Y100 Z30 J-5", [0, 1], [100.0, 95.0], 5.0);
    assert!(helix.is_sorted_by_key(|[_, _, z]| (z * STEPS_PER_MM) as i32));
    assert_eq!(helix[helix.len() / 2 - 1], [100.0, 90.0, 25.0], "half way round is half way up");
    assert_eq!(sim.counted_steps(), [5000, 5000, 1500]);
}

#[test]
fn arcs_of_other_planes_in_inches_and_increments() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G61 G0 X100 Y100 Z20"), ["ok"]);
    let down = follow(&mut sim, "G20 G91 G18 G2 X1 Z1 K1 F90", [2, 0], [45.4, 100.0], 25.4);
    assert_eq!(down.last(), Some(&[125.4, 100.0, 45.4]));
    let back = follow(&mut sim, "G3 X-1 Z-1 R1", [2, 0], [45.4, 100.0], 25.4);
    assert_eq!(back.last(), Some(&[100.0, 100.0, 20.0]));
    let thread = follow(&mut sim, "G19 G2 Y0 J.5 X1", [1, 2], [112.7, 20.0], 12.7);
    assert_eq!(thread.last(), Some(&[125.4, 100.0, 20.0]));
    assert_eq!(say(&mut sim, "G64\n$G"), ["ok", "[GC:G2 G54 G19 G20 G91 G94 G64 M5 M9 T0 F2286 S0]", "ok"]);
}

#[test]
fn an_arc_that_bulges_out_of_the_travel_never_begins() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G0 X340 Y100\nF1200"), ["ok", "ok"]);
    let before = moves(&mut sim);
    let words = "[MSG:the arc's X360.000 is outside the travel, 0.000 to 350.000 mm: correct the program, then $X]";
    for lines in ["G3 X340 Y140 J20", "$C\nG3 X340 Y140 J20"] {
        let heard = say(&mut sim, lines);
        assert!(heard.contains(&"ALARM:2".to_owned()) && heard.contains(&words.to_owned()), "{heard:?}");
        assert_eq!(heard.iter().filter(|line| *line == "error:9").count(), 1, "{heard:?}");
        assert_eq!(status(&mut sim), "<Alarm|MPos:340.000,100.000,0.000");
        say(&mut sim, "$X");
    }
    assert_eq!(moves(&mut sim), before);
    assert!(say(&mut sim, "G2 X330 Y90 I-10 Z-1 F1200").contains(&"ALARM:2".to_owned()), "nor a helix");
    say(&mut sim, "$X");
    // In the other direction the arc is within the travel. An arc that touches the end of the travel is allowed too.
    assert_eq!(say(&mut sim, "G2 X340 Y140 J20\nG2 X340 Y120 J-10"), ["ok", "ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:340.000,120.000,0.000");
}

#[test]
fn the_arc_tolerance_says_how_many_chords_there_are() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G61 G0 X100 Y100\nF2400"), ["ok", "ok"]);
    let mut chords = |setting: &str| {
        assert_eq!(say(&mut sim, setting), ["ok"]);
        follow(&mut sim, "G2 X100 Y100 I20", [0, 1], [120.0, 100.0], 20.0).len()
    };
    let [fine, usual, coarse] = ["$12=0.001", "$12=0.002", "$12=0.004"].map(&mut chords);
    assert_eq!([fine, usual, coarse], [315, 223, 158]);
    // A quarter of a step is 0.005 mm.
    assert_eq!(chords("$12=0.005"), chords("$12=1"));
}

#[test]
fn a_circle_of_no_step_moves_nothing() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G0 X100 Y100\nF1200"), ["ok", "ok"]);
    let before = moves(&mut sim);
    assert_eq!(say(&mut sim, "G2 X100 Y100 I0.002\nG3 X100 J.004\nG2 X100 I0"), ["ok", "ok", "ok"]);
    assert_eq!(moves(&mut sim), before);
}

#[test]
fn checking_moves_along_no_arc() {
    let mut sim = homed();
    let before = moves(&mut sim);
    assert_eq!(say(&mut sim, "$C\nG2 X20 I10 F600\nX40 I10\nX60 I10 Z2"), ["[MSG:Enabled]", "ok", "ok", "ok", "ok"]);
    assert_eq!(moves(&mut sim), before);
}

/// A reset by this console and one by another. After a reset by another console, the line that makes the chords is
/// still being carried out.
#[test]
fn a_reset_ends_an_arc_where_it_brakes() {
    for by_another in [false, true] {
        let mut sim = homed();
        // With blends of so little the arc is of many chords.
        assert_eq!(say(&mut sim, "G64 P0.002 G0 X100 Y100\nF1200"), ["ok", "ok"]);
        assert_eq!(
            begin(&mut sim, "N7 G2 X100 Y100 I20", Duration::from_secs(3)),
            [""; 0],
            "it is asked for bit by bit"
        );
        assert_eq!(field(&mut sim, "Ln"), "7");
        if by_another {
            sim.machine().reset();
        } else {
            sim.send(b"\x18");
        }
        sim.run_until_idle().unwrap();
        let expected = if by_another { "error:9" } else { "Grbl 1.1h ['$' for help]" };
        assert_eq!(sim.replies(), [expected]);
        assert_eq!(sim.machine().state(), State::Idle);
        let [x, y, z] = sim.counted_steps();
        // At 20 mm/s, which it takes 0.4 s and 4 mm to reach or to brake from, the arc has covered 56 mm. It continues
        // for at most 0.1 s.
        let [x_mm, y_mm] = [x, y].map(|steps| f64::from(steps) / STEPS_PER_MM);
        let (right_mm, up_mm) = (x_mm - 120.0, y_mm - 100.0);
        assert!((right_mm.hypot(up_mm) - 20.0).abs() < 0.5_f64.sqrt() / STEPS_PER_MM + 2e-3, "{x_mm} {y_mm}");
        let distance_mm = 20.0 * (PI - up_mm.atan2(right_mm));
        assert!((59.0..62.0).contains(&distance_mm), "it braked after {distance_mm} mm");
        assert_eq!(say(&mut sim, "G91 G1 X1 F600"), ["ok"]);
        assert_eq!(sim.counted_steps(), [x + 50, y, z], "the program goes on from there");
    }
}

#[test]
fn inverse_time_is_the_time_of_the_whole_arc() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$910=600\n$911=600\nG0 X100 Y100"), ["ok", "ok", "ok"]);
    let before = moves(&mut sim);
    // 20 mm around in 12 s are 314 mm/min. That is below the start speed, so ramps take no time.
    assert_eq!(say(&mut sim, "G93 G2 X100 Y100 I10 F5"), ["ok"]);
    let outcome = sim.outcome();
    let [first, .., last] = &outcome.moves[before..] else { panic!("{} moves", outcome.moves.len()) };
    assert_eq!(first.run, last.run, "it does not stop on its way");
    let planned_s = last.plan_s - first.plan.begin_s();
    assert!((planned_s - 12.0).abs() < 0.1, "{planned_s} s");
}

/// The resolutions of the axes differ, so a chord may deviate from the arc by another length in each plane: by a quarter
/// of a step of the finer axis of the plane, and by no more than `$12`.
#[test]
fn chords_are_as_fine_as_their_plane_asks() {
    const RADIUS_MM: f64 = 8.0;
    for per_mm in [[80.0, 80.0, 400.0], [400.0, 80.0, 80.0], [80.0, 400.0, 80.0]] {
        for most_mm in [0.1, 0.002] {
            let mut config = Config::default();
            (config.settings.steps_per_mm, config.settings.arc_tolerance_mm) = (per_mm.map(|per| per as f32), most_mm);
            (config.settings.max_rate_mm_min, config.settings.accel_mm_s2) = ([6_000.0; 3], [1_000.0; 3]);
            config.settings.blend_deviation_mm = 0.0;
            let mut sim = powered_up(&config);
            for (line, axes) in [
                ("G17 G2 X0 Y0 I8 F3000", [0, 1]),
                ("G18 G2 X0 Z0 I8 F3000", [0, 2]),
                ("G19 G3 Y0 Z0 J8 F3000", [1, 2]),
            ] {
                let before = moves(&mut sim);
                assert_eq!(say(&mut sim, line), ["ok"]);
                let outcome = sim.outcome();
                let may_mm =
                    (0.25 / axes.map(|axis: usize| per_mm[axis]).into_iter().fold(0.0, f64::max)).min(most_mm.into());
                // A chord of this angle deviates by so much in its middle.
                let widest_rad = 2.0 * (1.0 - may_mm / RADIUS_MM).acos();
                let needed = (2.0 * PI / widest_rad).ceil() as usize;
                let chords = &outcome.moves[before..];
                let found = chords.len();
                assert!((needed..=needed + 1).contains(&found), "{line} at {per_mm:?}: {found} chords, not {needed}");
                for chord in chords {
                    let mm = axes.map(|axis| f64::from(chord.next_corner_steps()[axis]) / per_mm[axis]);
                    let off_mm = ((mm[0] - RADIUS_MM).hypot(mm[1]) - RADIUS_MM).abs();
                    let half_mm = axes.map(|axis| 0.5 / per_mm[axis]);
                    assert!(off_mm <= half_mm[0].hypot(half_mm[1]) + 1e-3, "{line} at {per_mm:?}: {mm:?}");
                }
            }
        }
    }
}
