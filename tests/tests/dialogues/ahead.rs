//! Lines that wait, and the real-time bytes behind them: what a console keeps, what it loses, and what must not be made.

use embassy_time::Duration;
use isostep_sim::world::Wire;
use isostep_sim::{Config, Sim};

use crate::talk::{powered_up, say};

const WELCOME: &str = "Grbl 1.1h ['$' for help]";
const LOST: &str = "[MSG:This line is lost, because more was sent ahead than the console keeps: reset (ctrl-x), then send no more \
                    than Bf: says]";
/// USB, which has its host wait, and a UART, which cannot.
const LINKS: [Option<u32>; 2] = [None, Some(115_200)];

fn two_consoles(baud: Option<u32>) -> Sim {
    let mut sim = powered_up(&Config { second_console: true, baud, ..Config::default() });
    assert_eq!(sim.replies_of(1), [WELCOME]);
    sim
}

fn wait(sim: &mut Sim, ms: u64) {
    sim.run_for(Duration::from_millis(ms)).unwrap();
}

/// Sends to a console and returns what it answers within some time.
fn tell(sim: &mut Sim, console: usize, bytes: &[u8], ms: u64) -> Vec<String> {
    sim.send_to(console, bytes);
    wait(sim, ms);
    sim.replies_of(console)
}

/// Lines of 16 bytes that move by 1 mm each.
fn moves(count: usize) -> String {
    "G91 G1 X1 F3000\n".repeat(count)
}

/// Where nothing goes on without a real-time byte, it is heard behind any number of lines. The lines for which there is
/// no room are reported one by one, and no line behind them is carried out before a reset.
#[test]
fn real_time_bytes_are_heard_however_many_lines_wait() {
    for baud in LINKS {
        for (console, waits) in [(0, "M0\n"), (1, "M0\n"), (1, "M6 T1\n"), (0, "!"), (1, "!")] {
            let mut sim = two_consoles(baud);
            tell(&mut sim, console, waits.as_bytes(), 50);
            let sent = 200;
            let heard = tell(&mut sim, console, moves(sent).as_bytes(), 600);
            let taken_early = heard.iter().filter(|line| *line == "ok").count();
            let heard = tell(&mut sim, console, b"?", 20);
            assert!(heard[0].starts_with("<Hold:0|MPos:0.000,"), "{baud:?}, {waits:?}: {heard:?}");
            let heard = tell(&mut sim, console, b"~", 60_000);
            let (taken, lost): (Vec<_>, Vec<_>) =
                heard.iter().filter(|line| !line.starts_with("[MSG:M6")).partition(|line| *line == "ok");
            // The pause is answered, too.
            let taken = taken_early + taken.len() - usize::from(waits.ends_with('\n'));
            assert_eq!(lost.len(), 2 * (sent - taken), "{baud:?}, {waits:?}");
            assert!(lost.chunks(2).all(|pair| pair[0] == LOST && pair[1] == "error:11"), "{lost:?}");
            assert_eq!(heard.iter().rposition(|line| line == "ok").map(|at| heard.len() - at - 1), Some(lost.len()));
            // 512 bytes are kept, and up to 79 moves are asked for in a hold. No part of a line is made.
            assert!((32..=32 + 79).contains(&taken), "{baud:?}, {waits:?}: {taken}");
            assert_eq!(sim.counted_steps(), [50 * taken as i32, 0, 0], "{baud:?}, {waits:?}");
            assert_eq!(tell(&mut sim, console, b"G91 G0 X1\n", 500), [LOST, "error:11"]);
            assert_eq!(tell(&mut sim, console, b"\x18G91 G0 X1\n", 500), [WELCOME, "ok"]);
            assert_eq!(sim.counted_steps(), [50 * (taken as i32 + 1), 0, 0]);
        }
    }
}

/// The same for the reset itself, in a pause, a hold and asleep, on the console that waits and on the other one.
#[test]
fn a_reset_is_heard_however_many_lines_wait() {
    for baud in LINKS {
        for waits in ["M0\n", "M6 T1\n", "!G4 P1\n", "$SLP\n", "!"] {
            for console in [0, 1] {
                let mut sim = two_consoles(baud);
                tell(&mut sim, 0, waits.as_bytes(), 50);
                tell(&mut sim, console, moves(100).as_bytes(), 600);
                let heard = tell(&mut sim, console, b"\x18", 500);
                assert_eq!(heard[0], WELCOME, "{baud:?}, {waits:?} on {console}: {heard:?}");
                let heard = tell(&mut sim, console, b"$X\nG91 G0 X1\n", 500);
                assert_eq!(heard.last().map(String::as_str), Some("ok"), "{baud:?}, {waits:?} on {console}: {heard:?}");
                assert_eq!(sim.counted_steps(), [50, 0, 0], "{baud:?}, {waits:?} on {console}");
            }
        }
    }
}

