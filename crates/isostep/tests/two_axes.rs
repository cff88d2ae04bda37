//! The verbs of the tool for a machine of X and Y alone.

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

fn verb(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_isostep")).args(arguments).stdin(Stdio::null()).output().unwrap()
}

/// The words of a verb that succeeds.
fn printed(arguments: &[&str]) -> String {
    let output = verb(arguments);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{arguments:?}: {said}{}", String::from_utf8_lossy(&output.stderr));
    said
}

/// A path of this test's own with a program at it.
fn program(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, "G21 G91\nG1 X10 Y4 F600\nM2\n").unwrap();
    path.into_os_string().into_string().unwrap()
}

#[test]
fn sim_starts_at_two_places_and_shows_two() {
    let program = program("sim.nc");
    let said = printed(&["sim", &program, "--start", "5,6"]);
    assert!(said.contains(" to X Y, mm ") && said.contains(" 10.00 4.00 "), "{said}");
    assert!(said.contains("\nfinal position: X 10.00 Y 4.00 mm (500, 200 steps)\n"), "{said}");
    let refused = verb(&["sim", &program, "--start", "5,6,7"]);
    let why = String::from_utf8(refused.stderr).unwrap();
    assert!(!refused.status.success() && why.contains("two numbers of mm, such as 35,40"), "{why}");
}

#[test]
fn check_finds_the_room_of_two_axes() {
    let said = printed(&["check", &program("check.nc"), "--start", "5,6"]);
    assert!(said.contains("  extents    X 0.000 to 10.000, Y 0.000 to 4.000 mm: 10.000 x 4.000\n"), "{said}");
    assert!(said.contains("  travel     it stays within, from --start 5,6\n"), "{said}");
}

#[test]
fn help_names_two_places() {
    for name in ["sim", "check"] {
        let help = printed(&[name, "--help"]);
        assert!(help.contains("--start <X,Y>"), "{help}");
    }
}
