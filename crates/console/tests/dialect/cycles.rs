//! Canned cycles: each line, and the moves that it makes, by LinuxCNC's rules.

use expect_test::expect;
use isostep_console::ReportedState;

use super::talk::{Talk, check};

#[test]
fn g81_drills_from_r_at_the_feed_and_ends_where_the_series_began_or_at_r() {
    check(
        "G0 Z10\nG81 X1 Y2 Z-3 R2 F100\nX4\nG99 X5\nX6\nG98 X7 Z-1\nY9 R1\nG80\nG0 Z0.5\nG81 X1 Z-3 R2\nG99 G81 X2 Z-3 R12\n$G\nM2\n$G",
        expect![[r#"
            G0 Z10 -> (rapid [0.0, 0.0, 10.0]) ok
            G81 X1 Y2 Z-3 R2 F100 -> 1,2,10| 1,2,2 F100:1,2,-3| 1,2,10| ok
            X4 -> 4,2,10| 4,2,2 F100:4,2,-3| 4,2,10| ok
            G99 X5 -> 5,2,10| 5,2,2 F100:5,2,-3| 5,2,2| ok
            X6 -> 6,2,2| F100:6,2,-3| 6,2,2| ok
            G98 X7 Z-1 -> 7,2,2| F100:7,2,-1| 7,2,10| ok
            Y9 R1 -> 7,9,10| 7,9,1 F100:7,9,-1| 7,9,10| ok
            G80 -> ok
            G0 Z0.5 -> (rapid [7.0, 9.0, 0.5]) ok
            G81 X1 Z-3 R2 -> 7,9,2| 1,9,2| F100:1,9,-3| 1,9,2| ok
            G99 G81 X2 Z-3 R12 -> 1,9,12| 2,9,12| F100:2,9,-3| 2,9,12| ok
            $G -> [GC:G81 G54 G17 G21 G90 G94 G64 G99 M5 M9 T0 F100 S0] ok
            M2 -> (end) ok
            $G -> [GC:G1 G54 G17 G21 G90 G94 G64 M5 M9 T0 F100 S0] ok
        "#]],
    );
}

/// In one series with G99 first, G98 still ends at the height at which the series began, which grblHAL forgets; with another code too.
#[test]
fn g98_behind_g99_ends_where_the_series_began() {
    check(
        "G0 Z10\nG99 G81 X1 Z-3 R2 F100\nG98 X2\nX3\nG99 X4\nG98 G82 X5 Z-3 R2 P0",
        expect![[r#"
            G0 Z10 -> (rapid [0.0, 0.0, 10.0]) ok
            G99 G81 X1 Z-3 R2 F100 -> 1,0,10| 1,0,2 F100:1,0,-3| 1,0,2| ok
            G98 X2 -> 2,0,2| F100:2,0,-3| 2,0,10| ok
            X3 -> 3,0,10| 3,0,2 F100:3,0,-3| 3,0,10| ok
            G99 X4 -> 4,0,10| 4,0,2 F100:4,0,-3| 4,0,2| ok
            G98 G82 X5 Z-3 R2 P0 -> 5,0,2| F100:5,0,-3| 5,0,10| ok
        "#]],
    );
}

#[test]
fn each_code_has_its_way_down_and_up() {
    check(
        "G0 Z5\nG82 X1 Z-1 R1 P0.5 F60\nX2\nG85 X3 Z-1 R1\nG89 X4 Z-1 R1 P2\nG86 X5 Z-1 R1\nX6 P1\nG82 X7 Z-1 R1 P0",
        expect![[r#"
            G0 Z5 -> (rapid [0.0, 0.0, 5.0]) ok
            G82 X1 Z-1 R1 P0.5 F60 -> 1,0,5| 1,0,1 F60:1,0,-1| (wait 0.5 s) 1,0,5| ok
            X2 -> 2,0,5| 2,0,1 F60:2,0,-1| (wait 0.5 s) 2,0,5| ok
            G85 X3 Z-1 R1 -> 3,0,5| 3,0,1 F60:3,0,-1| F60:3,0,5| ok
            G89 X4 Z-1 R1 P2 -> 4,0,5| 4,0,1 F60:4,0,-1| (wait 2 s) F60:4,0,5| ok
            G86 X5 Z-1 R1 -> 5,0,5| 5,0,1 F60:5,0,-1| (spindle off) 5,0,5| (spindle on) ok
            X6 P1 -> 6,0,5| 6,0,1 F60:6,0,-1| (wait 1 s) (spindle off) 6,0,5| (spindle on) ok
            G82 X7 Z-1 R1 P0 -> 7,0,5| 7,0,1 F60:7,0,-1| 7,0,5| ok
        "#]],
    );
}

#[test]
fn pecks_go_up_to_r_or_by_the_clearance() {
    check(
        "G0 Z5\nG83 X1 Z-5 R1 Q2.5 F60\nX2 Q10\nG73 X3 Z-5 R1 Q2.5\nX4 Q0.4 Z0\n$28=0.25\nG83 X5 Z-5 R1 Q3\n$28=9\nX6",
        expect![[r#"
            G0 Z5 -> (rapid [0.0, 0.0, 5.0]) ok
            G83 X1 Z-5 R1 Q2.5 F60 -> 1,0,5| 1,0,1 F60:1,0,-1.5| 1,0,1| 1,0,-0.5 F60:1,0,-4| 1,0,1| 1,0,-3 F60:1,0,-5| 1,0,5| ok
            X2 Q10 -> 2,0,5| 2,0,1 F60:2,0,-5| 2,0,5| ok
            G73 X3 Z-5 R1 Q2.5 -> 3,0,5| 3,0,1 F60:3,0,-1.5| 3,0,-0.5| F60:3,0,-4| 3,0,-3| F60:3,0,-5| 3,0,5| ok
            X4 Q0.4 Z0 -> 4,0,5| 4,0,1 F60:4,0,0.6| 4,0,1| F60:4,0,0.2| 4,0,1| F60:4,0,0| 4,0,5| ok
            $28=0.25 -> ok
            G83 X5 Z-5 R1 Q3 -> 5,0,5| 5,0,1 F60:5,0,-2| 5,0,1| 5,0,-1.75 F60:5,0,-5| 5,0,5| ok
            $28=9 -> ok
            X6 -> 6,0,5| 6,0,1 F60:6,0,-2| 6,0,1| F60:6,0,-5| 6,0,5| ok
        "#]],
    );
}

#[test]
fn g91_counts_r_from_where_the_series_began_and_repeats_l_times() {
    check(
        "G0 X10 Z5\nG91 G81 X1 Y2 Z-4 R-3 L3 F100\nX-5\nG99 Y1 L2\nG90 X0 Y0 Z-1 R1 L2",
        expect![[r#"
            G0 X10 Z5 -> (rapid [10.0, 0.0, 5.0]) ok
            G91 G81 X1 Y2 Z-4 R-3 L3 F100 -> 11,2,5| 11,2,2 F100:11,2,-2| 11,2,5| 12,4,5| 12,4,2 F100:12,4,-2| 12,4,5| 13,6,5| 13,6,2 F100:13,6,-2| 13,6,5| ok
            X-5 -> 8,6,5| 8,6,2 F100:8,6,-2| 8,6,5| ok
            G99 Y1 L2 -> 8,7,5| 8,7,2 F100:8,7,-2| 8,7,2| 8,8,2| F100:8,8,-2| 8,8,2| ok
            G90 X0 Y0 Z-1 R1 L2 -> 0,0,2| 0,0,1 F100:0,0,-1| 0,0,1| F100:0,0,-1| 0,0,1| ok
        "#]],
    );
}

#[test]
fn planes_offsets_and_inches_count() {
    check(
        "G0 X5 Y5 Z5\nG18 G81 X1 Z2 Y-3 R1 F100\nG19 G81 Y1 Z2 X-3 R1\nG80\nG17 G0 Z5\nG92 X0 Y0 Z0\nG10 L2 P1 X100\nG81 X1 Z-1 R1\nG20 X1 Z-0.1 R0.1\nG54 G83 Q0.05 X2 Z-0.1 R0.1",
        expect![[r#"
            G0 X5 Y5 Z5 -> (rapid [5.0, 5.0, 5.0]) ok
            G18 G81 X1 Z2 Y-3 R1 F100 -> 1,5,2| 1,1,2 F100:1,-3,2| 1,5,2| ok
            G19 G81 Y1 Z2 X-3 R1 -> 1,1,2| F100:-3,1,2| 1,1,2| ok
            G80 -> ok
            G17 G0 Z5 -> (rapid [1.0, 1.0, 5.0]) ok
            G92 X0 Y0 Z0 -> ok
            G10 L2 P1 X100 -> ok
            G81 X1 Z-1 R1 -> 1,1,6| 102,1,6| F100:102,1,4| 102,1,6| ok
            G20 X1 Z-0.1 R0.1 -> 102,1,7.54| 126.4,1,7.54| F100:126.4,1,2.46| 126.4,1,7.54| ok
            G54 G83 Q0.05 X2 Z-0.1 R0.1 -> 151.8,1,7.54| F100:151.8,1,6.27| 151.8,1,7.54| 151.8,1,7.27 F100:151.8,1,5| 151.8,1,7.54| 151.8,1,6 F100:151.8,1,3.73| 151.8,1,7.54| 151.8,1,4.73 F100:151.8,1,2.46| 151.8,1,7.54| ok
        "#]],
    );
}

/// G0 to G3 and G80 end a series; words alone go on behind G80 as before it.
#[test]
fn other_motion_ends_a_series() {
    check(
        "G1 F100\nG0 Z5\nG81 X1 Z-1 R1\nG0 X9\nG81 X2\nG81 X2 Z-1 R1\nG82 X3\nG82 X3 Z-1 R1 P1\nG80 Z9\n$G\nG1\nG81 X1 Z-1 R1\nG80\nX5\nG2 X6 I0.5\nG80\nX7\nG81 X2 Z-1 R1\nG80 X9\nG80 G28 Z1\nG81 X2 Z-1 R1\nG4 P1\nX3\nG92 X1\nX4",
        expect![[r#"
            G1 F100 -> ok
            G0 Z5 -> (rapid [0.0, 0.0, 5.0]) ok
            G81 X1 Z-1 R1 -> 1,0,5| 1,0,1 F100:1,0,-1| 1,0,5| ok
            G0 X9 -> (rapid [9.0, 0.0, 5.0]) ok
            G81 X2 -> error:28
            G81 X2 Z-1 R1 -> 2,0,5| 2,0,1 F100:2,0,-1| 2,0,5| ok
            G82 X3 -> error:28
            G82 X3 Z-1 R1 P1 -> 3,0,5| 3,0,1 F100:3,0,-1| (wait 1 s) 3,0,5| ok
            G80 Z9 -> (rapid [3.0, 0.0, 9.0]) ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F100 S0] ok
            G1 -> ok
            G81 X1 Z-1 R1 -> 1,0,9| 1,0,1 F100:1,0,-1| 1,0,9| ok
            G80 -> ok
            X5 -> (feed 100 [5.0, 0.0, 9.0]) ok
            G2 X6 I0.5 -> (arc 100.0 [6.0, 0.0, 9.0] of 1.571 in 5.000..6.000 0.000..0.500 9.000..9.000) ok
            G80 -> ok
            X7 -> error:31
            G81 X2 Z-1 R1 -> 2,0,9| 2,0,1 F100:2,0,-1| 2,0,9| ok
            G80 X9 -> error:31
            G80 G28 Z1 -> (via [2.0, 0.0, 1.0]) (rapid [2.0, 0.0, 0.0]) ok
            G81 X2 Z-1 R1 -> 2,0,1| F100:2,0,-1| 2,0,1| ok
            G4 P1 -> (wait 1 s) ok
            X3 -> 3,0,1| F100:3,0,-1| 3,0,1| ok
            G92 X1 -> ok
            X4 -> 6,0,1| F100:6,0,-1| 6,0,1| ok
        "#]],
    );
}

#[test]
fn a_cycle_that_cannot_be_is_refused_and_changes_nothing() {
    let mut talk = Talk::new(ReportedState::Idle);
    talk.send("G0 Z5\nG81 X1 Z-1 R1 F100");
    let before = talk.interpreter;
    let mut heard = String::new();
    for line in [
        "G82 X2",
        "G83 X2 Z-1 R1",
        "G82 X2 Z-1 R1",
        "X2 R-2",
        "X2 Z1.5",
        "X2 L0",
        "X2 L-1",
        "X2 L10000",
        "X2 L1.5",
        "G83 X2 Z-1 R1 Q0",
        "G83 X2 Z-1 R1 Q-1",
        "G83 X2 Z-1 R1 Q0.00001",
        "G93 X2",
        "G93 F2 X2",
        "G18 X2",
        "F0 X2",
        "R2",
        "L2",
        "G81",
        "X2 Q1",
        "X2 P1",
        "G73 G81 X2",
        "G53 X2",
        "G98 G99 X2",
        "X99999",
        "G91 X9 L9999",
        "G91 X99999999 L9999",
        "G20 G91 X-99999999 Y99999999 Z-99999999 R99999999 L9999",
        "R99999 X2",
        "$J=G81 X1 F1",
        "G84 X2 Z-1 R1",
        "G74 X2",
        "G76 X2",
        "G87 X2",
        "G88 X2",
        "G81.1",
    ] {
        heard.push_str(&talk.send(line));
        assert_eq!(talk.interpreter, before, "{line}");
    }
    expect![[r#"
        G82 X2 -> error:28
        G83 X2 Z-1 R1 -> error:28
        G82 X2 Z-1 R1 -> error:28
        X2 R-2 -> [MSG:R: -2.000 mm is below Z, -1.000 mm: give an R above the hole] error:39
        X2 Z1.5 -> [MSG:R: 1.000 mm is below Z, 1.500 mm: give an R above the hole] error:39
        X2 L0 -> [MSG:L: 0, and 1 to 9999 holes are possible: correct L] error:39
        X2 L-1 -> [MSG:L: -1, and 1 to 9999 holes are possible: correct L] error:39
        X2 L10000 -> [MSG:L: 10000, and 1 to 9999 holes are possible: correct L] error:39
        X2 L1.5 -> error:23
        G83 X2 Z-1 R1 Q0 -> [MSG:Q: 0.000 mm, too small for the 99999 pecks that a line may have: give a greater Q] error:39
        G83 X2 Z-1 R1 Q-1 -> [MSG:Q: -1.000 mm, too small for the 99999 pecks that a line may have: give a greater Q] error:39
        G83 X2 Z-1 R1 Q0.00001 -> [MSG:Q: 0.000 mm, too small for the 99999 pecks that a line may have: give a greater Q] error:39
        G93 X2 -> error:22
        G93 F2 X2 -> [MSG:G93: a cycle is several moves, and needs a feed: add G94 and F] error:39
        G18 X2 -> error:28
        F0 X2 -> error:22
        R2 -> [MSG:R: no code on the line uses it: remove it, or add the code that does] error:36
        L2 -> [MSG:L: no code on the line uses it: remove it, or add the code that does] error:36
        G81 -> error:26
        X2 Q1 -> [MSG:Q: no code on the line uses it: remove it, or add the code that does] error:36
        X2 P1 -> [MSG:P: no code on the line uses it: remove it, or add the code that does] error:36
        G73 G81 X2 -> error:24
        G53 X2 -> error:30
        G98 G99 X2 -> error:21
        X99999 -> error:33
        G91 X9 L9999 -> error:33
        G91 X99999999 L9999 -> error:33
        G20 G91 X-99999999 Y99999999 Z-99999999 R99999999 L9999 -> error:33
        R99999 X2 -> error:33
        $J=G81 X1 F1 -> error:16
        G84 X2 Z-1 R1 -> [MSG:G84: no tapping here, the spindle does not say where it stands: tap by hand, or mill the thread] error:20
        G74 X2 -> [MSG:G74: no tapping here, the spindle does not say where it stands: tap by hand, or mill the thread] error:20
        G76 X2 -> [MSG:G76: no threads here, the spindle does not say where it stands: remove it] error:20
        G87 X2 -> [MSG:G87: the canned cycles are G73 G81 G82 G83 G85 G86 G89: let the post-processor expand others] error:20
        G88 X2 -> [MSG:G88: the canned cycles are G73 G81 G82 G83 G85 G86 G89: let the post-processor expand others] error:20
        G81.1 -> [MSG:G81.1: the canned cycles are G73 G81 G82 G83 G85 G86 G89: let the post-processor expand others] error:20
    "#]].assert_eq(&heard);
}