/// While the machine works, USB has its host wait: nothing is lost.
#[test]
fn a_host_with_flow_control_loses_no_line_while_the_machine_works() {
    let mut sim = two_consoles(None);
    let heard = tell(&mut sim, 0, moves(300).as_bytes(), 60_000);
    assert_eq!(heard, vec!["ok"; 300]);
    assert_eq!(sim.counted_steps(), [15_000, 0, 0]);
}

/// What a console has received behind a line that resets is forgotten, to the end of a line, also what it has not kept yet.
#[test]
fn no_line_is_cut_where_a_reset_comes_while_bytes_wait_for_room() {
    for begins in 0..16 {
        let mut sim = two_consoles(None);
        let lines = format!("$RST=#\n({}\n{}", "-".repeat(begins), moves(100));
        let heard = tell(&mut sim, 0, lines.as_bytes(), 30_000);
        let welcome = heard.iter().position(|line| line == WELCOME).unwrap();
        let made = heard[welcome + 1..].iter().filter(|line| *line == "ok").count();
        assert_eq!(heard.len() - welcome - 1, made, "{begins}: {heard:?}");
        assert!((50..70).contains(&made), "{begins}: {made}");
        assert_eq!(sim.counted_steps(), [50 * made as i32, 0, 0], "{begins}");
    }
}

/// A UART would lose bytes itself, in the middle of lines and in silence: lines are lost whole, reported, and a hold is heard.
#[test]
fn without_flow_control_a_hold_is_heard_in_motion_too() {
    let mut sim = two_consoles(LINKS[1]);
    let slow = "G91 G1 X5 F300\n".repeat(200);
    let heard = tell(&mut sim, 0, slow.as_bytes(), 600);
    assert_eq!(heard, vec!["ok"; 79], "those behind them wait, or are lost");
    assert_eq!(tell(&mut sim, 0, b"!", 1_000), [""; 0]);
    let heard = tell(&mut sim, 0, b"?", 20);
    assert!(heard.iter().any(|line| line.starts_with("<Hold:0|MPos:")), "{heard:?}");
}

/// Jogs that come while M0 or M6 waits are answered in order, and are not made after the resume, whoever gives it.
#[test]
fn a_jog_sent_in_a_pause_is_refused() {
    for pause in ["M0\n", "M6\n"] {
        for (by, jog) in [(0, "$J=G91 X5 F600\n"), (1, "$J=G91 X5 F600\n"), (2, "$J=G91 X5 F600\n$J=G91 Y5 F600\n")] {
            for in_one in [true, false] {
                let mut sim = two_consoles(None);
                let jogs = jog.lines().count();
                if in_one {
                    sim.send_to(0, format!("{pause}{jog}").as_bytes());
                } else {
                    tell(&mut sim, 0, pause.as_bytes(), 20);
                    sim.send_to(0, jog.as_bytes());
                }
                wait(&mut sim, 100);
                sim.replies_of(0);
                if by == 2 {
                    sim.set_hand_input(Wire::Start, true);
                } else {
                    sim.send_to(by, b"~");
                }
                wait(&mut sim, 2_000);
                let expected = [vec!["ok"], vec!["error:8"; jogs]].concat();
                assert_eq!(sim.replies_of(0), expected, "{pause:?} {jog:?} by {by}, in one: {in_one}");
                assert_eq!(sim.counted_steps(), [0; 3], "{pause:?} by {by}");
                // The next one is made.
                assert_eq!(tell(&mut sim, 0, b"$J=G91 X1 F600\n", 500), ["ok"]);
                assert_eq!(sim.counted_steps(), [50, 0, 0], "{pause:?} by {by}");
            }
        }
    }
}

