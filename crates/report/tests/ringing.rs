//! Loads on springs, against the physics of a smooth move and an integration in small steps.

use std::f64::consts::TAU;

use isostep_console::Settings;
use isostep_report::Figures;
use isostep_report::again;
use isostep_report::ringing::{residual, swings};
use isostep_sim::analysis::Oscillator;
use isostep_sim::springs::Springs;
use isostep_sim::{AXES, Axis, Config, Outcome, run};

const STEPS_PER_MM: f32 = 80.0;

/// 200 mm/s and 2,000 mm/s2 on every axis.
fn machine(steps_per_mm: f32) -> Config {
    let settings = Settings {
        steps_per_mm: [steps_per_mm; AXES],
        max_rate_mm_min: [12_000.0; AXES],
        accel_mm_s2: [2_000.0; AXES],
        decel_or_0_mm_s2: [0.0; AXES],
        soft_limits: false,
        ..Settings::DEFAULT
    };
    Config { settings, ..Config::default() }
}

fn outcome(steps_per_mm: f32, program: &str) -> Outcome {
    run(program.as_bytes(), &machine(steps_per_mm)).unwrap()
}

fn spring(natural_hz: f64, damping_ratio: f64) -> Oscillator {
    Oscillator::new(natural_hz, damping_ratio).unwrap()
}

fn after_stop_mm(outcome: &Outcome, oscillator: Oscillator) -> f64 {
    residual(outcome, Axis::X, oscillator).after_stops.unwrap().0
}

/// Without damping, a ramp of T leaves 2 a/w2 |sin(w T/2)|, and a second one S after it began adds by its phase: the
/// trapezoid leaves twice |sin(w S/2)| of that.
fn trapezoid_mm(accel_mm_s2: f64, ramp_s: f64, apart_s: f64, natural_hz: f64) -> f64 {
    let w = TAU * natural_hz;
    4.0 * accel_mm_s2 / (w * w) * ((w * ramp_s / 2.0).sin() * (w * apart_s / 2.0).sin()).abs()
}

/// What the edges leave is what the plan leaves, but for what the steps add: the finer they are, the less.
#[test]
fn a_trapezoid_leaves_what_its_closed_form_says_within_a_fraction_of_a_step() {
    for (feed_mm_min, distance_mm) in [(6_000.0, 17.0), (9_000.0, 31.0), (12_000.0, 60.0)] {
        let (speed_mm_s, program) = (feed_mm_min / 60.0, format!("G91 G1 F{feed_mm_min} X{distance_mm}\n"));
        let (ramp_s, apart_s) = (speed_mm_s / 2_000.0, distance_mm / speed_mm_s);
        for steps_per_mm in [80.0, 800.0] {
            let outcome = outcome(steps_per_mm, &program);
            let step_mm = 1.0 / f64::from(steps_per_mm);
            for natural_hz in [22.0, 34.0, 45.0] {
                let found_mm = after_stop_mm(&outcome, spring(natural_hz, 0.0));
                let expected_mm = trapezoid_mm(2_000.0, ramp_s, apart_s, natural_hz);
                let off = (found_mm - expected_mm).abs() / step_mm;
                assert!(off < 0.5, "{natural_hz} Hz, F{feed_mm_min}: {found_mm} for {expected_mm}, {off} steps off");
            }
        }
    }
}

/// 0.1 s are four periods of 40 Hz, and four and a half of 45 Hz.
#[test]
fn a_ramp_of_whole_periods_leaves_nothing_but_steps() {
    let outcome = outcome(STEPS_PER_MM, "G91 G1 F12000 X60\n");
    let [whole, half] = [40.0, 45.0].map(|natural_hz| after_stop_mm(&outcome, spring(natural_hz, 0.0)));
    assert!(whole < 0.5 / f64::from(STEPS_PER_MM), "{whole} mm");
    assert!(half > 10.0 * whole, "{half} beside {whole} mm");
}

