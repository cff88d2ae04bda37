//! Stops at every instant of what a stop may find the firmware in the midst of: a line on its way to becoming a move, and a
//! change of what moves.
//!
//! `cargo xtask test` tries some hundred instants of each. All of them, microsecond by microsecond, take minutes: the README
//! of the emulator has the command.

use std::env;
use std::fmt::Write as _;

use isostep_sim::Port;
use isostep_tests::emulated::Board;
use oorandom::Rand32;

/// Seed of the instants.
const SEED: u64 = 21;
/// Asks for every microsecond.
const EVERY_US: &str = "ISOSTEP_SWEEP_EVERY_US";
/// From the last byte of a line to well behind the first step of its move, which is some 5 ms later.
const LINE_US: u32 = 6_500;
/// From a byte that changes what moves to where that has come about; and of that, where every microsecond is asked for, what
/// the firmware does first.
const CHANGE_US: u32 = 80_000;
const CHANGE_BEGINS_US: u32 = 2_000;

/// What stops the machine, the latest that a step may follow in microseconds, and how it goes on. Nothing moves any more,
/// unlocked or not.
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
    // Before a line has been read a reset forgets it, and nothing is left to be stopped: no alarm then.
    Stop {
        name: "reset",
        script: |us| {
            format!("bytes 18\nwait-us 400\nbytes 18\nwait-arrival\nstop-within {us}\nwait-us 3000\n{UNLOCKED}")
        },
    },
];

/// The answer to `$G` tells that `$X` has been carried out, however many lines were answered before.
const UNLOCKED: &str = "send $X\nsend $G\nexpect [GC:\nwait-us 500\ncheck-stopped\ncheck-position\n";

/// Three axes that leave standstill at 5,000,000 steps/s², switches debounced in a millisecond, coolant on.
fn settings(top_mm_min: u32) -> String {
    let mut script = "expect Grbl\nsend $26=1\nexpect ok\n".to_owned();
    for axis in 0..3 {
        for (number, value) in [(110, top_mm_min), (120, 100_000)] {
            writeln!(script, "send ${}={value}\nexpect ok", number + axis).unwrap();
        }
    }
    script
}

/// The instants that are tried, us: so many at random, or, if asked for, all whole ones below `every_us`.
fn instants(until_us: u32, count: u32, every_us: u32) -> Vec<f64> {
    if env::var_os(EVERY_US).is_some() {
        return (1..=every_us).map(f64::from).collect();
    }
    let mut random = Rand32::new(SEED);
    // To a hundredth, and not at once: a wait of nothing is none.
    (0..count).map(|_| f64::from(random.rand_range(1..100 * until_us)) / 100.0).collect()
}

/// The longest that a step may follow a stop, us. The timer port's task hears USB only between steps.
fn within_us(port: Port, stop: &Stop) -> u32 {
    match (port, stop.name) {
        (Port::Timer, "reset") => 100,
        _ => 10,
    }
}

/// Carries out a script of that many stops.
fn held(port: Port, name: &str, stops: usize, script: &str) {
    let run = Board::stepped_by(port, name).with(&["--start", "900,900,900"]).script(script);
    let found = run.printed.lines().find(|line| line.starts_with("FAILED")).unwrap_or_default();
    assert!(run.ok, "{found}: target/emulated/{name}/script.txt, SEED={SEED}, has what was done before");
    println!("{name}: stopped at {stops} instants, no step and no alarm lost");
}

/// Stops while a line becomes a move onto the switches: wherever it has got, nothing goes further.
fn while_a_line_becomes_a_move(port: Port, count: u32) {
    for stop in &STOPS {
        let instants = instants(LINE_US, count, LINE_US);
        let mut script = settings(12_000);
        for (index, at_us) in instants.iter().enumerate() {
            // By turns, so that all stay where they are; but a switch that closes at rest stops only what goes onto it.
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
    while_a_line_becomes_a_move(Port::Pio, 100);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn no_stop_of_the_timer_port_is_lost_while_a_line_becomes_a_move() {
    while_a_line_becomes_a_move(Port::Timer, 40);
}

/// What changes two moves with a corner between them: the bytes that ask for it, and what stops them then. Once a reset has
/// braked, a limit switch stops nothing.
const CHANGES: [(&str, &str, &[Stop]); 5] = [
    ("hold", "bytes 21\n", &STOPS),
    ("resume", "bytes 21\nwait-ms 100\nbytes 7e\n", &STOPS),
    ("override", "bytes 91 91 91\n", &STOPS),
    ("reset", "bytes 18\n", STOPS.split_at(1).1),
    ("corner", "", &STOPS),
];

/// Stops while moves of some 130 ms, with a corner between them, are held, sped up, reset or left alone.
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
    while_moves_change(Port::Pio, 24);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn no_stop_of_the_timer_port_is_lost_while_moves_change() {
    while_moves_change(Port::Timer, 12);
}
