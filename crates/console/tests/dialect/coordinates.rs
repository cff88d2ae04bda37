//! Coordinates: work offsets, G92, the tool length, and the places of G28 and G30.

use super::talk::{Talk, check, in_mm};
use expect_test::expect;
use isostep_console::ReportedState;

/// Work coordinates are machine coordinates minus the work offset, G92's shift and, along Z, the tool length.
#[test]
fn work_offsets_shift_what_absolute_words_mean() {
    check(
        "G10 L2 P1 X100 Y-20\nX1 Y1 Z1\nG91 X1\nG90 G53 X5 Y5\nG55 X1\nG54 X1\nG10 L2 P0 X7\nX1\nG10 L2 P6 Z-3\nG59 Z0\n$#",
        expect![[r#"
            G10 L2 P1 X100 Y-20 -> ok
            X1 Y1 Z1 -> (rapid [101.0, -19.0, 1.0]) ok
            G91 X1 -> (rapid [102.0, -19.0, 1.0]) ok
            G90 G53 X5 Y5 -> (rapid [5.0, 5.0, 1.0]) ok
            G55 X1 -> (rapid [1.0, 5.0, 1.0]) ok
            G54 X1 -> (rapid [101.0, 5.0, 1.0]) ok
            G10 L2 P0 X7 -> ok
            X1 -> (rapid [8.0, 5.0, 1.0]) ok
            G10 L2 P6 Z-3 -> ok
            G59 Z0 -> (rapid [8.0, 5.0, -3.0]) ok
            $# -> [G54:7.000,-20.000,0.000] [G55:0.000,0.000,0.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,-3.000] [G59.1:0.000,0.000,0.000] [G59.2:0.000,0.000,0.000] [G59.3:0.000,0.000,0.000] [G28:0.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,0.000] [TLO:0.000] [PRB:0.000,0.000,0.000:0] ok
        "#]],
    );
}

#[test]
fn g10_l20_and_g92_make_the_place_where_it_stands_what_they_say() {
    check(
        "X10 Y20 Z30\nG10 L20 P2 X1 Z2\nG55 X1 Z2\nG92 X0 Y0\nX0 Y0\nG10 L20 P2 X3\nX3\nG92.1\nX3\n$#",
        expect![[r#"
            X10 Y20 Z30 -> (rapid [10.0, 20.0, 30.0]) ok
            G10 L20 P2 X1 Z2 -> ok
            G55 X1 Z2 -> (rapid [10.0, 20.0, 30.0]) ok
            G92 X0 Y0 -> ok
            X0 Y0 -> (rapid [10.0, 20.0, 30.0]) ok
            G10 L20 P2 X3 -> ok
            X3 -> (rapid [10.0, 20.0, 30.0]) ok
            G92.1 -> ok
            X3 -> (rapid [9.0, 20.0, 30.0]) ok
            $# -> [G54:0.000,0.000,0.000] [G55:6.000,0.000,28.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,0.000] [G59.1:0.000,0.000,0.000] [G59.2:0.000,0.000,0.000] [G59.3:0.000,0.000,0.000] [G28:0.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,0.000] [TLO:0.000] [PRB:0.000,0.000,0.000:0] ok
        "#]],
    );
}

#[test]
fn g92_and_the_tool_length_end_with_a_reset_and_offsets_do_not() {
    let mut talk = Talk::new(ReportedState::Idle);
    talk.send("G10 L2 P1 X1\nG92 Y2\nG43.1 Z3\nG55");
    assert_eq!(in_mm(talk.interpreter.work_offset_pm()), [0.0, -2.0, 3.0]);
    talk.interpreter.reset();
    assert_eq!(in_mm(talk.interpreter.work_offset_pm()), [1.0, 0.0, 0.0]);
}

/// Both codes set the position of the tool's tip. Only Z has a tool length, X has none.
#[test]
fn g92_and_g10_l20_count_from_the_tip_of_the_tool() {
    for zero in ["G92 X3 Z7", "G10 L20 P1 X3 Z7"] {
        let mut talk = Talk::new(ReportedState::Idle);
        talk.send(&format!("G0 X10 Z30\nG43.1 Z5\n{zero}"));
        let [position_mm, offset_mm] = [talk.interpreter.position_pm(), talk.interpreter.work_offset_pm()].map(in_mm);
        let [x, _, z] = [0, 1, 2].map(|axis| position_mm[axis] - offset_mm[axis]);
        assert_eq!((x, z), (3.0, 7.0), "{zero}");
    }
}

#[test]
fn the_tool_length_moves_z_alone() {
    check(
        "G43.1 Z5\nZ0\nG20 G43.1 Z-1\nG21 Z0 X0\nG43.1 X1\nG43.1 X1 Z1\nG43.1\nG49\nZ0",
        expect![[r#"
        G43.1 Z5 -> ok
        Z0 -> (rapid [0.0, 0.0, 5.0]) ok
        G20 G43.1 Z-1 -> ok
        G21 Z0 X0 -> (rapid [0.0, 0.0, -25.4]) ok
        G43.1 X1 -> error:37
        G43.1 X1 Z1 -> error:37
        G43.1 -> error:37
        G49 -> ok
        Z0 -> (rapid [0.0, 0.0, 0.0]) ok
    "#]],
    );
}

#[test]
fn g28_and_g30_go_to_the_places_kept() {
    check(
        "X10 Y20 Z30\nG28.1\nX1 Y2 Z3\nG30.1\nX0\nG28\nG30 Z50\nG10 L2 P1 Z1\nG91 G28 Z5\nG30.1 X1\nG90 G30",
        expect![[r#"
            X10 Y20 Z30 -> (rapid [10.0, 20.0, 30.0]) ok
            G28.1 -> ok
            X1 Y2 Z3 -> (rapid [1.0, 2.0, 3.0]) ok
            G30.1 -> ok
            X0 -> (rapid [0.0, 2.0, 3.0]) ok
            G28 -> (rapid [10.0, 20.0, 30.0]) ok
            G30 Z50 -> (via [10.0, 20.0, 50.0]) (rapid [10.0, 20.0, 3.0]) ok
            G10 L2 P1 Z1 -> ok
            G91 G28 Z5 -> (via [10.0, 20.0, 8.0]) (rapid [10.0, 20.0, 30.0]) ok
            G30.1 X1 -> (rapid [11.0, 20.0, 30.0]) ok
            G90 G30 -> (rapid [10.0, 20.0, 30.0]) ok
        "#]],
    );
}

#[test]
fn g10_and_g92_want_their_words() {
    check(
        "G10 L2 P1\nG10 P1 X1\nG10 L2 X1\nG10 L2 P10 X1\nG10 L3 P1 X1\nG10 L2 P1 X1 R0\nG10 L20 P1 X1 R0\nG92\nG92 X20000\nG10 L2 P1 X-10000.1\nG43.1 Z10001\n$#",
        expect![[r#"
            G10 L2 P1 -> error:26
            G10 P1 X1 -> error:28
            G10 L2 X1 -> error:28
            G10 L2 P10 X1 -> error:29
            G10 L3 P1 X1 -> [MSG:G10: L1, L2, L10, L11 or L20 here, without a rotation: correct L, remove R of L2] error:20
            G10 L2 P1 X1 R0 -> [MSG:G10: L1, L2, L10, L11 or L20 here, without a rotation: correct L, remove R of L2] error:20
            G10 L20 P1 X1 R0 -> [MSG:R: no code on the line uses it: remove it, or add the code that does] error:36
            G92 -> error:26
            G92 X20000 -> error:33
            G10 L2 P1 X-10000.1 -> error:33
            G43.1 Z10001 -> error:33
            $# -> [G54:0.000,0.000,0.000] [G55:0.000,0.000,0.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,0.000] [G59.1:0.000,0.000,0.000] [G59.2:0.000,0.000,0.000] [G59.3:0.000,0.000,0.000] [G28:0.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,0.000] [TLO:0.000] [PRB:0.000,0.000,0.000:0] ok
        "#]],
    );
}

#[test]
fn g28_goes_home_by_way_of_the_axes_named() {
    check(
        "G0 X10 Y20 Z30\nG28 Z5\nG91 G28 X1\nG28\nG28 G0 X1\nG1 G28 X1\nG28.1",
        expect![[r#"
            G0 X10 Y20 Z30 -> (rapid [10.0, 20.0, 30.0]) ok
            G28 Z5 -> (via [10.0, 20.0, 5.0]) (rapid [10.0, 20.0, 0.0]) ok
            G91 G28 X1 -> (via [11.0, 20.0, 0.0]) (rapid [0.0, 20.0, 0.0]) ok
            G28 -> (rapid [0.0, 0.0, 0.0]) ok
            G28 G0 X1 -> (via [1.0, 0.0, 0.0]) (rapid [0.0, 0.0, 0.0]) ok
            G1 G28 X1 -> (via [1.0, 0.0, 0.0]) (rapid [0.0, 0.0, 0.0]) ok
            G28.1 -> ok
        "#]],
    );
}

/// Sums of increments, against whole numbers: straight moves and jogs in mm and inches, and the ends of arcs, while
/// offsets come and go.
#[test]
fn a_million_increments_end_where_their_sum_is() {
    let (mut talk, mut random) = (Talk::new(ReportedState::Idle), 1u64);
    let mut sum_pm = [0i64; 3];
    for line in 0..1_000_000 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let (axis, inches) = ((random >> 40) as usize % 3, random >> 50 & 1 == 1);
        // Up to 0.1 of its unit, in 10^-8, and back towards zero.
        let size = (random >> 32) as i64 % 10_000_000;
        let step = if sum_pm[axis] > 0 { -size } else { size };
        sum_pm[axis] += step * if inches { 254 } else { 10 };
        let (units, letter) = (if inches { "G20" } else { "G21" }, ["X", "Y", "Z"][axis]);
        let word = format!("{letter}{}0.{size:08}", if step < 0 { "-" } else { "" });
        let text = match line % 5 {
            0 => format!("$J=G91 {units} F100 {word}"),
            // The end of an arc.
            1 if axis == 0 && size > 1_000 => format!("G91 {units} G2 {word} R1 F100"),
            2 => format!("G91 {units} G0 {word}"),
            _ => format!("G91 {units} G1 {word} F100"),
        };
        assert!(talk.bytes(format!("{text}\n").as_bytes()).ends_with("ok"), "{text}");
        if line % 1_000 == 0 {
            let zero =
                ["G92 X0.1 Y7", "G43.1 Z0.3", "G10 L20 P1 X1.0001 Z2", "G55", "G54", "G92.1", "G49"][line / 1_000 % 7];
            talk.send(&format!("G20 {zero}"));
        }
        if line % 10_000 == 0 {
            // What the machine says where it stands.
            talk.interpreter.set_position_pm(sum_pm);
        }
    }
    assert_eq!(talk.interpreter.position_pm(), sum_pm);
    // So the way back in work coordinates is exact as well.
    talk.send("G21 G90 G92 X0 Y0 Z0\nG91 X0.001 F1\nG90 G1 X0 F1");
    assert_eq!(talk.interpreter.position_pm(), sum_pm);
}

/// As typed: from X257 in thousandths of a millimetre, and in ten-thousandths of an inch.
#[test]
fn ten_thousand_thousandths_are_ten_millimetres() {
    let mut talk = Talk::new(ReportedState::Idle);
    talk.send("G0 X257\nG91");
    (0..10_000).for_each(|_| _ = talk.bytes(b"X0.001\n"));
    assert_eq!(in_mm(talk.interpreter.position_pm()), [267.0, 0.0, 0.0]);
    talk.send("G20");
    (0..10_000).for_each(|_| _ = talk.bytes(b"X-0.0001\n"));
    assert_eq!(in_mm(talk.interpreter.position_pm()), [241.6, 0.0, 0.0]);
}

/// Nine decimals and more are rounded to eight, so a million lines are off by 5 micrometres at most, or in inches by
/// 0.13 mm.
#[test]
fn decimals_beyond_the_eighth_are_rounded_line_by_line() {
    let mut talk = Talk::new(ReportedState::Idle);
    talk.send("G91");
    (0..10_000).for_each(|_| _ = talk.bytes(b"X0.33333333333\nG20 Y0.000000005\nG21\n"));
    assert_eq!(talk.interpreter.position_pm(), [10_000 * 333_333_330, 10_000 * 254, 0]);
}