/// The load in space, y, obeys y'' = w2 (u - y) - 2 z w y' while its axis rests at u, and an edge pushes it by its
/// damper. Integrated by Runge-Kutta in steps of 20 us at most.
#[test]
fn the_closed_form_is_what_small_steps_integrate() {
    let outcome = outcome(STEPS_PER_MM, "G91 G1 F6000 X6 Y2\nX-3 Y4\n");
    let (hz, ratio) = (35.0, 0.07);
    let (w, step_mm) = (TAU * hz, 1.0 / f64::from(STEPS_PER_MM));
    let (mut foot, mut y, mut v) = (0.0, 0.0, 0.0);
    for swing in swings(&outcome, Axis::X, spring(hz, ratio)) {
        let direction = outcome.edges.iter().find(|edge| edge.axis == 0 && edge.t_ns as f64 * 1e-9 == swing.begin_s);
        let direction = f64::from(direction.unwrap().direction);
        foot += direction * step_mm;
        v += 2.0 * ratio * w * direction * step_mm;
        let count = ((swing.end_s - swing.begin_s) / 20e-6).ceil().clamp(1.0, 5_000.0);
        let h = ((swing.end_s - swing.begin_s) / count).min(20e-6);
        let change = |y: f64, v: f64| (v, w * w * (foot - y) - 2.0 * ratio * w * v);
        for _ in 0..count as u32 {
            let (a, b) = change(y, v);
            let (c, d) = change(y + h / 2.0 * a, v + h / 2.0 * b);
            let (e, f) = change(y + h / 2.0 * c, v + h / 2.0 * d);
            let (g, i) = change(y + h * e, v + h * f);
            y += h / 6.0 * (a + 2.0 * c + 2.0 * e + g);
            v += h / 6.0 * (b + 2.0 * d + 2.0 * f + i);
        }
        let middle_s = swing.begin_s + count * h * (1.0 - 1e-9);
        let found = swing.deviation(middle_s);
        assert!((found - (y - foot)).abs() < 1e-6, "at {middle_s} s: {found} for {}", y - foot);
    }
    assert!((foot - 3.0).abs() < 1e-9);
}

/// A corner is known by its jump, and a stop by the end of what flows.
#[test]
fn stops_and_corners_are_told_apart_with_their_lines() {
    let springs: Springs = "X:40:0.05,Y:40:0.05".parse().unwrap();
    let reported = |program: &str| {
        let outcome = run(program.as_bytes(), &Config { springs, ..machine(STEPS_PER_MM) }).unwrap();
        Figures::new("test", &outcome).ringing
    };
    let [x, y] = &reported("G61 G91 G1 F6000\nX10\nX20\nY30\n")[..] else { panic!("two springs") };
    assert_eq!((x.axis.as_str(), y.axis.as_str()), ("X", "Y"));
    for one in [x, y] {
        let corner = one.after_corners.unwrap();
        assert_eq!((corner.move_number, corner.line), (3, Some(4)), "{one:?}");
        assert!(corner.mm > 0.02 && one.anywhere_mm >= corner.mm, "{one:?}");
    }
    assert_eq!(y.after_stops.unwrap().line, Some(4));
    // Each move ends at rest.
    let [x, y] = &reported("G61.1 G91 G1 F6000\nX10\nX20\nY30\n")[..] else { panic!("two springs") };
    assert_eq!((x.after_corners, y.after_corners), (None, None));
    assert!(x.after_stops.unwrap().mm > 0.01 && x.after_stops.unwrap().line < Some(4), "{x:?}");
    // A straight chain has no corner.
    let [x, _] = &reported("G61 G91 G1 F6000\nX10\nX20\n")[..] else { panic!("two springs") };
    assert_eq!((x.after_corners, x.after_stops.unwrap().line), (None, Some(3)));
}

/// Homing strikes the switches at speed, but is none of the program's.
#[test]
fn homing_is_not_reported() {
    let springs: Springs = "X:8:0.05".parse().unwrap();
    let outcome = run(b"$H\nG4 P5\nG0 Y10\n", &Config { springs, ..Config::default() }).unwrap();
    let [x] = &Figures::new("test", &outcome).ringing[..] else { panic!("one spring") };
    assert!(x.after_stops.unwrap().mm < 1e-4 && x.anywhere_mm == 0.0, "{x:?}");
}

