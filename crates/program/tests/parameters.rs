//! Parameters, by number and by name.

use crate::made::{error, lines, numbered};

/// All values of a line are those before it.
#[test]
fn a_parameter_has_its_new_value_from_the_next_line_on() {
    assert_eq!(lines("#3=15\n#3=6 G1 X#3\nX#3"), ["G1 X15", "X6"]);
    assert_eq!(lines("#3=15 #3=6\n#3=[#3+1] #4=#3\nX#3 Y#4"), ["X7 Y6"]);
    assert_eq!(lines("#<a> = 1\n#<a>=2 X#<a>\nX#<a>"), ["X1", "X2"]);
}

#[test]
fn a_number_never_set_is_0_and_a_name_is_an_error() {
    assert_eq!(lines("X#31 Y#5000"), ["X0 Y0"]);
    assert!(error("X#<depth>").ends_with(
        "#<depth> has never been set: set it on a line before; names without _ belong to the subroutine that sets them"
    ));
}

#[test]
fn blanks_and_case_do_not_count_in_names() {
    assert_eq!(lines("#<Cut Depth> = 2\nZ-#<cutdepth>"), ["Z-2"]);
    assert_eq!(lines("# <_Up> = 3\nX[ # < _ u p > ]"), ["X3"]);
}

/// Only what stands for a value is replaced; what sets something goes away.
#[test]
fn a_line_stays_as_it_is_written_but_for_its_values() {
    for (line, expected) in [
        ("G1  X#1 Y2.50 F[100*#1] (cut #1) ; [2]", "G1  X3 Y2.50 F300 (cut #1) ; [2]"),
        ("n10 g[0+1] x-#1y+#1", "n10 g1 x-3y3"),
        ("G1 #2=5 X1 #4 = 6 Y2", "G1 X1 Y2"),
        ("X-SIN[30]", "X-0.5"),
        ("T[2.9999999] M6", "T3 M6"),
        ("X#1 *71", "X3 *71"),
        ("/X#1", "/X3"),
        ("X1..5 Y#1", "X1..5 Y3"),
        ("G Y#1", "G Y3"),
    ] {
        assert_eq!(lines(&format!("#1=3\n{line}")), [expected], "{line}");
    }
}

#[test]
fn a_line_that_only_sets_makes_none_but_for_its_message() {
    assert_eq!(
        numbered("N5 #1=2 (depth)\n#2=3 ; rest\n(note)\n\n#1=3 (MSG, put in T1)").unwrap(),
        ["3 (note)", "4 ", "5 (MSG, put in T1)"]
    );
}

#[test]
fn what_the_machine_alone_knows_is_refused() {
    for (parameter, what) in [
        ("#5021", "where the machine stands"),
        ("#5061", "what a probe has found"),
        ("#5081", "the tool's length"),
        ("#5161", "a place of G28 or G30"),
        ("#5211", "an offset of G92"),
        ("#5221", "a work offset"),
        ("#5399", "an input"),
        ("#5400", "the tool and its measures"),
        ("#5422", "where the machine stands"),
        ("#5500", "reserved"),
        ("#<_x>", "what LinuxCNC's machine says of itself"),
        ("#<_hal[motion.time]>", "what LinuxCNC's machine says of itself"),
    ] {
        let problem = format!(
            "{parameter} is {what}, which is known on the machine only: set a parameter of your own (#1 to #5000) before, and use that"
        );
        assert_eq!(error(&format!("X{parameter}")), format!("line 1 `X{parameter}`: {problem}"));
    }
    assert_eq!(lines("X1 (#5061)\nY#1"), ["X1 (#5061)", "Y0"]);
}

#[test]
fn a_parameter_that_cannot_be_is_refused() {
    for (line, problem) in [
        ("X#0", "#0: parameters are #1 to #5000"),
        ("X#-3", "#-3: parameters are #1 to #5000"),
        ("X#6000", "#6000: parameters are #1 to #5000"),
        ("X#1.5", "#1.5: a parameter's number is whole"),
        ("#1 5", "= is missing before ``: write #1=value"),
        ("#<_value> = 1", "#<_value> can be read and not set: use another name"),
        ("#<_x> = 1", "#<_x> can be read and not set: use another name"),
        ("X#<>", "`<>` is no name: write <name>"),
        ("X#<a", "`<a` is no name: write <name>"),
        (
            "X1 [2]",
            "`[2]` has no letter before it: write a word such as X[...], or a parameter to be set, such as #1=[...]",
        ),
    ] {
        assert!(error(line).ends_with(problem), "{line}: {}", error(line));
    }
}

#[test]
fn the_line_and_the_level_can_be_read() {
    assert_eq!(
        lines("o<s> sub\nX#<_line> Y#<_call_level>\no<s> endsub\no<s> call\nX#<_line> Y#<_call_level>"),
        ["X2 Y1", "X5 Y0"]
    );
}
