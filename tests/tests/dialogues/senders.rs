//! Replays what real senders do when they connect, and how they stream. The dialogues were recorded at a
//! pseudo-terminal. The table in docs/console.md describes each sender.

use std::collections::VecDeque;

use embassy_time::Duration;
use isostep_sim::{Config, Sim};

use crate::talk::{bytes, homed, report, state};

const WELCOME: &str = "Grbl 1.1h ['$' for help]";
const MODAL: &str = "[GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0]";

/// A header as post-processors write it, followed by 60 short moves.
fn job() -> Vec<String> {
    let header = ["(made by hand)", "G21 G17 G40 G49 G80 G90 G94 G54", "T1 M3 S1000 (no spindle)", "G0 Z5.000"];
    let square = [(10, 0), (10, 10), (0, 10), (0, 0)];
    let moves = (0..60).map(|i| {
        let (x, y) = square[i % 4];
        format!("N{} G1 X{x}.000 Y{y}.000 F2400.0 ; corner {i}", 10 * i)
    });
    header.iter().map(ToString::to_string).chain(moves).chain(["M9 M5".into(), "G0 X0 Y0 Z0".into()]).collect()
}

/// Streams by counting characters: at most `window` unanswered bytes, or one line more if `overshoots`. Every line must
/// be answered with `ok`. The reports from polling every `poll_ms` are ignored.
struct Streamer<'a> {
    sim: &'a mut Sim,
    window: usize,
    overshoots: bool,
    end: &'a str,
    poll_ms: u64,
}

impl Streamer<'_> {
    fn run(self, lines: &[String]) {
        let Self { sim, window, overshoots, end, poll_ms } = self;
        let (mut waiting, mut in_flight, mut oks) = (lines.iter().peekable(), VecDeque::new(), 0);
        let mut most = 0;
        while oks < lines.len() {
            while let Some(line) = waiting.peek() {
                let unanswered: usize = in_flight.iter().sum();
                let length = line.len() + end.len();
                let full = if overshoots { unanswered >= window } else { unanswered + length > window };
                if full {
                    break;
                }
                sim.send(format!("{line}{end}").as_bytes());
                in_flight.push_back(length);
                most = most.max(unanswered + length);
                waiting.next();
            }
            sim.run_for(Duration::from_millis(poll_ms)).unwrap();
            sim.send(b"?");
            sim.run_for(Duration::from_millis(1)).unwrap();
            for reply in sim.replies() {
                match reply.as_str() {
                    "ok" => {
                        oks += 1;
                        in_flight.pop_front();
                    }
                    report => assert!(report.starts_with('<') && report.ends_with('>'), "{report}"),
                }
            }
        }
        assert!(overshoots || most <= window);
        assert!(most > window / 2, "the window was used: {most} of {window}");
    }
}

/// Checks the state after the job: at rest where it ends, with every step made.
fn done(sim: &mut Sim) {
    sim.run_until_idle().unwrap();
    assert_eq!(state(sim), "Idle");
    assert!(report(sim).contains("MPos:0.000,0.000,0.000"));
    let outcome = sim.outcome();
    assert_eq!((outcome.drift_steps, outcome.violations.len()), ([0; 3], 0));
}

/// A machine that was homed by an earlier sender.
fn machine() -> Sim {
    let mut sim = homed();
    sim.run_for(Duration::from_secs(5)).unwrap();
    sim
}

fn hear(sim: &mut Sim, sent: &[u8], wait: Duration) -> Vec<String> {
    sim.send(sent);
    sim.run_for(wait).unwrap();
    sim.replies()
}

fn lists_settings(heard: &[String]) -> bool {
    heard.first().is_some_and(|line| line.starts_with("$0="))
        && heard.iter().any(|line| line.starts_with("$132="))
        && heard.last().is_some_and(|line| line == "ok")
}

#[test]
fn cncjs_connects_and_streams() {
    let mut sim = machine();
    // The sender is silent for 2 s and then requests a report. After the report it requests the settings.
    sim.run_for(Duration::from_secs(2)).unwrap();
    assert!(report(&mut sim).starts_with("<Idle|MPos:"));
    assert!(lists_settings(&hear(&mut sim, b"$$\n", Duration::from_millis(250))));
    assert_eq!(hear(&mut sim, b"$G\n", Duration::from_millis(250)), [MODAL, "ok"]);
    // Overrides are sent as UTF-8: twice 10 % less, then half rapids.
    assert_eq!(bytes(&mut sim, "\u{92}\u{92}\u{96}".as_bytes()), [""; 0]);
    assert!((0..12).any(|_| report(&mut sim).contains("|Ov:80,50,100")));
    let mut lines = job();
    lines.push("G4 P0.5".into());
    Streamer { sim: &mut sim, window: 120, overshoots: false, end: "\n", poll_ms: 249 }.run(&lines);
    done(&mut sim);
}

