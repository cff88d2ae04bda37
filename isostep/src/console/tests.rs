//! Tests the console with a simulated machine behind a pseudo-terminal.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use super::session::Session;
use super::{piped, port, stream};
use crate::project;
use crate::pty::tests::while_running;

const SPEED: f64 = 50.0;

fn session(path: &Path) -> Session {
    let mut session = Session::open(path.to_str().unwrap(), 115_200).unwrap();
    assert_eq!(session.greet().unwrap(), ["Grbl 1.1h ['$' for help]"]);
    session
}

/// Pipes `lines` in. Returns what was printed and how the console ended.
fn pipe(path: &Path, lines: &'static str) -> (String, Result<(), String>) {
    let mut out = String::new();
    let ended = piped::run(&mut session(path), Cursor::new(lines), |line| out += &format!("{line}\n"));
    (out, ended.map_err(|error| error.to_string()))
}

fn program(name: &str, text: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("isostep-{name}-{}.nc", std::process::id()));
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn piped_lines_are_answered_one_by_one_to_the_end_of_the_motion() {
    let (tally, closing) = while_running(SPEED, |path| {
        let (printed, ended) = pipe(path, "$H\nG21 G90\r\nG0 X10 Y4 (there)\n?\n\nG1 X2 F600");
        assert_eq!(ended, Ok(()));
        let lines: Vec<_> = printed.lines().map(|line| line.split('|').next().unwrap()).collect();
        assert_eq!(lines, ["ok", "ok", "ok", "<Run", "ok", "ok"]);
    });
    assert_eq!((closing.position_steps, closing.state.as_str(), closing.steps_lost), ([100, 200, 0], "Idle", Some(0)));
    assert_eq!((tally.flight.lines, tally.flight.answered, tally.dropped_bytes), (5, 5, 0));
}

#[test]
fn a_refused_line_an_unfit_one_and_an_alarm_are_failures_that_say_what_they_mean() {
    while_running(SPEED, |path| {
        let (printed, ended) = pipe(path, "G5 X1\n$I\n");
        assert_eq!(ended.unwrap_err(), "lines refused: 1 of 2");
        assert!(printed.contains("error:20  The machine has no such code"), "{printed}");
        let (printed, ended) = pipe(path, "G0 X1 !\n");
        assert_eq!(ended.unwrap_err(), "lines not fit to be sent: 1");
        assert!(printed.starts_with("not sent: '!' acts at once"), "{printed}");
        let (printed, ended) = pipe(path, "$H\nG0 X400\n");
        assert_eq!(ended.unwrap_err(), "an alarm came");
        assert!(printed.contains("ALARM:2  axis target outside the travel"), "{printed}");
    });
}

#[test]
fn a_program_is_streamed_within_the_window_and_to_its_end() {
    let (tally, closing) = while_running(SPEED, |path| {
        let parking = project::file("programs/parking.nc");
        stream::run(&mut session(path), &stream::Program::read(&parking).unwrap()).unwrap();
    });
    assert_eq!((closing.state.as_str(), closing.steps_lost), ("Idle", Some(0)));
    assert_eq!(closing.position_mm, [175.0, 40.0, 0.0]);
    let flight = tally.flight;
    assert_eq!((flight.refused, flight.times_over, flight.lines), (0, 0, flight.answered));
    assert!((100..=128).contains(&flight.most), "{} bytes in flight", flight.most);
}

#[test]
fn a_program_stops_at_the_line_that_is_refused() {
    let (_, closing) = while_running(SPEED, |path| {
        let text = format!("G0 X1\nQ9\n{}", "G0 X2\n".repeat(100));
        let bad = program("refused", &text);
        let ended = stream::run(&mut session(path), &stream::Program::read(&bad).unwrap()).unwrap_err().to_string();
        assert!(ended.contains(":2: `Q9` was refused: error:20"), "{ended}");
        fs::write(&bad, "$H\nG0 X400\nG0 X1\n").unwrap();
        let ended = stream::run(&mut session(path), &stream::Program::read(&bad).unwrap()).unwrap_err().to_string();
        assert!(ended.starts_with("ALARM:2") && ended.contains(":2: `G0 X400` was refused: error:9"), "{ended}");
        fs::write(&bad, "G0 X1\n?\n").unwrap();
        let refused = format!("{:#}", stream::Program::read(&bad).err().unwrap());
        assert!(refused.contains("line 2: '?' is a real-time command"), "{refused}");
        fs::remove_file(bad).unwrap();
    });
    assert!(closing.state.starts_with("Alarm"));
}

#[test]
fn a_port_that_another_program_has_is_refused_and_free_again_afterwards() {
    while_running(SPEED, |path| {
        let name = path.to_str().unwrap();
        let first = port::open(name, 115_200).unwrap();
        let refused = port::open(name, 115_200).err().unwrap().to_string();
        assert!(refused.contains("another program has it"), "{refused}");
        drop(first);
        port::open(name, 115_200).unwrap();
    });
    let missing = port::open("/dev/isostep-nowhere", 115_200).err().unwrap().to_string();
    assert!(missing.contains("there is no such port"), "{missing}");
    let unfit = port::open("/dev/null", 115_200).err().unwrap().to_string();
    assert!(unfit.contains("cannot be opened as a serial port"), "{unfit}");
}

#[test]
fn a_machine_that_goes_away_ends_the_session() {
    let mut left = None;
    while_running(SPEED, |path| left = Some(session(path)));
    let mut session = left.unwrap();
    let gone = loop {
        if let Err(error) = session.next() {
            break error.to_string();
        }
    };
    assert!(gone.contains("gone") || gone.contains("take"), "{gone}");
}
