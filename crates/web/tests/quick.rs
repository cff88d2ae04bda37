//! A program that is run for its time alone takes as long as one that is run whole, and its departures are those of its path.

use isostep_report::ringing::figures;
use isostep_sim::analysis::Oscillator;
use isostep_sim::springs::Springs;
use isostep_sim::{Config, lines_of_moves, run};
use isostep_web::{About, Found, Job, Kept, Quick, ringing};
use serde_json::Value;

const PARKING: &[u8] = include_bytes!("../../../programs/parking.nc");
const ENGRAVING: &[u8] = include_bytes!("../../../programs/engraving.nc");
const ARCS: &[u8] = include_bytes!("../../../programs/arcs.nc");
/// Nothing homes, so that no edges are made: lines, a corner, a dwell, a pause.
const PLAIN: &[u8] = b"G21 G91\nG1 X30 Y7 F2400\nM0\nY12\nG4 P0.1\nX-5\n";

fn quick(program: &[u8], settings: &str) -> Found {
    let mut quick = Quick::new(program, settings).unwrap();
    let mut until_us = 0.0;
    while !quick.advance(until_us).unwrap() {
        until_us += 1e5;
    }
    assert_eq!(quick.answered(), quick.lines());
    quick.end().unwrap()
}

/// As the page says it of a whole run.
fn whole_s(program: &[u8], settings: &str) -> f64 {
    let mut job = Job::new(program, settings, Kept::Nothing).unwrap();
    while !job.advance(job.now_us() + 1e6).unwrap() {}
    let summary: Value = serde_json::from_str(&job.end().unwrap().summary).unwrap();
    summary["duration_s"].as_f64().unwrap() - summary["homing_s"].as_f64().unwrap()
}

#[test]
fn it_takes_as_long_as_the_whole_run() {
    for (name, program) in [("parking", PARKING), ("engraving", ENGRAVING), ("arcs", ARCS), ("plain", PLAIN)] {
        for settings in [
            "",
            "$120=500\n$121=400\n",
            "$904=0\n",
            "$940=1\n$930=900\n",
            "$950=2\n$951=1\n",
            "$907=1\n",
            "$907=1\n$950=2\n",
        ] {
            let found = quick(program, settings);
            assert_eq!(found.stopped, None, "{name}, {settings}");
            let expected_s = whole_s(program, settings);
            assert!((found.program_s - expected_s).abs() < 5e-4, "{name}, {settings}: {found:?}, whole {expected_s} s");
        }
    }
}

#[test]
fn what_does_not_come_to_its_end_says_why() {
    let refused = Quick::new(b"G21\n", "$100=50\n$110=-1\n").err().unwrap();
    assert_eq!((refused.about, refused.line), (About::Settings, Some(2)));
    let mut quick = Quick::new(b"G21 G91\nG1 X1 F600\nG42\nX5\n", "").unwrap();
    while !quick.advance(1e8).unwrap() {}
    let stopped = quick.end().unwrap().stopped.unwrap();
    assert!(stopped.starts_with("line 3 `G42` was refused: error:20 "), "{stopped}");
}

#[test]
fn corners_are_left_by_what_the_setting_says() {
    let corner = b"G21 G91\nG1 X10 F2400\nY10\n";
    for deviation_mm in [0.05, 0.1] {
        for belts in ["", "$907=1\n"] {
            let found = quick(corner, &format!("$904={deviation_mm}\n{belts}")).departures;
            let corners_mm = found.corners_mm.unwrap();
            assert!((corners_mm - deviation_mm).abs() < 1e-6, "{corners_mm} for {deviation_mm}");
            assert_eq!((found.together_mm, found.shaped_mm), (None, None));
        }
    }
    assert_eq!(quick(corner, "$904=0\n").departures.corners_mm, None);
    let (half, other_half) = ("G2 X10 Y10 I5 J5", "G1 Y10");
    let arc = quick(format!("G21 G91 F1200\n{half}\n").as_bytes(), "").departures;
    assert_eq!(arc.corners_mm, None, "the sides of an arc have no corners");
    let behind = quick(format!("G21 G91 F2400\n{half}\n{other_half}\n").as_bytes(), "").departures;
    assert!((behind.corners_mm.unwrap() - 0.01).abs() < 1e-3, "{behind:?}");
    let shaped = quick(corner, "$904=0\n$11=0.2\n$950=1\n$951=1\n").departures;
    assert!(shaped.shaped_mm.unwrap() > 0.01, "{shaped:?}");
    let chords: String = (0..400).map(|_| "G1 X0.01 Y0.0001\n").collect();
    let together = quick(format!("G21 G91 F1200\n{chords}").as_bytes(), "").departures;
    assert!((0.0..=0.005 + 0.02).contains(&together.together_mm.unwrap()), "{together:?}");
}

#[test]
fn loads_swing_as_the_figures_of_a_run_with_springs_say() {
    let load = Oscillator::new(40.0, 0.05).unwrap();
    let mut config = Config::default();
    (config.springs.0[0], config.springs.0[1]) = (Some(load), Some(load));
    let Springs(springs) = config.springs;
    assert_eq!(springs.iter().flatten().count(), 2);
    let outcome = run(PLAIN, &config).unwrap();
    let figures = figures(&outcome, &lines_of_moves::of_moves(&outcome));
    let found = ringing::swings(PLAIN, "", 40.0, 0.05).unwrap();
    let most = |of: fn(&isostep_report::ringing::RingingFigures) -> Option<f64>| {
        figures.iter().filter_map(of).reduce(f64::max)
    };
    assert_eq!(found.after_stops_mm, most(|axis| axis.after_stops.map(|swing| swing.mm)));
    assert_eq!(found.after_corners_mm, most(|axis| axis.after_corners.map(|swing| swing.mm)));
    assert!(found.after_stops_mm.unwrap() > 1e-4, "{found:?}");
    let too_long = ringing::swings(&b"G1 X1 F600\n".repeat(50_001), "", 40.0, 0.05).unwrap_err();
    assert!(too_long.words.contains("50001"), "{too_long}");
    assert!(ringing::swings(PLAIN, "", 0.0, 0.05).unwrap_err().words.contains("0 Hz"));
}
