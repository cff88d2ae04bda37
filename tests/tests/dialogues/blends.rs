//! Corners as blends: how a program asks for them, and what becomes of its path, its steps and its laser.

use isostep_motion::{AXES, Finish};
use isostep_sim::measure::across;
use isostep_sim::{Config, Outcome, corners, run, verify};

/// A zigzag, a triangle and half a circle, at more speed than the corners allow.
const PROGRAM: &str = "G1 F2400 X10\nY10\nX0\nX10 Y0.3\nX0.013 Y1.007\nY20\nG2 X20.013 I10\nG1 X20 Y0\n";

fn made(before: &str) -> Outcome {
    let outcome = run(format!("{before}\n{PROGRAM}").as_bytes(), &Config::default()).unwrap();
    for verdict in verify::verdicts(&outcome, &verify::moves(&outcome).collect()) {
        assert!(verdict.kept, "{before}: {} {}", verdict.promise, verdict.detail);
    }
    outcome
}

/// The largest acceleration of an axis over its limit, from the closed form of blends, and from all edges.
fn accel_ratio(outcome: &Outcome) -> f64 {
    let blends = outcome.moves.iter().filter_map(|record| record.blend);
    let in_blend = blends.flat_map(|blend| {
        (0..AXES).map(move |axis| blend.accel_steps_s2(axis).abs() / outcome.limits[axis].accel_steps_s2)
    });
    in_blend.fold(across::highest(outcome).map_or(0.0, |window| window.ratio), f64::max)
}

fn has_blends(outcome: &Outcome) -> bool {
    outcome.moves.iter().any(|record| record.blend.is_some())
}

fn jump_mm_s(outcome: &Outcome) -> f64 {
    corners::largest_jumps(outcome).into_iter().flatten().map(|jump| jump.mm_s).fold(0.0, f64::max)
}

#[test]
fn g64_p_goes_round_corners_within_the_limits() {
    let outcome = made("G64 P0.05");
    assert!(accel_ratio(&outcome) < 1.01, "{}", accel_ratio(&outcome));
    assert!(jump_mm_s(&outcome) < 1e-3, "{}", jump_mm_s(&outcome));
    // All but the first move begin with a blend: X10 Y0.3 X0.013 Y1.007 bends by 178 degrees, so back and forth too.
    let blends = outcome.moves.iter().filter(|record| record.blend.is_some()).count();
    assert_eq!(blends, outcome.moves.len() - 1);
    assert_eq!(outcome.position_steps, [1_000, 0, 0]);
}

#[test]
fn the_blend_setting_is_that_of_g64_alone_and_g61_goes_to_the_corner() {
    for (before, blends) in [
        ("$904=0.05", true),
        ("$904=0.05\nG61.1\nG64", true),
        ("$904=0.05\nG64 P0", false),
        ("$904=0.05\nG61", false),
        ("G64", true),
        ("", true),
        ("$904=0", false),
        ("$904=0\nG64", false),
        ("M2", true),
        ("G61\nM30", true),
        ("$904=0.05\n$940=1", false),
        ("$904=0.05\n$910=60\n$911=60", false),
    ] {
        let outcome = made(before);
        assert_eq!(has_blends(&outcome), blends, "{before}");
        assert_eq!(outcome.position_steps, [1_000, 0, 0], "{before}");
    }
}

/// The place nearest to each corner of the square is no further from it than was asked for and half a step, and with a
/// larger deviation the program takes less time.
#[test]
fn a_larger_deviation_is_faster_and_is_kept() {
    let mut before_s = f64::INFINITY;
    for deviation_mm in [0.01, 0.05, 0.25] {
        let program = format!("G64 P{deviation_mm}\nG1 F2400 X10\nY10\nX0\nY0\n");
        let outcome = run(program.as_bytes(), &Config::default()).unwrap();
        for corner in [[10.0, 0.0], [10.0, 10.0], [0.0, 10.0]] {
            let mut at = [0; AXES];
            let off_mm = outcome.edges.iter().map(|edge| {
                at[edge.axis] += edge.direction;
                let [x, y, _] = outcome.mm(at);
                (x - corner[0]).hypot(y - corner[1])
            });
            let nearest_mm = off_mm.fold(f64::INFINITY, f64::min);
            let half_step_mm = 0.5 / 50.0 * 2_f64.sqrt();
            assert!(nearest_mm <= deviation_mm + half_step_mm, "P{deviation_mm}: {nearest_mm} mm from {corner:?}");
        }
        let took_s = outcome.moves.last().unwrap().plan_s;
        assert!(took_s < before_s, "P{deviation_mm}: {took_s} s after {before_s} s");
        before_s = took_s;
    }
}

/// Both step ports make the steps of an axis that turns within a blend.
#[test]
fn an_axis_turns_within_a_blend_on_both_ports() {
    for port in isostep_sim::Port::ALL {
        let config = Config { port, ..Config::default() };
        let program = format!("G64 P1\nG1 F2400\n{}", "X3 Y5\nX6 Y0\nX9 Y5\nX12 Y0\nX0\n".repeat(3));
        let outcome = run(program.as_bytes(), &config).unwrap();
        let turns = |record: &isostep_sim::MoveRecord| {
            record.blend.is_some_and(|blend| {
                let (all, out) = blend.step_counts(1);
                out > 0 && all > out
            })
        };
        assert!(outcome.moves.iter().filter(|record| turns(record)).count() >= 9, "{port}");
        for verdict in verify::verdicts(&outcome, &verify::moves(&outcome).collect()) {
            assert!(verdict.kept, "{port}: {} {}", verdict.promise, verdict.detail);
        }
        assert!(outcome.moves.iter().all(|record| record.finish == Finish::Done));
    }
}
