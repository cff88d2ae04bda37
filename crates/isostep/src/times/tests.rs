//! Tests the verb as a user runs it, without the shell.

use std::fs;

use clap::Parser;
use isostep_controller::least_times::RP2040;

use super::ratios::Times;
use super::*;

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: Args,
}

/// A folder for one test, with two programs, a machine and a table.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, table: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("isostep-times-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("slow.nc"), "G21 G90 G94\nG1 X10 F600\n").unwrap();
        fs::write(folder.join("bad.nc"), "G21 G90\nG1 X1 F600\nG41\n").unwrap();
        fs::write(
            folder.join("mill.txt"),
            "$22=0\n$110=12000\n$111=12000\n$112=12000\n$120=1000\n$121=1000\n$122=1000\n",
        )
        .unwrap();
        fs::write(folder.join("table.csv"), table).unwrap();
        Self(folder)
    }

    fn args(&self, more: &[&str]) -> Args {
        let path = |name: &str| self.0.join(name).display().to_string();
        let words = ["times".to_owned(), self.0.display().to_string(), path("table.csv")];
        let machine = format!("--machine=MILL={}", path("mill.txt"));
        let words = words.into_iter().chain([machine]).chain(more.iter().map(|word| (*word).to_owned()));
        Cli::try_parse_from(words).unwrap_or_else(|error| panic!("{error}")).args
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn programs_are_timed_beside_the_table() {
    let folder = Folder::new("timed", "program,moves,MILL_s,MILL_max_feed_s\nslow.nc,1,1.01,0.2\n");
    let out = folder.0.join("times.json");
    let args = folder.args(&["--json", out.to_str().unwrap(), "--jobs", "1"]);
    let report = report(&args).unwrap();
    // 10 mm at 10 mm/s and 1,000 mm/s2 take 1.01 s. 200 mm/s is never reached: that takes twice the square root of 10
    // mm / 1,000 mm/s2.
    let times: Vec<_> = report.columns.iter().map(|column| column.programs[0].isostep_s.unwrap()).collect();
    assert!((times[0] - 1.01).abs() < 1e-6 && (times[1] - 0.2).abs() < 1e-6, "{times:?}");
    // On a straight line nothing is faster, and there is nothing to take together.
    for (column, s) in report.columns.iter().zip(times) {
        let Times { fastest_s, one_by_one_s, blends_s, moves, together, .. } = column.programs[0];
        for made_s in [fastest_s, one_by_one_s, blends_s] {
            assert!((made_s.unwrap() - s).abs() < 1e-6, "{made_s:?}");
        }
        assert_eq!((moves, together), (Some(1), Some(0)));
    }
    assert_eq!(report.broken(), [""; 0]);
    let text = print::text(&report);
    assert!(text.contains("MILL_max_feed: 50 steps/mm, 12000 mm/min, 1000 mm/s2, every feed F12000"), "{text}");
    assert!(text.contains("slow.nc") && text.contains("1.010"), "{text}");
    run(args).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&fs::read(&out).unwrap()).unwrap();
    assert!((json["columns"][1]["programs"][0]["ratio"].as_f64().unwrap() - 1.0).abs() < 1e-4, "{json}");
}

/// Round a right angle a blend is 1.29 times as fast as the jump that is allowed without, and takes less time.
#[test]
fn blends_have_a_column() {
    let folder = Folder::new("blends", "program,MILL_s\nbent.nc,1\n");
    fs::write(folder.0.join("bent.nc"), "G21 G90 G94\nG1 X10 F6000\nX20\nY10\nX10\n").unwrap();
    let report = report(&folder.args(&["--blends", "0.05"])).unwrap();
    let times = &report.columns[0].programs[0];
    let (with_s, without_s) = (times.blends_s.unwrap(), times.isostep_s.unwrap());
    assert!(with_s < without_s - 1e-3 && with_s > 0.5 * without_s, "{with_s} s with blends, {without_s} s without");
    let text = print::text(&report);
    assert!(text.contains("blends, s") && text.contains("blends/Grbl        median"), "{text}");
}

