//! G-code as Grbl reads it: what each line does, or why it is refused.

use super::talk::{Talk, check};
use expect_test::expect;
use isostep_console::{Interpreter, PathControl, ReportedState, Settings};

#[test]
fn motion_is_modal_and_needs_a_feed() {
    check(
        "G1 X1\nG0 X1 Y2\nZ3\nG1\nG1 F600\nX-4.5\nF0 X1\nF.5 X1\nF1 X1\nG80\nX1\nG0",
        expect![[r#"
            G1 X1 -> error:22
            G0 X1 Y2 -> (rapid [1.0, 2.0, 0.0]) ok
            Z3 -> (rapid [1.0, 2.0, 3.0]) ok
            G1 -> error:22
            G1 F600 -> ok
            X-4.5 -> (feed 600 [-4.5, 2.0, 3.0]) ok
            F0 X1 -> error:22
            F.5 X1 -> (feed 1 [1.0, 2.0, 3.0]) ok
            F1 X1 -> (feed 1 [1.0, 2.0, 3.0]) ok
            G80 -> ok
            X1 -> (feed 1 [1.0, 2.0, 3.0]) ok
            G0 -> ok
        "#]],
    );
}

/// P is in the units of its block and stays in force; G64 without one, M2 and a reset go back to the setting's.
#[test]
fn g64_says_how_far_the_path_may_leave_a_corner() {
    let (mut interpreter, settings) = (Interpreter::new(), Settings::DEFAULT);
    let paths = [
        ("G0 X1", PathControl::Blend),
        ("G64 P0.05 X2", within(0.05, None)),
        ("X3", within(0.05, None)),
        ("G20 G64 P.5 X1", within(12.7, None)),
        ("G21 G64 X3", PathControl::Blend),
        ("G61 X4", PathControl::Exact),
        ("G61.1 X5", PathControl::Stop),
        ("G64 P0 X6", within(0.0, None)),
        ("G64 P0.05 Q0.01 X7", within(0.05, Some(0.01))),
        ("G20 G64 Q0 P.5 X1", within(12.7, Some(0.0))),
        ("G21 G64 G10 L2 P2 X0", PathControl::Blend),
    ];
    for (line, path) in paths {
        let block = interpreter.gcode(&line.replace(' ', ""), &settings).unwrap();
        assert_eq!(interpreter.modal().path, path, "{line}");
        assert!(block.motion.is_none_or(|motion| motion.path == path), "{line}");
    }
    interpreter.gcode("G64P1", &settings).unwrap();
    for refused in ["G64P2R1", "G64Q1", "G64P2Q-1", "G61P1Q1", "G4P1Q1", "Q1"] {
        assert!(interpreter.gcode(refused, &settings).is_err(), "{refused}");
    }
    assert_eq!(interpreter.modal().path, within(1.0, None), "a refused block changes nothing");
    interpreter.gcode("M2", &settings).unwrap();
    assert_eq!(interpreter.modal().path, PathControl::Blend);
    for (path, setting_mm, wanted_mm) in [
        (PathControl::Blend, 0.02, 0.02),
        (within(0.0, None), 0.02, 0.0),
        (within(0.05, None), 0.02, 0.05),
        (PathControl::Exact, 0.02, 0.0),
        (PathControl::Stop, 0.02, 0.0),
    ] {
        assert_eq!(path.deviation_mm(setting_mm), wanted_mm, "{path:?}");
    }
    for (path, wanted_mm) in [
        (PathControl::Blend, 0.02),
        (within(0.02, None), 0.01),
        (within(0.02, Some(0.004)), 0.004),
        (within(0.02, Some(0.5)), 0.01),
        (within(0.02, Some(0.0)), 0.0),
        (PathControl::Exact, 0.0),
        (PathControl::Stop, 0.0),
    ] {
        assert_eq!(path.together_mm(0.04), wanted_mm, "{path:?}");
    }
}

fn within(deviation_mm: f32, together_mm: Option<f32>) -> PathControl {
    PathControl::BlendWithin { deviation_mm, together_mm }
}

#[test]
fn g64_is_listed_while_it_makes_a_difference() {
    check(
        "$G\nG61\n$G\nG64 P0\n$G\nG64\n$G\n$904=0\n$G\nG64 P.01\n$G\nG61\n$G",
        expect![[r#"
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            G61 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G61 M5 M9 T0 F0 S0] ok
            G64 P0 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G61 M5 M9 T0 F0 S0] ok
            G64 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            $904=0 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0] ok
            G64 P.01 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            G61 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0] ok
        "#]],
    );
}

