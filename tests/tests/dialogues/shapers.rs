//! Shapers on the whole machine: what they make later, what they bend, and what they leave as it is.

use embassy_time::Duration;
use isostep_motion::{Axis, Shaping, State};
use isostep_sim::plate::Plate;
use isostep_sim::tool::ToolOutput;
use isostep_sim::{Config, Outcome, Sim, run};

use crate::talk::{powered_up, report, say};

/// Instants are whole ticks of 1 us.
const TICKS_S: f64 = 2e-6;

/// A fast machine with shapers of these kinds on X and Y, of 40 and 25 Hz.
fn machine(kinds: [u16; 2]) -> Config {
    let mut config = Config::default();
    let settings = &mut config.settings;
    settings.accel_mm_s2 = [1_000.0; 3];
    (settings.shaper_kind[0], settings.shaper_kind[1]) = (kinds[0], kinds[1]);
    (settings.shaper_hz[0], settings.shaper_hz[1]) = (40.0, 25.0);
    config
}

fn shaping(config: &Config) -> Shaping {
    isostep_controller::config(&config.settings).shaping().unwrap()
}

/// Sends a line, and stops some time after its run has begun.
fn under_way(config: &Config, line: &str, s: f64) -> Sim {
    let mut sim = powered_up(config);
    sim.send(format!("{line}\n").as_bytes());
    sim.run_until_state(|state| state == State::Run).unwrap();
    sim.run_for(Duration::from_micros((s * 1e6).round() as u64)).unwrap();
    sim
}

/// Every edge is where it is without shapers, to the nanosecond.
#[test]
fn homing_and_probing_are_not_shaped() {
    let edges = |kinds: [u16; 2]| {
        let mut sim = powered_up(&machine(kinds));
        sim.set_plate(Some(Plate { axis: Axis::Y, place_mm: 30.0, is_below: false }));
        assert_eq!(say(&mut sim, "$H"), ["ok"]);
        assert!(say(&mut sim, "G38.2 Y50 F300")[0].starts_with("[PRB:"));
        sim.outcome().edges
    };
    let unshaped = edges([0, 0]);
    assert!(unshaped.len() > 1_000 && edges([1, 4]) == unshaped);
}

/// The largest distance of the axes from the line from 0 to X20 Y10, mm: while the speed changes, and in the middle.
fn off_line_mm(outcome: &Outcome) -> [f64; 2] {
    let (first, last) = (outcome.edges.first().unwrap().t_ns, outcome.edges.last().unwrap().t_ns);
    let (mut at, mut off_mm) = ([0; 3], [0.0_f64; 2]);
    for edge in &outcome.edges {
        at[edge.axis] = edge.position_steps;
        let [x, y, _] = outcome.mm(at);
        let part = (edge.t_ns - first) as f64 / (last - first) as f64;
        let at = usize::from((0.4..0.6).contains(&part));
        off_mm[at] = off_mm[at].max((y - 0.5 * x).abs());
    }
    off_mm
}

/// Each axis is rounded to its half step, 0.01 mm.
#[test]
fn a_line_stays_straight_with_the_same_shaper_and_at_constant_speed_with_any() {
    let rounding_mm = 0.01 + 0.5 * 0.01 + 1e-9;
    let off_mm = |config: &Config| off_line_mm(&run(b"G1 X20 Y10 F2400\n", config).unwrap());
    for kind in 1..=5 {
        let mut same = machine([kind, kind]);
        same.settings.shaper_hz = [25.0; 3];
        let [changing, even] = off_mm(&same);
        assert!(changing < rounding_mm && even < rounding_mm, "kind {kind}: {changing} and {even} mm");
    }
    let [changing, even] = off_mm(&machine([1, 4]));
    assert!(even < rounding_mm, "{even} mm");
    assert!(changing > 2.0 * rounding_mm, "{changing} mm: different shapers bend it");
}

/// The feed is that of the place on the path, to which the axes come later by the mean delay.
#[test]
fn the_reported_feed_is_late_by_the_delay() {
    let feed = |config: &Config, s: f64| {
        let report = report(&mut under_way(config, "G1 X20 Y10 F2400", s));
        let fields = report.split("FS:").nth(1).unwrap();
        fields.split(',').next().unwrap().parse::<f64>().unwrap()
    };
    let (shaped, plain) = (machine([1, 4]), machine([0, 0]));
    let delay_s = shaping(&shaped).delay_s;
    for s in [0.01, 0.02, 0.03, 0.1] {
        let [early, late] = [feed(&plain, s), feed(&shaped, s + delay_s)];
        // A microsecond of 1,118 mm/s2 along the path.
        assert!((early - late).abs() < 1.1, "after {s} s {early} mm/min, {late} with shapers");
    }
    assert!(feed(&shaped, 0.02) < 0.5 * feed(&plain, 0.02));
}

/// Levels change later by the mean delay, so they stay at their places. The run and its enable output end later by the length of the shaper.
#[test]
fn a_laser_is_late_by_the_delay() {
    let changes = |kinds: [u16; 2]| {
        let outcome = run(b"$32=1\nM3 S500\nG1 X5 F1200\nX10 S1000\nM5\n", &machine(kinds)).unwrap();
        let start_ns = outcome.moves[0].start_ns;
        let levels = outcome.tool.iter().filter(|change| change.t_ns >= start_ns);
        levels.map(|change| (change.t_ns - start_ns, change.output, change.duty)).collect::<Vec<_>>()
    };
    let (plain, shaped) = (changes([0, 0]), changes([1, 4]));
    let Shaping { delay_s, lasts_s, .. } = shaping(&machine([1, 4]));
    assert_eq!((plain.len(), shaped.len()), (4, 4));
    for (early, late) in plain.iter().zip(&shaped) {
        let by_s = if early.1 == ToolOutput::Pwm { delay_s } else { lasts_s };
        let off_s = (late.0 - early.0) as f64 * 1e-9 - by_s;
        assert!(off_s.abs() < TICKS_S, "{early:?}, {late:?}: {off_s} s");
        assert_eq!((early.1, early.2), (late.1, late.2));
    }
}

/// The machine brakes as it does without shapers, and stands when the last impulse has passed.
#[test]
fn a_hold_ends_later_by_the_length_of_the_shaper() {
    let held_s = |config: &Config| {
        let mut sim = under_way(config, "G1 X20 Y10 F2400", 0.15);
        let asked_ns = sim.now_ns();
        sim.send(b"!");
        sim.run_until_state(|state| state == State::Hold { still: true }).unwrap();
        (sim.now_ns() - asked_ns) as f64 * 1e-9
    };
    let (shaped, plain) = (machine([1, 4]), machine([0, 0]));
    let off_s = held_s(&shaped) - held_s(&plain) - shaping(&shaped).lasts_s;
    assert!(off_s.abs() < TICKS_S, "{off_s} s");
}

/// At 50 mm/s2 it speeds up for four chunks of 15 ms, as long as is committed at first, and slows down for as many.
#[test]
fn a_move_whose_phases_end_with_chunks_is_made() {
    let mut config = machine([1, 0]);
    config.settings.accel_mm_s2 = [50.0; 3];
    config.start_mm = [50.0; 3];
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "G91 G0 Z-0.18"), ["ok"]);
    assert_eq!(sim.counted_steps(), [0, 0, -9]);
}
