//! Corners as blends, while somebody interferes: holds, overrides, the door, resets and jogs, at instants all over a
//! program. A failure names the instant of its case.

use embassy_time::Duration;
use isostep_motion::{AXES, Finish, State};
use isostep_sim::measure::across;
use isostep_sim::{Config, MoveRecord, Outcome, Sim, verify};

use crate::talk::{field, powered_up, say, state};

/// Blends of some tenths of a second, lines between them, and rapids.
const PROGRAM: &str = "G64 P1\nG1 F2400 X20\nY20\nX5\nY8 F1500\nG0 X25\nY25\nG1 X0 Y0\n";
const END_STEPS: [i32; AXES] = [0; AXES];
/// The time that it takes undisturbed, ms, and the time between two cases.
const LASTS_MS: u64 = 6_000;
const STRIDE_MS: u64 = 97;

/// The motion under way at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Where {
    Blend,
    Line,
    Rest,
}

fn under_way(outcome: &Outcome, at_ns: u64) -> Where {
    let record = outcome.moves.iter().rfind(|record| record.begin_ns() <= at_ns && at_ns < record.end_ns);
    let Some(record) = record else { return Where::Rest };
    let t_s = (at_ns - record.start_ns) as f64 * 1e-9;
    if record.blend.is_some_and(|blend| t_s < blend.end_s()) { Where::Blend } else { Where::Line }
}

/// Sends the program, lets this time pass and does `act`, which returns once nothing moves; then checks every promise,
/// and every axis's acceleration from its edges. Returns what was under way at the instant of the act, and all.
fn disturbed(program: &str, at_ms: u64, act: impl FnOnce(&mut Sim)) -> (Where, Outcome) {
    let mut sim = powered_up(&Config::default());
    sim.send(program.as_bytes());
    sim.run_for(Duration::from_millis(at_ms)).unwrap();
    let at_ns = sim.now_ns();
    act(&mut sim);
    let outcome = sim.outcome();
    for verdict in verify::verdicts(&outcome, &verify::moves(&outcome).collect()) {
        assert!(verdict.kept, "at {at_ms} ms: {} {}", verdict.promise, verdict.detail);
    }
    let most = across::highest(&outcome);
    assert!(most.is_none_or(|window| window.ratio < 1.02), "at {at_ms} ms: {most:?}");
    (under_way(&outcome, at_ns), outcome)
}

/// The same at instants all over the program. Returns how many of them fell into a blend, and how many onto a line.
fn all_over(mut act: impl FnMut(u64, &mut Sim)) -> [usize; 2] {
    let mut count = [0; 2];
    for at_ms in (100..LASTS_MS).step_by(STRIDE_MS as usize) {
        let (place, _) = disturbed(PROGRAM, at_ms, |sim| act(at_ms, sim));
        match place {
            Where::Blend => count[0] += 1,
            Where::Line => count[1] += 1,
            Where::Rest => {}
        }
    }
    count
}

fn at_rest(sim: &mut Sim) {
    sim.run_until_state(|state| !matches!(state, State::Run | State::Jog | State::Hold { still: false })).unwrap();
}

fn assert_stays(sim: &mut Sim, at_ms: u64) -> [i32; AXES] {
    let still = sim.counted_steps();
    sim.run_for(Duration::from_millis(400)).unwrap();
    assert_eq!(sim.counted_steps(), still, "at {at_ms} ms: it moved at rest");
    assert_eq!(sim.machine().position_steps(), still, "at {at_ms} ms");
    still
}

#[test]
fn a_hold_in_a_blend_or_on_a_line_comes_to_rest_and_goes_on() {
    let mut longest_s = 0.0_f64;
    let [blends, lines] = all_over(|at_ms, sim| {
        let asked_ns = sim.now_ns();
        sim.send(b"!");
        at_rest(sim);
        longest_s = longest_s.max((sim.now_ns() - asked_ns) as f64 * 1e-9);
        assert_stays(sim, at_ms);
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.counted_steps(), END_STEPS, "at {at_ms} ms");
    });
    assert!(blends > 8 && lines > 15, "{blends} in blends, {lines} on lines");
    // 60 ms that are committed, a blend of at most 0.4 s, and 0.8 s to brake from 40 mm/s at 50 mm/s².
    assert!(longest_s < 1.3, "{longest_s} s to rest");
}

/// Two holds on the way through the same blend lose nothing.
#[test]
fn a_hold_again_right_after_a_resume_loses_nothing() {
    let [blends, _] = all_over(|at_ms, sim| {
        for pause_ms in [40, 150, 15] {
            sim.send(b"!");
            at_rest(sim);
            sim.send(b"~");
            sim.run_for(Duration::from_millis(pause_ms)).unwrap();
        }
        sim.run_until_idle().unwrap();
        assert_eq!(sim.counted_steps(), END_STEPS, "at {at_ms} ms");
    });
    assert!(blends > 8, "{blends}");
}

