//! Moves of one step each, straight on, behind a hold with as many of them as the machine takes: whatever is too short for the
//! processor is made slower, and no port runs out of steps (`tests/tests/short_moves.rs` is the same in virtual time).

use std::fmt::Write as _;

use isostep_profile::SpeedProfile;
use isostep_sim::{AXES, Port};
use isostep_tests::emulated::{self, Board};
use isostep_trials::stride;

/// The number of moves that the machine takes while it is held: its look-ahead without the move under way, and nearly its queue.
const HELD: usize = 63 + 14;
/// All of them, those included that come after the resume.
const MOVES: usize = 200;
const STEPS_PER_MM: f64 = 400.0;
/// The steps of the move in which it is held.
const LONG_STEPS: usize = 3_200;

fn script(speed_profile: usize, words: &str, axes: &[&str]) -> String {
    let start = if SpeedProfile::ALL[speed_profile].is_over_displacement() { 60 } else { 0 };
    let each = [(100, STEPS_PER_MM as u32), (110, 12_000), (120, 10_000), (910, start), (930, 300_000)];
    let settings = each.into_iter().flat_map(|(first, value)| (0..AXES as u32).map(move |axis| (first + axis, value)));
    let mut script = "expect Grbl\n".to_owned();
    for (number, value) in settings.chain([(940, speed_profile as u32)]) {
        writeln!(script, "send ${number}={value}\nexpect ok").unwrap();
    }
    writeln!(script, "send {words}\nexpect ok\nsend G91 G1 F600 X8\nexpect ok").unwrap();
    let line = |script: &mut String| {
        let step: String = axes.iter().map(|axis| format!("{axis}{}", 1.0 / STEPS_PER_MM)).collect();
        writeln!(script, "send {step} F12000").unwrap();
    };
    for _ in 0..HELD {
        line(&mut script);
        script += "expect ok\n";
    }
    script += "bytes 21\nwait-ms 400\nbytes 3f\nexpect <Hold:0\nbytes 7e\n";
    (HELD..MOVES).for_each(|_| line(&mut script));
    script += &"expect ok\n".repeat(MOVES - HELD);
    script + "wait-idle\n"
}

fn are_slower(port: Port) {
    const ALL: &[&str] = &["X", "Y", "Z"];
    let curved = (1..SpeedProfile::ALL.len()).map(|speed_profile| (speed_profile, &ALL[..1])).step_by(stride(4));
    for (speed_profile, axes) in [(0, &ALL[..1]), (0, ALL)].into_iter().chain(curved) {
        let words = ["G61", "G64 P0.01 Q0", "$904=0"][speed_profile % 3];
        let name = format!("short-{port}-{speed_profile}-{}", axes.len());
        let run =
            Board::stepped_by(port, &name).with(&["--start", "9,9,9"]).script(&script(speed_profile, words, axes));
        assert!(run.ok && !run.printed.contains("ALARM"), "{name}: {}", run.printed);
        let x: Vec<_> = run.edges.iter().filter(|edge| edge.axis == 0).collect();
        assert_eq!(run.edges.len(), LONG_STEPS + MOVES * axes.len(), "{name}");
        let lasts_s = (x[x.len() - 1].t_ns - x[LONG_STEPS].t_ns) as f64 * 1e-9;
        println!("{name}: {:.0} moves/s (emulated)", (MOVES - 1) as f64 / lasts_s);
        assert!(
            lasts_s > 0.999 * (MOVES - 1) as f64 * emulated::config().least_times.straight_s,
            "{name}: {lasts_s} s"
        );
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn short_moves_behind_a_hold_are_slower_and_never_an_alarm() {
    are_slower(Port::Pio);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn short_moves_behind_a_hold_by_the_timer_port_are_slower_and_never_an_alarm() {
    are_slower(Port::Timer);
}
