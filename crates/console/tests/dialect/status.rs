//! Status reports, and the lines that any byte stream gives.

use crate::talk::Talk;
use expect_test::expect;
use isostep_console::{Move, Overrides, Settings, State, Status, StatusReporter, report};
use proptest::prelude::*;

#[test]
fn literals_are_grbls() {
    assert_eq!(report::WELCOME, "\r\nGrbl 1.1h ['$' for help]\r\n");
    let mut out = String::new();
    report::alarm(&mut out, isostep_console::Alarm::SwitchNotFound).unwrap();
    report::error(&mut out, isostep_console::Error::LineTooLong).unwrap();
    report::message(&mut out, report::messages::HOW_TO_UNLOCK).unwrap();
    assert_eq!(out, "ALARM:9\r\nerror:11\r\n[MSG:'$H'|'$X' to unlock]\r\n");
}

#[test]
fn a_report_inside_a_line_leaves_the_line_whole() {
    let heard = Talk::new(State::Idle).bytes(b"G0 X1\x900.\xC2?5\n");
    expect!["<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000> (rapid [10.5, 0.0, 0.0]) ok"].assert_eq(&heard);
}

#[test]
fn offset_and_overrides_take_turns() {
    let mut talk = Talk::new(State::Idle);
    let mut kinds = |state, count| {
        talk.state = state;
        (0..count)
            .map(|_| talk.bytes(b"?"))
            .map(|line| match (line.contains("WCO"), line.contains("Ov")) {
                (true, false) => 'w',
                (false, true) => 'o',
                (false, false) => '.',
                (true, true) => '!',
            })
            .collect::<String>()
    };
    assert_eq!(kinds(State::Idle, 22), "wo........wo........wo");
    assert_eq!(kinds(State::Run, 50), "........wo...................o........w..........o");
}

#[test]
fn the_mask_chooses_fields_and_inches_scale() {
    let status = Status {
        state: State::Alarm,
        position_mm: [25.4, -0.0002, -10_000.0],
        work_offset_mm: [0.0, 50.8, -10_000.0],
        line_number: 10_000_000,
        feed_mm_min: 254.0,
        limits_pressed: [true, false, true],
        emergency_stop: true,
        overrides: Overrides::DEFAULT,
        free_blocks: 255,
        free_bytes: u16::MAX,
    };
    let mut heard = String::new();
    for (report_mask, report_inches) in [(0, false), (1, false), (2, true), (3, true)] {
        let settings = Settings { report_mask, report_inches, ..Settings::DEFAULT };
        let before = heard.len();
        StatusReporter::new().write(&mut heard, &status, &settings).unwrap();
        assert!(heard.len() - before <= 160);
    }
    expect![[r#"
        <Alarm|WPos:25.400,-50.800,0.000|Ln:10000000|FS:254,0|Pn:XZR|WCO:0.000,50.800,-10000.000>
        <Alarm|MPos:25.400,0.000,-10000.000|Ln:10000000|FS:254,0|Pn:XZR|WCO:0.000,50.800,-10000.000>
        <Alarm|WPos:1.0000,-2.0000,0.0000|Bf:255,65535|Ln:10000000|FS:10.0,0|Pn:XZR|WCO:0.0000,2.0000,-393.7008>
        <Alarm|MPos:1.0000,0.0000,-393.7008|Bf:255,65535|Ln:10000000|FS:10.0,0|Pn:XZR|WCO:0.0000,2.0000,-393.7008>
    "#]]
    .assert_eq(&heard.replace('\r', ""));
}

#[test]
fn states_print_as_grbl_prints_them() {
    let states = [
        (State::Idle, "Idle"),
        (State::Run, "Run"),
        (State::Hold { stopping: false }, "Hold:0"),
        (State::Hold { stopping: true }, "Hold:1"),
        (State::Jog, "Jog"),
        (State::Home, "Home"),
        (State::Alarm, "Alarm"),
        (State::Check, "Check"),
        (State::Sleep, "Sleep"),
    ];
    for (state, name) in states {
        let heard = Talk::new(state).bytes(b"?");
        assert_eq!(heard, format!("<{name}|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>"));
    }
}

#[test]
fn a_changed_offset_unit_or_override_is_told_at_once() {
    let mut talk = Talk::new(State::Idle);
    let extras = |talk: &mut Talk, sent: &[u8]| {
        talk.bytes(sent);
        let heard = [(); 3].map(|()| talk.bytes(b"?"));
        heard.map(|line| line.rsplit('|').next().unwrap().trim_end_matches('>').to_owned())
    };
    assert_eq!(extras(&mut talk, b""), ["WCO:0.000,0.000,0.000", "Ov:100,100,100", "FS:0,0"]);
    assert_eq!(extras(&mut talk, b"G92 X1\n"), ["WCO:-1.000,0.000,0.000", "FS:0,0", "FS:0,0"]);
    assert_eq!(extras(&mut talk, b"\x91"), ["Ov:110,100,100", "FS:0,0", "FS:0,0"]);
    assert_eq!(extras(&mut talk, b"G92 X2\n\x97"), ["WCO:-2.000,0.000,0.000", "Ov:110,25,100", "FS:0,0"]);
    assert_eq!(extras(&mut talk, b"$13=1\n"), ["WCO:-0.0787,0.0000,0.0000", "FS:0.0,0", "FS:0.0,0"]);
    assert_eq!(extras(&mut talk, b"$13=1\n"), ["FS:0.0,0"; 3]);
}

proptest! {
    #[test]
    fn any_bytes_get_one_reply_a_line_and_finite_targets(
        bytes in prop::collection::vec(prop_oneof![any::<u8>(), prop::sample::select(&b"GMXYZFNT$=.-0123459 \n\r"[..])], 0..600)
    ) {
        let mut talk = Talk::new(State::Idle);
        let heard = talk.bytes(&bytes);
        let replies = heard.split(' ').filter(|word| *word == "ok" || word.starts_with("error:")).count();
        prop_assert_eq!(replies, bytes.iter().filter(|byte| matches!(byte, b'\r' | b'\n')).count());
        prop_assert!(talk.interpreter.position_mm().iter().all(|mm| mm.abs() <= isostep_console::MAX_COORDINATE_MM));
        prop_assert_eq!(talk.settings.check(&crate::talk::carries), Ok(()));
    }

    #[test]
    fn targets_are_read_exactly(mm in -9999.999f32..9999.999) {
        let mut interpreter = isostep_console::Interpreter::new();
        let line = format!("X{mm}");
        let command = interpreter.interpret(&line, State::Idle, &Settings::DEFAULT);
        let isostep_console::Command::Block(block) = command.unwrap() else { panic!("a block") };
        let Some(Move { target_mm, .. }) = block.motion else { panic!("a move") };
        prop_assert_eq!(target_mm[0], mm);
    }
}
