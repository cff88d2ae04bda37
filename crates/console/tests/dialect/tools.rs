//! Lengths of tools: the table, and what G43, G43.2 and G49 make of it.

use super::talk::{Talk, check, in_mm};
use expect_test::expect;
use isostep_console::{ReportedState, Settings, ToolEntry};

/// The offset counts before the motion of its line: a rapid that is modal goes to Z and the length.
#[test]
fn g43_counts_before_the_motion_of_its_line() {
    check(
        "G10 L1 P1 Z20\nG0 Z5\nG43 Z15 H1\nX1 G49\nZ15\nG43 H1\nG0 G43 H1 Z0 X2\nG53 Z50\nG43.1 Z3\nZ1\nG0 G43 H7 Z1",
        expect![[r#"
            G10 L1 P1 Z20 -> ok
            G0 Z5 -> (rapid [0.0, 0.0, 5.0]) ok
            G43 Z15 H1 -> (rapid [0.0, 0.0, 35.0]) ok
            X1 G49 -> (rapid [1.0, 0.0, 35.0]) ok
            Z15 -> (rapid [1.0, 0.0, 15.0]) ok
            G43 H1 -> ok
            G0 G43 H1 Z0 X2 -> (rapid [2.0, 0.0, 20.0]) ok
            G53 Z50 -> (rapid [2.0, 0.0, 50.0]) ok
            G43.1 Z3 -> ok
            Z1 -> (rapid [2.0, 0.0, 4.0]) ok
            G0 G43 H7 Z1 -> (rapid [2.0, 0.0, 1.0]) ok
        "#]],
    );
}

/// What grblHAL does wrong: it moves with the length that was in force before.
#[test]
fn another_tools_length_counts_from_its_line_on() {
    check(
        "G10 L1 P1 Z10\nG10 L1 P2 Z30\nG43 Z5 H1\nG43 Z5 H2\nG1 F100 Z4\nG43 H1\nZ4\nG2 X2 I1 G43 H2\nG81 G43 H1 X1 Z-1 R1",
        expect![[r#"
            G10 L1 P1 Z10 -> ok
            G10 L1 P2 Z30 -> ok
            G43 Z5 H1 -> (rapid [0.0, 0.0, 15.0]) ok
            G43 Z5 H2 -> (rapid [0.0, 0.0, 35.0]) ok
            G1 F100 Z4 -> (feed 100 [0.0, 0.0, 34.0]) ok
            G43 H1 -> ok
            Z4 -> (feed 100 [0.0, 0.0, 14.0]) ok
            G2 X2 I1 G43 H2 -> (arc 100.0 [2.0, 0.0, 14.0] of 3.142 in 0.000..2.000 0.000..1.000 14.000..14.000) ok
            G81 G43 H1 X1 Z-1 R1 -> 1,0,14| 1,0,11 F100:1,0,9| 1,0,14| ok
        "#]],
    );
}

/// An entry that was never set counts as 0, and so does H0.
#[test]
fn without_h_it_is_the_tool_in_the_spindle_and_not_the_one_that_t_names() {
    check(
        "G10 L1 P1 Z10\nG10 L1 P2 Z20\nG43 Z0\nT2 G43 Z0\nT1 M6\nG43 Z0\nT2 G43 Z0\nM6 G43 Z0\nT3 M6 G43 Z0\nG43 H0 Z0\nM30\nG43 Z0",
        expect![[r#"
            G10 L1 P1 Z10 -> ok
            G10 L1 P2 Z20 -> ok
            G43 Z0 -> (rapid [0.0, 0.0, 0.0]) ok
            T2 G43 Z0 -> (rapid [0.0, 0.0, 0.0]) ok
            T1 M6 -> (tool 1) ok
            G43 Z0 -> (rapid [0.0, 0.0, 10.0]) ok
            T2 G43 Z0 -> (rapid [0.0, 0.0, 10.0]) ok
            M6 G43 Z0 -> (tool 2) (rapid [0.0, 0.0, 20.0]) ok
            T3 M6 G43 Z0 -> (tool 3) (rapid [0.0, 0.0, 0.0]) ok
            G43 H0 Z0 -> (rapid [0.0, 0.0, 0.0]) ok
            M30 -> (end) ok
            G43 Z0 -> error:22
        "#]],
    );
    let mut talk = Talk::new(ReportedState::Idle);
    talk.send("G10 L1 P4 Z7\nT4 M6");
    talk.interpreter.reset();
    talk.send("G43");
    assert_eq!(talk.interpreter.tool_length_pm(), 7_000_000_000, "a reset leaves the tool where it is");
}

#[test]
fn g43_2_adds() {
    check(
        "G10 L1 P1 Z10\nG10 L1 P2 Z0.5\nG43 H1\nG43.2 H2 Z0\nG43.2 H2\nZ0\nG43.2\nG43.2 H99\nG10 L1 P3 Z9999\nG43.2 H3\nZ0",
        expect![[r#"
            G10 L1 P1 Z10 -> ok
            G10 L1 P2 Z0.5 -> ok
            G43 H1 -> ok
            G43.2 H2 Z0 -> (rapid [0.0, 0.0, 10.5]) ok
            G43.2 H2 -> ok
            Z0 -> (rapid [0.0, 0.0, 11.0]) ok
            G43.2 -> error:28
            G43.2 H99 -> ok
            G10 L1 P3 Z9999 -> ok
            G43.2 H3 -> error:33
            Z0 -> (rapid [0.0, 0.0, 11.0]) ok
        "#]],
    );
}

/// L10 makes the place where it stands what Z says, with the offsets in force; L11 does the same as seen from G59.3, which G92 does not shift.
#[test]
fn l10_and_l11_measure_a_length_where_the_machine_stands() {
    check(
        "G10 L2 P1 Z-50\nG10 L2 P9 Z-80\nG0 G53 Z-20\nG10 L10 P1 Z2\nG10 L11 P2 Z2\nG92 Z0\nG10 L10 P3 Z2\nG10 L11 P4 Z2\n$#\nG92.1\nG43 H1 Z2\nG43 H2 G59.3 Z2",
        expect![[r#"
            G10 L2 P1 Z-50 -> ok
            G10 L2 P9 Z-80 -> ok
            G0 G53 Z-20 -> (rapid [0.0, 0.0, -20.0]) ok
            G10 L10 P1 Z2 -> ok
            G10 L11 P2 Z2 -> ok
            G92 Z0 -> ok
            G10 L10 P3 Z2 -> ok
            G10 L11 P4 Z2 -> ok
            $# -> [G54:0.000,0.000,-50.000] [G55:0.000,0.000,0.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,0.000] [G59.1:0.000,0.000,0.000] [G59.2:0.000,0.000,0.000] [G59.3:0.000,0.000,-80.000] [G28:0.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,30.000] [T:1|0.000,0.000,28.000|0.000] [T:2|0.000,0.000,58.000|0.000] [T:3|0.000,0.000,-2.000|0.000] [T:4|0.000,0.000,58.000|0.000] [TLO:0.000] [PRB:0.000,0.000,0.000:0] ok
            G92.1 -> ok
            G43 H1 Z2 -> (rapid [0.0, 0.0, -20.0]) ok
            G43 H2 G59.3 Z2 -> (rapid [0.0, 0.0, -20.0]) ok
        "#]],
    );
}

/// Entries change the table; the length in force stays until G43 is given again.
#[test]
fn a_changed_entry_counts_with_the_next_g43() {
    check(
        "G10 L1 P1 Z10 R1.5\nG43 H1 Z0\nG10 L1 P1 Z20\nZ0\nG43 H1 Z0\nG20 G10 L1 P99999 Z1 R0.125\n$#\n$13=1\n$#\nG10 L1 P1 Z0\nG10 L1 P1 R0\n$#",
        expect![[r#"
            G10 L1 P1 Z10 R1.5 -> ok
            G43 H1 Z0 -> (rapid [0.0, 0.0, 10.0]) ok
            G10 L1 P1 Z20 -> ok
            Z0 -> (rapid [0.0, 0.0, 10.0]) ok
            G43 H1 Z0 -> (rapid [0.0, 0.0, 20.0]) ok
            G20 G10 L1 P99999 Z1 R0.125 -> ok
            $# -> [G54:0.000,0.000,0.000] [G55:0.000,0.000,0.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,0.000] [G59.1:0.000,0.000,0.000] [G59.2:0.000,0.000,0.000] [G59.3:0.000,0.000,0.000] [G28:0.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,0.000] [T:1|0.000,0.000,20.000|1.500] [T:99999|0.000,0.000,25.400|3.175] [TLO:20.000] [PRB:0.000,0.000,0.000:0] ok
            $13=1 -> ok
            $# -> [G54:0.0000,0.0000,0.0000] [G55:0.0000,0.0000,0.0000] [G56:0.0000,0.0000,0.0000] [G57:0.0000,0.0000,0.0000] [G58:0.0000,0.0000,0.0000] [G59:0.0000,0.0000,0.0000] [G59.1:0.0000,0.0000,0.0000] [G59.2:0.0000,0.0000,0.0000] [G59.3:0.0000,0.0000,0.0000] [G28:0.0000,0.0000,0.0000] [G30:0.0000,0.0000,0.0000] [G92:0.0000,0.0000,0.0000] [T:1|0.0000,0.0000,0.7874|0.0591] [T:99999|0.0000,0.0000,1.0000|0.1250] [TLO:0.7874] [PRB:0.0000,0.0000,0.0000:0] ok
            G10 L1 P1 Z0 -> ok
            G10 L1 P1 R0 -> ok
            $# -> [G54:0.0000,0.0000,0.0000] [G55:0.0000,0.0000,0.0000] [G56:0.0000,0.0000,0.0000] [G57:0.0000,0.0000,0.0000] [G58:0.0000,0.0000,0.0000] [G59:0.0000,0.0000,0.0000] [G59.1:0.0000,0.0000,0.0000] [G59.2:0.0000,0.0000,0.0000] [G59.3:0.0000,0.0000,0.0000] [G28:0.0000,0.0000,0.0000] [G30:0.0000,0.0000,0.0000] [G92:0.0000,0.0000,0.0000] [T:99999|0.0000,0.0000,1.0000|0.1250] [TLO:0.7874] [PRB:0.0000,0.0000,0.0000:0] ok
        "#]],
    );
}

#[test]
fn wrong_entries_and_lengths_are_refused_and_change_nothing() {
    check(
        "G10 L1 P1 Z10\nG10 L1 P0 Z1\nG10 L1 P1.5 Z1\nG10 L1 P100000 Z1\nG10 L1 Z1\nG10 L1 P1\nG10 L10 P1 R1\nG10 L11 P1\nG10 L1 P1 X1 Z1\n\
         G10 L1 P1 Z1 R-1\nG10 L1 P1 R1001\nG10 L1 P1 Z10001\nG10 L1 P1 Z1 Q2\nG10 L12 P1 Z1\nG43 H-1\nG43 H1.5\nG43 H100000\nG43 G49\nG43 H1 G43.2 H1\nH1\n\
         G43 H1 Z0 D1\nG43.1 Z1 H1\n$J=G43 H1 X1 F100\nG43 X1 X2 H1\n$#",
        expect![[r#"
            G10 L1 P1 Z10 -> ok
            G10 L1 P0 Z1 -> error:38
            G10 L1 P1.5 Z1 -> [MSG:P: G10 numbers systems and tools by whole numbers: remove the fraction] error:23
            G10 L1 P100000 Z1 -> error:38
            G10 L1 Z1 -> error:28
            G10 L1 P1 -> error:26
            G10 L10 P1 R1 -> error:26
            G10 L11 P1 -> error:26
            G10 L1 P1 X1 Z1 -> error:37
            G10 L1 P1 Z1 R-1 -> error:38
            G10 L1 P1 R1001 -> error:38
            G10 L1 P1 Z10001 -> error:33
            G10 L1 P1 Z1 Q2 -> [MSG:Q: no code on the line uses it: remove it, or add the code that does] error:36
            G10 L12 P1 Z1 -> [MSG:G10: L1, L2, L10, L11 or L20 here, without a rotation: correct L, remove R of L2] error:20
            G43 H-1 -> error:4
            G43 H1.5 -> error:23
            G43 H100000 -> error:38
            G43 G49 -> error:21
            G43 H1 G43.2 H1 -> error:21
            H1 -> [MSG:H: it names a tool for G43 and G43.2: add one of them, or remove it] error:36
            G43 H1 Z0 D1 -> [MSG:D: no cutter compensation here: let the CAM program compensate] error:20
            G43.1 Z1 H1 -> [MSG:H: it names a tool for G43 and G43.2: add one of them, or remove it] error:36
            $J=G43 H1 X1 F100 -> error:36
            G43 X1 X2 H1 -> error:25
            $# -> [G54:0.000,0.000,0.000] [G55:0.000,0.000,0.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,0.000] [G59.1:0.000,0.000,0.000] [G59.2:0.000,0.000,0.000] [G59.3:0.000,0.000,0.000] [G28:0.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,0.000] [T:1|0.000,0.000,10.000|0.000] [TLO:0.000] [PRB:0.000,0.000,0.000:0] ok
        "#]],
    );
}

#[test]
fn the_table_has_room_for_32_tools_and_says_what_to_do_about_more() {
    let (mut talk, settings) = (Talk::new(ReportedState::Idle), Settings::DEFAULT);
    for number in 1..=32 {
        talk.send(&format!("G10 L1 P{} Z{number}", 100 * number));
    }
    let refused = talk.interpreter.gcode("G10L1P1Z1", &settings).unwrap_err();
    assert_eq!((refused.code(), refused.to_string().contains("Z0 R0")), (38, true), "{refused}");
    talk.send("G10 L1 P100 Z0\nG10 L1 P1 Z1");
    assert_eq!(talk.interpreter.tools().tool(1), ToolEntry { number: 1, length_pm: 1_000_000_000, radius_nm: 0 });
    assert_eq!(in_mm(talk.interpreter.work_offset_pm()), [0.0; 3]);
}

#[test]
fn there_are_nine_work_coordinate_systems() {
    check(
        "G10 L2 P7 X1\nG10 L2 P8 X2\nG0 X5\nG59.3\nG10 L20 P0 X1\n$G\nG59.1 X0\nG59.2 X0\nG59.3 X0\nG59.4\nG10 L2 P10 X1\n$#\nM30\n$G",
        expect![[r#"
            G10 L2 P7 X1 -> ok
            G10 L2 P8 X2 -> ok
            G0 X5 -> (rapid [5.0, 0.0, 0.0]) ok
            G59.3 -> ok
            G10 L20 P0 X1 -> ok
            $G -> [GC:G0 G59.3 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            G59.1 X0 -> (rapid [1.0, 0.0, 0.0]) ok
            G59.2 X0 -> (rapid [2.0, 0.0, 0.0]) ok
            G59.3 X0 -> (rapid [4.0, 0.0, 0.0]) ok
            G59.4 -> error:23
            G10 L2 P10 X1 -> error:29
            $# -> [G54:0.000,0.000,0.000] [G55:0.000,0.000,0.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,0.000] [G59.1:1.000,0.000,0.000] [G59.2:2.000,0.000,0.000] [G59.3:4.000,0.000,0.000] [G28:0.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,0.000] [TLO:0.000] [PRB:0.000,0.000,0.000:0] ok
            M30 -> (end) ok
            $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
        "#]],
    );
}
