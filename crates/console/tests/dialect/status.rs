//! Status reports, and the lines that result from arbitrary bytes.

use super::talk::Talk;
use expect_test::expect;
use isostep_console::{
    BlockMove, Coolant, DoorPhase, MAX_COORDINATE_PM, Overrides, ReportedState, Settings, SpindleMode, StatusReport,
    StatusReporter, length, report,
};
use proptest::prelude::*;

/// The limits that [`StatusReporter::write`] and [`StatusReporter::write_full`] document.
const LONGEST_BYTES: usize = 188;
const LONGEST_FULL_BYTES: usize = 220;

/// A machine at rest, with nothing switched on and nothing pressed.
const QUIET: StatusReport = StatusReport {
    state: ReportedState::Idle,
    position_pm: [0; 3],
    work_offset_pm: [0; 3],
    line_number: 0,
    feed_mm_min: 0.0,
    spindle_rpm: 0.0,
    actual_rpm: None,
    spindle: SpindleMode::Off,
    coolant: Coolant::Off,
    probe_touched: false,
    limits_pressed: [false; 3],
    second_limit_pressed: false,
    door_open: false,
    drive_alarm: false,
    emergency_stop: false,
    hold_pressed: false,
    start_pressed: false,
    overrides: Overrides::DEFAULT,
    free_blocks: 15,
    free_bytes: 128,
    homed: [false; 3],
    tool: 0,
    system: 0,
    has_tool_reference: false,
};

#[test]
fn literals_are_grbls() {
    assert_eq!(report::WELCOME, "\r\nGrbl 1.1h ['$' for help]\r\n");
    let mut out = String::new();
    report::alarm(&mut out, isostep_console::AlarmCode::SwitchNotFound).unwrap();
    report::error(&mut out, isostep_console::Error::LineTooLong).unwrap();
    report::message(&mut out, report::messages::HOW_TO_UNLOCK).unwrap();
    assert_eq!(out, "ALARM:9\r\nerror:11\r\n[MSG:'$H'|'$X' to unlock]\r\n");
}

#[test]
fn a_report_inside_a_line_leaves_the_line_whole() {
    let heard = Talk::new(ReportedState::Idle).bytes(b"G0 X1\x900.\xC2?5\n");
    expect!["<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000> (rapid [10.5, 0.0, 0.0]) ok"].assert_eq(&heard);
}

#[test]
fn a_full_report_has_every_field_and_counts_as_both() {
    let mut talk = Talk::new(ReportedState::Idle);
    let mut heard = |sent: &[u8]| talk.bytes(sent);
    expect!["<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000|Ov:100,100,100|A:|WCS:G54|H:0,0|T:0|TLR:0|FW:Isostep> <Idle|MPos:0.000,0.000,0.000|FS:0,0> (rapid [1.0, 0.0, 0.0]) ok"].assert_eq(&heard(b"G0 X1\x87\x80\n"));
    assert_eq!(heard(b"M4 S1 M8\n"), "(spindle) (speed) (coolant) ok");
    expect!["<Idle|MPos:1.000,0.000,0.000|FS:0,1|WCO:0.000,0.000,0.000|Ov:100,100,100|A:CF|WCS:G54|H:0,0|T:0|TLR:0|FW:Isostep>"]
        .assert_eq(&heard(b"\x87"));
    assert_eq!((0..9).filter(|_| heard(b"?").contains("WCO")).count(), 0);
    expect!["<Idle|MPos:1.000,0.000,0.000|FS:0,1|WCO:0.000,0.000,0.000>"].assert_eq(&heard(b"?"));
}

#[test]
fn a_full_report_says_which_axes_are_homed() {
    let heard = |homed, settings: &Settings| {
        let mut heard = String::new();
        StatusReporter::new().write_full(&mut heard, &StatusReport { homed, ..QUIET }, settings).unwrap();
        heard.split_once("|A:").unwrap().1.trim_end().to_owned()
    };
    let homes = Settings::DEFAULT;
    assert_eq!(heard([false; 3], &homes), "|WCS:G54|H:0,0|T:0|TLR:0|FW:Isostep>");
    assert_eq!(heard([true, false, true], &homes), "|WCS:G54|H:0,5|T:0|TLR:0|FW:Isostep>");
    assert_eq!(heard([true; 3], &homes), "|WCS:G54|H:1,7|T:0|TLR:0|FW:Isostep>");
    assert_eq!(heard([false; 3], &Settings { homing: false, ..homes }), "|WCS:G54|T:0|TLR:0|FW:Isostep>");
}

