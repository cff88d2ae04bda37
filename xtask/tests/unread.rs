//! Verbs whose output nobody reads to its end, as with `| head`.

use std::process::{Command, Stdio};

/// Runs the verb with both outputs into a pipe whose reader has gone.
fn ends_well(arguments: &[&str]) {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut verb = Command::new(env!("CARGO_BIN_EXE_xtask"));
    verb.args(arguments).stdin(Stdio::null()).stdout(writer.try_clone().unwrap()).stderr(writer);
    let status = verb.status().unwrap();
    assert!(status.success(), "{arguments:?}: {status}");
}

#[test]
fn a_table() {
    ends_well(&["profile", "--law", "trapezoid", "--steps", "400", "--top-speed", "2400", "--accel", "2500"]);
}

#[test]
fn a_run_of_a_program() {
    ends_well(&["sim", concat!(env!("CARGO_MANIFEST_DIR"), "/../programs/parking.nc")]);
}

#[test]
fn a_list() {
    ends_well(&["console", "--list"]);
}
