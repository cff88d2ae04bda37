//! O-words: branches, loops and subroutines.

use crate::made::{error, lines, numbered};

#[test]
fn the_first_branch_that_holds_is_carried_out() {
    let program =
        "o1 if [#1 GT 5]\nF100\no1 elseif [#1 LT 2]\nF200\no1 elseif [#1 LT 3]\nF250\no1 else\nF150\no1 endif\nM2";
    for (value, feed) in [(6, "4 F100"), (1, "6 F200"), (2, "8 F250"), (3, "10 F150")] {
        let program = format!("#1={value}\n\n{program}");
        assert_eq!(numbered(&program).unwrap(), ["2 ", feed, "12 M2"], "{value}");
    }
    assert_eq!(lines("o1 if [0]\nX1\no1 endif\nX2"), ["X2"]);
}

#[test]
fn loops_go_round_as_often_as_they_say() {
    for (program, expected) in [
        ("o1 while [#1 LT 3]\nX#1\n#1=[#1+1]\no1 endwhile", vec!["X0", "X1", "X2"]),
        ("o1 while [0]\nX1\no1 endwhile\nX2", vec!["X2"]),
        ("o1 do\nX#1\n#1=[#1+1]\no1 while [#1 LT 2]\nY1", vec!["X0", "X1", "Y1"]),
        ("o1 do\nX5\no1 while [0]", vec!["X5"]),
        ("o1 repeat [2]\nX#1\n#1=[#1+1]\no1 endrepeat\nY1", vec!["X0", "X1", "Y1"]),
        ("o1 repeat [-1]\nX1\no1 endrepeat\nY1", vec!["Y1"]),
        ("o1 repeat [1.6]\nX1\no1 endrepeat", vec!["X1", "X1"]),
        ("o1 repeat [2]\no2 repeat [2]\nX1\no2 endrepeat\nY1\no1 endrepeat", vec!["X1", "X1", "Y1", "X1", "X1", "Y1"]),
    ] {
        assert_eq!(lines(program), expected, "{program}");
    }
}

#[test]
fn break_and_continue_leave_the_loop_of_their_label() {
    let inner = "#1=[#1+1]\no9 if [#1 EQ 2]\no1 WORD\no9 endif\nX#1\n";
    for (begin, end, broken, continued) in [
        ("o1 while [#1 LT 3]", "o1 endwhile", vec!["X1"], vec!["X1", "X3"]),
        ("o1 do", "o1 while [#1 LT 3]", vec!["X1"], vec!["X1", "X3"]),
        ("o1 repeat [3]", "o1 endrepeat", vec!["X1"], vec!["X1", "X3"]),
    ] {
        let program = |word: &str| format!("{begin}\n{}{end}", inner.replace("WORD", word));
        assert_eq!(lines(&program("break")), broken, "{begin}");
        assert_eq!(lines(&program("continue")), continued, "{begin}");
    }
    let outer = "o1 repeat [2]\no2 while [1]\nX1\no1 continue\no2 endwhile\nX2\no1 endrepeat\nY1";
    assert_eq!(lines(outer), ["X1", "X1", "Y1"]);
    assert_eq!(lines(&outer.replace("continue", "break")), ["X1", "Y1"]);
}

#[test]
fn a_subroutine_has_its_own_arguments_and_names() {
    let program = "o<line> sub\n#<end>=[#1+#2]\n#1=9 #40=[#40+1]\nX#<end> Y#3\n#2=0\no<line> endsub\n\
                   #1=5 #2=6 #3=7\nO <LINE> CALL [1] (the end) [#2] ; both\no<line>call\nX#1 Y#2 Z#40";
    assert_eq!(lines(program), ["X7 Y0", "X0 Y0", "X5 Y6 Z2"]);
    assert!(error(&format!("{program}\nX#<end>")).contains("#<end> has never been set"));
}

#[test]
fn a_subroutine_returns_a_value_and_may_call_itself() {
    let program = "o1 sub\no2 if [#1 LE 1]\no2 return [1]\no2 endif\no1 call [#1 - 1]\no1 endsub [#1 * #<_value>]\n\
                   X#<_value_returned>\no1 call [5]\nX#<_value> Y#<_value_returned>\no3 call\nX#<_value> Y#<_value_returned>\n\
                   M2\no3 sub\no3 endsub";
    assert_eq!(lines(program), ["X0", "X120 Y1", "X0 Y0", "M2"]);
}

/// It leaves loops, whose counts begin anew.
#[test]
fn return_leaves_loops_too() {
    let program = "o1 sub\no2 repeat [3]\nX1\no3 if [#1]\no1 return\no3 endif\no2 endrepeat\no1 endsub\n\
                   o1 call [1]\no1 call [0]\nY1";
    assert_eq!(lines(program), ["X1", "X1", "X1", "X1", "Y1"]);
}

#[test]
fn the_label_of_a_call_can_be_computed_and_labels_are_used_again() {
    let program =
        "o101 sub\nX1\no101 endsub\no102 sub\nX2\no102 endsub\n#1=100\no[#1+2] call\no#2call\n#2=101\no#2 call";
    assert!(
        error(program).ends_with("there is no o0 sub in this file, and no other file is read: copy it into this one")
    );
    assert_eq!(lines(&program.replace("o#2call\n", "")), ["X2", "X1"]);
    assert_eq!(lines("o1 if [1]\nX1\no1 endif\no01 if [1]\nX2\no1 endif"), ["X1", "X2"]);
}

#[test]
fn m2_and_m30_end_the_program_wherever_they_are() {
    assert_eq!(lines("#1=1\nX#1 M2\nX2"), ["X1 M2"]);
    assert_eq!(lines("o1 sub\nM30 (end)\no1 endsub\no1 call\nX2"), ["M30 (end)"]);
    assert_eq!(lines("#1=30\nM#1\nX2"), ["M30"]);
}

#[test]
fn a_program_can_say_that_it_cannot_go_on() {
    let program = "o1 if [#1 LE 0]\n(ABORT, set #1 first)\no1 endif\nX1";
    assert_eq!(error(program), "line 2 `(ABORT, set #1 first)`: the program says so: set #1 first");
    assert_eq!(lines(&format!("#1=1\n{program}")), ["X1"]);
}

#[test]
fn what_has_no_end_is_an_error() {
    let endless = "o1 while [1]\n#1=[#1+1]\no1 endwhile\nX1";
    let words = "1000000 lines were carried out without one for the machine: does a loop have no end?";
    assert!(error(endless).ends_with(words), "{}", error(endless));
    let words = "more than 1000000 lines are made: does a loop have no end? If it has, divide the program";
    assert_eq!(error("o1 while [1]\nX1\no1 endwhile"), format!("line 2 `X1`: {words}"));
    let deep = |levels: u32| {
        format!("o1 sub\no2 if [#1 GT 1]\no1 call [#1 - 1]\no2 endif\nX#1\no1 endsub\no1 call [{levels}]")
    };
    assert_eq!(lines(&deep(32)).len(), 32);
    let words =
        "line 3 `o1 call [#1 - 1]`: subroutines are nested more than 32 deep: does one call itself without an end?";
    assert_eq!(error(&deep(33)), words);
}
