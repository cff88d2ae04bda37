//! Messages beside `ok` and the errors: comments for the operator, and what to do about a refused line.

use super::talk::check;
use expect_test::expect;

/// As LinuxCNC and grblHAL print it. No sender may take it for an answer.
#[test]
fn comments_for_the_operator_are_reported() {
    check(
        "(MSG, put in T2)\nM0 (msg,look out: error or ALARM)\n(note) G0 X1 (MSG, moving) Y2\nG0 D1 (MSG, refused)\n(MSG, (a) b)",
        expect![[r#"
            (MSG, put in T2) -> [MSG:put in T2] ok
            M0 (msg,look out: error or ALARM) -> [MSG:loOK out: ERROR or alarm] (pause) ok
            (note) G0 X1 (MSG, moving) Y2 -> [MSG:moving] (rapid [1.0, 2.0, 0.0]) ok
            G0 D1 (MSG, refused) -> [MSG:refused] [MSG:D: no cutter compensation here: let the CAM program compensate] error:20
            (MSG, (a) b) -> [MSG:(a] [MSG:): a comment ends at its first ): leave brackets out of it] error:2
        "#]],
    );
}

/// The message about each line leads to a line that is taken.
#[test]
fn a_refused_line_is_told_what_to_do() {
    check(
        "X5,5\nX1, Y2\nG0 (bore (6 mm) twice) X1\n(tool #3 (flat) C)\nG1 (a) (b)) X1\nF600\nG2 X10 I5 P2\nG2 X10 R5 I5\nX5 R9 G1\nG0 X1 P1 L2\n\
        T1.5\nN1.5 X1\nN1.0 X1\nT2.0\nG10 L2 P1.5 X1\nG10 L2.5 P1 X1\nG10 L20.0 P1.000 X0\n$N0=G10 L2 P1.5 X1\nT0.00000001\nN00000000000000000005.00000",
        expect![[r#"
            X5,5 -> [MSG:,5: no commas here: write a decimal point, and nothing between words] error:1
            X1, Y2 -> [MSG:,: no commas here: write a decimal point, and nothing between words] error:1
            G0 (bore (6 mm) twice) X1 -> [MSG:): a comment ends at its first ): leave brackets out of it] error:2
            (tool #3 (flat) C) -> [MSG:): a comment ends at its first ): leave brackets out of it] error:2
            G1 (a) (b)) X1 -> [MSG:): a comment ends at its first ): leave brackets out of it] error:1
            F600 -> ok
            G2 X10 I5 P2 -> [MSG:P: an arc has no turns here: write a line for each turn] error:36
            G2 X10 R5 I5 -> [MSG:I: R has given the arc: keep one of them] error:36
            X5 R9 G1 -> [MSG:R: no code on the line uses it: remove it, or add the code that does] error:36
            G0 X1 P1 L2 -> [MSG:L: no code on the line uses it: remove it, or add the code that does] error:36
            T1.5 -> error:23
            N1.5 X1 -> error:23
            N1.0 X1 -> (N1) (rapid [1.0, 0.0, 0.0]) ok
            T2.0 -> ok
            G10 L2 P1.5 X1 -> [MSG:P: G10 numbers systems and tools by whole numbers: remove the fraction] error:23
            G10 L2.5 P1 X1 -> error:23
            G10 L20.0 P1.000 X0 -> ok
            $N0=G10 L2 P1.5 X1 -> [MSG:P: G10 numbers systems and tools by whole numbers: remove the fraction] error:23
            T0.00000001 -> error:23
            N00000000000000000005.00000 -> error:2
        "#]],
    );
}