#[test]
fn bcnc_connects_streams_and_ends() {
    let mut sim = machine();
    sim.run_for(Duration::from_secs(2)).unwrap();
    assert_eq!(hear(&mut sim, b"\n\n", Duration::from_millis(100)), ["ok", "ok"]);
    assert!(report(&mut sim).starts_with("<Idle|"));
    let parameters = hear(&mut sim, b"$#\n", Duration::from_millis(100));
    assert_eq!((parameters.len(), parameters.last().unwrap().as_str()), (15, "ok"));
    assert_eq!(hear(&mut sim, b"$G\n", Duration::from_millis(100)), [MODAL, "ok"]);
    Streamer { sim: &mut sim, window: 127, overshoots: false, end: "\n", poll_ms: 199 }.run(&job());
    done(&mut sim);
    // It disconnects with a hold and, a second later, a reset. Nothing moves, so there is no alarm.
    assert_eq!(hear(&mut sim, b"!", Duration::from_secs(1)), [""; 0]);
    assert_eq!(hear(&mut sim, b"\x18", Duration::from_millis(10)), [WELCOME]);
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn grbl_streamer_connects_and_overshoots() {
    let mut sim = machine();
    assert_eq!(hear(&mut sim, b"\x18", Duration::from_millis(10)), [WELCOME]);
    assert!(lists_settings(&hear(&mut sim, b"$$\n", Duration::from_millis(100))));
    assert_eq!(hear(&mut sim, b"$#\n", Duration::from_millis(100)).len(), 15);
    assert_eq!(hear(&mut sim, b"$G\n", Duration::from_millis(100)), [MODAL, "ok"]);
    Streamer { sim: &mut sim, window: 128, overshoots: true, end: "\n", poll_ms: 99 }.run(&job());
    done(&mut sim);
}

#[test]
fn ugs_connects_and_streams() {
    let mut sim = Sim::new(&Config::default());
    sim.run_for(Duration::from_secs(2)).unwrap();
    assert_eq!(sim.replies(), [WELCOME]);
    assert!(report(&mut sim).starts_with("<Idle|"));
    sim.run_for(Duration::from_secs(2)).unwrap();
    let build = hear(&mut sim, b"$I\n", Duration::from_millis(100));
    assert!(build[0].starts_with("[VER:1.1h.") && build[1].starts_with("[OPT:"), "{build:?}");
    // It looks for the lines by how they begin, and takes others, such as our message.
    assert_eq!(build.last().map(String::as_str), Some("ok"), "{build:?}");
    assert!(lists_settings(&hear(&mut sim, b"$$\n", Duration::from_millis(100))));
    assert_eq!(hear(&mut sim, b"$G\n", Duration::from_millis(100)), [MODAL, "ok"]);
    Streamer { sim: &mut sim, window: 128, overshoots: false, end: "\n", poll_ms: 199 }.run(&job());
    done(&mut sim);
    // The sender's jog buttons.
    assert_eq!(hear(&mut sim, b"$J=G21G91X10F1000\n", Duration::from_millis(100)), ["ok"]);
    assert_eq!(state(&mut sim), "Jog");
}

#[test]
fn gsender_connects_and_streams() {
    let mut sim = machine();
    let build = hear(&mut sim, b"$I\n", Duration::from_millis(100));
    assert!(build.iter().any(|line| line.to_lowercase().contains("grbl")), "{build:?}");
    assert!(lists_settings(&hear(&mut sim, b"$$\n", Duration::from_millis(100))));
    Streamer { sim: &mut sim, window: 100, overshoots: false, end: "\n", poll_ms: 199 }.run(&job());
    done(&mut sim);
}

/// Its lines end with CR, and the reply to its reset must begin with the welcome.
#[test]
fn candle_connects_and_streams() {
    let mut sim = machine();
    let heard = hear(&mut sim, b"\x18", Duration::from_millis(100));
    assert!(heard[0].starts_with("Grbl"), "{heard:?}");
    assert!(lists_settings(&hear(&mut sim, b"$$\r", Duration::from_millis(100))));
    assert_eq!(hear(&mut sim, b"$#\r", Duration::from_millis(100)).len(), 15);
    assert_eq!(hear(&mut sim, b"$G\r", Duration::from_millis(100)), [MODAL, "ok"]);
    Streamer { sim: &mut sim, window: 127, overshoots: false, end: "\r", poll_ms: 39 }.run(&job());
    done(&mut sim);
}
