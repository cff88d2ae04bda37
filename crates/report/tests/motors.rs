//! Motors on machines that people have: what they do, they do here, and what they cannot do is reported with its line and
//! what to set.

use embassy_time::Duration;
use isostep_motion::DriverTiming;
use isostep_report::Figures;
use isostep_sim::drive::{Drive, Load, MotorData};
use isostep_sim::{Config, Outcome, Port, Sim, State, run, settings};

/// The lines of settings of a machine that homes nothing and may go anywhere.
fn machine(lines: &str) -> Config {
    let text = format!("$20=0\n$21=0\n$22=0\n$130=1000\n$131=1000\n$132=1000\n{lines}");
    let settings = settings::read("my.txt", text.as_bytes(), Port::Pio, DriverTiming::TMC2209).unwrap();
    Config { settings, driver: DriverTiming::TMC2209, start_mm: [300.0; 3], ..Config::default() }
}

/// The settings that set `$100`, `$110` and `$120` of all axes.
fn axes(steps_per_mm: f64, max_mm_min: f64, accel_mm_s2: f64) -> String {
    let axis = |axis: usize| format!("$10{axis}={steps_per_mm}\n$11{axis}={max_mm_min}\n$12{axis}={accel_mm_s2}\n");
    (0..3).map(axis).collect()
}

fn broken(program: &str, outcome: &Outcome) -> Vec<String> {
    Figures::new(program, outcome).broken().map(|verdict| format!("{}: {}", verdict.promise, verdict.detail)).collect()
}

#[test]
fn a_lone_short_move_loses_nothing() {
    for (steps_per_mm, max_mm_min, accel_mm_s2) in [
        (80.0, 3_000.0, 1_000.0),
        (80.0, 6_000.0, 3_000.0),
        (40.0, 6_000.0, 1_500.0),
        (25.0, 5_000.0, 1_000.0),
        (20.0, 6_000.0, 1_000.0),
    ] {
        let config = machine(&axes(steps_per_mm, max_mm_min, accel_mm_s2));
        for program in ["G0 X20\n", "G0 X0.1\n", "G91\nG0 X1\nX-1\nX3 Y-2\n"] {
            let outcome = run(program.as_bytes(), &config).unwrap();
            assert_eq!(broken(program, &outcome), [""; 0], "{program} at {steps_per_mm}/{max_mm_min}/{accel_mm_s2}");
        }
    }
}

/// 2,000 mm/min and 50 mm/s² on a screw: at `$11=0.01`, without blends, a corner lets the speed of an axis jump by 2 mm/s.
#[test]
fn a_leadscrew_takes_jumps_of_2_mm_s() {
    let config = machine(&format!("$11=0.01\n$904=0\n{}", axes(800.0, 2_000.0, 50.0)));
    let program = format!("G91 G1 F2000\n{}X-40 Y40\nY-80\nX-8\nG0 Z3\nX20\n", "X20 Y13.5\nX20 Y16.5\n".repeat(4));
    let outcome = run(program.as_bytes(), &config).unwrap();
    assert_eq!(broken("screw", &outcome), [""; 0]);
    let jump = Figures::new("screw", &outcome)
        .axes
        .iter()
        .filter_map(|axis| axis.jump.as_ref()?.mm_s.into())
        .fold(0.0, f64::max);
    assert!(jump > 1.75, "the test's own jump, {jump} mm/s");
}

/// The losses in a run of `program`, as the report tells them.
fn lost(program: &str, config: &Config) -> Vec<String> {
    let outcome = run(program.as_bytes(), config).unwrap();
    Figures::new("test", &outcome).losses.iter().map(ToString::to_string).collect()
}

/// Each true problem is found, with the line and what to set. With that set, nothing is lost.
#[test]
fn what_is_too_much_is_found_and_what_is_reported_mends_it() {
    let back = "G91 G0 X1\nX0.5\nG0 X200\n";
    let corner = "G91 G1 F9000\nX100\nY100\n";
    // Here the motor takes each corner by itself. It swings from one to the next.
    let zigzag = |x: f64, y: f64| format!("G91 G1 F12000\n{}", format!("X{x} Y{y}\nX{x} Y-{y}\n").repeat(100));
    let (fine, flat) = (zigzag(0.05, 0.05), zigzag(0.2, 0.02));
    for (settings, program, line, reported) in [
        (axes(80.0, 9_000.0, 40_000.0), back, 1, "$120 to "),
        (axes(80.0, 9_000.0, 1_000.0) + "$920=40000\n", "G91 G0 X100\nX50\n", 2, "$920 to "),
        (axes(20.0, 18_000.0, 1_000.0) + "$910=15000\n", back, 1, "$910 to "),
        (axes(80.0, 60_000.0, 3_000.0), "G91\nG0 X600\n", 2, "$110 to "),
        (axes(80.0, 9_000.0, 8_000.0) + "$11=2\n$904=0\n", corner, 3, "$11 to "),
        (axes(400.0, 3_000.0, 3_000.0) + "$11=0.01\n$904=0\n", &fine, 5, "$11 to 0.0025 mm or less"),
        (axes(400.0, 6_000.0, 2_600.0) + "$11=0.01\n$904=0\n", &flat, 11, "$120 to 1300 mm/s2 or less"),
    ] {
        let found = lost(program, &machine(&settings));
        let first = found.first().unwrap_or_else(|| panic!("nothing is lost: {settings}{program}"));
        assert!(
            first.contains(&format!(": line {line}, move ")) && first.contains(&format!("set {reported}")),
            "{first}"
        );
        // "set $110 to 2400 mm/min, and $120 to 1700 mm/s2 or less"
        let words: Vec<_> = first.split_once(": set ").unwrap().1.split([' ', ',']).collect();
        let set = words.windows(3).filter(|words| words[1] == "to").map(|words| {
            let axis_settings = if words[0] == "$11" { 1 } else { 3 };
            let number: u32 = words[0][1..].parse().unwrap();
            (0..axis_settings).map(|axis| format!("${}={}\n", number + axis, words[2])).collect::<String>()
        });
        let mended = settings.clone() + &set.collect::<String>();
        assert_eq!(lost(program, &machine(&mended)), [""; 0], "{first}");
    }
}

