//! Shaped runs: every edge is where the simulation has it, on both ports, and nobody who interferes loses a step.

use std::fmt::Write as _;

use isostep_sim::world::Edge;
use isostep_sim::{AXES, Config, Port, run};
use isostep_tests::emulated::{self, Board};

use super::blends::{settings, streamed, wave};

/// ZV, EI and MZV; their frequencies and damping ratios.
const SHAPERS: [&str; 9] =
    ["$950=1", "$951=4", "$952=2", "$960=40", "$961=35", "$962=60", "$970=0.1", "$971=0.05", "$972=0.02"];
/// A gap between two edges that is a standstill, ns.
const STANDSTILL_NS: u64 = 100_000_000;

fn begin() -> impl Iterator<Item = String> {
    settings().chain(SHAPERS.map(String::from)).chain(["G64 P0.05 G1 F3000 X20 Y10".into()])
}

fn program() -> String {
    let turns =
        ["X60", "Y0 F2000", "X50 Y6", "X52 Y-4", "G61", "X54", "G64", "G2 X58 I2", "G4 P0.3", "G1 X70", "X0 Y0"];
    begin().chain(wave()).chain(turns.map(String::from)).fold(String::new(), |text, line| text + &line + "\n")
}

/// The instants of an axis, each from the first edge of any axis after a standstill, and its direction.
fn instants(edges: &[Edge], axis: usize) -> Vec<(u64, i32)> {
    let (mut start_ns, mut last_ns) = (0, None);
    let mut instants = Vec::new();
    for edge in edges {
        if last_ns.is_none_or(|last_ns| edge.t_ns > last_ns + STANDSTILL_NS) {
            start_ns = edge.t_ns;
        }
        last_ns = Some(edge.t_ns);
        if edge.axis == axis {
            instants.push((edge.t_ns - start_ns, edge.direction));
        }
    }
    instants
}

/// The largest distance of an edge from where it should be, ns. All of them are there, and in their directions.
pub fn off_at_most_ns(made: &[Edge], should: &[Edge]) -> u64 {
    let mut worst_ns = 0;
    for axis in 0..AXES {
        let [made, should] = [made, should].map(|edges| instants(edges, axis));
        assert_eq!(made.len(), should.len(), "axis {axis}");
        for (made, should) in made.iter().zip(&should) {
            assert_eq!(made.1, should.1, "axis {axis}");
            worst_ns = worst_ns.max(made.0.abs_diff(should.0));
        }
    }
    worst_ns
}

fn are_exact(port: Port, off_max_ns: u64) {
    let emulated = streamed("shaped", port, &program());
    let simulated = run(program().as_bytes(), &Config { port, ..emulated::config() }).unwrap();
    let worst_ns = off_at_most_ns(&emulated.edges, &simulated.edges);
    println!("{port}: edges of shaped runs at most {worst_ns} ns off (emulated)");
    assert!(worst_ns <= off_max_ns, "{port}: {worst_ns} ns");
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn shaped_runs_are_where_the_simulation_has_them() {
    are_exact(Port::Pio, 50);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn shaped_runs_by_the_timer_port_are_where_the_simulation_has_them() {
    are_exact(Port::Timer, 20_000);
}

/// Overrides, holds and resumes among short moves, and a reset in the middle: no alarm, and no step lost.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn shaped_runs_are_overridden_held_and_reset() {
    overridden_held_and_reset(Port::Pio);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn shaped_runs_by_the_timer_port_are_overridden_held_and_reset() {
    overridden_held_and_reset(Port::Timer);
}

fn overridden_held_and_reset(port: Port) {
    let mut script = "expect Grbl\n".to_owned();
    let changes = ["91 91 91 91 91", "21\nwait-ms 500\nbytes 7e", "90", "92 92 92 92", "90"];
    let mut changes = changes.into_iter().cycle();
    for (index, line) in begin().chain(wave()).chain(["X50Y5Z1".into()]).enumerate() {
        writeln!(script, "send {line}\nexpect ok").unwrap();
        if index % 15 == 14 {
            writeln!(script, "bytes {}", changes.next().unwrap()).unwrap();
        }
    }
    script += "wait-idle\nbytes 3f\nexpect <Idle|MPos:50.000,5.000,1.000\n";
    script += "send G1 X10 Y20 F3000\nexpect ok\nwait-ms 300\nbytes 18\nexpect Grbl\nwait-idle\n";
    script += "send G1 X12 Y21 F3000\nexpect ok\nwait-idle\nbytes 3f\nexpect <Idle|MPos:12.000,21.000,1.000\n";
    let run = Board::stepped_by(port, &format!("shaped-changed-{port}")).script(&script);
    assert!(run.ok, "{port}: {}", run.printed);
    for (axis, steps) in [("X", 12 * 80), ("Y", 21 * 80), ("Z", 80)] {
        assert_eq!(run.figures["axes"][axis]["position_steps"], steps, "{port}: {axis}");
    }
}
