//! G38 as Grbl reads it: where it goes, why it is refused, and what it reports.

use super::talk::{Talk, check};
use expect_test::expect;
use isostep_console::{ReportedState, Settings, length, report};

#[test]
fn a_probe_is_modal_and_the_program_goes_on_from_its_target() {
    check(
        "G38.2 Z-10 F100\n$G\nZ-20\nG91 G38.3 X1 Y1\n$G\nX1\nG90 G38.4 Z-10\n$G\nG38.5 Z0 F50\n$G\nN5 X5 M0\nG0 X9\nZ1\n\
         G20 G38.2 X1 F1\nG21 G92 X0\nX1\nG28\nG28 X3\nG28.1 Z7\nG4 P1\nM3 S10 Z8\nG80\nX1\nG38.2 Z9\nM2\n$G\nG61.1 G38.2 Z1",
        expect![[r#"
            G38.2 Z-10 F100 -> (probe toward or alarm 100 [0.0, 0.0, -10.0]) ok
            $G -> [GC:G38.2 G54 G17 G21 G90 G94 G64 M5 M9 T0 F100 S0] ok
            Z-20 -> (probe toward or alarm 100 [0.0, 0.0, -20.0]) ok
            G91 G38.3 X1 Y1 -> (probe toward 100 [1.0, 1.0, -20.0]) ok
            $G -> [GC:G38.3 G54 G17 G21 G91 G94 G64 M5 M9 T0 F100 S0] ok
            X1 -> (probe toward 100 [2.0, 1.0, -20.0]) ok
            G90 G38.4 Z-10 -> (probe away or alarm 100 [2.0, 1.0, -10.0]) ok
            $G -> [GC:G38.4 G54 G17 G21 G90 G94 G64 M5 M9 T0 F100 S0] ok
            G38.5 Z0 F50 -> (probe away 50 [2.0, 1.0, 0.0]) ok
            $G -> [GC:G38.5 G54 G17 G21 G90 G94 G64 M5 M9 T0 F50 S0] ok
            N5 X5 M0 -> (N5) (probe away 50 [5.0, 1.0, 0.0]) (pause) ok
            G0 X9 -> (rapid [9.0, 1.0, 0.0]) ok
            Z1 -> (rapid [9.0, 1.0, 1.0]) ok
            G20 G38.2 X1 F1 -> (probe toward or alarm 25.4 [25.4, 1.0, 1.0]) ok
            G21 G92 X0 -> ok
            X1 -> (probe toward or alarm 25.4 [26.4, 1.0, 1.0]) ok
            G28 -> (rapid [0.0, 0.0, 0.0]) ok
            G28 X3 -> (via [28.4, 0.0, 0.0]) (rapid [0.0, 0.0, 0.0]) ok
            G28.1 Z7 -> (probe toward or alarm 25.4 [0.0, 0.0, 7.0]) ok
            G4 P1 -> (wait 1 s) ok
            M3 S10 Z8 -> (spindle) (speed) (probe toward or alarm 25.4 [0.0, 0.0, 8.0]) ok
            G80 -> ok
            X1 -> error:31
            G38.2 Z9 -> (probe toward or alarm 25.4 [0.0, 0.0, 9.0]) ok
            M2 -> (end) ok
            $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T0 F25 S10] ok
            G61.1 G38.2 Z1 -> (probe toward or alarm 25.4 [0.0, 0.0, 1.0]) ok
        "#]],
    );
}

#[test]
fn a_probe_needs_a_feed_an_axis_and_a_way() {
    check(
        "G38.2 Z-1\nG38.2\nG38.2 F0 Z-1\nF100\nG38.2\nG38.2 F100 M3\nG38.3 X0\nG38.4 X0 I1\nG38.2 Z-20000\nG38.2 Z1 I1\nG38.2 Z1 R1\nG38.2 Z1 P1\n\
         G53 G38.2 Z1\nG38.2 G53 Z1\nG38.2 G0 Z1\nG38.2 G38.3 Z1\nG28 G38.2 Z1\nG92 G38.2 Z1\nG43.1 G38.2 Z1\n$J=G38.2 X1 F1\n$J=G38.2 F1\n$G\n\
         G38.2 Z1\nG53 Z2\n$J=X1 F1\nZ1\nG18 G38.2 Y1",
        expect![[r#"
            G38.2 Z-1 -> error:22
            G38.2 -> error:22
            G38.2 F0 Z-1 -> error:22
            F100 -> ok
            G38.2 -> error:26
            G38.2 F100 M3 -> error:26
            G38.3 X0 -> error:33
            G38.4 X0 I1 -> error:33
            G38.2 Z-20000 -> error:33
            G38.2 Z1 I1 -> [MSG:I: no code on the line uses it: remove it, or add the code that does] error:36
            G38.2 Z1 R1 -> [MSG:R: no code on the line uses it: remove it, or add the code that does] error:36
            G38.2 Z1 P1 -> [MSG:P: no code on the line uses it: remove it, or add the code that does] error:36
            G53 G38.2 Z1 -> error:30
            G38.2 G53 Z1 -> error:30
            G38.2 G0 Z1 -> error:24
            G38.2 G38.3 Z1 -> error:24
            G28 G38.2 Z1 -> error:24
            G92 G38.2 Z1 -> error:24
            G43.1 G38.2 Z1 -> error:24
            $J=G38.2 X1 F1 -> error:16
            $J=G38.2 F1 -> error:26
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F100 S0] ok
            G38.2 Z1 -> (probe toward or alarm 100 [0.0, 0.0, 1.0]) ok
            G53 Z2 -> error:30
            $J=X1 F1 -> (jog 1 [1.0, 0.0, 1.0]) ok
            Z1 -> error:33
            G18 G38.2 Y1 -> (probe toward or alarm 100 [1.0, 1.0, 1.0]) ok
        "#]],
    );
}

#[test]
fn a_probe_takes_an_inverse_time() {
    // The path of 3 and 4 mm is 5 mm long; twice a minute is 10 mm/min.
    check(
        "G93 G38.2 X3 Y4 F2\nX0\nG38.2 X0\nX0 F.01\nG94 G38.3 X1\nG94 G38.3 X1 F5",
        expect![[r#"
        G93 G38.2 X3 Y4 F2 -> (probe toward or alarm 10 [3.0, 4.0, 0.0]) ok
        X0 -> error:22
        G38.2 X0 -> error:22
        X0 F.01 -> (probe toward or alarm 1 [0.0, 4.0, 0.0]) ok
        G94 G38.3 X1 -> error:22
        G94 G38.3 X1 F5 -> (probe toward 5 [1.0, 4.0, 0.0]) ok
    "#]],
    );
}

#[test]
fn what_a_probe_touched_outlives_a_reset() {
    let mut talk = Talk::new(ReportedState::Idle);
    let prb = |talk: &mut Talk| {
        let heard = talk.bytes(b"$#\n");
        heard.split(' ').find(|line| line.starts_with("[PRB")).map(str::to_owned).unwrap()
    };
    assert_eq!(talk.interpreter.touched(), ([0; 3], false));
    assert_eq!(prb(&mut talk), "[PRB:0.000,0.000,0.000:0]");
    talk.interpreter.set_touched([1.0, -25.4, 3.1234].map(length::from_mm), true);
    talk.send("G92 X5\nG55");
    talk.interpreter.reset();
    assert_eq!(prb(&mut talk), "[PRB:1.000,-25.400,3.123:1]");
    talk.interpreter.set_touched([1.0, -25.4, 3.0].map(length::from_mm), false);
    assert_eq!(talk.interpreter.touched(), ([1_000_000_000, -25_400_000_000, 3_000_000_000], false));
    let mut heard = String::new();
    let inches = Settings { report_inches: true, ..Settings::DEFAULT };
    report::probed(&mut heard, &talk.interpreter, &inches).unwrap();
    assert_eq!(heard, "[PRB:0.0394,-1.0000,0.1181:0]\r\n");
}
