//! Programs that have nothing of this.

use std::borrow::Cow;

use isostep_program::plain_lines;

/// Bytes that are no text, blanks, comments, numbers of programs and what stands behind M30 are all kept.
#[test]
fn a_plain_program_comes_back_byte_for_byte() {
    let program: &[&[u8]] = &[
        b"%",
        b"O1234 (#1 [2] M98)",
        b"O1234",
        b":7",
        b"O7 SUBPLATE",
        b"  g1 X 1. y-0 (\xc4) ; o1 if",
        b"$#",
        b"$N0=G20",
        b"",
        b"M30",
        b"X1?!\xff",
        b"(ABORT, never)",
        b"%",
    ];
    let lines = plain_lines(program).unwrap();
    assert!(lines.is_plain());
    for (line, (number, source)) in lines.map(Result::unwrap).zip((1..).zip(program)) {
        assert!(line.number == number && matches!(line.text, Cow::Borrowed(_)), "line {number}");
        assert_eq!(line.text, *source);
    }
    assert_eq!(plain_lines(program).unwrap().count(), program.len());
}

/// Beside lines that are not.
#[test]
fn a_plain_line_comes_back_as_it_is() {
    let program: &[&[u8]] = &[b"#1=2", b" g1 X 1. (\xc4)", b"O99", b"X#1"];
    let lines = plain_lines(program).unwrap();
    assert!(!lines.is_plain());
    let lines: Vec<_> = lines.map(|line| line.unwrap().text.into_owned()).collect();
    assert_eq!(lines, [&b" g1 X 1. (\xc4)"[..], b"O99", b"X2"]);
}

/// A program of any length is made as it is asked for, and a plain one has no limit.
#[test]
fn long_programs_are_made_piece_by_piece() {
    let plain = vec!["X1"; 1_100_000];
    assert_eq!(plain_lines(&plain).unwrap().count(), plain.len());
    let program = ["#1=1", "o1 repeat [1000000]", "X#1", "o1 endrepeat"];
    let mut lines = plain_lines(&program).unwrap();
    assert_eq!(lines.next().unwrap().unwrap().number, 3);
    assert_eq!(lines.filter(Result::is_ok).count(), 999_999);
}
