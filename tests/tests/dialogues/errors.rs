//! Each error of the table in docs/console.md, and that nothing has changed after it.

use embassy_time::Duration;
use isostep_sim::{Config, Flash, Sim};

use crate::talk::{begin, homed, powered_up, refused, say, status};

/// Each line must be refused with the error. Modal state, offsets, settings and position must be as before.
fn refused_and_unchanged(lines: &[&str], code: u8) {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G55 G91 G1 X1 F600"), ["ok"]);
    let before = everything(&mut sim);
    for line in lines {
        refused(&mut sim, line, code);
        assert_eq!(everything(&mut sim), before, "{line}");
    }
}

fn everything(sim: &mut Sim) -> Vec<String> {
    let mut heard: Vec<_> = ["$G", "$#", "$$", "$N"].iter().flat_map(|line| say(sim, line)).collect();
    heard.push(status(sim));
    heard
}

#[test]
fn error_1_letter_missing() {
    refused_and_unchanged(&["5X", "X1.2.3", "%1", "-X1", "G1)X2", "#1=2", "G1*71", "G0 X1 \u{1}", "\u{7f}"], 1);
}

#[test]
fn error_2_bad_number() {
    refused_and_unchanged(
        &["X", "G", "X--5", "X.", "XINF", "X100000000", "G-1", "$100=", "$100=1e3", "$100=0", "$N=G0", "$901=311"],
        2,
    );
}

#[test]
fn error_3_unknown_statement() {
    refused_and_unchanged(&["$999=1", "$NONSENSE", "$HA", "$100", "$N2=", "$IX", "$RST=", "$E99", "$A", "$$$"], 3);
}

#[test]
fn error_4_negative() {
    refused_and_unchanged(&["G1 X1 F-1", "N-1", "G4 P-1", "S-1", "T-1", "$100=-50"], 4);
}

#[test]
fn error_5_homing_disabled() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$22=0"), ["ok"]);
    refused(&mut sim, "$H", 5);
}

#[test]
fn error_7_not_stored() {
    let flash = Flash::blank();
    let mut sim = Sim::with_flash(&Config::default(), flash.clone());
    say(&mut sim, "");
    flash.refuse();
    for line in ["$110=1234", "G10 L2 P1 X1", "$N0=G21"] {
        let [reported, answer] = &say(&mut sim, line)[..] else { panic!("{line}") };
        assert!(reported.starts_with("[MSG:The flash has refused: the change is in force, but"), "{reported}");
        assert_eq!(answer, "error:7", "{line}");
    }
    // Lines that change nothing are not refused. The next change also stores what is not stored yet.
    assert_eq!(say(&mut sim, "G0 X1"), ["ok"]);
    flash.mend();
    assert_eq!(say(&mut sim, "$130=300"), ["ok"]);
    let mut next = Sim::with_flash(&Config::default(), flash);
    let heard = say(&mut next, "$$");
    assert!(heard.contains(&"$110=1234.000".to_owned()) && heard.contains(&"$130=300.000".to_owned()), "{heard:?}");
}

#[test]
fn error_8_not_idle() {
    let mut sim = homed();
    assert_eq!(begin(&mut sim, "G1 X100 F600", Duration::from_secs(1)), ["ok"]);
    for line in ["$$", "$#", "$I", "$N", "$N0=G21", "$H", "$J=X1F100", "$SLP", "$RST=*", "$100=60", "$C"] {
        assert_eq!(begin(&mut sim, line, Duration::from_millis(10)), ["error:8"], "{line}");
    }
    sim.run_until_idle().unwrap();
    assert_eq!(status(&mut sim), "<Idle|MPos:100.000,0.000,0.000");
}

#[test]
fn error_9_locked() {
    let mut sim = homed();
    assert_eq!(begin(&mut sim, "$J=X100F600", Duration::from_secs(1)), ["ok"]);
    assert_eq!(begin(&mut sim, "G0 X1", Duration::from_millis(10)), ["error:9"], "while jogging");
    sim.run_until_idle().unwrap();
    assert_eq!(say(&mut sim, "G0 X-1").iter().filter(|line| *line == "error:9").count(), 1, "raises the alarm");
    refused(&mut sim, "G0 X1", 9);
    refused(&mut sim, "G4 P0", 9);
    assert_eq!(say(&mut sim, ""), ["ok"], "an empty line is not G-code");
}

#[test]
fn error_10_soft_limits_need_homing() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$22=0"), ["ok"]);
    let reported = "[MSG:$20=1 needs a machine that homes: set $22=1 or $20=0; until then nothing moves]";
    assert_eq!(say(&mut sim, "$20=1"), [reported, "ok"]);
    assert_eq!(say(&mut sim, "$X"), [reported, "error:10"]);
    assert_eq!(say(&mut sim, "$22=1\n$X"), ["ok", "ok"]);
}