#[test]
fn the_modal_state_is_printed_within_a_line() {
    let heard = Talk::new(ReportedState::Run).bytes(b"G0 \x83X1\n");
    expect!["[GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] (rapid [1.0, 0.0, 0.0]) ok"].assert_eq(&heard);
}

#[test]
fn offset_and_overrides_take_turns() {
    let mut talk = Talk::new(ReportedState::Idle);
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
    assert_eq!(kinds(ReportedState::Idle, 22), "wo........wo........wo");
    assert_eq!(kinds(ReportedState::Run, 50), "........wo...................o........w..........o");
}

#[test]
fn the_mask_chooses_fields_and_inches_scale() {
    let status = StatusReport {
        state: ReportedState::Alarm,
        position_pm: [25.4, -0.0002, -10_000.0].map(length::from_mm),
        work_offset_pm: [0.0, 50.8, -10_000.0].map(length::from_mm),
        line_number: 10_000_000,
        feed_mm_min: 254.0,
        spindle_rpm: 999.5,
        spindle: SpindleMode::Clockwise,
        coolant: Coolant::Both,
        limits_pressed: [true, false, true],
        drive_alarm: true,
        emergency_stop: true,
        free_blocks: 255,
        free_bytes: u16::MAX,
        ..QUIET
    };
    let mut heard = String::new();
    for (report_mask, report_inches) in [(0, false), (1, false), (2, true), (3, true)] {
        let settings = Settings { report_mask, report_inches, ..Settings::DEFAULT };
        let before = heard.len();
        StatusReporter::new().write(&mut heard, &status, &settings).unwrap();
        assert!(heard.len() - before <= LONGEST_BYTES);
    }
    expect![[r#"
        <Alarm|WPos:25.400,-50.800,0.000|Ln:10000000|FS:254,1000|Pn:XZMR|WCO:0.000,50.800,-10000.000>
        <Alarm|MPos:25.400,0.000,-10000.000|Ln:10000000|FS:254,1000|Pn:XZMR|WCO:0.000,50.800,-10000.000>
        <Alarm|WPos:1.0000,-2.0000,0.0000|Bf:255,65535|Ln:10000000|FS:10.0,1000|Pn:XZMR|WCO:0.0000,2.0000,-393.7008>
        <Alarm|MPos:1.0000,0.0000,-393.7008|Bf:255,65535|Ln:10000000|FS:10.0,1000|Pn:XZMR|WCO:0.0000,2.0000,-393.7008>
    "#]]
    .assert_eq(&heard.replace('\r', ""));
}

/// Every field has its greatest length: the work position includes a system, a shift and a tool length; the feed along
/// three axes at the highest `$110` has 9 digits, and so has twice the greatest S.
#[test]
fn the_longest_report_is_as_long_as_promised() {
    let status = StatusReport {
        state: ReportedState::Door(DoorPhase::Resuming),
        position_pm: [-MAX_COORDINATE_PM; 3],
        work_offset_pm: [-3, 3, -3].map(|times| times * MAX_COORDINATE_PM),
        line_number: 10_000_000,
        feed_mm_min: 1.75e8,
        spindle_rpm: 199_999_984.0,
        actual_rpm: Some(6_553_500_000.0),
        spindle: SpindleMode::CounterClockwise,
        coolant: Coolant::Both,
        probe_touched: true,
        limits_pressed: [true; 3],
        second_limit_pressed: true,
        door_open: true,
        drive_alarm: true,
        emergency_stop: true,
        hold_pressed: true,
        start_pressed: true,
        overrides: Overrides { feed_percent: 200, rapid_percent: 100, spindle_percent: 200 },
        free_blocks: 255,
        free_bytes: u16::MAX,
        homed: [true; 3],
        tool: 99_999,
        system: 8,
        has_tool_reference: true,
    };
    let mut heard = String::new();
    for report_inches in [false, true] {
        let settings = Settings { report_mask: 3, report_inches, ..Settings::DEFAULT };
        let mut reporter = StatusReporter::new();
        for _ in 0..2 {
            let before = heard.len();
            reporter.write(&mut heard, &status, &settings).unwrap();
            assert!(heard.len() - before <= LONGEST_BYTES, "{heard}");
        }
    }
    let position_pm = status.position_pm.map(|pm| pm - 3 * MAX_COORDINATE_PM);
    let status = StatusReport { position_pm, work_offset_pm: [-3 * MAX_COORDINATE_PM; 3], ..status };
    let settings = Settings { report_mask: 3, ..Settings::DEFAULT };
    let before = heard.len();
    StatusReporter::new().write(&mut heard, &status, &settings).unwrap();
    assert_eq!(heard.len() - before, LONGEST_BYTES);
    let before = heard.len();
    StatusReporter::new().write_full(&mut heard, &status, &settings).unwrap();
    assert_eq!(heard.len() - before, LONGEST_FULL_BYTES);
    expect![[r#"
        <Door:3|MPos:-10000.000,-10000.000,-10000.000|Bf:255,65535|Ln:10000000|FS:175000000,199999984,6553500160|Pn:PXYZ2DMRHS|WCO:-30000.000,30000.000,-30000.000|WCS:G59.3|H:1,7|T:99999|TLR:1>
        <Door:3|MPos:-10000.000,-10000.000,-10000.000|Bf:255,65535|Ln:10000000|FS:175000000,199999984,6553500160|Pn:PXYZ2DMRHS|Ov:200,100,200|A:CFM>
        <Door:3|MPos:-393.7008,-393.7008,-393.7008|Bf:255,65535|Ln:10000000|FS:6889764.0,199999984,6553500160|Pn:PXYZ2DMRHS|WCO:-1181.1024,1181.1024,-1181.1024|WCS:G59.3|H:1,7|T:99999|TLR:1>
        <Door:3|MPos:-393.7008,-393.7008,-393.7008|Bf:255,65535|Ln:10000000|FS:6889764.0,199999984,6553500160|Pn:PXYZ2DMRHS|Ov:200,100,200|A:CFM>
        <Door:3|MPos:-40000.000,-40000.000,-40000.000|Bf:255,65535|Ln:10000000|FS:175000000,199999984,6553500160|Pn:PXYZ2DMRHS|WCO:-30000.000,-30000.000,-30000.000|WCS:G59.3|H:1,7|T:99999|TLR:1>
        <Door:3|MPos:-40000.000,-40000.000,-40000.000|Bf:255,65535|Ln:10000000|FS:175000000,199999984,6553500160|Pn:PXYZ2DMRHS|WCO:-30000.000,-30000.000,-30000.000|Ov:200,100,200|A:CFM|WCS:G59.3|H:1,7|T:99999|TLR:1|FW:Isostep>
    "#]].assert_eq(&heard.replace('\r', ""));
}

#[test]
fn pins_are_reported_in_grbls_order() {
    let settings = Settings::DEFAULT;
    let rows = [
        (QUIET, "FS:0,0"),
        (StatusReport { probe_touched: true, ..QUIET }, "Pn:P"),
        (StatusReport { limits_pressed: [false, true, false], ..QUIET }, "Pn:Y"),
        (StatusReport { limits_pressed: [false, true, false], second_limit_pressed: true, ..QUIET }, "Pn:Y2"),
        (StatusReport { door_open: true, ..QUIET }, "Pn:D"),
        (StatusReport { emergency_stop: true, ..QUIET }, "Pn:R"),
        (StatusReport { hold_pressed: true, ..QUIET }, "Pn:H"),
        (StatusReport { start_pressed: true, ..QUIET }, "Pn:S"),
        (
            StatusReport {
                probe_touched: true,
                limits_pressed: [true; 3],
                door_open: true,
                start_pressed: true,
                ..QUIET
            },
            "Pn:PXYZDS",
        ),
        (StatusReport { emergency_stop: true, hold_pressed: true, start_pressed: true, ..QUIET }, "Pn:RHS"),
    ];
    for (status, last) in rows {
        let mut heard = String::new();
        StatusReporter::new().write(&mut heard, &status, &settings).unwrap();
        let heard = heard.replace("|WCO:0.000,0.000,0.000>\r\n", "");
        assert_eq!(heard.rsplit('|').next(), Some(last));
    }
}

#[test]
fn spindle_and_coolant_are_reported_with_the_overrides_and_when_they_change() {
    let mut talk = Talk::new(ReportedState::Idle);
    let extras = |talk: &mut Talk, sent: &[u8]| {
        talk.bytes(sent);
        let heard = [(); 3].map(|()| talk.bytes(b"?"));
        heard.map(|line| line.split_once("|FS:").unwrap().1.trim_end_matches('>').to_owned())
    };
    let rows: &[(&[u8], [&str; 3])] = &[
        (b"", ["0,0|WCO:0.000,0.000,0.000", "0,0|Ov:100,100,100", "0,0"]),
        (b"M3 S1000.5\n", ["0,1001|Ov:100,100,100|A:S", "0,1001", "0,1001"]),
        (b"S500\n", ["0,500", "0,500", "0,500"]),
        (b"M7\n", ["0,500|Ov:100,100,100|A:SM", "0,500|WCO:0.000,0.000,0.000", "0,500"]),
        (b"M4 M8\n", ["0,500|Ov:100,100,100|A:CFM", "0,500", "0,500"]),
        (b"M5\nG92 X1\n", ["0,0|WCO:-1.000,0.000,0.000", "0,0|Ov:100,100,100|A:FM", "0,0"]),
        (b"M9 M8 \nM9\nM8\n", ["0,0|Ov:100,100,100|A:F", "0,0", "0,0"]),
        (b"M9\n", ["0,0|Ov:100,100,100", "0,0", "0,0"]),
    ];
    for &(sent, reported) in rows {
        assert_eq!(extras(&mut talk, sent), reported, "{}", String::from_utf8_lossy(sent));
    }
}

#[test]
fn states_print_as_grbl_prints_them() {
    let states = [
        (ReportedState::Idle, "Idle"),
        (ReportedState::Run, "Run"),
        (ReportedState::Hold { stopping: false }, "Hold:0"),
        (ReportedState::Hold { stopping: true }, "Hold:1"),
        (ReportedState::Door(DoorPhase::Closed), "Door:0"),
        (ReportedState::Door(DoorPhase::Open), "Door:1"),
        (ReportedState::Door(DoorPhase::Stopping), "Door:2"),
        (ReportedState::Door(DoorPhase::Resuming), "Door:3"),
        (ReportedState::Jog, "Jog"),
        (ReportedState::Home, "Home"),
        (ReportedState::Alarm, "Alarm"),
        (ReportedState::Check, "Check"),
        (ReportedState::Sleep, "Sleep"),
    ];
    for (state, name) in states {
        let heard = Talk::new(state).bytes(b"?");
        assert_eq!(heard, format!("<{name}|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>"));
    }
}

#[test]
fn a_changed_offset_unit_or_override_is_reported_at_once() {
    let mut talk = Talk::new(ReportedState::Idle);
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
        let mut talk = Talk::new(ReportedState::Idle);
        let heard = talk.bytes(&bytes);
        let replies = heard.split(' ').filter(|word| *word == "ok" || word.starts_with("error:")).count();
        prop_assert_eq!(replies, bytes.iter().filter(|byte| matches!(byte, b'\r' | b'\n')).count());
        prop_assert!(talk.interpreter.position_pm().iter().all(|pm| pm.abs() <= MAX_COORDINATE_PM));
        prop_assert_eq!(talk.settings.check(&super::talk::carries), Ok(()));
    }

    #[test]
    fn targets_are_read_exactly(pm in (-999_999_999_999..1_000_000_000_000i64).prop_map(|tens| 10 * tens)) {
        let mut interpreter = isostep_console::Interpreter::new();
        let (sign, magnitude) = (if pm < 0 { "-" } else { "" }, pm.abs() / 10);
        let line = format!("X{sign}{}.{:08}", magnitude / 100_000_000, magnitude % 100_000_000);
        let command = interpreter.interpret(&line, ReportedState::Idle, &Settings::DEFAULT);
        let isostep_console::Command::Block(block) = command.unwrap() else { panic!("a block") };
        let Some(BlockMove { target_pm, .. }) = block.motion else { panic!("a move") };
        prop_assert_eq!(target_pm[0], pm);
    }
}
