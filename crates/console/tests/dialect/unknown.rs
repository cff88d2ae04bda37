//! Words and lines that this machine does not know, and those that it passes over.

use expect_test::expect;

use super::talk::check;

#[test]
fn what_the_gantry_lacks_is_refused_by_name() {
    check(
        "G38 Z-1\nG38.1 Z1\nG38.6 Z1\nG38.25 Z1\nA1\nO100\nG44 H1\nG41 D1\nG64.1\nG61.2\nG90.1\nG92.3\nG28.2\nG81\nM62\n\
         G5 X1\nG5.1\nG33 K1\nG42.1\nG73\nG76\nG80.1\nG83 X1 R1 Q1\nG99\nM98 P1\nM99\nM100\nM104 S200\nG0 X1 B2.5 C3\nG1 X1 E0.1\nG1 X1e5\nD1\nH1\n\
         g0 d1\nW-1\nG99999999\nG0 A1 B2\nX1 D1 G42\nG10 L3 P1 X1\nG10 L2 P1 X1 R5\n$J=A1 F1\n$N0=G0 E1\nG041\nG12.25",
        expect![[r#"
            G38 Z-1 -> [MSG:G38: probing is G38.2 to G38.5: give one of them] error:20
            G38.1 Z1 -> [MSG:G38.1: probing is G38.2 to G38.5: give one of them] error:20
            G38.6 Z1 -> [MSG:G38.6: probing is G38.2 to G38.5: give one of them] error:20
            G38.25 Z1 -> [MSG:G38.25: probing is G38.2 to G38.5: give one of them] error:20
            A1 -> [MSG:A: three axes only, X Y Z: remove it, or flash the firmware with 4-axes in its name] error:20
            O100 -> ok
            G44 H1 -> [MSG:G44: no negative lengths here: give the length below 0, and G43] error:20
            G41 D1 -> [MSG:G41: no cutter compensation here: let the CAM program compensate] error:20
            G64.1 -> [MSG:G64.1: unknown here: remove it] error:20
            G61.2 -> [MSG:G61.2: unknown here: remove it] error:20
            G90.1 -> [MSG:G90.1: arc centres are incremental here: use I J K from the start] error:20
            G92.3 -> [MSG:G92.3: unknown here: remove it] error:20
            G28.2 -> [MSG:G28.2: unknown here: remove it] error:20
            G81 -> error:22
            M62 -> [MSG:M62: unknown here: remove it] error:20
            G5 X1 -> [MSG:G5: no splines here: let the CAM program give lines and arcs] error:20
            G5.1 -> [MSG:G5.1: no splines here: let the CAM program give lines and arcs] error:20
            G33 K1 -> [MSG:G33: no threads here, the spindle does not say where it stands: remove it] error:20
            G42.1 -> [MSG:G42.1: no cutter compensation here: let the CAM program compensate] error:20
            G73 -> error:22
            G76 -> [MSG:G76: no threads here, the spindle does not say where it stands: remove it] error:20
            G80.1 -> error:23
            G83 X1 R1 Q1 -> error:22
            G99 -> ok
            M98 P1 -> [MSG:M98: no subprograms here: isostep console --stream makes plain lines of them] error:20
            M99 -> [MSG:M99: no subprograms here: isostep console --stream makes plain lines of them] error:20
            M100 -> [MSG:M100: unknown here: remove it] error:20
            M104 S200 -> [MSG:M104: unknown here: remove it] error:20
            G0 X1 B2.5 C3 -> [MSG:B: three axes only, X Y Z: remove it] error:20
            G1 X1 E0.1 -> [MSG:E: no extruder here, and numbers have no exponents: use a post-processor for mills] error:20
            G1 X1e5 -> [MSG:E: no extruder here, and numbers have no exponents: use a post-processor for mills] error:20
            D1 -> [MSG:D: no cutter compensation here: let the CAM program compensate] error:20
            H1 -> [MSG:H: it names a tool for G43 and G43.2: add one of them, or remove it] error:36
            g0 d1 -> [MSG:D: no cutter compensation here: let the CAM program compensate] error:20
            W-1 -> [MSG:W: three axes only, X Y Z: remove it] error:20
            G99999999 -> [MSG:G99999999: unknown here: remove it] error:20
            G0 A1 B2 -> [MSG:A: three axes only, X Y Z: remove it, or flash the firmware with 4-axes in its name] error:20
            X1 D1 G42 -> [MSG:D: no cutter compensation here: let the CAM program compensate] error:20
            G10 L3 P1 X1 -> [MSG:G10: L1, L2, L10, L11 or L20 here, without a rotation: correct L, remove R of L2] error:20
            G10 L2 P1 X1 R5 -> [MSG:G10: L1, L2, L10, L11 or L20 here, without a rotation: correct L, remove R of L2] error:20
            $J=A1 F1 -> [MSG:A: three axes only, X Y Z: remove it, or flash the firmware with 4-axes in its name] error:20
            $N0=G0 E1 -> [MSG:E: no extruder here, and numbers have no exponents: use a post-processor for mills] error:20
            G041 -> [MSG:G041: no cutter compensation here: let the CAM program compensate] error:20
            G12.25 -> [MSG:G12.25: unknown here: remove it] error:20
        "#]],
    );
}

/// Marks and numbers of programs, and words that Grbl refuses.
#[test]
fn program_marks_and_numbers_are_passed_over() {
    check(
        "%\n%wait (text)\nO1234 (a name)\no0001\n:1234\nO\nO12X1\nO1 SUB\n:\nN1 O5\nO-1",
        expect![[r#"
            % -> ok
            %wait (text) -> ok
            O1234 (a name) -> ok
            o0001 -> ok
            :1234 -> ok
            O -> error:2
            O12X1 -> [MSG:O: a program number stands alone on its line; isostep console --stream makes plain lines of subprograms] error:20
            O1 SUB -> [MSG:O: a program number stands alone on its line; isostep console --stream makes plain lines of subprograms] error:20
            : -> error:1
            N1 O5 -> [MSG:O: a program number stands alone on its line; isostep console --stream makes plain lines of subprograms] error:20
            O-1 -> [MSG:O: a program number stands alone on its line; isostep console --stream makes plain lines of subprograms] error:20
        "#]],
    );
}