#[test]
fn error_11_line_too_long() {
    let longest = format!("X1{}", "Y".repeat(77));
    refused_and_unchanged(&[&longest], 2);
    refused_and_unchanged(&[&format!("{longest}Y"), &"X".repeat(10_000)], 11);
}

#[test]
fn error_12_rate_too_high() {
    let mut sim = homed();
    for (line, again) in [("$110=300000", "$110=2880"), ("$102=10000", "$102=50"), ("$911=3000", "$911=0")] {
        assert_eq!(say(&mut sim, line).last_line(), "ok", "{line}");
        refused(&mut sim, "$H", 12);
        assert_eq!(say(&mut sim, again).last_line(), "ok");
    }
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
}

#[test]
fn error_15_travel_exceeded() {
    refused_and_unchanged(&["$J=X350 F100", "$J=G90 X350.02 F100", "$J=G53 Z-0.02 F100", "$J=G91 G20 Y16 F100"], 15);
}

#[test]
fn error_16_bad_jog() {
    refused_and_unchanged(&["$J", "$JX1F100", "$J=G1 X1 F100", "$J=G55 X1 F100", "$J=M3 X1 F100"], 16);
}

#[test]
fn error_20_unsupported() {
    refused_and_unchanged(
        &["G5", "G64.1", "G43 H1", "M62", "A1", "O100", "G0 Q5", "G10 L3 P1 X1", "G10 L2 P1 R1 X1"],
        20,
    );
    let mut sim = homed();
    for (line, reported) in [
        ("G38.6 Z-1", "G38.6: probing is G38.2 to G38.5: give one of them"),
        ("G0 X1 G42 D1", "G42: no cutter compensation here: let the CAM program compensate"),
        ("M100 Q1", "M100: unknown here: remove it"),
        ("G0 X1 A-2.5 M62", "A: three axes only, X Y Z: remove it"),
        ("$J=X1 F100 C1", "C: three axes only, X Y Z: remove it"),
        ("$N1=G0 Q1", "Q: no code here uses it: remove it"),
        ("G10 L3 P1 X1", "G10: L2 or L20 here, without a rotation: correct L, remove R"),
    ] {
        assert_eq!(say(&mut sim, line), [format!("[MSG:{reported}]"), "error:20".to_owned()], "{line}");
    }
}

/// Whatever the error is, the machine says what is not known here, as `isostep check` does.
#[test]
fn expressions_are_named_with_any_error() {
    let mut sim = homed();
    for (line, word, code) in
        [("#1=5", "#1", 1), ("G1 X#1 F100", "X#1", 2), ("G0 X[1+2]", "X[1+2]", 2), ("G1*71", "*71", 1)]
    {
        let reported = format!(
            "[MSG:{word}: no variables, expressions, checksums here: let the post-processor write plain numbers]"
        );
        assert_eq!(say(&mut sim, line), [reported, format!("error:{code}")], "{line}");
    }
}

#[test]
fn error_21_modal_clash() {
    refused_and_unchanged(
        &["G20 G21", "G90 G91", "G17 G19", "G54 G56", "G93 G94", "M3 M4", "M7 M8", "M2 M30", "G38.2 G17 G18 X5"],
        21,
    );
}

#[test]
fn error_22_no_feed() {
    let mut sim = homed();
    for line in ["G1 X1", "G1", "G2 X1 I1", "$J=X1", "$J=X1 F0", "G93 G1 X1", "G93 G3 X1 I1", "G38.2 X1"] {
        refused(&mut sim, line, 22);
    }
}

#[test]
fn error_23_integer_required() {
    refused_and_unchanged(
        &["G1.5 X1", "M3.1", "G54.1", "G4.1 P1", "$1=2.5", "T1.5", "N1.5 X1", "G10 L2 P1.5 X1", "G10 L2.5 P1 X1"],
        23,
    );
}

#[test]
fn error_24_axis_conflict() {
    refused_and_unchanged(
        &["G0 G1 X1", "G28 G0 X1", "G1 G92 X1", "G43.1 G0 Z1", "G10 G28 L2 P1 X1", "G38.2 G0 X1"],
        24,
    );
}

#[test]
fn error_25_repeated_word() {
    refused_and_unchanged(&["X1 X2", "F1 F2", "N1 N1"], 25);
}

#[test]
fn error_26_axis_words_missing() {
    refused_and_unchanged(&["G10 L2 P1", "G92", "$J=F100", "G2", "G3 I5", "G38.2"], 26);
}

#[test]
fn error_27_bad_line_number() {
    refused_and_unchanged(&["N10000001", "N99999999 G0 X1", "$J=X1 F1 N10000001"], 27);
}

#[test]
fn error_28_value_missing() {
    refused_and_unchanged(&["G4", "G10 L2 X1", "G10 P1 X1"], 28);
}

