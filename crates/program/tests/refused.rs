//! Blocks that do not fit, each found before a line is made; and how it goes on behind an error.

use isostep_program::plain_lines;

use crate::made::{error, lines};

#[test]
fn blocks_that_do_not_fit_are_refused_before_a_line_is_made() {
    for (program, problem) in [
        ("X1\no1 if [1]", "line 2 `o1 if [1]`: o1 if has no o1 endif: add it where the block ends"),
        ("o<a> sub", "o<a> sub has no o<a> endsub: add it where the block ends"),
        ("o1 do\nX1", "o1 do has no o1 while: add it where the block ends"),
        ("o1 while [1]", "o1 while has no o1 endwhile: add it where the block ends"),
        ("o1 repeat [1]", "o1 repeat has no o1 endrepeat: add it where the block ends"),
        (
            "o1 if [1]\no2 endif",
            "line 2 `o2 endif`: o2 endif does not belong to o1 if of line 1, which is to end first: make the labels and words fit",
        ),
        (
            "o1 while [1]\no1 endif",
            "o1 endif does not belong to o1 while of line 1, which is to end first: make the labels and words fit",
        ),
        ("o1 endif", "o1 endif ends or divides a block that has not begun: begin it before, with the same label"),
        ("o1 else", "o1 else ends or divides a block that has not begun: begin it before, with the same label"),
        ("o1 if [1]\no1 else\no1 else\no1 endif", "o1 else comes behind the else of its block: put it before"),
        ("o1 if [1]\no1 else\no1 elseif [1]\no1 endif", "o1 elseif comes behind the else of its block: put it before"),
        ("o1 break", "o1 break is in no loop of this label: use the label of the while, do or repeat around it"),
        (
            "o1 if [1]\no1 continue\no1 endif",
            "o1 continue is in no loop of this label: use the label of the while, do or repeat around it",
        ),
        ("o1 return", "o1 return is in no subroutine: put it between a sub and its endsub"),
        ("o1 if [1]\no2 sub", "a subroutine cannot begin inside o1 if: put it before or behind that"),
        ("o1 sub\no1 endsub\no1 sub\no1 endsub", "line 3 `o1 sub`: o1 sub is in line 1 already: give it another label"),
        ("o1 do [1]", "`[1]` stands behind the O-word: give it a line of its own"),
    ] {
        let source: Vec<&str> = program.lines().collect();
        let error = plain_lines(&source).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.ends_with(problem), "{program}: {error}");
    }
}

#[test]
fn a_line_of_flow_that_cannot_be_carried_out_ends_the_program() {
    for (program, problem) in [
        (
            "o1 call\nX1",
            "line 1 `o1 call`: there is no o1 sub in this file, and no other file is read: copy it into this one",
        ),
        ("o<a> call [1]", "there is no o<a> sub in this file, and no other file is read: copy it into this one"),
        ("o[1] if [1]", "`[1] if [1]`: only the label of a call can be computed: write a number or <name>"),
        (
            "o1 until [#1]",
            "`1 until [#1]`: behind a label comes sub, endsub, return, call, if, elseif, else, endif, while, endwhile, do, repeat, \
          endrepeat, break or continue",
        ),
        ("o<> sub\nX1", "`<> sub` is no name: write <name>"),
        ("o[1/2] call", "0.5 is no label: it is a whole number, 0 or more"),
        ("o1 if 1\no1 endif", "a value in brackets belongs before `1`: write [...]"),
        ("o1 if\no1 endif", "a value in brackets belongs before ``: write [...]"),
        ("o1 if [1] X1\no1 endif", "`X1` stands behind the O-word: give it a line of its own"),
        ("o1 sub\no1 endsub\no1 call 5", "a value in brackets belongs before `5`: write [...]"),
        ("o1 repeat [10**10]\no1 endrepeat", "1e10 is no count: it is a whole number from 0 to 1000000000"),
    ] {
        assert!(error(program).ends_with(problem), "{program}: {}", error(program));
    }
    let call = format!("o1 sub\no1 endsub\no1 call {}", "[1]".repeat(31));
    assert!(error(&call).ends_with("a call has at most 30 values: 31 are too many"), "{}", error(&call));
    assert!(lines(&call.replacen("[1]", "", 1)).is_empty());
}

/// So that a check reports all of them.
#[test]
fn lines_that_only_move_are_passed_over_and_reported_once() {
    let program = "o1 repeat [2]\nX[1/0]\nY1\no1 endrepeat\nO[number]\nX#0\n#1=[\nY2";
    let source: Vec<&str> = program.lines().collect();
    let made = plain_lines(&source).unwrap().map(|line| match line {
        Ok(line) => String::from_utf8_lossy(&line.text).into_owned(),
        Err(error) => format!("error in line {}", error.line),
    });
    assert_eq!(
        made.collect::<Vec<_>>(),
        ["error in line 2", "Y1", "Y1", "error in line 5", "error in line 6", "error in line 7"]
    );
}
