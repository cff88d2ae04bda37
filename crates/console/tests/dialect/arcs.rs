//! Arcs as Grbl reads them: the target and the bounding box of each, or why it is refused.

use super::talk::check;
use expect_test::expect;

#[test]
fn both_ways_round_by_centre_and_by_radius() {
    check(
        "F600\nG2 X10 Y10 I10\nG3 X0 Y0 I-10\nX10 Y10 J10\nG2 X0 Y0 R10\nX10 Y10 R-10\nG3 X0 Y0 R10\nX20 R10\nG2 X0 R-10\n$G",
        expect![[r#"
            F600 -> ok
            G2 X10 Y10 I10 -> (arc 600.0 [10.0, 10.0, 0.0] of 15.708 in 0.000..10.000 0.000..10.000 0.000..0.000) ok
            G3 X0 Y0 I-10 -> (arc 600.0 [0.0, 0.0, 0.0] of 47.124 in -10.000..10.000 0.000..20.000 0.000..0.000) ok
            X10 Y10 J10 -> (arc 600.0 [10.0, 10.0, 0.0] of 15.708 in 0.000..10.000 0.000..10.000 0.000..0.000) ok
            G2 X0 Y0 R10 -> (arc 600.0 [0.0, 0.0, 0.0] of 15.708 in 0.000..10.000 0.000..10.000 0.000..0.000) ok
            X10 Y10 R-10 -> (arc 600.0 [10.0, 10.0, 0.0] of 47.124 in -10.000..10.000 0.000..20.000 0.000..0.000) ok
            G3 X0 Y0 R10 -> (arc 600.0 [0.0, 0.0, 0.0] of 15.708 in 0.000..10.000 0.000..10.000 0.000..0.000) ok
            X20 R10 -> (arc 600.0 [20.0, 0.0, 0.0] of 31.416 in 0.000..20.000 -10.000..0.000 0.000..0.000) ok
            G2 X0 R-10 -> (arc 600.0 [0.0, 0.0, 0.0] of 31.416 in 0.000..20.000 -10.000..0.000 0.000..0.000) ok
            $G -> [GC:G2 G54 G17 G21 G90 G94 G64 M5 M9 T0 F600 S0] ok
        "#]],
    );
}

#[test]
fn a_target_that_is_the_start_is_a_full_circle_and_a_third_axis_a_helix() {
    check(
        "G0 X50 Y50\nG2 X50 Y50 I10 F600\nG3 X50 I-10\nG3 Y50 J5 Z-9\nG91 G2 X0 Z9 I5 K77\nX0 Y0 R5\nX0 Z1 R5",
        expect![[r#"
            G0 X50 Y50 -> (rapid [50.0, 50.0, 0.0]) ok
            G2 X50 Y50 I10 F600 -> (arc 600.0 [50.0, 50.0, 0.0] of 62.832 in 50.000..70.000 40.000..60.000 0.000..0.000) ok
            G3 X50 I-10 -> (arc 600.0 [50.0, 50.0, 0.0] of 62.832 in 30.000..50.000 40.000..60.000 0.000..0.000) ok
            G3 Y50 J5 Z-9 -> (arc 600.0 [50.0, 50.0, -9.0] of 32.680 in 45.000..55.000 50.000..60.000 -9.000..0.000) ok
            G91 G2 X0 Z9 I5 K77 -> (arc 600.0 [50.0, 50.0, 0.0] of 32.680 in 50.000..60.000 45.000..55.000 -9.000..0.000) ok
            X0 Y0 R5 -> error:33
            X0 Z1 R5 -> error:33
        "#]],
    );
}

/// Grbl takes an angle below 5e-7 rad for a full circle: here 0.001 mm would be 18.85 m.
#[test]
fn an_arc_of_a_small_angle_is_short() {
    check(
        "F600\nG2 X0.001 Y0 R3000\nG3 X0 R3000\nG3 X0 Y0.001 I-3000\nG2 X0 Y0 I-3000\nG2 X0 Y0 I-5",
        expect![[r#"
            F600 -> ok
            G2 X0.001 Y0 R3000 -> (arc 600.0 [0.001, 0.0, 0.0] of 0.001 in 0.000..0.001 0.000..0.000 0.000..0.000) ok
            G3 X0 R3000 -> (arc 600.0 [0.0, 0.0, 0.0] of 0.001 in 0.000..0.001 0.000..0.000 0.000..0.000) ok
            G3 X0 Y0.001 I-3000 -> (arc 600.0 [0.0, 0.001, 0.0] of 0.001 in 0.000..0.000 0.000..0.001 0.000..0.000) ok
            G2 X0 Y0 I-3000 -> (arc 600.0 [0.0, 0.0, 0.0] of 0.001 in 0.000..0.000 0.000..0.001 0.000..0.000) ok
            G2 X0 Y0 I-5 -> (arc 600.0 [0.0, 0.0, 0.0] of 31.416 in -10.000..0.000 -5.000..5.000 0.000..0.000) ok
        "#]],
    );
}

#[test]
fn planes_turn_z_to_x_and_y_to_z() {
    check(
        "F600\nG18 G2 X10 Z10 K10\nG3 X0 Z0 I-10\nG19 G2 Y10 Z10 J10\nG3 Y0 Z0 R10 X5\nG18 G2 X10 Z5 I5 Y3\nG17 G3 X0 Y0 R20\n$G",
        expect![[r#"
            F600 -> ok
            G18 G2 X10 Z10 K10 -> (arc 600.0 [10.0, 0.0, 10.0] of 15.708 in 0.000..10.000 0.000..0.000 0.000..10.000) ok
            G3 X0 Z0 I-10 -> (arc 600.0 [0.0, 0.0, 0.0] of 15.708 in 0.000..10.000 0.000..0.000 0.000..10.000) ok
            G19 G2 Y10 Z10 J10 -> (arc 600.0 [0.0, 10.0, 10.0] of 15.708 in 0.000..0.000 0.000..10.000 0.000..10.000) ok
            G3 Y0 Z0 R10 X5 -> (arc 600.0 [5.0, 0.0, 0.0] of 16.485 in 0.000..5.000 0.000..10.000 0.000..10.000) ok
            G18 G2 X10 Z5 I5 Y3 -> (arc 600.0 [10.0, 3.0, 5.0] of 23.752 in 5.000..15.000 0.000..3.000 -5.000..5.000) ok
            G17 G3 X0 Y0 R20 -> (arc 600.0 [0.0, 0.0, 5.0] of 10.563 in 0.000..10.000 0.000..3.000 5.000..5.000) ok
            $G -> [GC:G3 G54 G17 G21 G90 G94 G64 M5 M9 T0 F600 S0] ok
        "#]],
    );
}

#[test]
fn units_and_distance_are_those_of_axis_words() {
    check(
        "G20 G91 G2 X1 Y1 I1 F10\nG21 X-25.4 Y-25.4 R25.4\nG20 G90 G3 X1 R-1\nG91.1 G21 G3 X0 Y0 R40\nG90.1",
        expect![[r#"
            G20 G91 G2 X1 Y1 I1 F10 -> (arc 254.0 [25.4, 25.4, 0.0] of 39.898 in 0.000..25.400 0.000..25.400 0.000..0.000) ok
            G21 X-25.4 Y-25.4 R25.4 -> (arc 254.0 [0.0, 0.0, 0.0] of 39.898 in 0.000..25.400 0.000..25.400 0.000..0.000) ok
            G20 G90 G3 X1 R-1 -> (arc 254.0 [25.4, 0.0, 0.0] of 132.994 in -12.700..38.100 -47.397..0.000 0.000..0.000) ok
            G91.1 G21 G3 X0 Y0 R40 -> (arc 254.0 [0.0, 0.0, 0.0] of 25.847 in 0.000..25.400 0.000..2.070 0.000..0.000) ok
            G90.1 -> [MSG:G90.1: arc centres are incremental here: use I J K from the start] error:20
        "#]],
    );
}

#[test]
fn inverse_time_counts_the_whole_arc() {
    check(
        "G93 G2 X20 I10 F2\nG2 X0 I-10 Z10 F1\nX20 I10\nG94 X20 I10\nG94 X0 I-10 F100",
        expect![[r#"
        G93 G2 X20 I10 F2 -> (arc 62.8 [20.0, 0.0, 0.0] of 31.416 in 0.000..20.000 0.000..10.000 0.000..0.000) ok
        G2 X0 I-10 Z10 F1 -> (arc 33.0 [0.0, 0.0, 10.0] of 32.969 in 0.000..20.000 -10.000..0.000 0.000..10.000) ok
        X20 I10 -> error:22
        G94 X20 I10 -> error:22
        G94 X0 I-10 F100 -> (arc 100.0 [0.0, 0.0, 10.0] of 62.832 in -20.000..0.000 -10.000..10.000 10.000..10.000) ok
    "#]],
    );
}

#[test]
fn what_is_no_arc_is_refused_in_grbls_order() {
    check(
        "G2 X1 I1\nF600\nG2\nG2 I1\nG2 Z1\nG2 Z1 I1\nG2 Z20000\nG18 G2 Y1\nG19 G2 X1\nG2 X10\nG2 X10 K5\nG18 G2 X10 J5\nG19 G2 Z1 I1\n\
        G2 X10 I4.994\nG2 X10 I4.998\nG2 X0 Y0 R5\nX10\nG2 X20 R4.9\nG2 X20 R0\nG2 X20 I10 R10\nG2 X20 J0 R10\nG2 X20 I10 P1\nG2 G1 X20 I5\n\
        G2 G3 X20 I5\nG53 G2 X20 I5\nG53\nG92 G2 X20 I5\nG2.5 X1 I1\nG2.1 X1 I1\nG2 X9000 R-9000\nG1 X20 I5\nG0 X20 R5\nG2 X2 X3 I1\nG2 X20 I5 I5\n$G",
        expect![[r#"
            G2 X1 I1 -> error:22
            F600 -> ok
            G2 -> error:26
            G2 I1 -> (arc 600.0 [0.0, 0.0, 0.0] of 6.283 in 0.000..2.000 -1.000..1.000 0.000..0.000) ok
            G2 Z1 -> error:32
            G2 Z1 I1 -> (arc 600.0 [0.0, 0.0, 1.0] of 6.362 in 0.000..2.000 -1.000..1.000 0.000..1.000) ok
            G2 Z20000 -> error:32
            G18 G2 Y1 -> error:32
            G19 G2 X1 -> error:32
            G2 X10 -> error:35
            G2 X10 K5 -> error:35
            G18 G2 X10 J5 -> error:35
            G19 G2 Z1 I1 -> error:35
            G2 X10 I4.994 -> [MSG:the start is 4.994 mm from the arc's centre, the target 5.006 mm: correct the target or I, J, K] error:33
            G2 X10 I4.998 -> (arc 600.0 [10.0, 0.0, 1.0] of 15.708 in 0.000..10.000 0.000..5.002 1.000..1.000) ok
            G2 X0 Y0 R5 -> (arc 600.0 [0.0, 0.0, 1.0] of 15.708 in 0.000..10.000 -5.000..0.000 1.000..1.000) ok
            X10 -> error:35
            G2 X20 R4.9 -> [MSG:the target is 20.000 mm from the start, more than twice R 4.900 mm: correct it, or make R 10.000 mm] error:34
            G2 X20 R0 -> [MSG:the target is 20.000 mm from the start, more than twice R 0.000 mm: correct it, or make R 10.000 mm] error:34
            G2 X20 I10 R10 -> [MSG:I: R has given the arc: keep one of them] error:36
            G2 X20 J0 R10 -> [MSG:J: R has given the arc: keep one of them] error:36
            G2 X20 I10 P1 -> [MSG:P: an arc has no turns here: write a line for each turn] error:36
            G2 G1 X20 I5 -> error:24
            G2 G3 X20 I5 -> error:24
            G53 G2 X20 I5 -> error:30
            G53 -> error:30
            G92 G2 X20 I5 -> error:24
            G2.5 X1 I1 -> error:23
            G2.1 X1 I1 -> error:23
            G2 X9000 R-9000 -> error:33
            G1 X20 I5 -> [MSG:I: no code on the line uses it: remove it, or add the code that does] error:36
            G0 X20 R5 -> [MSG:R: no code on the line uses it: remove it, or add the code that does] error:36
            G2 X2 X3 I1 -> error:25
            G2 X20 I5 I5 -> error:25
            $G -> [GC:G2 G54 G17 G21 G90 G94 G64 M5 M9 T0 F600 S0] ok
        "#]],
    );
}

/// 0.005 mm, or 0.1 % of the radius, as for a centre.
#[test]
fn a_radius_may_be_as_wrong_as_a_centre() {
    check(
        "F600\nG2 X10.0001 R5\nX0 R5\nX10.0099 R5\nG3 X0 R4.949\nX0 R-4.949\nG91 G3 X200.19 R100\nX200.21 R100\nG20 X1 R.4998\nX1 R.49",
        expect![[r#"
            F600 -> ok
            G2 X10.0001 R5 -> (arc 600.0 [10.0001, 0.0, 0.0] of 15.708 in 0.000..10.000 0.000..5.000 0.000..0.000) ok
            X0 R5 -> (arc 600.0 [0.0, 0.0, 0.0] of 15.708 in 0.000..10.000 -5.000..0.000 0.000..0.000) ok
            X10.0099 R5 -> (arc 600.0 [10.0099, 0.0, 0.0] of 15.724 in 0.000..10.010 0.000..5.005 0.000..0.000) ok
            G3 X0 R4.949 -> [MSG:the target is 10.010 mm from the start, more than twice R 4.949 mm: correct it, or make R 5.005 mm] error:34
            X0 R-4.949 -> [MSG:the target is 10.010 mm from the start, more than twice R 4.949 mm: correct it, or make R 5.005 mm] error:34
            G91 G3 X200.19 R100 -> (arc 600.0 [210.1999, 0.0, 0.0] of 314.458 in 10.010..210.200 -100.095..0.000 0.000..0.000) ok
            X200.21 R100 -> [MSG:the target is 200.210 mm from the start, more than twice R 100.000 mm: correct it, or make R 100.105 mm] error:34
            G20 X1 R.4998 -> (arc 600.0 [235.5999, 0.0, 0.0] of 39.898 in 210.200..235.600 -12.700..0.000 0.000..0.000) ok
            X1 R.49 -> [MSG:the target is 25.400 mm from the start, more than twice R 12.446 mm: correct it, or make R 12.700 mm] error:34
        "#]],
    );
}

/// As Mach writes it by default.
#[test]
fn a_centre_that_is_a_place_is_reported() {
    check(
        "F600\nG10 L2 P1 X100 Y-20\nG0 X10 Y0\nG3 X0 Y10 I0 J0\nG3 X0 Y10 I0.1 J0\nG3 X0 Y10 I0\nG91 G2 X-2 Y-2 I8 J0\nG90 G18 G2 X12 Z2 I12 K0",
        expect![[r#"
            F600 -> ok
            G10 L2 P1 X100 Y-20 -> ok
            G0 X10 Y0 -> (rapid [110.0, -20.0, 0.0]) ok
            G3 X0 Y10 I0 J0 -> [MSG:the start is 0.000 mm from the arc's centre, the target 14.142 mm: it fits if I, J, K are absolute (G90.1): have them written from the start (G91.1)] error:33
            G3 X0 Y10 I0.1 J0 -> [MSG:the start is 0.100 mm from the arc's centre, the target 14.213 mm: correct the target or I, J, K] error:33
            G3 X0 Y10 I0 -> [MSG:the start is 0.000 mm from the arc's centre, the target 14.142 mm: correct the target or I, J, K] error:33
            G91 G2 X-2 Y-2 I8 J0 -> [MSG:the start is 8.000 mm from the arc's centre, the target 10.198 mm: it fits if I, J, K are absolute (G90.1): have them written from the start (G91.1)] error:33
            G90 G18 G2 X12 Z2 I12 K0 -> [MSG:the start is 12.000 mm from the arc's centre, the target 10.198 mm: it fits if I, J, K are absolute (G90.1): have them written from the start (G91.1)] error:33
        "#]],
    );
}

#[test]
fn arcs_are_modal_until_another_motion_or_the_end() {
    check(
        "G3 X10 I5 F600\nX0 I-5\nI5\nX10\nG28 X0\n$G\nG92 X5\nG0 X0\nX10 I5\nG2\n$G\nM2\n$G",
        expect![[r#"
            G3 X10 I5 F600 -> (arc 600.0 [10.0, 0.0, 0.0] of 15.708 in 0.000..10.000 -5.000..0.000 0.000..0.000) ok
            X0 I-5 -> (arc 600.0 [0.0, 0.0, 0.0] of 15.708 in 0.000..10.000 0.000..5.000 0.000..0.000) ok
            I5 -> (arc 600.0 [0.0, 0.0, 0.0] of 31.416 in 0.000..10.000 -5.000..5.000 0.000..0.000) ok
            X10 -> error:35
            G28 X0 -> (via [0.0, 0.0, 0.0]) (rapid [0.0, 0.0, 0.0]) ok
            $G -> [GC:G3 G54 G17 G21 G90 G94 G64 M5 M9 T0 F600 S0] ok
            G92 X5 -> ok
            G0 X0 -> (rapid [-5.0, 0.0, 0.0]) ok
            X10 I5 -> [MSG:I: no code on the line uses it: remove it, or add the code that does] error:36
            G2 -> error:26
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F600 S0] ok
            M2 -> (end) ok
            $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T0 F600 S0] ok
        "#]],
    );
}

#[test]
fn no_jog_is_an_arc() {
    check(
        "F600\n$J=G2 X10 I5 F100\n$J=G3 X10 F100\n$J=G2 Z1 F100\nG2 X10 I5\n$J=X5 F100\n$J=X5 I1 F100\n$G",
        expect![[r#"
            F600 -> ok
            $J=G2 X10 I5 F100 -> error:16
            $J=G3 X10 F100 -> error:35
            $J=G2 Z1 F100 -> error:32
            G2 X10 I5 -> (arc 600.0 [10.0, 0.0, 0.0] of 15.708 in 0.000..10.000 0.000..5.000 0.000..0.000) ok
            $J=X5 F100 -> (jog 100 [5.0, 0.0, 0.0]) ok
            $J=X5 I1 F100 -> error:36
            $G -> [GC:G2 G54 G17 G21 G90 G94 G64 M5 M9 T0 F600 S0] ok
        "#]],
    );
}

#[test]
fn exact_stop_is_modal_and_reported_while_it_is_on() {
    check(
        "G61.1 G1 X1 F600\n$G\nG0 X2\nG2 X12 I5\nG91 G28 X1\nG90 G61 X5 I2.5\nG61 G61.1\nG61.5\nG61.1\nM30\n$G",
        expect![[r#"
            G61.1 G1 X1 F600 -> (feed 600 [1.0, 0.0, 0.0]) (stop) ok
            $G -> [GC:G1 G54 G17 G21 G90 G94 G61.1 M5 M9 T0 F600 S0] ok
            G0 X2 -> (rapid [2.0, 0.0, 0.0]) (stop) ok
            G2 X12 I5 -> (arc 600.0 [12.0, 0.0, 0.0] of 15.708 in 2.000..12.000 0.000..5.000 0.000..0.000) (stop) ok
            G91 G28 X1 -> (via [13.0, 0.0, 0.0]) (rapid [0.0, 0.0, 0.0]) (stop) ok
            G90 G61 X5 I2.5 -> (arc 600.0 [5.0, 0.0, 0.0] of 7.854 in 0.000..5.000 0.000..2.500 0.000..0.000) ok
            G61 G61.1 -> error:21
            G61.5 -> [MSG:G61.5: unknown here: remove it] error:20
            G61.1 -> ok
            M30 -> (end) ok
            $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T0 F600 S0] ok
        "#]],
    );
}

/// Every form of an arc that occurs in example programs of others.
#[test]
fn arcs_as_programs_write_them() {
    check(
        "G90 G20 G17 G0 X3.4311 Y.3782\nG3 X3.7021 Y.4139 Z-.125 R1.0625 F100\nG21 G0 X0 Y0 Z0\nG3 X0 Y0 z 20 I20 J0\nG02X1.I.5F200",
        expect![[r#"
            G90 G20 G17 G0 X3.4311 Y.3782 -> (rapid [87.14994, 9.60628, 0.0]) ok
            G3 X3.7021 Y.4139 Z-.125 R1.0625 F100 -> (arc 2540.0 [94.03334, 10.51306, -3.175] of 7.652 in 87.150..94.033 9.606..10.513 -3.175..0.000) ok
            G21 G0 X0 Y0 Z0 -> (rapid [0.0, 0.0, 0.0]) ok
            G3 X0 Y0 z 20 I20 J0 -> (arc 2540.0 [0.0, 0.0, 20.0] of 127.245 in 0.000..40.000 -20.000..20.000 0.000..20.000) ok
            G02X1.I.5F200 -> (arc 200.0 [1.0, 0.0, 20.0] of 1.571 in 0.000..1.000 0.000..0.500 20.000..20.000) ok
        "#]],
    );
}