/// A load changes nothing that is reported of the run, and two runs tell the same of it.
#[test]
fn a_spring_changes_no_edge_and_the_same_run_tells_the_same() {
    let program = b"G91 G1 F6000 X10 Y5\nX-4\n";
    let (rigid, sprung) = (machine(STEPS_PER_MM), "X:40:0.05,Y:35:0.05".parse().unwrap());
    let reported = |springs: Springs| {
        let outcome = run(program, &Config { springs, ..rigid.clone() }).unwrap();
        let figures = serde_json::to_value(Figures::new("test", &outcome)).unwrap();
        (outcome.edges, figures)
    };
    let ((edges, mut figures), again) = (reported(sprung), reported(sprung));
    assert_eq!((&edges, &figures), (&again.0, &again.1));
    let (rigid_edges, rigid_figures) = reported(Springs::default());
    let object = figures.as_object_mut().unwrap();
    assert_eq!(object.remove("ringing").unwrap().as_array().unwrap().len(), 2);
    object.insert("replay".to_owned(), rigid_figures["replay"].clone());
    assert_eq!((edges, figures), (rigid_edges, rigid_figures));
}

#[test]
fn a_spring_that_cannot_be_is_refused_with_what_to_give() {
    for (text, words) in [
        ("X40", "such as X:40:0.05"),
        ("", "such as X:40:0.05"),
        ("Q:40:0.05", "`Q` is no axis: use X, Y"),
        ("X:0:0.05", "X: natural frequency 0 Hz is outside 0.5 to 1000 Hz: machines have some 5 to 100"),
        ("X:NaN:0.05", "natural frequency NaN Hz is outside"),
        ("y:40:1", "Y: damping ratio 1 is outside 0 to below 1"),
        ("X:40:much", "damping ratio `much` is no number: give one such as 0.05"),
        ("X:40:0.05,Y:9:0.1,x:30:0.05", "X has two springs: give each axis one at most"),
    ] {
        let error = text.parse::<Springs>().unwrap_err();
        assert!(error.contains(words), "{text}: {error}");
    }
    assert_eq!("y:35:0.05, X:40:0.1".parse::<Springs>().unwrap().to_string(), "X:40:0.1,Y:35:0.05");
}

/// Behind a corner onto X the load of Y swings freely, so a pen draws waves of the length v/f.
#[test]
fn what_a_pen_draws_behind_a_corner_is_the_frequency_of_the_load() {
    let program = include_bytes!("../../../programs/ringing.nc");
    // Steps fine enough to measure a wave by.
    let steps_per_mm = 10.0 * STEPS_PER_MM;
    let outcome = run(program, &machine(steps_per_mm)).unwrap();
    let oscillator = spring(35.0, 0.05);
    let along_x: Vec<_> =
        outcome.moves.iter().filter(|record| record.plan.steps[1] == 0 && record.plan.steps[0] > 0).collect();
    assert_eq!(along_x.len(), 3);
    for (record, mm_s) in along_x.into_iter().zip([20.0, 50.0, 100.0]) {
        let begin_s = record.start_ns as f64 * 1e-9 + record.plan.begin_s();
        let swing = swings(&outcome, Axis::Y, oscillator)
            .find(|swing| swing.begin_s <= begin_s + 0.05 && swing.end_s >= begin_s + 0.2)
            .expect("Y stands still");
        let sample_s = |index: u32| begin_s + 0.05 + f64::from(index) * 1e-5;
        let crossings_s: Vec<_> = (1..12_000)
            .filter(|&index| swing.deviation(sample_s(index - 1)) < 0.0 && swing.deviation(sample_s(index)) >= 0.0)
            .map(sample_s)
            .collect();
        let [first_s, .., last_s] = crossings_s[..] else { panic!("no waves: {crossings_s:?}") };
        // How far the pen went meanwhile, by the edges of X.
        let is_between = |t_ns: u64| (first_s..last_s).contains(&(t_ns as f64 * 1e-9));
        let steps = outcome.edges.iter().filter(|edge| edge.axis == Axis::X as usize && is_between(edge.t_ns)).count();
        let waves_mm = steps as f64 / f64::from(steps_per_mm);
        let found_hz = (crossings_s.len() - 1) as f64 * mm_s / waves_mm;
        assert!((found_hz - 35.0).abs() < 0.2, "{found_hz} Hz at {mm_s} mm/s");
    }
}

