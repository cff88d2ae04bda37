//! Lines that wait, and the real-time bytes behind them: what a console keeps, what it loses, and what must not be made.

use embassy_time::Duration;
use isostep_sim::world::Wire;
use isostep_sim::{Config, Sim};

use crate::talk::{powered_up, say};

const WELCOME: &str = "Grbl 1.1h ['$' for help]";
const LOST: &str = "[MSG:This line is lost, because more was sent ahead than the console keeps: reset (ctrl-x), then send no more \
                    than Bf: says]";
const ELSEWHERE: &str = "[MSG:Reset from elsewhere: all lines sent before are forgotten]";
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
