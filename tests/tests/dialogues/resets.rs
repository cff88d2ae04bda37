//! A reset is the machine's, whichever console it comes from: nothing that any console sent before it moves, switches,
//! holds or prompts after it, every console is told, and no console hears an answer to a line that was forgotten.

use embassy_time::Duration;
use isostep_sim::{Config, Sim};

use crate::talk::powered_up;

const WELCOME: &str = "Grbl 1.1h ['$' for help]";
const ELSEWHERE: &str = "[MSG:Reset from elsewhere: all lines sent before are forgotten]";

/// A machine with two consoles that have read their welcome.
fn two_consoles() -> Sim {
    let mut sim = powered_up(&Config { second_console: true, ..Config::default() });
    assert_eq!(sim.replies_of(1), [WELCOME]);
    sim
}

fn wait(sim: &mut Sim, ms: u64) {
    sim.run_for(Duration::from_millis(ms)).unwrap();
}

/// The first part of a status report on a console.
fn status(sim: &mut Sim, console: usize) -> String {
    sim.send_to(console, b"?");
    wait(sim, 1);
    let report = sim.replies_of(console).pop().unwrap();
    report.split('|').take(2).collect::<Vec<_>>().join("|")
}

/// Console 0 moves, and `waiting` waits for the end of the move; then console `by` resets the machine.
#[track_caller]
fn is_forgotten(waiting: &str, by: usize) {
    let mut sim = two_consoles();
    sim.send_to(0, b"G91 G1 X10 F600\n");
    sim.send_to(0, waiting.as_bytes());
    wait(&mut sim, 500);
    assert_eq!(sim.replies_of(0), ["ok"], "{waiting:?}: the move is under way");
    sim.send_to(by, b"\x18");
    wait(&mut sim, 3_000);
    let welcome = |console| if console == by { vec![WELCOME] } else { vec![WELCOME, ELSEWHERE] };
    assert_eq!([0, 1].map(|console| sim.replies_of(console)), [0, 1].map(welcome), "{waiting:?} by {by}");
    let stands = status(&mut sim, 0);
    let [steps, 0, 0] = sim.counted_steps() else { panic!("{waiting:?}: another axis has moved") };
    assert!(stands.starts_with("<Idle|MPos:") && (250..300).contains(&steps), "{waiting:?}: {stands}");
    assert!(sim.outcome().tool.is_empty(), "{waiting:?}: an output was on");
    // Each console goes on, and the first answer is that to its next line.
    for console in [0, 1] {
        sim.send_to(console, b"G20 G91\n$G\n");
        wait(&mut sim, 10);
        let heard = sim.replies_of(console);
        assert!(heard[0] == "ok" && heard[1].contains("G20") && heard.len() == 3, "{waiting:?}: {heard:?}");
    }
}

#[test]
fn a_reset_forgets_the_lines_of_every_console() {
    let waiting = [
        "G4 P0.1\nX10\n",
        "M0\nX10\n",
        "M6 T1\nX10\n",
        "M3 S500\n",
        "M8\n",
        "G10 L20 P1 X0\n",
        "G4 P9\n",
        "G38.3 X5\n",
    ];
    for by in [0, 1] {
        for waiting in waiting {
            is_forgotten(waiting, by);
        }
    }
}

#[test]
fn a_reset_forgets_a_full_queue_of_every_console() {
    let mut sim = two_consoles();
    let moves = "X1\n".repeat(200);
    sim.send_to(0, format!("G91 G1 F600\n{moves}").as_bytes());
    sim.send_to(1, b"G0 X-1\n");
    wait(&mut sim, 500);
    sim.replies_of(0);
    sim.replies_of(1);
    sim.send_to(1, b"\x18");
    wait(&mut sim, 3_000);
    assert_eq!([0, 1].map(|console| sim.replies_of(console)), [vec![WELCOME, ELSEWHERE], vec![WELCOME]]);
    let stood = status(&mut sim, 1);
    assert!(stood.starts_with("<Idle|"), "{stood}");
    wait(&mut sim, 3_000);
    assert_eq!(status(&mut sim, 1), stood);
}

/// A hold of the other console: the reset ends it, and the pause that caused it.
#[test]
fn a_reset_ends_the_pause_of_every_console() {
    for paused in ["M0\nG0 X5\n", "M6 T2\nG0 X5\n", "!G0 X5\n", "$SLP\nG0 X5\n"] {
        let mut sim = two_consoles();
        sim.send_to(0, paused.as_bytes());
        wait(&mut sim, 100);
        sim.replies_of(0);
        sim.send_to(1, b"\x18");
        wait(&mut sim, 100);
        assert_eq!(sim.replies_of(0)[..2], [WELCOME, ELSEWHERE], "{paused:?}");
        sim.send_to(1, b"~");
        wait(&mut sim, 1_000);
        assert_eq!(sim.counted_steps(), [0; 3], "{paused:?}");
        let state = if paused.contains("SLP") { "<Alarm|" } else { "<Idle|" };
        assert!(status(&mut sim, 0).starts_with(state), "{paused:?}");
    }
}