/// A program of one column, timed on the machine with these settings too.
fn timed(name: &str, lines: &str, more: &[&str], settings: &str) -> Times {
    let folder = Folder::new(name, "program,MILL_s\nmade.nc,1\n");
    fs::write(folder.0.join("made.nc"), lines).unwrap();
    let mill = fs::read_to_string(folder.0.join("mill.txt")).unwrap();
    fs::write(folder.0.join("mill.txt"), mill + settings).unwrap();
    report(&folder.args(more)).unwrap().columns.remove(0).programs.remove(0)
}

#[test]
fn the_fastest_right_angle_has_the_speed_of_its_parabola() {
    let lines = "G21 G90 G94\nG1 X10 F6000\nY10\n";
    let Times { blends_s, one_by_one_s, fastest_s, of_fastest, .. } = timed("angle", lines, &["--blends", "0.05"], "");
    // The blend reaches 4 x 0.05 mm/√2 to both sides, and there x turns into y at 1,000 mm/s2. The speed rises and falls
    // between 0 and 100 mm/s else.
    let corner_mm_s = f64::sqrt(2.0 * 4.0 * 0.05 / f64::sqrt(2.0) * 1_000.0);
    let wanted_s = 4.0 * 0.1 - corner_mm_s / 1_000.0;
    for made_s in [blends_s, one_by_one_s, fastest_s] {
        assert!((made_s.unwrap() - wanted_s).abs() < 1e-6, "{made_s:?}, not {wanted_s}");
    }
    assert!((of_fastest.unwrap() - 1.0).abs() < 1e-5);
}

/// Points beside a line to either side in turn, by what a program rounds.
#[test]
fn what_the_chip_and_what_the_path_bounds_are_told_apart() {
    const OFF_MM: f64 = 0.000_312_5;
    let times = [2_000, 4_000].map(|chords| {
        let point = |index: i32| format!("X{:.3}Y{:.7}\n", 0.05 * f64::from(index), f64::from(index % 2) * OFF_MM);
        let lines = format!("G21 G90 G94\nG1 F6000\n{}", (1..=chords).map(point).collect::<String>());
        timed(&format!("chords-{chords}"), &lines, &["--blends", "0.05"], "")
    });
    // What 2,000 more of them take: on the chip the least time of a move with a blend each; by blends that reach to the middles of chords at the speed at which y
    // has its 1,000 mm/s2; and straight on, at the feed.
    let length_mm = f64::hypot(0.05, OFF_MM);
    let path_mm_s = f64::sqrt(length_mm * 1_000.0 / (2.0 * OFF_MM / length_mm));
    let wanted_s = [2_000.0 * RP2040.blend_s, 2_000.0 * length_mm / path_mm_s, 2_000.0 * 0.05 / 100.0];
    let made_s =
        times.each_ref().map(|times| [times.one_by_one_s, times.fastest_s, times.blends_s].map(Option::unwrap));
    for (index, within) in [1e-3, 1e-3, 5e-3].into_iter().enumerate() {
        let more_s = made_s[1][index] - made_s[0][index];
        assert!((more_s / wanted_s[index] - 1.0).abs() < within, "{more_s}, not {}", wanted_s[index]);
    }
    let Times { moves, together, beside_mm, .. } = times[1];
    assert_eq!(moves, Some(4_000));
    assert!(
        together > Some(3_900) && beside_mm > Some(0.4 * OFF_MM) && beside_mm < Some(1.6 * OFF_MM),
        "{:?}",
        times[1]
    );
}

#[test]
fn a_shaper_is_part_of_the_fastest_time_and_a_curved_speed_profile_has_none() {
    let lines = "G21 G90 G94\nG1 X10 F600\nG4 P0.5\nX0\n";
    let plain_s = timed("plain", lines, &[], "").fastest_s.unwrap();
    let Times { blends_s, fastest_s, .. } = timed("shaped", lines, &[], "$950=1\n$960=40\n");
    // Each of both moves ends when the last impulse has passed, half a period later.
    let shaped_s = fastest_s.unwrap();
    assert!((shaped_s - blends_s.unwrap()).abs() < 1e-6, "{shaped_s} {blends_s:?}");
    assert!((shaped_s - plain_s - 2.0 * 0.0125).abs() < 1e-4, "{shaped_s} {plain_s}");
    let curved = timed("curved", lines, &[], "$940=1\n");
    assert!(curved.fastest_s.is_none() && curved.blends_s > Some(plain_s), "{curved:?}");
    let text = print::text(&Report::new(
        &Table::read(&Folder::new("none", "program,MILL_s\nslow.nc,1\n").0.join("table.csv")).unwrap(),
        vec![],
        vec![],
        Bounds { median: 1.0, each: 1.0 },
    ));
    assert!(text.contains("blends/fastest     no program has both times"), "{text}");
}

