//! Each state of the table in docs/console.md, and what is accepted in it.

use embassy_time::Duration;
use isostep_sim::{Config, Sim};

use crate::talk::{begin, bytes, homed, powered_up, say, state};

/// The answer to each line in the current state. Does not wait for what the line starts.
fn answers(sim: &mut Sim, lines: &[&str]) -> Vec<String> {
    let answer = |line: &&str| begin(sim, line, Duration::from_millis(5)).pop().unwrap_or_default();
    lines.iter().map(answer).collect()
}

#[test]
fn state_idle() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(state(&mut sim), "Idle");
    let lines = ["$", "$$", "$G", "$#", "$I", "$N", "$X", "$100=50", "G21", "$N0=G21", "$N0=", ""];
    assert_eq!(answers(&mut sim, &lines), ["ok"; 12]);
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn state_run() {
    let mut sim = homed();
    begin(&mut sim, "G1 X100 F600", Duration::from_secs(1));
    assert_eq!(state(&mut sim), "Run");
    assert_eq!(answers(&mut sim, &["$", "$G", "$X", "$E1", "G21", "G0 X0"]), ["ok"; 6]);
    assert_eq!(answers(&mut sim, &["$$", "$#", "$H", "$C", "$SLP", "$J=X1F1"]), ["error:8"; 6]);
    sim.run_until_idle().unwrap();
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn state_hold() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G0 X1 M0"), [""; 0], "answered when it is resumed");
    assert_eq!(state(&mut sim), "Hold:0");
    assert_eq!(bytes(&mut sim, b"~"), ["ok"]);
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn state_jog() {
    let mut sim = homed();
    begin(&mut sim, "$J=X100F600", Duration::from_secs(1));
    assert_eq!(state(&mut sim), "Jog");
    assert_eq!(answers(&mut sim, &["$", "$$", "$G", "$J=X120F600"]), ["ok"; 4]);
    assert_eq!(
        answers(&mut sim, &["G0 X1", "G21", "$#", "$H", "$C"]),
        ["error:9", "error:9", "error:8", "error:8", "error:8"]
    );
    sim.run_until_idle().unwrap();
    assert_eq!(state(&mut sim), "Idle");
    begin(&mut sim, "G1 X0 F600", Duration::from_secs(1));
    assert_eq!(state(&mut sim), "Run", "the jog is over");
}

/// A line sent during homing waits for its end.
#[test]
fn state_home() {
    let mut sim = powered_up(&Config::default());
    begin(&mut sim, "$H", Duration::from_secs(1));
    assert_eq!(state(&mut sim), "Home");
    assert_eq!(say(&mut sim, "$G").len(), 3, "ok for the homing, then the modal state");
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn state_alarm() {
    let mut sim = homed();
    say(&mut sim, "G0 X-1");
    assert_eq!(state(&mut sim), "Alarm");
    assert_eq!(answers(&mut sim, &["$", "$$", "$G", "$#", "$I", "$N", "$100=50", ""]), ["ok"; 8]);
    assert_eq!(answers(&mut sim, &["G21", "$J=X1F1", "$C", "$N0=G21"]), ["error:9", "error:8", "error:8", "error:8"]);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", "[MSG:'$H'|'$X' to unlock]"], "a reset does not unlock");
    assert_eq!(state(&mut sim), "Alarm");
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn state_check() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$C"), ["[MSG:Enabled]", "ok"]);
    assert_eq!(state(&mut sim), "Check");
    assert_eq!(answers(&mut sim, &["$", "$$", "$G", "G0 X1", "G4 P5", "M0"]), ["ok"; 6]);
    assert_eq!(answers(&mut sim, &["$#", "$H", "$J=X1F1", "$SLP", "$100=1"]), ["error:8"; 5]);
    bytes(&mut sim, b"\x18");
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn state_sleep() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$SLP"), ["ok", "[MSG:Sleeping]"]);
    assert_eq!(state(&mut sim), "Sleep");
    assert_eq!(say(&mut sim, "$X\nG0 X1\n$"), [""; 0], "silence until a reset");
    assert_eq!(state(&mut sim), "Sleep");
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", "[MSG:'$H'|'$X' to unlock]"]);
    assert_eq!(state(&mut sim), "Alarm");
    assert_eq!(answers(&mut sim, &["G0 X1"]), ["error:9"]);
    assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
    assert_eq!(state(&mut sim), "Idle");
}