/// Homing stops at once at the switch, and the motor slips when it comes back. With what is reported it homes.
#[test]
fn a_seek_that_stops_too_fast_is_reported_with_the_speed_of_the_seek() {
    for (steps_per_mm, seek_mm_min, reported) in [
        (
            400.0,
            3_000,
            "homing stops it at its switch at once, from 50 mm/s, and the motor takes 36: set $25 to 1000 mm/min or less, or give it room behind the switch ($906)",
        ),
        (
            80.0,
            7_200,
            "homing stops it at its switch at once, from 120 mm/s, and the motor takes 93: set $25 to 2700 mm/min or less, or give it room behind the switch ($906)",
        ),
    ] {
        let settings = axes(steps_per_mm, f64::from(seek_mm_min), 3_000.0) + "$20=1\n$22=1\n$24=60\n";
        let with_seek = |mm_min: &str| Config { start_mm: [30.0; 3], ..machine(&format!("{settings}$25={mm_min}\n")) };
        let found = lost("$H\nG0 X5\n", &with_seek(&seek_mm_min.to_string()));
        assert!(found.first().is_some_and(|first| first.ends_with(reported)), "{reported} in {found:?}");
        let set = reported.split_once("$25 to ").unwrap().1.split_once(' ').unwrap().0;
        let outcome = run(b"$H\nG0 X5\n", &with_seek(set)).unwrap();
        assert_eq!((broken("homed", &outcome), outcome.alarm_code), (vec![], None), "{reported}");
    }
}

/// A second reset stops at once: at 150 mm/s 2 kg go on, at 50 mm/s they do not.
#[test]
fn an_abrupt_stop_overshoots_by_whole_periods_if_it_is_fast() {
    for (mm_min, is_lost) in [(9_000, true), (3_000, false)] {
        let mut sim = Sim::new(&machine(&axes(80.0, 9_000.0, 1_000.0)));
        sim.send(format!("G1 X200 F{mm_min}\n").as_bytes());
        sim.run_for(Duration::from_millis(1_000)).unwrap();
        sim.send(&[0x18]);
        sim.run_for(Duration::from_millis(1)).unwrap();
        sim.send(&[0x18]);
        sim.run_for(Duration::from_millis(500)).unwrap();
        let outcome = sim.outcome();
        assert!(matches!(outcome.state, State::Alarm(_)), "{:?}", outcome.state);
        let drift_steps = outcome.drift_steps[0];
        assert_eq!((drift_steps > 0, drift_steps % 64), (is_lost, 0), "{drift_steps} at {mm_min} mm/min");
        let reported = Figures::new("test", &outcome).losses.iter().map(ToString::to_string).collect::<String>();
        assert_eq!(reported.contains("an abrupt stop loses nothing up to 93 mm/s"), is_lost, "{reported}");
    }
}

/// The table of the page is that of the closed forms.
#[test]
fn the_page_has_the_margins() {
    let page = include_str!("../../../docs/motors.md");
    let rows = [20.0, 25.0, 40.0, 50.0, 80.0, 160.0, 400.0, 800.0].map(|steps_per_mm| {
        let drive = Drive::new(MotorData::NEMA_17, Load::preset(steps_per_mm, 30.0), steps_per_mm);
        format!(
            "| {steps_per_mm} | 1/{} | {} | {:.1} | {:.0} | {:.0} | {:.0} | {:.0} |\n",
            drive.microsteps(),
            drive.mm_per_rev(),
            drive.inertia_kg_m2() * 1e7,
            drive.jump_mm_s(),
            drive.accel_mm_s2(0.0),
            drive.top_mm_s(),
            drive.gone_mm_s(),
        )
    });
    assert!(page.contains(&rows.concat()), "{}", rows.concat());
}