/// The feed of the table's programs is replaced in the lines that are sent, where F is a word and no part of a name.
#[test]
fn a_program_with_parameters_is_timed_as_the_lines_that_it_makes() {
    let folder = Folder::new("made", "program,MILL_s,MILL_max_feed_s\nslow.nc,1,1\nbad.nc,1,1\n");
    fs::write(folder.0.join("slow.nc"), "#<feed>=[60*FIX[10.5]]\nG21 G90 G94\nG1 X[2*5] F#<feed>\n").unwrap();
    fs::write(folder.0.join("bad.nc"), "G0 X1\nG1 X[#<far>] F600\n").unwrap();
    let report = report(&folder.args(&[])).unwrap();
    let times: Vec<_> = report.columns.iter().map(|column| column.programs[0].isostep_s.unwrap()).collect();
    assert!((times[0] - 1.01).abs() < 1e-6 && (times[1] - 0.2).abs() < 1e-6, "{times:?}");
    let why = report.columns[1].programs[1].failed.clone().unwrap();
    assert!(why.starts_with("line 2 `G1 X[#<far>] F600`: #<far> has never been set"), "{why}");
}

#[test]
fn what_takes_too_long_or_comes_to_no_end_fails() {
    let folder = Folder::new("fails", "program,MILL_s\nslow.nc,0.505\nbad.nc,0.1\n");
    let failure = format!("{:#}", run(folder.args(&[])).unwrap_err());
    assert!(failure.contains("1 of 2 runs did not come to their end"), "{failure}");
    assert!(failure.contains("1 of 2 ratios are above 1.05 (--each)"), "{failure}");
    assert!(failure.contains("the median of MILL, 2.000, is above 1.02 (--median)"), "{failure}");
    let report = report(&folder.args(&[])).unwrap();
    let why = report.columns[0].programs[1].failed.clone().unwrap();
    assert!(why.starts_with("line 3 `G41` was refused: error:20"), "{why}");
    assert!(run(folder.args(&["--only", "slow.nc", "--median=2.1", "--each=2.1"])).is_ok());
}

#[test]
fn what_is_missing_is_named() {
    let folder = Folder::new("missing", "program,MILL_s,LATHE_s\nslow.nc,1,1\n");
    let failure = format!("{:#}", run(folder.args(&[])).unwrap_err());
    assert!(failure.contains("machine LATHE: name its file of settings with --machine LATHE=FILE"), "{failure}");
    let folder = Folder::new("misspelt", "program,A_s\nslow.nc,1\n");
    let failure = format!("{:#}", run(folder.args(&[])).unwrap_err());
    assert!(failure.contains("--machine MILL") && failure.contains("its machines are A"), "{failure}");
    let folder = Folder::new("absent", "program,MILL_s\nother.nc,1\n");
    assert!(format!("{:#}", run(folder.args(&[])).unwrap_err()).contains("other.nc does not exist"));
}

/// The machines that come with the project.
#[test]
fn machines_of_the_project_are_what_their_files_say() {
    let table = [("A", 50.0, 2_880.0, 50.0), ("B", 80.0, 5_000.0, 500.0), ("C", 80.0, 12_000.0, 2_000.0)];
    for (name, steps_per_mm, top_mm_min, accel_mm_s2) in table {
        let settings = machine_settings(name, &[]).unwrap();
        assert_eq!(settings.steps_per_mm, [steps_per_mm; 3]);
        assert_eq!((settings.max_rate_mm_min, settings.accel_mm_s2), ([top_mm_min; 3], [accel_mm_s2; 3]));
        assert!(
            !settings.soft_limits && !settings.hard_limits && !settings.homing && settings.travel_mm == [10_000.0; 3]
        );
    }
}
