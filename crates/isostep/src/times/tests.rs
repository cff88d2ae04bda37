//! Tests the verb as a user runs it, without the shell.

use std::fs;

use clap::Parser;

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
        fs::write(folder.join("bad.nc"), "G21 G90\nG1 X1 F600\nG99\n").unwrap();
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
    assert!(text.contains("blends, s") && text.contains("MILL, blends"), "{text}");
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
    assert!(why.starts_with("line 3 `G99` was refused: error:20"), "{why}");
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
