//! Spindle and coolant as Grbl reads them: what changes, and when.

use super::talk::{Talk, check};
use expect_test::expect;
use isostep_console::{Coolant, ReportedState};

#[test]
fn spindle_speed_and_coolant_are_reported_when_they_change() {
    check(
        "S500\nM3\nM3 S500\nM3 S600\nM4\nM5\nM5 S0\nM7\nM7\nM8\nM8\nM9\nM9\nM8 M3 S1 G4 P1 G0 X1\n$G\nM4 P1\nM3 M4\nM3.2\nS-1\nM7 M8\n$G\nM5 S9 X2",
        expect![[r#"
            S500 -> (speed) ok
            M3 -> (spindle) ok
            M3 S500 -> ok
            M3 S600 -> (speed) ok
            M4 -> (spindle) ok
            M5 -> (spindle) ok
            M5 S0 -> (speed) ok
            M7 -> (coolant) ok
            M7 -> ok
            M8 -> (coolant) ok
            M8 -> ok
            M9 -> (coolant) ok
            M9 -> ok
            M8 M3 S1 G4 P1 G0 X1 -> (spindle) (speed) (coolant) (wait 1 s) (rapid [1.0, 0.0, 0.0]) ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M3 M8 T0 F0 S1] ok
            M4 P1 -> [MSG:P: no code on the line uses it: remove it, or add the code that does] error:36
            M3 M4 -> error:21
            M3.2 -> error:23
            S-1 -> error:4
            M7 M8 -> error:21
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M3 M8 T0 F0 S1] ok
            M5 S9 X2 -> (spindle) (speed) (rapid [2.0, 0.0, 0.0]) ok
        "#]],
    );
}

#[test]
fn the_end_of_a_program_leaves_spindle_and_coolant_to_the_caller() {
    check(
        "M3 S100 M8\nM2\n$G\nM3\nM30\nM5 M9\nM3 S7 M30\n$G",
        expect![[r#"
        M3 S100 M8 -> (spindle) (speed) (coolant) ok
        M2 -> (end) ok
        $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S100] ok
        M3 -> (spindle) ok
        M30 -> (end) ok
        M5 M9 -> ok
        M3 S7 M30 -> (spindle) (speed) (end) ok
        $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S7] ok
    "#]],
    );
}

#[test]
fn a_tool_change_comes_before_the_spindle_and_a_pause_after_both() {
    check(
        "T1 M6 M3 S100\nM6 M0\nT2 M6 M0\nT3 M6 M4 M0\nT4 M6 S5 M0\nT5 M6 M8 M0\nT6 M6 M3 S5 M0\nG38.2 Z-1 F1 T7 M6 M0",
        expect![[r#"
            T1 M6 M3 S100 -> (tool 1) (spindle) (speed) ok
            M6 M0 -> (pause) ok
            T2 M6 M0 -> (tool 2) ok
            T3 M6 M4 M0 -> (tool 3) (spindle) (pause) ok
            T4 M6 S5 M0 -> (tool 4) (speed) (pause) ok
            T5 M6 M8 M0 -> (tool 5) (coolant) (pause) ok
            T6 M6 M3 S5 M0 -> (tool 6) (spindle) (pause) ok
            G38.2 Z-1 F1 T7 M6 M0 -> (tool 7) (probe toward or alarm 1 [0.0, 0.0, -1.0]) (pause) ok
        "#]],
    );
}

#[test]
fn a_caller_turns_the_tool_off_and_switches_coolant() {
    let mut talk = Talk::new(ReportedState::Idle);
    talk.send("M4 S100 M8");
    talk.interpreter.set_coolant(Coolant::of(true, true));
    assert_eq!(talk.bytes(b"$G\n"), "[GC:G0 G54 G17 G21 G90 G94 G64 M4 M7 M8 T0 F0 S100] ok");
    assert_eq!(talk.bytes(b"M7\nM9\nM7\n"), "ok (coolant) ok (coolant) ok");
    talk.interpreter.stop_tool();
    assert_eq!(talk.bytes(b"$G\n"), "[GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S100] ok");
    assert_eq!(talk.bytes(b"M4\n"), "(spindle) ok");
}
