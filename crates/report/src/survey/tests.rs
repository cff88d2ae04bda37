//! Surveys of small programs.

use super::*;
use isostep_sim::Config;
use isostep_sim::program::Program;

fn survey(text: &str) -> Survey {
    let config = Config::default();
    Survey::of(&Program::read_raw(text.as_bytes()).unwrap(), &config.settings, config.start_mm)
}

#[test]
fn lines_are_counted_by_what_they_are() {
    let found = survey("%\n(a comment)\n\n$G\nG21 G90\nG1 X10 F600\nY5\nG2 X0 I-5\nM30\n%\n");
    assert_eq!((found.lines, found.statements, found.moves, found.arcs), (10, 1, 3, 1));
    assert_eq!((found.blocks, found.empty, found.ends_at), (5, 4, Some(9)));
    let too_long = survey(&format!("M30\nG0 X1{}\n", " Y1".repeat(40)));
    assert_eq!((too_long.blocks, too_long.refused[0].code, too_long.ends_at), (2, 11, Some(1)));
    assert_eq!(survey("M2\nG0 X1\n").ends_at, None, "something follows");
    assert_eq!(found.feeds_mm_min, Some((600.0, 600.0)));
    assert!(!found.leaves_tool_on && found.outside.is_none(), "{found:?}");
}

/// From (0, 0) to (10, 0), then the half circle below with the centre (5, 0).
#[test]
fn extents_take_in_arcs_and_where_it_begins() {
    let bounds = survey("G1 X10 F600\nG2 X0 I-5\n").extents_mm.unwrap();
    assert_eq!(bounds.low_mm, [0.0, -5.0, 0.0]);
    assert_eq!(bounds.high_mm.map(|mm| (mm * 1e3).round() / 1e3), [10.0, 0.0, 0.0]);
    assert_eq!(survey("G21\nG4 P1\n").extents_mm, None);
    assert_eq!(survey("G20 G91 G0 Z-1\n").extents_mm.unwrap().size_mm().map(f64::round), [0.0, 0.0, 25.0]);
}

#[test]
fn refused_lines_are_named_and_change_nothing() {
    let found = survey("G1 X1\nG0 X1\n$100=-5\nG0 X2 X3\nG0 X2\nG42 D1 X3\n");
    let refused: Vec<_> = found.refused.iter().map(|one| (one.line, one.code, one.word.as_deref())).collect();
    assert_eq!(refused, [(1, 22, None), (3, 4, None), (4, 25, Some("X3")), (6, 20, Some("G42"))]);
    assert!(found.refused[1].remedy.starts_with("$100=-5 is negative"), "{:?}", found.refused[1]);
    assert!(found.refused[3].remedy.starts_with("G42: "), "{:?}", found.refused[3]);
    let counted: Vec<_> = found.refused_by_word.iter().map(|(word, count)| (word.as_str(), *count)).collect();
    assert_eq!(counted, [("G42", 1), ("error:22", 1), ("error:25 X", 1), ("error:4", 1)]);
    let slicer: String = (0..20).map(|k| format!("G1 X{k} E{k}.5 F600\n")).collect();
    assert_eq!(survey(&slicer).refused_by_word, BTreeMap::from([("E".to_owned(), 20)]));
    assert_eq!(found.extents_mm.unwrap().high_mm, [2.0, 0.0, 0.0]);
}

/// Lines of the file that cannot be carried out stand among those that the machine refuses.
#[test]
fn what_a_program_makes_is_reported_by_the_lines_of_the_file() {
    let text = "G91\no1 repeat [2]\nX[1/0]\nG0 X[#1+1]\nD9\n#1=2\no1 endrepeat\nM0\nG0 X-90\n";
    let found = survey(text);
    assert_eq!((found.lines, found.made_from), (7, Some(9)));
    let refused: Vec<_> = found.refused.iter().map(|one| (one.line, one.code, one.text.as_str())).collect();
    assert_eq!(refused, [(3, 0, "X[1/0]"), (5, 20, "D9"), (5, 20, "D9")]);
    assert_eq!(found.refused[0].remedy, "1 is divided by zero: test the divisor by an o-if before");
    assert_eq!((found.pauses, found.outside.map(|outside| outside.line)), (vec![8], Some(9)));
    let program = Program::read_raw(text.as_bytes()).unwrap();
    let accepted = survey(text).accepted(&program);
    assert_eq!(accepted.join(&b'\n'), b"G91\nG0 X1\n\nG0 X3\n\nM0\nG0 X-90");
    assert_eq!((1..=7).map(|line| accepted.number(line)).collect::<Vec<_>>(), [1, 4, 5, 4, 5, 8, 9]);
}

#[test]
fn pauses_and_a_tool_that_stays_on_are_found() {
    let found = survey("M3 S1000\nT2\nG0 X1 M6\nM0\nT7 M6\n");
    assert_eq!((found.pauses_total, found.pauses), (3, vec![3, 4, 5]));
    assert_eq!(found.tools, BTreeMap::from([(2, 3), (7, 5)]));
    let commented = survey("(T2 D=6 flat)\nT2 M6\nM6 T7 (V-bit)\nM6 T3\n");
    assert_eq!(commented.tool_comments, BTreeMap::from([(2, "D=6 flat".to_owned()), (7, "V-bit".to_owned())]));
    assert!(found.leaves_tool_on && found.ends_at.is_none());
    assert!(!survey("M3 S1000\nM30\n").leaves_tool_on);
}

