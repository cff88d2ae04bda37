//! Each check of a dialogue fails where what it says is not so.

use isostep_tests::dialogue::{Dialogue, On, Wrong, carry_out, dialogues};

/// The beginning of a dialogue, a last step that is so, and others that are not.
const ROWS: &[(&str, &str, &[&str])] = &[
    ("powered up\n> $X", "< ok", &["< error:9", "< ok\n< ok", "> $X", "silence", "note", ""]),
    ("powered up\n> $X\n< ok\nnote", "silence", &["< ok"]),
    ("with second console\npowered up\n2< Grbl...\n2> $X", "2< ok", &["2< error:9", "< ok", "> $X", "silence", ""]),
    ("powered up\n> $X\n< ...\n> $X", "< ok\npowered up", &["powered up", "power off and on"]),
    (
        "powered up",
        "report Idle MPos:0.000,... no Pn",
        &["report Run", "report no MPos", "report MPos:1...", "report Pn:X"],
    ),
    ("powered up\n> M8\n< ok", "accessories F", &["accessories none", "accessories S"]),
    ("powered up", "unchanged error:20 G5", &["unchanged error:2 G5", "unchanged error:20 G91", "unchanged ok G91"]),
    ("powered up", "state Idle", &["state Run", "motors on", "homed X"]),
    ("homed", "homed Z X Y", &["homed X Y Z", "homed Z X", "trusted X Y", "trusted none"]),
    (
        "homed\nnote\n> G0 X1\n< ok",
        "steps 50 0 0",
        &["steps 49 0 0", "steps 50 1 0", "steps 51.. 0 0", "steps * 1..2 0"],
    ),
    ("homed\nnote", "no step made", &["moved 1 0 0", "places 1 * *"]),
    ("homed\nnote\n> G0 X1\n< ok", "moved 50 0 0", &["no step made", "moved 0 0 0", "moved 50 1 0", "places as noted"]),
    ("homed\n> G0 X1\n< ok", "moves 1", &["moves 0", "moves 2..", "motors off"]),
    ("homed\nnote\nwait 5 ms", "took 5 ms", &["took 6 ms", "took ..4 ms"]),
    ("homed\n> G0 X1\n< ok\nwait 1 s", "rested 1000..1100 ms", &["rested ..999 ms", "rested 1101.. ms"]),
    ("powered up\n> M8\n< ok", "tool flood", &["tool off", "tool flood mist", "tool never on", "output flood off"]),
    ("powered up\n> M3 S500\n< ok", "output pwm ~50%", &["output pwm ~51%", "output enable off"]),
    ("powered up", "tool never on", &["output flood on", "tool mist"]),
    (
        "powered up\n> M8\n< ok\n>> G4 P0.005\n>> M9\nwatch 20 ms\n< ok\n< ok",
        "changed off",
        &["changed flood", "changed off at once", "changed off with move 1", "note\npowered up", ""],
    ),
    ("powered up\nfault chatter:X@0.01\nwait 1 s", "counts agree", &["steps 1 0 0"]),
    (
        "with board skr-pico\npowered up",
        "driver X is spread-cycle",
        &["driver X is stealth-chop", "driver X is 17-microsteps", "driver X is tells-stalls"],
    ),
];

fn carried_out(begin: &str, last: &str) -> Result<(), Wrong> {
    let text = format!("=== one\nA sentence.\n\n{begin}\n{last}\n");
    let found = dialogues(&text).unwrap_or_else(|error| panic!("{text}{error}"));
    let [one @ Dialogue { .. }] = &found[..] else { panic!("{text}") };
    carry_out(one, On::Simulator)
}

#[test]
fn what_is_not_so_fails_at_its_line() {
    for &(begin, right, wrong) in ROWS {
        assert_eq!(carried_out(begin, right), Ok(()), "{begin}\n{right}");
        for last in wrong {
            let failed = carried_out(begin, last).map_err(|wrong| wrong.line);
            let (from, lines) = (4 + begin.lines().count(), last.lines().count());
            // What is left unsaid at the end is noticed at the last step.
            let lines = if lines == 0 { 4..=from - 1 } else { from..=from + lines - 1 };
            assert!(failed.as_ref().is_err_and(|line| lines.contains(line)), "{begin}\n{last}: {failed:?}");
        }
    }
}
