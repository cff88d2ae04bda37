//! G-code as Grbl reads it: what each line does, or why it is refused.

use crate::talk::Talk;
use expect_test::{Expect, expect};
use isostep_console::State;

fn check(program: &str, heard: Expect) {
    heard.assert_eq(&Talk::new(State::Idle).send(program));
}

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
        F.5 X1 -> error:22
        F1 X1 -> (feed 1 [1.0, 2.0, 3.0]) ok
        G80 -> ok
        X1 -> error:31
        G0 -> ok
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
        $G -> [GC:G1 G54 G17 G21 G90 G94 M5 M9 T0 F254 S0] ok
    "#]],
    );
}

#[test]
fn g28_goes_home_by_way_of_the_axes_named() {
    check(
        "G0 X10 Y20 Z30\nG28 Z5\nG91 G28 X1\nG28\nG28 G0 X1\nG1 G28 X1\nG28.1",
        expect![[r#"
            G0 X10 Y20 Z30 -> (rapid [10.0, 20.0, 30.0]) ok
            G28 Z5 -> (go to [10.0, 20.0, 0.0] via Some([10.0, 20.0, 5.0])) ok
            G91 G28 X1 -> (go to [0.0, 20.0, 0.0] via Some([11.0, 20.0, 0.0])) ok
            G28 -> (go to [0.0, 0.0, 0.0] via None) ok
            G28 G0 X1 -> error:24
            G1 G28 X1 -> error:24
            G28.1 -> ok
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

#[test]
fn the_end_of_a_program_puts_back_modes_but_not_units_and_feed() {
    check(
        "G20 G91 G0 F10 M3 S100 M8 T2\n$G\nM30\n$G",
        expect![[r#"
        G20 G91 G0 F10 M3 S100 M8 T2 -> ok
        $G -> [GC:G0 G54 G17 G20 G91 G94 M3 M8 T2 F254 S100] ok
        M30 -> (end) ok
        $G -> [GC:G1 G54 G17 G20 G90 G94 M5 M9 T2 F254 S100] ok
    "#]],
    );
}

#[test]
fn codes_that_change_nothing_here_are_accepted() {
    check(
        "G17 G21 G40 G49 G54 G61 G80 G90 G91.1 G94 M5 M9\nM1\nM3 S1000\nM4\nM7\nM8\nT3\n$G\nM9\n$G\nN12\n%",
        expect![[r#"
            G17 G21 G40 G49 G54 G61 G80 G90 G91.1 G94 M5 M9 -> ok
            M1 -> ok
            M3 S1000 -> ok
            M4 -> ok
            M7 -> ok
            M8 -> ok
            T3 -> ok
            $G -> [GC:G80 G54 G17 G21 G90 G94 M4 M7 M8 T3 F0 S1000] ok
            M9 -> ok
            $G -> [GC:G80 G54 G17 G21 G90 G94 M4 M9 T3 F0 S1000] ok
            N12 -> (N12) ok
            % -> error:1
        "#]],
    );
}

#[test]
fn what_the_gantry_lacks_is_refused_by_name() {
    check(
        "G2 X1 I1\nG10 L2\nG18\nG53 G0 X1\nG55\nG92 X0\nG93\nG43.1 Z1\nG38.2 Z-1\nM0\nM6\nA1\nO100\nG1.5",
        expect![[r#"
            G2 X1 I1 -> [MSG:no arcs here: post-process G2 and G3 into G1] error:20
            G10 L2 -> error:26
            G18 -> ok
            G53 G0 X1 -> (rapid [1.0, 0.0, 0.0]) ok
            G55 -> ok
            G92 X0 -> ok
            G93 -> ok
            G43.1 Z1 -> ok
            G38.2 Z-1 -> [MSG:no probe here: remove G38] error:20
            M0 -> (pause) ok
            M6 -> [MSG:no tool changer here: stop with M0, change by hand] error:20
            A1 -> error:20
            O100 -> error:20
            G1.5 -> error:23
        "#]],
    );
}

#[test]
fn clashes_repeats_and_leftovers_are_refused() {
    check(
        "G0 G1\nG20 G21\nG90 G91\nM3 M5\nM2 M30\nG4 G28 P1\nX1 X2\nG0 X1 P1\nG0 X1 I1\nS1 S2\nM1.5",
        expect![[r#"
            G0 G1 -> error:24
            G20 G21 -> error:21
            G90 G91 -> error:21
            M3 M5 -> error:21
            M2 M30 -> error:21
            G4 G28 P1 -> error:21
            X1 X2 -> error:25
            G0 X1 P1 -> error:36
            G0 X1 I1 -> error:36
            S1 S2 -> error:25
            M1.5 -> error:23
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
            T256 -> error:38
            F-1 -> error:4
            S-1 -> error:4
            G0 N5 X1 -> (N5) (rapid [1.0, 0.0, 0.0]) ok
            G999999999 -> error:2
        "#]],
    );
}

#[test]
fn a_refused_line_changes_nothing() {
    let mut talk = Talk::new(State::Idle);
    talk.send("G1 X5 F100");
    let before = talk.interpreter.clone();
    for line in ["G20 G91 F5 M3 S9 T1 X1 P1", "G91 X1 X2", "G0 X99999", "G20 G4", "G80 X1", "G20 @"] {
        assert!(talk.send(line).contains("error:"), "{line}");
        assert_eq!(talk.interpreter, before, "{line}");
    }
}

#[test]
fn in_alarm_and_while_homing_g_code_is_refused_and_changes_nothing() {
    for (state, error) in [(State::Alarm, "error:9"), (State::Home, "error:8")] {
        let mut talk = Talk::new(state);
        assert_eq!(talk.bytes(b"G20 X1\n"), error);
        assert_eq!(talk.interpreter, Talk::new(state).interpreter);
        assert_eq!(talk.bytes(b"(only a comment)\r\n"), "ok ok");
    }
}

#[test]
fn the_position_follows_what_the_caller_says() {
    let mut talk = Talk::new(State::Idle);
    talk.interpreter.set_position_mm([1.0, 2.0, 3.0]);
    assert_eq!(talk.bytes(b"G91 X1\n"), "(rapid [2.0, 2.0, 3.0]) ok");
    talk.interpreter.reset();
    assert_eq!(talk.bytes(b"Y5\n"), "(rapid [2.0, 5.0, 3.0]) ok");
}
