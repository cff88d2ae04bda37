//! Options that cannot be combined are refused with a remedy, before anything runs or is written.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A folder for one test, with a program in it. The verbs run there.
struct TestFolder(PathBuf);

impl TestFolder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("isostep-options-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("my.nc"), "G0 X1\nM2\n").unwrap();
        Self(folder)
    }

    /// The error of a verb that refuses. The verb must print nothing to the standard output and write nothing.
    #[track_caller]
    fn refuses(&self, line: &str) -> String {
        let before = names(&self.0);
        let mut verb = Command::new(env!("CARGO_BIN_EXE_xtask"));
        verb.args(line.split(' ')).current_dir(&self.0).stdin(Stdio::null());
        let output = verb.output().unwrap();
        let reported = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && output.stdout.is_empty(), "`{line}` was not refused: {reported}");
        assert_eq!(names(&self.0), before, "`{line}` wrote something");
        assert_eq!(fs::read_to_string(self.0.join("my.nc")).unwrap(), "G0 X1\nM2\n", "`{line}`");
        reported
    }
}

impl Drop for TestFolder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn files_are_not_written_over_each_other() {
    let folder = TestFolder::new("files");
    for [line, one, other] in [
        ["sim my.nc --trace a --json ./a", "--trace a", "--json ./a"],
        ["sim my.nc --outputs a --vcd a", "--outputs a", "--vcd a"],
        ["sim my.nc --json my.nc", "--json my.nc", "FILE.nc my.nc"],
        ["sim my.nc --flash a --trace a", "--flash a", "--trace a"],
        ["sim --pty --link a --trace a", "--link a", "--trace a"],
        ["sim my.nc --report a --json a", "--report a", "--json a"],
        ["sim my.nc --settings s --json s", "--settings s", "--json s"],
        ["emulate my.nc --trace a --json a", "--trace a", "--json a"],
        ["emulate my.nc --vcd a --transcript a", "--vcd a", "--transcript a"],
        ["emulate my.nc --json a -- --edges a", "--json a", "--edges a"],
        ["emulate my.nc --transcript my.nc", "--transcript my.nc", "FILE.nc my.nc"],
        ["check my.nc --json my.nc", "--json my.nc", "FILE my.nc"],
        ["profile --speed-profile sine --steps 9 --csv a.svg --plot a.svg", "--csv a.svg", "--plot a.svg"],
        ["papers --report . --json index.html", "--report .", "--json index.html"],
        ["bench --report . --json index.html", "--report .", "--json index.html"],
    ] {
        let reported = folder.refuses(line);
        assert!(reported.contains(one) && reported.contains(other), "{line}: {reported}");
    }
    fs::write(folder.0.join("grbl.csv"), "program,A_s\nmy.nc,1\n").unwrap();
    let reported = folder.refuses("times . grbl.csv --json my.nc");
    assert!(reported.contains("--json my.nc would be written over the program ./my.nc"), "{reported}");
}

#[test]
fn an_option_that_would_be_passed_over_is_refused() {
    let folder = TestFolder::new("passed-over");
    for (line, words) in [
        ("sim my.nc --link a", "--link goes with --pty"),
        ("sim --link a", "--link goes with --pty"),
        ("sim my.nc --for-s 1", "--for-s goes with --pty"),
        ("emulate my.nc --link a", "--link goes with --pty"),
        ("emulate my.nc --speed 2", "--speed goes with --pty"),
        ("emulate my.nc -- --trace a", "--trace is an option of this verb: give it before the --"),
        ("check my.nc my.nc --all", "--all lists the refused lines of one program"),
        ("profile --speed-profile sine --steps 9 --derivatives paper", "--plot"),
        ("console --list port", "--list"),
    ] {
        let reported = folder.refuses(line);
        assert!(reported.contains(words), "{line}: {reported}");
    }
}
