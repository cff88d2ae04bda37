//! Stops at every instant of two processes in the firmware: a line that becomes a move, and a change of moves under
//! way.
//!
//! `cargo xtask test --all` tries some hundred instants of each. Trying all of them, microsecond by microsecond, takes
//! longer; docs/position.md has the command.

use std::env;
use std::fmt::Write as _;

use isostep_sim::{AXES, Port};
use isostep_tests::emulated::Board;
use isostep_trials::cases;
use oorandom::Rand32;

/// Seed of the instants.
const SEED: u64 = 21;
/// Environment variable that requests every microsecond.
const EVERY_US: &str = "ISOSTEP_SWEEP_EVERY_US";
/// From the last byte of a line to well after the first step of its move, which comes some 5 ms later.
const LINE_US: u32 = 6_500;
/// From a byte that changes a move under way until the change has taken effect. If every microsecond is requested, only
/// the first part is tried.
const CHANGE_US: u32 = 80_000;
const CHANGE_BEGINS_US: u32 = 2_000;

/// A script that stops the machine and continues. A step may follow the stop by at most `within_us`. After that nothing
/// may move, neither locked nor unlocked.
struct Stop {
    name: &'static str,
    script: fn(within_us: u32) -> String,
}

const STOPS: [Stop; 3] = [
    Stop {
        name: "limit",
        script: |us| {
            format!(
                "switch X stuck-closed\nstop-within {us}\nexpect ALARM:1\nwait-us 200\nswitch X normal\nwait-us 2500\n{UNLOCKED}"
            )
        },
    },
    Stop {
        name: "estop",
        script: |us| {
            format!(
                "estop pressed\nstop-within {us}\nexpect ALARM:10\nwait-us 200\nestop released\nwait-us 2500\n{UNLOCKED}"
            )
        },
    },
    // A reset before a line has been read discards the line. Nothing is left to be stopped, so no alarm is expected.
    Stop {
        name: "reset",
        script: |us| {
            format!("bytes 18\nwait-us 400\nbytes 18\nwait-arrival\nstop-within {us}\nwait-us 3000\n{UNLOCKED}")
        },
    },
];

/// The answer to `$G` shows that `$X` has been carried out, however many lines were answered before.
const UNLOCKED: &str = "send $X\nsend $G\nexpect [GC:\nwait-us 500\ncheck-stopped\ncheck-position\n";

/// Three axes that start at 5,000,000 steps/s², switches with a debounce of one millisecond, coolant on.
fn settings(top_mm_min: u32) -> String {
    let mut script = "expect Grbl\nsend $26=1\nexpect ok\n".to_owned();
    for axis in 0..AXES as u32 {
        for (number, value) in [(110, top_mm_min), (120, 100_000)] {
            writeln!(script, "send ${}={value}\nexpect ok", number + axis).unwrap();
        }
    }
    script
}

/// The instants to try, us: `count` random ones, or, if requested, all whole microseconds up to `every_us`.
fn instants(until_us: u32, count: u32, every_us: u32) -> Vec<f64> {
    if env::var_os(EVERY_US).is_some() {
        return (1..=every_us).map(f64::from).collect();
    }
    let mut random = Rand32::new(SEED);
    // Instants are multiples of 0.01 us and never 0, because a wait of 0 is no wait.
    (0..count).map(|_| f64::from(random.rand_range(1..100 * until_us)) / 100.0).collect()
}

/// The longest time after a stop at which a step may follow, us. The timer port's task reads USB only between steps.
fn within_us(port: Port, stop: &Stop) -> u32 {
    match (port, stop.name) {
        (Port::Timer, "reset") => 100,
        _ => 10,
    }
}

/// Runs a script with this number of stops.
fn held(port: Port, name: &str, stops: usize, script: &str) {
    let run = Board::stepped_by(port, name).with(&["--start", "900,900,900"]).script(script);
    let found = run.printed.lines().find(|line| line.starts_with("FAILED")).unwrap_or_default();
    assert!(run.ok, "{found}: target/emulated/{name}/script.txt, SEED={SEED}, has what was done before");
    println!("{name}: stopped at {stops} instants, no step and no alarm lost");
}

/// Stops while a line becomes a move towards the switches. Whatever stage it has reached, nothing may move further.
fn while_a_line_becomes_a_move(port: Port, count: u32) {
    for stop in &STOPS {
        let instants = instants(LINE_US, count, LINE_US);
        let mut script = settings(12_000);
        for (index, at_us) in instants.iter().enumerate() {
            // The direction alternates, so that the carriages stay where they are. The limit switch is different: a
            // switch that closes at rest stops only moves towards it.
            let mm = if stop.name == "limit" || index % 2 == 0 { -2 } else { 2 };
            writeln!(script, "send M8\nsend G91G0X{mm}Y{mm}Z{mm}\nwait-arrival\nwait-us {at_us}").unwrap();
            script += &(stop.script)(within_us(port, stop));
        }
        held(port, &format!("sweep-line-{}-{port}", stop.name), instants.len(), &script);
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn no_stop_is_lost_while_a_line_becomes_a_move() {
    while_a_line_becomes_a_move(Port::Pio, cases(6, 100));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn no_stop_of_the_timer_port_is_lost_while_a_line_becomes_a_move() {
    while_a_line_becomes_a_move(Port::Timer, cases(3, 40));
}

/// The changes to two moves with a corner between them: name, bytes, and the stops to try. After a reset has braked, a
/// limit switch stops nothing, so it is not tried then.
const CHANGES: [(&str, &str, &[Stop]); 5] = [
    ("hold", "bytes 21\n", &STOPS),
    ("resume", "bytes 21\nwait-ms 100\nbytes 7e\n", &STOPS),
    ("override", "bytes 91 91 91\n", &STOPS),
    ("reset", "bytes 18\n", STOPS.split_at(1).1),
    ("corner", "", &STOPS),
];

/// Stops while two moves of some 130 ms with a corner between them are held, resumed, overridden, reset or left alone.
fn while_moves_change(port: Port, count: u32) {
    for (change, bytes, stops) in CHANGES {
        let instants = instants(CHANGE_US, count, CHANGE_BEGINS_US);
        let mut script = settings(12_000);
        for (index, at_us) in instants.iter().enumerate() {
            let (stop, sign) = (&stops[index % stops.len()], if index % 2 == 0 { "-" } else { "" });
            let ways = [format!("X{sign}4Y{sign}2"), format!("X{sign}2Y{sign}4Z{sign}2")];
            writeln!(script, "send M8\nsend G91G1{}F3000\nsend G1{}\nwait-edge\nwait-us 9100", ways[0], ways[1])
                .unwrap();
            writeln!(script, "{bytes}wait-us {at_us}").unwrap();
            script += &(stop.script)(within_us(port, stop));
        }
        held(port, &format!("sweep-{change}-{port}"), instants.len(), &script);
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn no_stop_is_lost_while_moves_change() {
    while_moves_change(Port::Pio, cases(2, 24));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn no_stop_of_the_timer_port_is_lost_while_moves_change() {
    while_moves_change(Port::Timer, cases(2, 12));
}