#[test]
fn error_29_unsupported_system() {
    refused_and_unchanged(&["G59.1", "G59.3", "G10 L2 P7 X1", "G10 L20 P99 X1"], 29);
}

#[test]
fn error_30_absolute_needs_motion() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G80"), ["ok"]);
    refused(&mut sim, "G53 X1", 30);
    refused(&mut sim, "G53 G38.2 X1 F100", 30);
    assert_eq!(say(&mut sim, "G53 G0 X1"), ["ok"]);
}

#[test]
fn error_31_unused_axis_words() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G80"), ["ok"]);
    refused(&mut sim, "X1", 31);
    refused(&mut sim, "G28.1 X1", 31);
    assert_eq!(say(&mut sim, "G92 X1\nG28 X1\nG43.1 Z1\nG10 L2 P2 X1"), ["ok"; 4], "they take the axis words");
}

#[test]
fn error_32_plane_axes_missing() {
    refused_and_unchanged(&["G2 Z1 I1", "G18 G3 Y1 R5", "G19 G2 X1"], 32);
}

#[test]
fn error_33_invalid_target() {
    refused_and_unchanged(&["G2 X10 I4.99", "G3 X0 Y0 R5", "G2 X9000 R-9000"], 33);
    refused_and_unchanged(
        &[
            "X10001",
            "G20 X400",
            "$J=X20000 F1",
            "G10 L2 P1 X10001",
            "G92 X-10002",
            "G43.1 Z10001",
            "G38.2 X0",
            "G91 G38.3 Z0",
        ],
        33,
    );
}

/// Both distances from the centre are reported, in mm, whatever the units and the plane.
#[test]
fn error_33_names_both_radii() {
    let mut sim = homed();
    let reported_of = |start: &str, target: &str| {
        format!(
            "[MSG:the start is {start} mm from the arc's centre, the target {target} mm: correct the target or I, J, K]"
        )
    };
    for (line, start, target) in [
        ("G2 X10 I4.99 F100", "4.990", "5.010"),
        ("G91 G18 G3 X3 Z4 I-10 F100", "10.000", "13.601"),
        ("G20 G2 X1 I0.4 F10", "10.160", "15.240"),
    ] {
        assert_eq!(say(&mut sim, line), [reported_of(start, target).as_str(), "error:33"], "{line}");
    }
    assert_eq!(say(&mut sim, "G2 X9000 R-9000 F100"), ["error:33"], "not for want of a centre");
    assert_eq!(say(&mut sim, "G21 G90 G17 G0 X10 Y0 F100"), ["ok"]);
    let reported = "[MSG:the start is 0.000 mm from the arc's centre, the target 14.142 mm: it fits if I, J, K are absolute \
                (G90.1): have them written from the start (G91.1)]";
    assert_eq!(say(&mut sim, "G3 X0 Y10 I0 J0"), [reported, "error:33"]);
    assert_eq!(say(&mut sim, "G3 X0 Y10 I0 J0.1"), [reported_of("0.100", "14.072").as_str(), "error:33"]);
}

#[test]
fn error_34_radius_too_small() {
    refused_and_unchanged(&["G2 X10 F600 R4.99", "G3 X10 R0", "G18 G2 X-10 R-4.9"], 34);
    let reported =
        "[MSG:the target is 10.000 mm from the start, more than twice R 4.990 mm: correct it, or make R 5.000 mm]";
    assert_eq!(say(&mut homed(), "G2 X10 F600 R4.99"), [reported, "error:34"]);
}

#[test]
fn error_35_offsets_missing() {
    refused_and_unchanged(&["G2 X10", "G3 X10 K5", "G18 G2 X10 J5", "G19 G3 Y10 I5"], 35);
}

#[test]
fn error_36_names_the_word() {
    let mut sim = homed();
    for (line, words) in [
        ("G2 X0 I5 P2 F100", "P: an arc has no turns here: write a line for each turn"),
        ("G2 X10 I5 R5 F100", "I: R has given the arc: keep one of them"),
        ("G0 X1 P1", "P: no code on the line uses it: remove it, or add the code that does"),
    ] {
        assert_eq!(say(&mut sim, line), [format!("[MSG:{words}]").as_str(), "error:36"], "{line}");
    }
}

#[test]
fn error_36_unused_words() {
    refused_and_unchanged(&["X1 P1", "X1 I1", "G4 P1 L1", "R5", "G2 X10 I5 R5", "G2 X10 I5 P1", "$J=X1 F1 S5"], 36);
}

#[test]
fn error_37_tool_axis() {
    refused_and_unchanged(&["G43.1", "G43.1 X1", "G43.1 Y1 Z1"], 37);
}

#[test]
fn error_38_tool_number() {
    refused_and_unchanged(&["T256", "T1000"], 38);
}