/// The carriages are at 35, 40 and 15 mm from their switches; X can be up to 352 mm from its switch.
#[test]
fn a_program_that_leaves_the_travel_is_told_where_it_fits() {
    let found = survey("G0 X10\nG0 X-40 Z-5\n").outside.unwrap();
    assert_eq!((found.line, found.axis.as_str(), found.place_mm, found.homed), (2, "X", -40.0, false));
    assert_eq!(found.fit, Fit::StartAt([41.0, 40.0, 15.0]));
    let Fit::StartAt(start_mm) = found.fit else { unreachable!() };
    let lines = Program::read(b"G0 X10\nG0 X-40 Z-5\n").unwrap();
    assert_eq!(Survey::of(&lines, &Settings::DEFAULT, start_mm).outside, None);
    let found = survey("G91 G0 X300\nX50\n").outside.unwrap();
    assert_eq!((found.place_mm, found.nearest_mm, found.fit), (350.0, 317.0, Fit::StartAt([1.0, 40.0, 15.0])));
    assert_eq!(survey("G0 X400\n").outside.unwrap().fit, Fit::TooWide(0, 400.0, 350.0));
}

#[test]
fn behind_homing_the_origin_moves() {
    let found = survey("$H\nG0 X10 Y-20\nG0 Z-3\n").outside.unwrap();
    assert_eq!((found.line, found.axis.as_str(), found.nearest_mm, found.homed), (2, "Y", 0.0, true));
    assert_eq!(found.fit, Fit::OriginAt([0.0, 21.0, 4.0]));
    assert_eq!(survey("$H\nG53 G0 X-1\n").outside.unwrap().fit, Fit::Nowhere);
    assert_eq!(survey("$HY\nG0 X-1\n").outside, None, "X is not homed");
}

/// `G0 X-40` before homing and `X340` after it are in different coordinates.
#[test]
fn before_and_behind_homing_are_different_places() {
    let text = "G0 X-40\nG4 P0.1\n$H\nG0 X340\n";
    let Fit::StartAt(start_mm) = survey(text).outside.unwrap().fit else { panic!("it fits from somewhere") };
    let lines = Program::read(text.as_bytes()).unwrap();
    assert_eq!(Survey::of(&lines, &Settings::DEFAULT, start_mm).outside, None);
}

#[test]
fn settings_that_do_not_work_together_are_reported_where_something_is_to_move() {
    let found = survey("$31=2000\nG0 X1\n$H\n$30=3000\nG0 X2\n");
    let refused: Vec<_> = found.refused.iter().map(|one| (one.line, one.code)).collect();
    assert_eq!((refused, found.moves), (vec![(2, 9), (3, 2)], 1));
    for one in &found.refused {
        assert!(one.remedy.starts_with("$31=2000 is not below the S at full duty, $30=1000 rpm"), "{one:?}");
    }
}

#[test]
fn in_check_mode_nothing_moves_and_a_startup_line_does() {
    let found = survey("G0 X5\n$C\nG0 X-500\nM0\n$C\nG91\nG0 X5\n");
    assert_eq!((found.moves, found.pauses_total, found.outside), (2, 0, None));
    assert_eq!(found.extents_mm.unwrap().high_mm[0], 10.0);
    assert!(survey("$N0=G0 X-300\n").outside.is_some());
}

#[test]
fn the_travel_follows_the_settings_and_where_an_axis_homes() {
    assert_eq!(survey("$130=500\n$H\nG0 X499\n").outside, None);
    assert_eq!(survey("$130=500\nG0 X450\n").outside, None);
    assert!(survey("$23=6\n$H\nG0 X1\n").outside.is_some());
    assert_eq!(survey("$23=6\n$H\nG0 X-1\n").outside, None);
}

/// A reader of a check finds what the machine would say about each line.
#[test]
fn a_refused_line_is_reported_in_the_words_of_the_machine() {
    for (line, words) in [
        ("G5 X1", "G5: "),
        ("G0 D5", "D: no cutter compensation here"),
        ("G10 L3 P1 X1", "G10: L1, L2, L10, L11 or L20 here"),
        ("G1 X1 F100 *71", "*71: no variables, expressions, checksums here"),
        ("G2 X10 I4.99 F100", "the start is 4.990 mm from the arc's centre, the target 5.010 mm"),
        ("$100=-5", "$100=-5 is negative"),
    ] {
        let reported = survey(&format!("{line}\n")).refused.remove(0).remedy;
        let outcome = isostep_sim::run(format!("{line}\n").as_bytes(), &Config::default()).unwrap();
        assert!(reported.starts_with(words), "{line}: {reported}");
        assert_eq!(outcome.refusals[0].words.as_ref(), Some(&reported), "{line}");
    }
}
