//! Tests the console with a simulated machine behind a pseudo-terminal.

use std::fs;
use std::io::{BufReader, Cursor, Write, empty};
use std::path::{Path, PathBuf};

use super::session::{Event, Session};
use super::stream::{self, How};
use super::talk::Typist;
use super::{piped, port, talk};
use crate::project;
use crate::pty::tests::while_running;

const SPEED: f64 = 50.0;

fn session(path: &Path) -> Session {
    let mut session = Session::open(path.to_str().unwrap(), 115_200).unwrap();
    assert_eq!(session.greet().unwrap()[0], "Grbl 1.1h ['$' for help]");
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

/// Streams `text`, without anybody there. Returns what was printed and how it ended.
fn streamed(path: &Path, text: &str, keep_going: bool) -> (String, Result<(), String>) {
    stream_with(path, text, How { typist: Typist::Pipe, keep_going }, empty(), |_| {})
}

/// Streams `text` while a person answers each printed line with what `reply` types.
fn asked(path: &Path, text: &str, reply: impl Fn(&str) -> &'static str) -> (String, Result<(), String>) {
    let (reader, mut writer) = std::io::pipe().unwrap();
    let how = How { typist: Typist::Person, keep_going: false };
    stream_with(path, text, how, BufReader::new(reader), |line| writer.write_all(reply(line).as_bytes()).unwrap())
}

fn stream_with(
    path: &Path,
    text: &str,
    how: How,
    input: impl std::io::BufRead + Send + 'static,
    mut typed: impl FnMut(&str),
) -> (String, Result<(), String>) {
    let file = program(&format!("streamed-{}", path.file_name().unwrap().display()), text);
    let program = stream::Program::read(&file).unwrap();
    fs::remove_file(file).unwrap();
    let mut out = String::new();
    let ended = stream::run(&mut session(path), &program, how, input, |line| {
        out += &format!("{line}\n");
        typed(line);
    });
    (out, ended.map_err(|error| error.to_string()))
}

#[test]
fn piped_lines_are_answered_one_by_one_to_the_end_of_the_motion() {
    // The first move lasts a second here, so that the report is of it on a computer that is busy.
    let (tally, closing) = while_running(SPEED, |path| {
        let (printed, ended) = pipe(path, "$H\nG21 G90\r\nG1 X10 Y4 F12 (there)\n?\n\nG1 X2 F600");
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
        streamed(path, &fs::read_to_string(parking).unwrap(), false).1.unwrap();
    });
    assert_eq!((closing.state.as_str(), closing.steps_lost), ("Idle", Some(0)));
    assert_eq!(closing.position_mm, [175.0, 40.0, 0.0]);
    let flight = tally.flight;
    assert_eq!((flight.refused, flight.times_over, flight.lines), (0, 0, flight.answered));
    assert!((100..=128).contains(&flight.most), "{} bytes in flight", flight.most);
}

/// A plunge with the spindle on behind a line that is refused, as in the middle of a program that mills.
const PLUNGE: &str = "M3 S900\nG0 X5\nD9\nG4 P0.5\nG0 Z40\nX20\nX30 (there)\n";

#[test]
fn a_refused_line_stops_the_stream_and_what_is_behind_it_is_reported() {
    let mut text = PLUNGE.to_owned();
    text += &"G0 X31\n".repeat(100);
    let (_, closing) = while_running(SPEED, |path| {
        let (printed, ended) = streamed(path, &text, false);
        let ended = ended.unwrap_err();
        assert!(ended.contains(":3: `D9` was refused: error:20"), "{ended}");
        assert!(ended.contains("its outputs off, and its position is kept: Idle"), "{ended}");
        assert!(
            ended.contains("sent by then, were not carried out") && ended.contains("to 107 were not sent"),
            "{ended}"
        );
        assert!(printed.contains("the machine holds: Hold:0"), "{printed}");
        assert!(printed.contains("  line 5 `G0 Z40`\n  line 6 `X20`\n  line 7 `X30`\n"), "{printed}");
        assert!(printed.contains("\nstill to come: lines ") && printed.contains(" to 107\n"), "{printed}");
        // The machine is ready for the next program.
        assert_eq!(streamed(path, "M5\nG0 X2\nM2\n", false).1, Ok(()));
    });
    assert_eq!((closing.state.as_str(), closing.position_mm), ("Idle", [2.0, 0.0, 0.0]));
}

#[test]
fn a_person_is_asked_and_goes_on_or_stops() {
    let choose = |answer: &'static str| move |line: &str| if line.starts_with("g: ") { answer } else { "" };
    let (_, closing) = while_running(SPEED, |path| {
        let (printed, ended) = asked(path, PLUNGE, choose("what?\ng\n"));
        let ended = ended.unwrap_err();
        assert!(ended.contains(":3: `D9`") && !ended.contains("were not sent"), "{ended}");
        assert_eq!(printed.matches("g: go on without").count(), 2, "{printed}");
        assert!(printed.contains("no line is still to come"), "{printed}");
    });
    assert_eq!(closing.position_mm, [30.0, 0.0, 40.0]);
    let (_, closing) = while_running(SPEED, |path| {
        let ended = asked(path, PLUNGE, choose("s\n")).1.unwrap_err();
        assert!(ended.contains("the stream has stopped there, by a hold and a reset"), "{ended}");
    });
    assert_eq!((closing.state.as_str(), closing.position_mm[2]), ("Idle", 0.0));
    assert!(closing.position_mm[0] <= 5.0, "{closing:?}");
}

#[test]
fn refused_lines_are_passed_over_if_that_is_asked_for_and_where_nothing_moves() {
    let (_, closing) = while_running(SPEED, |path| {
        let (printed, ended) = streamed(path, &format!("{PLUNGE}D8\nM5\n"), true);
        let ended = ended.unwrap_err();
        assert!(ended.contains(":3: `D9`") && ended.contains(":8: `D8`"), "{ended}");
        assert!(printed.contains(":3: `D9` was refused: error:20") && !printed.contains("holds"), "{printed}");
        let (printed, ended) = streamed(path, "$C\nD9\nG0 X1\nD8\n", false);
        let ended = ended.unwrap_err();
        assert!(ended.contains(":2: `D9`") && !printed.contains("holds"), "{ended}\n{printed}");
    });
    assert_eq!((closing.state.as_str(), closing.position_mm), ("Idle", [30.0, 0.0, 40.0]));
}

/// The machine gets plain lines; a line that it refuses is named as it stands in the file.
#[test]
fn a_program_with_parameters_is_streamed_as_plain_lines() {
    let text = "G91 (#1)\no1 repeat [40]\n#1=[#1+1]\nG1 X[#1/1000] F600\no1 endrepeat\nG90\n";
    let (tally, closing) = while_running(SPEED, |path| {
        assert_eq!(streamed(path, text, false).1, Ok(()));
        let (printed, ended) = streamed(path, &format!("{text}D9\nG4 P5\nG0 X5\nM2\n"), false);
        let ended = ended.unwrap_err();
        assert!(ended.contains(":7: `D9` was refused: error:20") && ended.contains(" of the 46 made of it"), "{ended}");
        assert!(printed.contains("\n  line 9 `G0 X5`\n  line 10 `M2`\nno line is still to come\n"), "{printed}");
    });
    assert_eq!((closing.state.as_str(), closing.position_mm[0]), ("Idle", 1.64));
    assert_eq!((tally.flight.times_over, tally.flight.refused), (0, 1));
}

#[test]
fn a_program_that_cannot_be_carried_out_is_not_streamed() {
    let bad = program("unfit", "G0 X1\nG0 X[1/0]\nM2\n");
    let refused = format!("{:#}", stream::Program::read(&bad).err().unwrap());
    assert!(
        refused.ends_with(".nc: line 2 `G0 X[1/0]`: 1 is divided by zero: test the divisor by an o-if before"),
        "{refused}"
    );
    fs::remove_file(bad).unwrap();
}

#[test]
fn an_alarm_ends_the_stream_with_its_remedy() {
    let (_, closing) = while_running(SPEED, |path| {
        let ended = streamed(path, &format!("$H\nG0 X400\n{}", "G0 X1\n".repeat(50)), false).1.unwrap_err();
        assert!(ended.starts_with("ALARM:2  axis target outside the travel"), "{ended}");
        assert!(ended.contains("then $X\n") && ended.contains(":2: `G0 X400` was refused: error:9"), "{ended}");
        assert!(ended.contains(" more lines were refused\n") && ended.ends_with(" to 52 were not sent"), "{ended}");
        // What a locked machine refuses is no question.
        let (printed, ended) = streamed(path, "G0 X1\nG0 X2\n", false);
        assert!(ended.unwrap_err().contains(":1: `G0 X1` was refused: error:9") && !printed.contains("holds"));
        let bad = program("refused", "G0 X1\n?\n");
        let refused = format!("{:#}", stream::Program::read(&bad).err().unwrap());
        assert!(refused.contains("line 2: '?' is a real-time command"), "{refused}");
        fs::remove_file(bad).unwrap();
    });
    assert!(closing.state.starts_with("Alarm: "));
}

#[test]
fn a_program_that_waits_for_a_person_is_resumed_from_a_pipe() {
    let (_, closing) = while_running(SPEED, |path| {
        let (printed, ended) = pipe(path, "M0\n~\nG0 X3\nM6 T2\n?\n~\nG0 X4\n");
        assert_eq!(ended, Ok(()), "{printed}");
        assert_eq!(printed.matches("ok\n").count(), 4, "{printed}");
        assert!(printed.contains("<Hold:0|"), "{printed}");
        let how = How { typist: Typist::Pipe, keep_going: false };
        let text = "G0 X5\nM0 (look)\nG0 X6\nM6 T1\nG0 X7\n";
        let (printed, ended) = stream_with(path, text, how, Cursor::new("~\n~\n"), |_| {});
        assert_eq!(ended, Ok(()), "{printed}");
    });
    assert_eq!((closing.state.as_str(), closing.position_mm[0]), ("Idle", 7.0));
}

#[test]
fn a_person_is_told_that_the_machine_waits_and_resumes_it() {
    let (_, closing) = while_running(SPEED, |path| {
        let resume = |line: &str| if line.contains("type ~ and Enter") { "~\n" } else { "" };
        let (printed, ended) = asked(path, "G0 X5\nM0 (look)\nG0 X6\nM0\nG0 X7\n", resume);
        assert_eq!(ended, Ok(()), "{printed}");
        assert!(
            printed.contains("the machine waits (Hold:0) at ") && printed.contains(":2: `M0`: type ~"),
            "{printed}"
        );
        assert_eq!(printed.matches("type ~ and Enter").count(), 2, "{printed}");
    });
    assert_eq!((closing.state.as_str(), closing.position_mm[0]), ("Idle", 7.0));
}

/// What a person types is by hand while the lines of the program wait, and is not counted among them.
#[test]
fn a_person_is_told_the_tool_and_sets_its_z_by_hand_while_the_program_waits() {
    let text = "$H\n(T2 D=6 flat end mill)\n(Contour)\nT2 M6\nG0 X5\nD9\nG0 Z30\n";
    let (_, closing) = while_running(SPEED, |path| {
        pipe(path, "$341=1\n").1.unwrap();
        let reply = |line: &str| match line {
            _ if line.starts_with("the machine waits for tool 2: D=6 flat end mill; at ") => {
                "$J=G91 X1 F2000\nG10 L20 P0 Z30\n~\n"
            }
            _ if line.starts_with("g: ") => "g\n",
            _ => "",
        };
        let (printed, ended) = asked(path, text, reply);
        let ended = ended.unwrap_err();
        assert!(
            ended.contains(":6: `D9` was refused: error:20") && !ended.contains("more lines"),
            "{ended}\n{printed}"
        );
        assert!(printed.contains(":4: `T2 M6`: type ~ and Enter to go on"), "{printed}");
        assert_eq!(printed.matches("the machine waits").count(), 1, "{printed}");
        assert!(printed.contains("\nok (`$J=G91 X1 F2000`)\n"), "{printed}");
        assert!(printed.contains("\nok (`G10 L20 P0 Z30`)\n"), "{printed}");
    });
    assert_eq!((closing.state.as_str(), closing.position_mm[0]), ("Idle", 5.0));
}

/// At the prompt a person types the program too.
#[test]
fn at_the_prompt_lines_are_by_hand_while_the_machine_waits_for_a_tool() {
    let (_, closing) = while_running(SPEED, |path| {
        pipe(path, "$341=1\n$H\n").1.unwrap();
        let mut session = session(path);
        let typist = session.typist();
        let typed = |line: &str| typist.send(Event::Typed(line.to_owned())).unwrap();
        ["(T2 D=6 flat)", "M6 T2", "G0 X7", "G4 P0"].into_iter().for_each(typed);
        let (mut printed, mut is_set) = (String::new(), false);
        let show = |line: &str| {
            printed += &format!("{line}\n");
            if line.starts_with("the machine waits for tool 2: D=6 flat; jog") {
                typed("$J=G91 Y2 F2000");
                typed("G10 L20 P0 Z30");
            } else if line == "ok" && printed.ends_with("ok\nok\n") && printed.contains("waits for tool") && !is_set {
                is_set = true;
                typist.send(Event::AtOnce(b'~')).unwrap();
            } else if printed.matches("ok\n").count() == 6 {
                typist.send(Event::Quit).unwrap();
            }
            Ok(())
        };
        talk::run(&mut session, Typist::Person, show, |_| Ok(())).unwrap();
        assert_eq!(printed.matches("the machine waits for tool 2").count(), 1, "{printed}");
        assert!(!printed.contains("error:"), "{printed}");
    });
    assert_eq!((closing.state.as_str(), closing.position_mm[0]), ("Idle", 7.0));
}

#[test]
fn a_tool_that_was_not_measured_is_asked_for_again() {
    let (_, closing) = while_running(SPEED, |path| {
        pipe(path, "$341=1\n").1.unwrap();
        let resume = |line: &str| if line.starts_with("the machine waits for tool 3: V-bit;") { "~\n" } else { "" };
        let (printed, ended) = asked(path, "$H\nM6 T3 (V-bit)\n", resume);
        assert_eq!(ended, Ok(()), "{printed}");
        assert_eq!(printed.matches("the machine waits for tool 3").count(), 2, "{printed}");
        assert!(printed.contains("the tool was not measured"), "{printed}");
    });
    assert_eq!(closing.state, "Idle");
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