/// The host of console 0 does not know of the reset before it has read the welcome: what it sends until then was sent
/// before the reset.
#[test]
fn lines_of_a_host_that_has_not_read_the_welcome_are_forgotten() {
    let mut sim = powered_up(&Config { second_console: true, baud: Some(115_200), ..Config::default() });
    sim.replies_of(1);
    sim.send_to(0, b"G91 G1 X10 F600\nG4 P1\n");
    wait(&mut sim, 500);
    sim.replies_of(0);
    sim.send_to(1, b"\x18");
    // They arrive after the reset, and before the machine stands still.
    sim.send_to(0, b"X10\nM8\nX1");
    wait(&mut sim, 3_000);
    assert_eq!(sim.replies_of(0), [WELCOME, ELSEWHERE]);
    let stood = sim.counted_steps();
    assert!((250..300).contains(&stood[0]), "{stood:?}");
    assert!(sim.outcome().tool.is_empty(), "coolant was on");
    // The rest of the line that had begun belongs to it.
    sim.send_to(0, b"0 Y10\nG91 G0 X1\n");
    wait(&mut sim, 3_000);
    assert_eq!(sim.replies_of(0), ["ok"]);
    assert_eq!(sim.counted_steps(), [stood[0] + 50, 0, 0]);
}

/// What else there is to say after the welcome, and to store, takes time, in which the host's lines count already.
#[test]
fn a_line_counts_as_soon_as_its_host_has_read_that_all_is_forgotten() {
    let config = Config { second_console: true, baud: Some(115_200), ..Config::default() };
    // An alarm, which takes one more message, and a work offset that was not stored before the reset.
    for (before, last) in [("$H\n", "[MSG:'$H'|'$X' to unlock]"), ("G1 F300 X5\nG10 L2 P1 X1\n", ELSEWHERE)] {
        let mut sim = powered_up(&config);
        sim.replies_of(1);
        sim.send_to(0, before.as_bytes());
        wait(&mut sim, 300);
        sim.replies_of(0);
        sim.send_to(0, b"\x18");
        let mut heard = Vec::new();
        for _ in 0..10_000 {
            sim.run_for(Duration::from_micros(100)).unwrap();
            heard.extend(sim.replies_of(1));
            if heard.iter().any(|line| line == ELSEWHERE) {
                break;
            }
        }
        assert_eq!(heard.last().map(String::as_str), Some(ELSEWHERE), "{before:?}");
        sim.send_to(1, b"\n");
        wait(&mut sim, 200);
        heard.extend(sim.replies_of(1));
        assert_eq!(heard[heard.len() - 2..], [last, "ok"], "{before:?}: {heard:?}");
    }
}

/// Two resets, one from each console, at any time: each host hears of each.
#[test]
fn resets_of_two_consoles_are_told_to_both() {
    for apart_ms in [0, 1, 20, 500] {
        let mut sim = two_consoles();
        sim.send_to(0, b"M0\n");
        wait(&mut sim, 100);
        sim.send_to(0, b"\x18");
        wait(&mut sim, apart_ms);
        sim.send_to(1, b"\x18G91\n");
        wait(&mut sim, 1_000);
        let heard = [0, 1].map(|console| sim.replies_of(console));
        assert_eq!(heard[0].last().map(String::as_str), Some(ELSEWHERE), "{apart_ms}: {heard:?}");
        assert_eq!(heard[1][heard[1].len() - 2..], [WELCOME, "ok"], "{apart_ms}: {heard:?}");
        for console in [0, 1] {
            sim.send_to(console, b"G21\n");
            wait(&mut sim, 10);
            assert_eq!(sim.replies_of(console), ["ok"], "{apart_ms}");
        }
    }
}

/// `$C` and `$RST=` end in a reset, which is everybody's, too.
#[test]
fn a_line_that_ends_in_a_reset_resets_every_console() {
    for line in ["$RST=#", "$C\n$C"] {
        let mut sim = two_consoles();
        sim.send_to(0, b"G20\n");
        wait(&mut sim, 10);
        assert_eq!(sim.replies_of(0), ["ok"]);
        sim.send_to(1, line.as_bytes());
        sim.send_to(1, b"\n");
        wait(&mut sim, 100);
        assert_eq!(sim.replies_of(0), [WELCOME, ELSEWHERE], "{line}");
        assert_eq!(sim.replies_of(1).last().map(String::as_str), Some(WELCOME), "{line}");
    }
}

/// What has come behind such a line is forgotten whole: the rest of it is no line of its own.
#[test]
fn a_line_begun_behind_one_that_resets_is_forgotten_to_its_end() {
    for line in ["$RST=#", "$C\n$C"] {
        let mut sim = two_consoles();
        sim.send_to(0, format!("{line}\nG0 X1").as_bytes());
        wait(&mut sim, 100);
        assert_eq!(sim.replies_of(0).last().map(String::as_str), Some(WELCOME), "{line}");
        sim.send_to(0, b" Y1\n");
        wait(&mut sim, 1_000);
        assert_eq!((sim.replies_of(0), sim.counted_steps()), (Vec::new(), [0; 3]), "{line}");
        sim.send_to(0, b"G91 G0 X1\n");
        wait(&mut sim, 1_000);
        assert_eq!((sim.replies_of(0), sim.counted_steps()), (vec!["ok".to_owned()], [50, 0, 0]), "{line}");
    }
}
