//! Programs by number, called by M98.

use crate::made::{error, lines, numbered};

#[test]
fn m98_carries_out_a_program_as_often_as_l_says() {
    let program = "G0 X1\nM98 P1234 (once)\nM98 P1234 L2\nm98l0p1234\nM30\n\nO1234 (sub)\nG91\nM99\n%";
    let expected = ["1 G0 X1", "8 G91", "8 G91", "8 G91", "5 M30"];
    assert_eq!(numbered(program).unwrap(), expected);
}

/// LinuxCNC's example: #1 is the same everywhere.
#[test]
fn programs_call_each_other_and_share_their_parameters() {
    let program =
        "o1 (main)\n#1 = 0\nM98 P100 L5\nX#1\nM30\no100\n#1 = [#1 + 1]\nM98 P200 L5\nM99\n:200\n#1 = [#1 + 0.01]\nM99";
    assert_eq!(lines(program), ["o1 (main)", "X5.25", "M30"]);
}

#[test]
fn other_words_beside_m98_and_m99_go_first() {
    assert_eq!(lines("G0 X5 M98 P7 L2\nM2\nO7\nY1 M99"), ["G0 X5", "Y1", "Y1", "M2"]);
    assert_eq!(lines("#7=70\nN1 M98 P#7 L[1+1]\nM2\nO70\nX1\nN9 M99 (back)"), ["X1", "X1", "M2"]);
}

#[test]
fn what_m98_and_m99_cannot_do_is_refused() {
    for (program, problem) in [
        ("M98 P5\nM2", "`M98 P5`: there is no line O5 in this file, and no other file is read: copy it into this one"),
        (
            "M98 P41234\nM2\nO1234\nM99",
            "there is no line O41234 in this file: if it is to mean 4 times O1234, write M98 P1234 L4",
        ),
        ("M98\nM2", "M98 does not say which program it calls: write M98 P1234 for that of the line O1234"),
        ("M98 P1.5", "P1.5 is no count: it is a whole number from 0 to 4294967295"),
        ("M98 P1 L-1\nM2\nO1\nM99", "L-1 is no count: it is a whole number from 0 to 1000000"),
        ("M98 P1 M99", "M98 and M99 stand once on a line, whose P and L are theirs: give each a line of its own"),
        ("G4 P1 M98 P2", "M98 and M99 stand once on a line, whose P and L are theirs: give each a line of its own"),
        ("M98 P5\nM2\no1 sub\nO5\no1 endsub", "line 5 `o1 endsub`: O5 has no M99 before this line: end it with M99"),
        ("X1\nM99", "line 2 `M99`: M99 in the main program repeats it without an end: end it with M2 or M30"),
        (
            "M98 P1\nM2\nO1\nM99 P10",
            "M99 P10 goes on at a line by its number, which is not done: use an o-while or o-if",
        ),
        (
            "o1 sub\nM99\no1 endsub\no1 call",
            "M99 does not end a subroutine that begins with sub: write endsub or return",
        ),
        (
            "M98 P1\nX1\nO1\nM99",
            "line 3 `O1`: the program runs into O1, which is called from elsewhere: end it with M2 or M30 before",
        ),
        ("M98 P1\nM2\nO1\nX1", "line 4 `X1`: O1 has no M99 before this line: end it with M99"),
        ("M98 P1\nM2\nO1\nX1\nO2\nM99", "line 5 `O2`: O1 has no M99 before this line: end it with M99"),
        ("M98 P1\nM2\nO1\nM99\nO1\nM99", "O1 is in line 3 already: give it another label"),
        (
            "M98 P1\nM2\nO1\nM98 P1\nM99",
            "subroutines are nested more than 32 deep: does one call itself without an end?",
        ),
    ] {
        assert!(error(program).ends_with(problem), "{program}: {}", error(program));
    }
}