/// The rest after a move along X whose shaper is for a load of 30 Hz with this damping, of this kind; of a load at another
/// frequency too. Steps are so fine that they do not hide it.
fn shaped_mm(kind: u16, damping_ratio: f64, program: &str, natural_hz: f64) -> f64 {
    let mut config = machine(10.0 * STEPS_PER_MM);
    config.settings.shaper_kind[0] = kind;
    config.settings.shaper_hz[0] = 30.0;
    config.settings.shaper_damping_ratio[0] = damping_ratio as f32;
    after_stop_mm(&run(program.as_bytes(), &config).unwrap(), spring(natural_hz, damping_ratio))
}

/// At their own frequency ZV, MZV and ZVD leave nothing but what the steps add. EI leaves a twentieth there, and no more some
/// way beside it, where ZV leaves far more.
#[test]
fn shapers_leave_little_of_the_ringing() {
    let tenth_of_a_step_mm = 0.1 / f64::from(10.0 * STEPS_PER_MM);
    for program in ["G91 G1 F6000 X17\n", "G91 G1 F9000 X31\n", "G61 G91 G1 F3000 X10\nY5\nX-7 Y4\n"] {
        for damping_ratio in [0.0, 0.05, 0.1] {
            let mm = |kind: u16, natural_hz: f64| shaped_mm(kind, damping_ratio, program, natural_hz);
            let unshaped_mm = mm(0, 30.0);
            assert!(unshaped_mm > 0.05, "{program:?}, {damping_ratio}: {unshaped_mm} mm");
            for kind in 1..=3 {
                let left_mm = mm(kind, 30.0);
                assert!(left_mm < tenth_of_a_step_mm, "kind {kind}, {program:?}, {damping_ratio}: {left_mm} mm");
            }
            for beside in [-0.15, 0.0, 0.15] {
                let natural_hz = 30.0 * (1.0 + beside);
                let [unshaped_mm, zv_mm, left_mm] = [0, 1, 4].map(|kind| mm(kind, natural_hz));
                let most_mm = 0.05 * unshaped_mm + tenth_of_a_step_mm;
                assert!(
                    left_mm < most_mm,
                    "{natural_hz} Hz, {program:?}, {damping_ratio}: {left_mm} of {unshaped_mm} mm"
                );
                assert!(beside == 0.0 || zv_mm > 0.15 * unshaped_mm, "{natural_hz} Hz: ZV {zv_mm} of {unshaped_mm} mm");
            }
        }
    }
}

/// A program with shapers is run without them for comparison, whether its settings or its lines ask for them; any other is not.
#[test]
fn what_rings_without_shapers_is_found_by_another_run() {
    let springs: Springs = "X:40:0.05".parse().unwrap();
    let made = |kind: u16, program: &str| {
        let mut config = Config { springs, ..machine(STEPS_PER_MM) };
        config.settings.shaper_kind[0] = kind;
        run(program.as_bytes(), &config).unwrap()
    };
    let plain = made(0, "G1 X10 F6000\n");
    assert!(again::unshaped(&plain).is_none());
    for (kind, program) in [(1, "G1 X10 F6000\n"), (0, "$950=4 ; EI\nG1 X10 F6000\n")] {
        let (lines, config) = again::unshaped(&made(kind, program)).unwrap();
        let other = run(&lines.join(&b'\n'), &config).unwrap();
        assert_eq!(other.edges, plain.edges, "{program:?}");
    }
    let rigid = run(b"$950=1\nG1 X10 F6000\n", &machine(STEPS_PER_MM)).unwrap();
    assert!(again::unshaped(&rigid).is_none(), "nothing rings");
}