/// Overrides of feeds and rapids at once change speeds, and no count and no limit.
#[test]
fn overrides_in_a_blend_or_on_a_line_keep_path_and_limits() {
    let undisturbed_s = disturbed(PROGRAM, 100, |sim| sim.run_until_idle().unwrap()).1.motion_s;
    for (sent, slows) in [(&[0x92, 0x92, 0x92, 0x92, 0x92, 0x97][..], true), (&[0x91, 0x91, 0x91, 0x96], false)] {
        let [blends, lines] = all_over(|at_ms, sim| {
            sim.send(sent);
            sim.run_until_idle().unwrap();
            assert_eq!(sim.counted_steps(), END_STEPS, "at {at_ms} ms");
            let took_s = sim.outcome().motion_s;
            assert!(!slows || took_s > undisturbed_s - 1e-6, "at {at_ms} ms: {took_s} s for {undisturbed_s} s");
        });
        assert!(blends > 8 && lines > 15, "{blends} in blends, {lines} on lines");
    }
}

/// What is planned after an override asks for no more than it allows, in blends as on lines; what is slowed and put
/// back again is as fast as before.
#[test]
fn a_feed_override_holds_in_blends_too() {
    let program = "G64 P1\nG1 F1200 X20\nY20\nX0\nY0\n";
    let fastest_mm_s = |record: &MoveRecord| {
        let blend = record.blend.into_iter();
        let ends = blend.flat_map(|blend| {
            [blend.begin_s(), blend.end_s()].map(|t_s| (0..AXES).map(|axis| blend.speed_at(axis, t_s).powi(2)).sum())
        });
        let line = record.plan.profile.cruise_speed_steps_s();
        ends.map(f64::sqrt).fold(line, f64::max) / 50.0
    };
    let (_, outcome) = disturbed(program, 300, |sim| {
        sim.send(&[0x92; 5]);
        sim.run_until_idle().unwrap();
        assert_eq!(field(sim, "Ov"), "50,100,100");
    });
    let speeds: Vec<f64> = outcome.moves.iter().map(fastest_mm_s).collect();
    assert!(speeds[1..].iter().all(|mm_s| *mm_s < 10.0 + 1e-6), "{speeds:?}");
    assert!(speeds[1..].iter().all(|mm_s| *mm_s > 9.9), "{speeds:?}");
}

/// The count is exact wherever the reset comes, and the next program begins there.
#[test]
fn a_reset_in_a_blend_keeps_the_exact_count() {
    let [blends, lines] = all_over(|at_ms, sim| {
        sim.send(&[0x18]);
        sim.run_for(Duration::from_millis(1)).unwrap();
        at_rest(sim);
        let [x, y, z] = assert_stays(sim, at_ms);
        assert_eq!(sim.machine().state(), State::Idle, "at {at_ms} ms");
        sim.send(b"G91 G64 P0.5 G1 F1200 X2\nY2\n");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.counted_steps(), [x + 100, y + 100, z], "at {at_ms} ms");
    });
    assert!(blends > 8 && lines > 15, "{blends} in blends, {lines} on lines");
}

/// A second reset stops within a pulse, in a blend too, and the count is exact.
#[test]
fn a_second_reset_stops_a_blend_at_once() {
    let mut in_blends = 0;
    for at_ms in (100..LASTS_MS).step_by(4 * STRIDE_MS as usize) {
        let mut sim = powered_up(&Config::default());
        sim.send(PROGRAM.as_bytes());
        sim.run_for(Duration::from_millis(at_ms)).unwrap();
        sim.send(&[0x18]);
        sim.run_for(Duration::from_millis(20)).unwrap();
        let at_ns = sim.now_ns();
        sim.send(&[0x18]);
        sim.run_for(Duration::from_micros(20)).unwrap();
        assert_stays(&mut sim, at_ms);
        let outcome = sim.outcome();
        assert_eq!(outcome.counted_steps, outcome.position_steps, "at {at_ms} ms");
        let stopped = outcome.moves.last().unwrap();
        let in_blend = stopped.blend.is_some_and(|blend| (at_ns - stopped.start_ns) as f64 * 1e-9 < blend.end_s());
        in_blends += usize::from(in_blend && stopped.finish == Finish::Stopped);
    }
    assert!(in_blends > 1, "{in_blends}");
}