/// In a hold by hand too, if its line waits behind another.
#[test]
fn a_jog_that_waits_in_a_hold_is_refused() {
    let mut sim = two_consoles(None);
    tell(&mut sim, 0, b"G4 P1\n", 50);
    tell(&mut sim, 0, b"!", 50);
    assert_eq!(tell(&mut sim, 0, b"$J=G91 X5 F600\n", 50), [""; 0]);
    assert_eq!(tell(&mut sim, 0, b"~", 2_000), ["ok", "error:8"]);
    assert_eq!((tell(&mut sim, 0, b"$J=G91 X1 F600\n", 500), sim.counted_steps()), (vec!["ok".to_owned()], [50, 0, 0]));
}

/// Another console's jogs and probes are refused at once: its lines would wait for the resume, and then move.
#[test]
fn jogs_and_probes_of_the_other_console_are_refused_in_a_pause() {
    for pause in ["M0\n", "M6\n"] {
        let mut sim = two_consoles(None);
        tell(&mut sim, 0, pause.as_bytes(), 50);
        for line in ["$J=G91 X5 F600\n", "G91 G38.3 Z1 F100\n"] {
            assert_eq!(tell(&mut sim, 1, line.as_bytes(), 5), ["error:8"], "{pause:?} {line:?}");
        }
        tell(&mut sim, 1, b"G21\n$J=G91 X5 F600\n", 50);
        assert_eq!(tell(&mut sim, 0, b"~", 1_000), ["ok"], "{pause:?}");
        assert_eq!((sim.replies_of(1), sim.counted_steps()), (vec!["ok".to_owned(), "error:8".to_owned()], [0; 3]));
        assert_eq!(tell(&mut sim, 1, b"$J=G91 X1 F600\n", 500), ["ok"], "{pause:?}");
    }
    // It came while console 0 moved, and waits for its turn, which comes after the pause.
    let mut sim = two_consoles(None);
    tell(&mut sim, 0, b"G91 G1 X5 F600\nM0\n", 100);
    tell(&mut sim, 1, b"$J=G91 X5 F600\n", 2_000);
    assert_eq!(tell(&mut sim, 0, b"~", 1_000), ["ok"]);
    assert_eq!((sim.replies_of(1), sim.counted_steps()), (vec!["error:8".to_owned()], [250, 0, 0]));
}

/// A program may measure its new tool: a probe behind M6 is its next line.
#[test]
fn a_probe_behind_the_pause_of_its_own_program_is_made() {
    let mut sim = two_consoles(None);
    tell(&mut sim, 0, b"M6\nG91 G38.3 Z1 F300\n", 50);
    let heard = tell(&mut sim, 0, b"~", 2_000);
    assert!(heard[0] == "ok" && heard[1].starts_with("[PRB:") && heard[2] == "ok", "{heard:?}");
}

/// Two real-time bytes while lines wait, in each order and in one packet or apart, and then a line that must act: what
/// the first one has counted begins anew.
#[test]
fn a_line_behind_two_real_time_bytes_acts() {
    const BYTES: [&[u8]; 5] = [b"\x85", b"\x18", b"~", b"!~", b"?"];
    let lines = "$J=G91 X1 F300\n";
    for first in BYTES {
        for second in BYTES {
            for apart in [false, true] {
                let mut sim = powered_up(&Config::default());
                // Some are under way, and more wait as lines.
                sim.send(lines.repeat(120).as_bytes());
                wait(&mut sim, 500);
                sim.replies();
                sim.send(first);
                if apart {
                    wait(&mut sim, 50);
                }
                sim.send(second);
                let case = format!("{first:x?} {second:x?}, apart: {apart}");
                sim.run_until_idle().unwrap();
                // The second reset of two stops at once.
                say(&mut sim, "$X");
                let before = sim.counted_steps();
                sim.send(b"$J=G91 Y1 F300\n");
                sim.run_until_idle().unwrap();
                assert_eq!(sim.replies(), ["ok"], "{case}");
                assert_eq!(sim.counted_steps(), [before[0], before[1] + 50, 0], "{case}");
                // The same directly behind the bytes, where what waited before them is forgotten.
                if second != first && (second == b"\x18" || second == b"\x85") {
                    sim.send(lines.repeat(120).as_bytes());
                    wait(&mut sim, 500);
                    sim.replies();
                    sim.send(&[first, second, b"$J=G91 Y1 F300\n"].concat());
                    sim.run_until_idle().unwrap();
                    assert_eq!(sim.counted_steps()[1], before[1] + 100, "{case}");
                    assert_eq!(sim.replies().last().map(String::as_str), Some("ok"), "{case}");
                }
            }
        }
    }
}