#[test]
fn inches_scale_targets_and_feeds_and_increments_add_up() {
    check(
        "G20 G1 X1 F10\nG91 X1 Y-1\nG21 X.2\nG90 X.2\n$G",
        expect![[r#"
        G20 G1 X1 F10 -> (feed 254 [25.4, 0.0, 0.0]) ok
        G91 X1 Y-1 -> (feed 254 [50.8, -25.4, 0.0]) ok
        G21 X.2 -> (feed 254 [51.0, -25.4, 0.0]) ok
        G90 X.2 -> (feed 254 [0.2, -25.4, 0.0]) ok
        $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T0 F254 S0] ok
    "#]],
    );
}

#[test]
fn dwell_comes_before_motion_and_the_end_after_it() {
    check(
        "G4 P1.5\nG4\nG4 P-1\nG4 P.1 X1\nG0 X2 M30\nM2 G4 P1",
        expect![[r#"
        G4 P1.5 -> (wait 1.5 s) ok
        G4 -> error:28
        G4 P-1 -> error:4
        G4 P.1 X1 -> (wait 0.1 s) (rapid [1.0, 0.0, 0.0]) ok
        G0 X2 M30 -> (rapid [2.0, 0.0, 0.0]) (end) ok
        M2 G4 P1 -> (wait 1 s) (end) ok
    "#]],
    );
}

/// An incremental distance counts from the start of the move: neither a shift of the zero nor an offset affects it.
#[test]
fn an_incremental_way_is_as_long_under_every_offset() {
    check(
        "G0 X5 Y6 Z7\nG92 X100 Y-20 Z0\nG91 G0 X1 Y1 Z1\nG10 L2 P1 X3 Y4\nX1 Y1 Z1\nG55\nX1\nG43.1 Z2\nZ1\nG92.1\nX1 Y1 Z1\n$J=G91 X1 F100\nG90 X0\n$J=G91 X1 F100\nG91 G28 X1",
        expect![[r#"
            G0 X5 Y6 Z7 -> (rapid [5.0, 6.0, 7.0]) ok
            G92 X100 Y-20 Z0 -> ok
            G91 G0 X1 Y1 Z1 -> (rapid [6.0, 7.0, 8.0]) ok
            G10 L2 P1 X3 Y4 -> ok
            X1 Y1 Z1 -> (rapid [7.0, 8.0, 9.0]) ok
            G55 -> ok
            X1 -> (rapid [8.0, 8.0, 9.0]) ok
            G43.1 Z2 -> ok
            Z1 -> (rapid [8.0, 8.0, 10.0]) ok
            G92.1 -> ok
            X1 Y1 Z1 -> (rapid [9.0, 9.0, 11.0]) ok
            $J=G91 X1 F100 -> (jog 100 [10.0, 9.0, 11.0]) ok
            G90 X0 -> (rapid [0.0, 9.0, 11.0]) ok
            $J=G91 X1 F100 -> (jog 100 [1.0, 9.0, 11.0]) ok
            G91 G28 X1 -> (via [2.0, 9.0, 11.0]) (rapid [0.0, 9.0, 11.0]) ok
        "#]],
    );
}

#[test]
fn the_end_of_a_program_puts_back_modes_but_not_units_and_feed() {
    check(
        "G20 G91 G0 F10 M3 S100 M8 T2\n$G\nM30\n$G",
        expect![[r#"
            G20 G91 G0 F10 M3 S100 M8 T2 -> (spindle) (speed) (coolant) ok
            $G -> [GC:G0 G54 G17 G20 G91 G94 G64 M3 M8 T2 F254 S100] ok
            M30 -> (end) ok
            $G -> [GC:G1 G54 G17 G20 G90 G94 G64 M5 M9 T2 F254 S100] ok
        "#]],
    );
}

#[test]
fn codes_that_change_nothing_are_accepted() {
    check(
        "G17 G21 G40 G49 G54 G61 G80 G90 G91.1 G94 M5 M9\nG90 G54 G64 G50 G17 G40 G80 G94 G91.1 G49 G69\nG61\nG50 G50\nG51 X2\nG68 R5\nG50.1\nG70 X1\nG71 G20\nG71\nX0\nM1\nT3\n$G\nN12",
        expect![[r#"
            G17 G21 G40 G49 G54 G61 G80 G90 G91.1 G94 M5 M9 -> ok
            G90 G54 G64 G50 G17 G40 G80 G94 G91.1 G49 G69 -> ok
            G61 -> ok
            G50 G50 -> error:21
            G51 X2 -> [MSG:G51: no scaling here: let the CAM program scale] error:20
            G68 R5 -> [MSG:G68: no rotation here: let the CAM program rotate] error:20
            G50.1 -> error:23
            G70 X1 -> (rapid [25.4, 0.0, 0.0]) ok
            G71 G20 -> error:21
            G71 -> ok
            X0 -> (rapid [0.0, 0.0, 0.0]) ok
            M1 -> ok
            T3 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G61 M5 M9 T3 F0 S0] ok
            N12 -> (N12) ok
        "#]],
    );
}

#[test]
fn a_line_that_is_only_a_percent_sign_is_an_empty_line() {
    check(
        "%\n % (begin)\n%1\n%%\nX1 %\n%;end\nN1 %",
        expect![[r#"
            % -> ok
             % (begin) -> ok
            %1 -> ok
            %% -> ok
            X1 % -> error:1
            %;end -> ok
            N1 % -> error:1
        "#]],
    );
    for state in ReportedState::ALL {
        let mut talk = Talk::new(state);
        assert_eq!(talk.bytes(b"%\n"), talk.bytes(b"\n"), "{state}");
        assert_eq!(talk.bytes(b"%\n"), "ok", "{state}");
    }
}

#[test]
fn g64_is_as_g61_and_its_p_has_no_effect() {
    check(
        "G61.1\n$G\nG64\n$G\nG61.1 X1\nG64 P0.05 X2\nG64 P.05\nP.05\nG64 P0.1 G4 P2\nG4 P2 G64\nG64 G4\nG64 P-1\nG64 G61\nG61.1 G64\nG64 G64\nG64 G10 L2 P2 X5\nG64 P1 Q1\n$J=G64 X1 F1",
        expect![[r#"
            G61.1 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G61.1 M5 M9 T0 F0 S0] ok
            G64 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            G61.1 X1 -> (rapid [1.0, 0.0, 0.0]) (stop) ok
            G64 P0.05 X2 -> (rapid [2.0, 0.0, 0.0]) ok
            G64 P.05 -> ok
            P.05 -> [MSG:P: no code on the line uses it: remove it, or add the code that does] error:36
            G64 P0.1 G4 P2 -> error:25
            G4 P2 G64 -> (wait 2 s) ok
            G64 G4 -> error:28
            G64 P-1 -> error:4
            G64 G61 -> error:21
            G61.1 G64 -> error:21
            G64 G64 -> error:21
            G64 G10 L2 P2 X5 -> ok
            G64 P1 Q1 -> ok
            $J=G64 X1 F1 -> error:16
        "#]],
    );
}

#[test]
fn a_tool_change_is_carried_out_before_the_rest_of_its_line() {
    check(
        "M6\nT3 M6\nM6\nT4\nG0 X1 M6\nM6 T5 G4 P1\nT6 M6 M0\nM6 M0 X2\nM6 M0 G4 P1\nM6 M30\nM6 M6\nM6.1\n$G\n$J=M6 X1 F1\nT256 M6\nM61 D3",
        expect![[r#"
            M6 -> (tool 0) ok
            T3 M6 -> (tool 3) ok
            M6 -> ok
            T4 -> ok
            G0 X1 M6 -> (tool 4) (rapid [1.0, 0.0, 0.0]) ok
            M6 T5 G4 P1 -> (tool 5) (wait 1 s) ok
            T6 M6 M0 -> (tool 6) ok
            M6 M0 X2 -> (rapid [2.0, 0.0, 0.0]) (pause) ok
            M6 M0 G4 P1 -> (wait 1 s) (pause) ok
            M6 M30 -> (end) ok
            M6 M6 -> error:21
            M6.1 -> error:23
            $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T6 F0 S0] ok
            $J=M6 X1 F1 -> error:16
            T256 M6 -> (tool 256) ok
            M61 D3 -> [MSG:M61: unknown here: remove it] error:20
        "#]],
    );
}

#[test]
fn clashes_repeats_and_leftovers_are_refused() {
    check(
        "G0 G1\nG20 G21\nG90 G91\nG17 G18\nG54 G55\nG93 G94\nM3 M5\nM8 M9\nM2 M30\nM0 M2\nG4 G28 P1\nX1 X2\nG0 X1 P1\nG0 X1 I1\nS1 S2\nM1.5\nG1.5\nG54.1\nG59.4\nG10 G0 L2 P1 X1\nG43.1 G0 Z1\nG92 G49 X1\nG92 G53 X1",
        expect![[r#"
            G0 G1 -> error:24
            G20 G21 -> error:21
            G90 G91 -> error:21
            G17 G18 -> error:21
            G54 G55 -> error:21
            G93 G94 -> error:21
            M3 M5 -> error:21
            M8 M9 -> error:21
            M2 M30 -> error:21
            M0 M2 -> error:21
            G4 G28 P1 -> error:21
            X1 X2 -> error:25
            G0 X1 P1 -> [MSG:P: no code on the line uses it: remove it, or add the code that does] error:36
            G0 X1 I1 -> [MSG:I: no code on the line uses it: remove it, or add the code that does] error:36
            S1 S2 -> error:25
            M1.5 -> error:23
            G1.5 -> error:23
            G54.1 -> error:23
            G59.4 -> error:23
            G10 G0 L2 P1 X1 -> error:24
            G43.1 G0 Z1 -> error:24
            G92 G49 X1 -> ok
            G92 G53 X1 -> error:21
        "#]],
    );
}

#[test]
fn numbers_have_limits() {
    check(
        "N9999999 X1\nN10000000\nX10000\nX10000.1\nG91 X1\nX100000000\nX\nX1.2.3\n5\nT255\nT256\nF-1\nS-1\nG0 N5 X1\nG999999999",
        expect![[r#"
            N9999999 X1 -> (N9999999) (rapid [1.0, 0.0, 0.0]) ok
            N10000000 -> (N10000000) ok
            X10000 -> (rapid [10000.0, 0.0, 0.0]) ok
            X10000.1 -> error:33
            G91 X1 -> error:33
            X100000000 -> error:2
            X -> error:2
            X1.2.3 -> error:1
            5 -> error:1
            T255 -> ok
            T256 -> ok
            F-1 -> error:4
            S-1 -> error:4
            G0 N5 X1 -> (N5) (rapid [1.0, 0.0, 0.0]) ok
            G999999999 -> error:2
        "#]],
    );
}

#[test]
fn a_refused_line_changes_nothing() {
    let mut talk = Talk::new(ReportedState::Idle);
    talk.send("G1 X5 F100");
    let before = talk.interpreter;
    for line in [
        "G20 G91 F5 M3 S9 T1 X1 P1",
        "G61.1 G18 G2 X9 I9 K9",
        "G3 X1 R1",
        "G91 X1 X2",
        "G0 X99999",
        "G20 G4",
        "G80 G53 X1",
        "G20 @",
    ] {
        assert!(talk.send(line).contains("error:"), "{line}");
        assert_eq!(talk.interpreter, before, "{line}");
    }
}

#[test]
fn in_alarm_and_while_homing_g_code_is_refused_and_changes_nothing() {
    for (state, error) in [(ReportedState::Alarm, "error:9"), (ReportedState::Home, "error:8")] {
        let mut talk = Talk::new(state);
        assert_eq!(talk.bytes(b"G20 X1\n"), error);
        assert_eq!(talk.interpreter, Talk::new(state).interpreter);
        assert_eq!(talk.bytes(b"(only a comment)\r\n"), "ok ok");
    }
}

#[test]
fn the_position_follows_what_the_caller_says() {
    let mut talk = Talk::new(ReportedState::Idle);
    talk.interpreter.set_position_pm([1, 2, 3].map(|mm| mm * 1_000_000_000));
    assert_eq!(talk.bytes(b"G91 X1\n"), "(rapid [2.0, 2.0, 3.0]) ok");
    talk.interpreter.reset();
    assert_eq!(talk.bytes(b"Y5\n"), "(rapid [2.0, 5.0, 3.0]) ok");
}

#[test]
fn inverse_time_is_for_its_block_alone() {
    // The path of 3 and 4 mm is 5 mm long; twice a minute is 10 mm/min.
    check(
        "G93 G1 X3 Y4 F2\nX0\nG1 X1\nX1 Y4 F.1\nG0 X0 Y0\n$G\nF7\n$G\nG94 G1 X5\nG94 X5 F100\nX6\nG93\nG94 G1 X7\nG20 G93 G1 X1 F1\nG94 G1 X0 F1",
        expect![[r#"
            G93 G1 X3 Y4 F2 -> (feed 10 [3.0, 4.0, 0.0]) ok
            X0 -> error:22
            G1 X1 -> error:22
            X1 Y4 F.1 -> (feed 1 [1.0, 4.0, 0.0]) ok
            G0 X0 Y0 -> (rapid [0.0, 0.0, 0.0]) ok
            $G -> [GC:G0 G54 G17 G21 G90 G93 G64 M5 M9 T0 F0 S0] ok
            F7 -> ok
            $G -> [GC:G0 G54 G17 G21 G90 G93 G64 M5 M9 T0 F7 S0] ok
            G94 G1 X5 -> error:22
            G94 X5 F100 -> (rapid [5.0, 0.0, 0.0]) ok
            X6 -> (rapid [6.0, 0.0, 0.0]) ok
            G93 -> ok
            G94 G1 X7 -> error:22
            G20 G93 G1 X1 F1 -> (feed 19.4 [25.4, 0.0, 0.0]) ok
            G94 G1 X0 F1 -> (feed 25.4 [0.0, 0.0, 0.0]) ok
        "#]],
    );
}

#[test]
fn g53_is_absolute_whatever_the_mode_and_needs_a_motion() {
    check(
        "G10 L2 P1 X100\nG91 G53 G0 X1\nG53\nG90 G53 G1 X2 F10\nX3\nG80\nG53 X1\nG53\nG53 G0 X1",
        expect![[r#"
        G10 L2 P1 X100 -> ok
        G91 G53 G0 X1 -> (rapid [1.0, 0.0, 0.0]) ok
        G53 -> ok
        G90 G53 G1 X2 F10 -> (feed 10 [2.0, 0.0, 0.0]) ok
        X3 -> (feed 10 [103.0, 0.0, 0.0]) ok
        G80 -> ok
        G53 X1 -> error:30
        G53 -> error:30
        G53 G0 X1 -> (rapid [1.0, 0.0, 0.0]) ok
    "#]],
    );
}

/// As RS274/NGC has it. Only what is left over is refused.
#[test]
fn axis_words_in_g80_are_those_of_the_code_that_takes_them() {
    check(
        "G0 X5 Y5\nG80\nG92 X1\nG10 L2 P1 X1\nG43.1 Z1\nG28 X1\nG28\nX1\nG28.1 X1\nG4 P1 X1\nG92.1\nG80 G30 Y1\nG92 X1 G28\n$#",
        expect![[r#"
            G0 X5 Y5 -> (rapid [5.0, 5.0, 0.0]) ok
            G80 -> ok
            G92 X1 -> ok
            G10 L2 P1 X1 -> ok
            G43.1 Z1 -> ok
            G28 X1 -> (via [6.0, 5.0, 0.0]) (rapid [0.0, 5.0, 0.0]) ok
            G28 -> (rapid [0.0, 0.0, 0.0]) ok
            X1 -> (rapid [6.0, 0.0, 0.0]) ok
            G28.1 X1 -> (rapid [6.0, 0.0, 0.0]) ok
            G4 P1 X1 -> (wait 1 s) (rapid [6.0, 0.0, 0.0]) ok
            G92.1 -> ok
            G80 G30 Y1 -> (via [6.0, 1.0, 0.0]) (rapid [6.0, 0.0, 0.0]) ok
            G92 X1 G28 -> error:24
            $# -> [G54:1.000,0.000,0.000] [G55:0.000,0.000,0.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,0.000] [G59.1:0.000,0.000,0.000] [G59.2:0.000,0.000,0.000] [G59.3:0.000,0.000,0.000] [G28:6.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,0.000] [TLO:1.000] [PRB:0.000,0.000,0.000:0] ok
        "#]],
    );
}

/// The line with which many CAM programs begin.
#[test]
fn g49_takes_no_axis_words_and_g80_stands_beside_a_motion() {
    check(
        "G1 F100\nG0 G40 G49 G80 G17\nX1\nG80 G0 X2\nG80 G1 X3\nG80\n$G\nG1 X4\nG43.1 Z5\nG49 Z1\nG49 G43.1 Z1\nG0 G80 G1\nG80 G80\nG53 G80 X1\nG53 G0 G80 X1\n$J=G80 X1 F1",
        expect![[r#"
            G1 F100 -> ok
            G0 G40 G49 G80 G17 -> ok
            X1 -> (rapid [1.0, 0.0, 0.0]) ok
            G80 G0 X2 -> (rapid [2.0, 0.0, 0.0]) ok
            G80 G1 X3 -> (feed 100 [3.0, 0.0, 0.0]) ok
            G80 -> ok
            $G -> [GC:G80 G54 G17 G21 G90 G94 G64 M5 M9 T0 F100 S0] ok
            G1 X4 -> (feed 100 [4.0, 0.0, 0.0]) ok
            G43.1 Z5 -> ok
            G49 Z1 -> (feed 100 [4.0, 0.0, 1.0]) ok
            G49 G43.1 Z1 -> error:21
            G0 G80 G1 -> error:24
            G80 G80 -> error:21
            G53 G80 X1 -> error:30
            G53 G0 G80 X1 -> (rapid [1.0, 0.0, 1.0]) ok
            $J=G80 X1 F1 -> error:16
        "#]],
    );
}

#[test]
fn pauses_and_line_numbers_come_with_their_block() {
    check(
        "N7 G0 X1 M0\nM1\nN1.9 M0\nN-1\nN0 X2",
        expect![[r#"
            N7 G0 X1 M0 -> (N7) (rapid [1.0, 0.0, 0.0]) (pause) ok
            M1 -> ok
            N1.9 M0 -> error:23
            N-1 -> error:4
            N0 X2 -> (rapid [2.0, 0.0, 0.0]) ok
        "#]],
    );
}

#[test]
fn planes_and_feed_modes_are_kept_for_the_modal_state() {
    check(
        "G18 G59 G93 G20 G91 M4 M7\n$G\nM8\n$G\nM2\n$G",
        expect![[r#"
            G18 G59 G93 G20 G91 M4 M7 -> (spindle) (coolant) ok
            $G -> [GC:G0 G59 G18 G20 G91 G93 G64 M4 M7 T0 F0 S0] ok
            M8 -> (coolant) ok
            $G -> [GC:G0 G59 G18 G20 G91 G93 G64 M4 M7 M8 T0 F0 S0] ok
            M2 -> (end) ok
            $G -> [GC:G1 G54 G17 G20 G90 G94 G64 M5 M9 T0 F0 S0] ok
        "#]],
    );
}

#[test]
fn a_jog_changes_no_mode() {
    check(
        "$J=X10 F100\n$J=G91 X1 Y-1 F200\n$J=G20 X1 F10\n$J=G91 G21 G53 Z5 F1 N3\n$G\nG91 G20\n$J=X1 F10\n$J=G90 G21 X1 F10\nG93 G80\n$J=X1 F10\n$G",
        expect![[r#"
            $J=X10 F100 -> (jog 100 [10.0, 0.0, 0.0]) ok
            $J=G91 X1 Y-1 F200 -> (jog 200 [11.0, -1.0, 0.0]) ok
            $J=G20 X1 F10 -> (jog 254 [25.4, -1.0, 0.0]) ok
            $J=G91 G21 G53 Z5 F1 N3 -> (jog 1 [25.4, -1.0, 5.0]) ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            G91 G20 -> ok
            $J=X1 F10 -> (jog 254 [50.8, -1.0, 5.0]) ok
            $J=G90 G21 X1 F10 -> (jog 10 [1.0, -1.0, 5.0]) ok
            G93 G80 -> ok
            $J=X1 F10 -> (jog 254 [26.4, -1.0, 5.0]) ok
            $G -> [GC:G80 G54 G17 G20 G91 G93 G64 M5 M9 T0 F0 S0] ok
        "#]],
    );
}

#[test]
fn a_jog_takes_nothing_else() {
    check(
        "$J=X1\n$J=F100\n$J=\n$J\n$JX1F1\n$J=X1 F.5\n$J=X1 F0\n$J=X1 F-1\n$J=X1 F1 S5\n$J=X1 F1 T1\n$J=X1 F1 P1\n$J=G0 X1 F1\n$J=G1 X1 F1\n$J=M3 X1 F1\n$J=G55 X1 F1\n$J=G28 X1 F1\n$J=G92 X1 F1\n$J=G4 X1 F1\n$J=G93 X1 F1\n$J=X1 X2 F1\n$J=X20000 F1\n$J=D1\n$J=X F1\n$J=G20 G21 X1 F1\n$J=X1 F1 N10000001",
        expect![[r#"
            $J=X1 -> error:22
            $J=F100 -> error:26
            $J= -> error:22
            $J -> error:16
            $JX1F1 -> error:16
            $J=X1 F.5 -> (jog 1 [1.0, 0.0, 0.0]) ok
            $J=X1 F0 -> error:22
            $J=X1 F-1 -> error:4
            $J=X1 F1 S5 -> error:36
            $J=X1 F1 T1 -> error:36
            $J=X1 F1 P1 -> error:36
            $J=G0 X1 F1 -> error:16
            $J=G1 X1 F1 -> error:16
            $J=M3 X1 F1 -> error:16
            $J=G55 X1 F1 -> error:16
            $J=G28 X1 F1 -> error:16
            $J=G92 X1 F1 -> error:16
            $J=G4 X1 F1 -> error:16
            $J=G93 X1 F1 -> error:16
            $J=X1 X2 F1 -> error:25
            $J=X20000 F1 -> error:33
            $J=D1 -> [MSG:D: no cutter compensation here: let the CAM program compensate] error:20
            $J=X F1 -> error:2
            $J=G20 G21 X1 F1 -> error:21
            $J=X1 F1 N10000001 -> error:27
        "#]],
    );
}