/// The byte of the door is a door that is opened and closed again at once.
#[test]
fn the_door_in_a_blend_holds_and_goes_on() {
    let [blends, lines] = all_over(|at_ms, sim| {
        sim.send(&[0x84]);
        sim.run_for(Duration::from_millis(1)).unwrap();
        sim.run_until_state(|state| state == State::Hold { still: true }).unwrap();
        assert_stays(sim, at_ms);
        assert_eq!(state(sim), "Door:0", "at {at_ms} ms");
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.counted_steps(), END_STEPS, "at {at_ms} ms");
    });
    assert!(blends > 8 && lines > 15, "{blends} in blends, {lines} on lines");
}

/// Three jogs across each other with this `$904`, cancelled at an instant, and at rest again. Returns when they were cancelled, too.
fn cancelled_jogs(deviation_mm: f64, at_ms: u64) -> (Sim, u64) {
    let mut sim = powered_up(&Config::default());
    let jogs = "G61\n$J=G91 X15 F2400\n$J=G91 Y15 F2400\n$J=G91 X-15 F2400\n";
    sim.send(format!("$904={deviation_mm}\n{jogs}").as_bytes());
    sim.run_for(Duration::from_millis(at_ms)).unwrap();
    let cancelled_ns = sim.now_ns();
    sim.send(&[0x85]);
    at_rest(&mut sim);
    (sim, cancelled_ns)
}

/// Jogs go round their corners within the limits, and a cancelled one stops, in a blend too; the machine knows where it stands.
#[test]
fn a_jog_cancel_keeps_the_limits_and_the_exact_count() {
    let (mut in_blends, mut on_lines) = (0, 0);
    for at_ms in (100..1_900).step_by(17) {
        let (mut sim, cancelled_ns) = cancelled_jogs(1.0, at_ms);
        let [x, y, z] = assert_stays(&mut sim, at_ms);
        let most = across::highest(&sim.outcome());
        assert!(most.is_none_or(|window| window.ratio < 1.02), "at {at_ms} ms: {most:?}");
        match under_way(&sim.outcome(), cancelled_ns) {
            Where::Blend => in_blends += 1,
            Where::Line => on_lines += 1,
            Where::Rest => {}
        }
        assert_eq!(say(&mut sim, "G64 G91 G1 F1200 X2\nY2\nX2").last_line(), "ok");
        assert_eq!(sim.counted_steps(), [x + 200, y + 100, z], "at {at_ms} ms");
    }
    assert!(in_blends > 2 && on_lines > 10, "{in_blends} in blends, {on_lines} on lines");
}

/// Cancelled at any instant, jogs come to rest as soon with blends as without.
#[test]
fn a_jog_cancel_waits_for_no_long_blend() {
    let longest_ms = |deviation_mm: f64| {
        let rest_ms = |at_ms| {
            let (sim, cancelled_ns) = cancelled_jogs(deviation_mm, at_ms);
            (sim.now_ns() - cancelled_ns) / 1_000_000
        };
        (100..1_300).step_by(14).map(rest_ms).max().unwrap()
    };
    let [without_ms, with_ms] = [0.0, 1.0].map(longest_ms);
    assert!(without_ms > 500 && with_ms <= without_ms + 5, "{with_ms} ms, without blends {without_ms} ms");
}

/// A pendant sends a jog before the last one ends: on along the line, back again, and across.
#[test]
fn jogs_that_follow_each_other_keep_the_limits() {
    let held = "$J=G91 X2 F3000\n".repeat(12);
    let reversed = "$J=G91 X2 F3000\n$J=G91 X-2 F3000\n".repeat(6);
    let crossed = "$J=G91 X2 F3000\n$J=G91 Y2 F3000\n".repeat(6);
    let small = "$J=G91 X0.1 F3000\n$J=G91 Y0.1 F3000\n$J=G91 X-0.1 Z0.02 F3000\n".repeat(20);
    let zv_40_hz = "$950=1\n$951=1\n$952=1\n$960=40\n$961=40\n$962=40\n";
    let cases = [("held", held, 0), ("reversed", reversed, 0), ("crossed", crossed, 8), ("small", small, 20)];
    for (before, (what, jogs, corners)) in
        ["", zv_40_hz].into_iter().flat_map(|before| cases.iter().map(move |case| (before, case)))
    {
        let mut sim = powered_up(&Config::default());
        sim.send(format!("{before}{jogs}").as_bytes());
        at_rest(&mut sim);
        let outcome = sim.outcome();
        for verdict in verify::verdicts(&outcome, &verify::moves(&outcome).collect()) {
            assert!(verdict.kept, "{what}: {} {}", verdict.promise, verdict.detail);
        }
        let most = across::highest(&outcome).unwrap();
        assert!(most.ratio < 1.02, "{what}: {most:?}");
        let blends = outcome.moves.iter().filter(|record| record.blend.is_some()).count();
        assert!(blends >= *corners, "{what}: {blends} blends");
    }
}
