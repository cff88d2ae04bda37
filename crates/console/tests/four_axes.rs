//! The dialect of a machine with a fourth axis, A, which is rotary unless a setting says otherwise.

#[path = "dialect/talk.rs"]
mod talk;

use expect_test::{Expect, expect};
use isostep_console::{ReportedState, Settings};
use talk::{Talk, check};

/// The replies to a sender from a machine with this setting of A.
fn check_with(setting: &str, program: &str, heard: Expect) {
    let mut talk = Talk::new(ReportedState::Idle);
    assert!(talk.send(setting).lines().all(|line| line.ends_with("ok")), "{setting}");
    heard.assert_eq(&talk.send(program));
}

#[test]
fn a_is_an_axis_as_the_others_are() {
    check(
        "G1 X10 A90 F600\nG0 A-45.5\nG91 A10\nG90 G10 L2 P1 A5\nG0 A0\nG92 A1\nA2\nG92.1\nG28 A0\nG28.1\nG53 G0 A7\nG30\nG38.2 A20 F10\n\
         G43.1 Z1 A1\nG43.1 A1\n$#",
        expect![[r#"
            G1 X10 A90 F600 -> (feed 600 [10.0, 0.0, 0.0, 90.0]) ok
            G0 A-45.5 -> (rapid [10.0, 0.0, 0.0, -45.5]) ok
            G91 A10 -> (rapid [10.0, 0.0, 0.0, -35.5]) ok
            G90 G10 L2 P1 A5 -> ok
            G0 A0 -> (rapid [10.0, 0.0, 0.0, 5.0]) ok
            G92 A1 -> ok
            A2 -> (rapid [10.0, 0.0, 0.0, 6.0]) ok
            G92.1 -> ok
            G28 A0 -> (via [10.0, 0.0, 0.0, 5.0]) (rapid [10.0, 0.0, 0.0, 0.0]) ok
            G28.1 -> ok
            G53 G0 A7 -> (rapid [10.0, 0.0, 0.0, 7.0]) ok
            G30 -> (rapid [0.0, 0.0, 0.0, 0.0]) ok
            G38.2 A20 F10 -> (probe toward or alarm 10 [0.0, 0.0, 0.0, 25.0]) ok
            G43.1 Z1 A1 -> error:37
            G43.1 A1 -> error:37
            $# -> [G54:0.000,0.000,0.000,5.000] [G55:0.000,0.000,0.000,0.000] [G56:0.000,0.000,0.000,0.000] [G57:0.000,0.000,0.000,0.000] [G58:0.000,0.000,0.000,0.000] [G59:0.000,0.000,0.000,0.000] [G59.1:0.000,0.000,0.000,0.000] [G59.2:0.000,0.000,0.000,0.000] [G59.3:0.000,0.000,0.000,0.000] [G28:10.000,0.000,0.000,0.000] [G30:0.000,0.000,0.000,0.000] [G92:0.000,0.000,0.000,0.000] [TLO:0.000] [PRB:0.000,0.000,0.000,0.000:0] ok
        "#]],
    );
}

#[test]
fn degrees_are_degrees_in_inches_mode() {
    check(
        "$13=1\nG20 G0 X1 A10\nG92 X0 A0\n$#\n?",
        expect![[r#"
            $13=1 -> ok
            G20 G0 X1 A10 -> (rapid [25.4, 0.0, 0.0, 10.0]) ok
            G92 X0 A0 -> ok
            $# -> [G54:0.0000,0.0000,0.0000,0.000] [G55:0.0000,0.0000,0.0000,0.000] [G56:0.0000,0.0000,0.0000,0.000] [G57:0.0000,0.0000,0.0000,0.000] [G58:0.0000,0.0000,0.0000,0.000] [G59:0.0000,0.0000,0.0000,0.000] [G59.1:0.0000,0.0000,0.0000,0.000] [G59.2:0.0000,0.0000,0.0000,0.000] [G59.3:0.0000,0.0000,0.0000,0.000] [G28:0.0000,0.0000,0.0000,0.000] [G30:0.0000,0.0000,0.0000,0.000] [G92:1.0000,0.0000,0.0000,10.000] [TLO:0.0000] [PRB:0.0000,0.0000,0.0000,0.000:0] ok
            ? -> <Idle|MPos:1.0000,0.0000,0.0000,10.000|FS:0.0,0|WCO:1.0000,0.0000,0.0000,10.000> ok
        "#]],
    );
    check_with(
        "$133=100\n$376=0",
        "$13=1\nG20 G0 X1 A1\nG92 X0 A0\n$#\n?",
        expect![[r#"
            $13=1 -> ok
            G20 G0 X1 A1 -> (rapid [25.4, 0.0, 0.0, 25.4]) ok
            G92 X0 A0 -> ok
            $# -> [G54:0.0000,0.0000,0.0000,0.0000] [G55:0.0000,0.0000,0.0000,0.0000] [G56:0.0000,0.0000,0.0000,0.0000] [G57:0.0000,0.0000,0.0000,0.0000] [G58:0.0000,0.0000,0.0000,0.0000] [G59:0.0000,0.0000,0.0000,0.0000] [G59.1:0.0000,0.0000,0.0000,0.0000] [G59.2:0.0000,0.0000,0.0000,0.0000] [G59.3:0.0000,0.0000,0.0000,0.0000] [G28:0.0000,0.0000,0.0000,0.0000] [G30:0.0000,0.0000,0.0000,0.0000] [G92:1.0000,0.0000,0.0000,1.0000] [TLO:0.0000] [PRB:0.0000,0.0000,0.0000,0.0000:0] ok
            ? -> <Idle|MPos:1.0000,0.0000,0.0000,1.0000|FS:0.0,0|WCO:1.0000,0.0000,0.0000,1.0000> ok
        "#]],
    );
}

#[test]
fn a_turns_evenly_along_an_arc() {
    check(
        "G2 X10 Y0 I5 A180 F600\nG3 X0 Y0 I-5 A0\nG18 G2 X10 Z0 I5 A90\nG2 A10 F100",
        expect![[r#"
        G2 X10 Y0 I5 A180 F600 -> (arc 600.0 [10.0, 0.0, 0.0, 180.0] of 180.684 in 0.000..10.000 0.000..5.000 0.000..0.000 0.000..180.000) ok
        G3 X0 Y0 I-5 A0 -> (arc 600.0 [0.0, 0.0, 0.0, 0.0] of 180.684 in 0.000..10.000 0.000..5.000 0.000..0.000 0.000..180.000) ok
        G18 G2 X10 Z0 I5 A90 -> (arc 600.0 [10.0, 0.0, 0.0, 90.0] of 91.360 in 0.000..10.000 0.000..0.000 -5.000..0.000 0.000..90.000) ok
        G2 A10 F100 -> error:32
    "#]],
    );
}

/// The feeds are those of grblHAL's planner for the same lines.
#[test]
fn f_is_along_all_axes_or_along_the_linear_ones() {
    // For each line what is heard with $701=0, 1 and 3.
    let rows = [
        ("G1 X3 A4 F600", ["feed 600", "feed 1000", "feed 1000"]),
        ("G91 A10", ["feed 600", "feed 600", "feed 600"]),
        ("X5", ["feed 600", "feed 600", "feed 600"]),
        ("G2 X10 I5 A90", ["arc 600.0", "arc 3489.7", "arc 3489.7"]),
        ("G1 G93 X3 A4 F2", ["feed 10", "feed 10", "feed 10"]),
        ("G94 G20 F10", ["", "", ""]),
        ("A10", ["feed 254", "feed 254", "feed 10"]),
        ("X1 A10", ["feed 254", "feed 272.9762", "feed 272.9762"]),
        ("G21", ["", "", ""]),
        ("$J=X3 A4 F600", ["jog 600", "jog 1000", "jog 1000"]),
        ("G38.3 X3 A4 F600", ["probe toward 600", "probe toward 1000", "probe toward 1000"]),
    ];
    for (column, setting) in ["$701=0", "$701=1", "$701=3"].into_iter().enumerate() {
        let mut talk = Talk::new(ReportedState::Idle);
        assert_eq!(talk.bytes(format!("{setting}\n").as_bytes()), "ok");
        for (line, expected) in rows {
            let heard = talk.bytes(format!("{line}\n").as_bytes());
            let expected =
                if expected[column].is_empty() { "ok".to_owned() } else { format!("({} ", expected[column]) };
            assert!(heard.starts_with(&expected) && heard.ends_with("ok"), "{setting}, {line}: {heard}");
        }
    }
}

#[test]
fn a_has_settings_and_statements_of_its_own() {
    check(
        "$103=80\n$113=7200\n$123=100\n$133=0\n$133=0.5\n$130=0\n$133=360\n$376=0\n$133=0\n$133=360\n$133=1e9\n$113=1e6\n$3=8\n$3=16\n$23=15\n\
         $901=4123\n$901=3124\n$901=31\n$901=3014\n$901=1233\n$901=1239\n$HA\n$901=312\n$HA\n$HX\n$HB\n$BUZZ=A\n$BUZZ=B\n$27=400\n$I\nG1 B1\nU1",
        expect![[r#"
            $103=80 -> ok
            $113=7200 -> ok
            $123=100 -> ok
            $133=0 -> ok
            $133=0.5 -> [MSG:$133=0.500 is below the least, 1 degrees: raise it; until then nothing moves] ok
            $130=0 -> [MSG:$130=0 is below the least, 1 mm: raise it] error:2
            $133=360 -> ok
            $376=0 -> ok
            $133=0 -> [MSG:$133=0 is below the least, 1 mm: raise it; until then nothing moves] ok
            $133=360 -> ok
            $133=1e9 -> error:2
            $113=1e6 -> error:2
            $3=8 -> ok
            $3=16 -> [MSG:$3=16 is above the most, 15: lower it] error:2
            $23=15 -> ok
            $901=4123 -> ok
            $901=3124 -> ok
            $901=31 -> [MSG:$901=31 is below the least, 123: raise it] error:2
            $901=3014 -> [MSG:$901=3014 is no order: give each of 1 (X), 2 (Y) and 3 (Z) once, and 4 (A) if it homes, as in 312] error:2
            $901=1233 -> [MSG:$901=1233 is no order: give each of 1 (X), 2 (Y) and 3 (Z) once, and 4 (A) if it homes, as in 312] error:2
            $901=1239 -> [MSG:$901=1239 is no order: give each of 1 (X), 2 (Y) and 3 (Z) once, and 4 (A) if it homes, as in 312] error:2
            $HA -> (home 3) ok
            $901=312 -> ok
            $HA -> error:5
            $HX -> (home 0) ok
            $HB -> error:3
            $BUZZ=A -> (buzz 3) ok
            $BUZZ=B -> error:3
            $27=400 -> [MSG:$27=400 is above the most, 100 mm: lower it] error:2
            $I -> [VER:1.1h.20190830:Isostep 0.2.0 (grbl dialect)] [OPT:VNMZHL,79,128] [AXS:4:XYZA] ok
            G1 B1 -> [MSG:B: four axes only, X Y Z A: remove it] error:20
            U1 -> [MSG:U: four axes only, X Y Z A: remove it] error:20
        "#]],
    );
}

#[test]
fn senders_of_grblhal_read_four_axes() {
    let mut talk = Talk::new(ReportedState::Idle);
    let settings = talk.bytes(b"$ES\n");
    for line in [
        "[SETTING:113|2|A top speed|degrees/min|6|#######0.000|1.000|90000000.000|0|0]",
        "[SETTING:376|2|rotary axes||1|A|||0|0]",
        "[SETTING:901|5|homing order, axis digits||5|###0|123|4321|0|0]",
        "[SETTING:905|4|axis with a second motor||3|none,X,Y,Z,A|||0|0]",
    ] {
        assert!(settings.contains(line), "{line} is not in {settings}");
    }
    assert!(settings.split(" [").all(|line| line.len() <= 190));
    assert!(talk.bytes(b"$I+\n").contains("[OPT:VNMZHL,79,128,4,0] [AXS:4:XYZA]"));
    let report = talk.bytes(b"\x87");
    assert!(report.ends_with("|WCS:G54|H:0,0|T:0|TLR:0|FW:Isostep>"), "{report}");
}

#[test]
fn what_the_listing_prints_can_be_sent_back() {
    let mut talk = Talk::new(ReportedState::Idle);
    let listing = talk.bytes(b"$$\n");
    for setting in listing.split(' ').filter(|line| line.starts_with('$')) {
        assert_eq!(talk.bytes(format!("{setting}\n").as_bytes()), "ok", "{setting}");
    }
    assert_eq!(talk.settings, Settings::DEFAULT);
    for number in [103, 113, 123, 133, 173, 376, 701, 913, 923, 933] {
        assert!(listing.contains(&format!("${number}=")), "{listing}");
    }
}
