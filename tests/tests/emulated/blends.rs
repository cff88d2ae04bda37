//! Corners as blends: every edge is where the simulation has it, on both ports, and nobody who interferes loses a step.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;

use isostep_report::compare;
use isostep_sim::world::Edge;
use isostep_sim::{Config, Port, run};
use isostep_tests::emulated::{self, Board, Run};
use isostep_tests::root;
use isostep_trials::cases;

/// The settings of each axis: F6000 is reached within 5 mm.
const MACHINE: [(u32, u32); 4] = [(100, 80), (110, 24_000), (120, 1_000), (910, 0)];
/// Brief moves in all axes, in a row.
fn moves() -> usize {
    cases(60, 120) as usize
}

pub fn settings() -> impl Iterator<Item = String> {
    MACHINE.into_iter().flat_map(|(first, value)| (0..3).map(move |axis| format!("${}={value}", first + axis)))
}

/// A wave of moves of 0.2 mm along X, that comes back to Y0 Z0.
pub fn wave() -> impl Iterator<Item = String> {
    (1..=moves()).map(|index| {
        let turn = index as f64 / moves() as f64 * TAU * 4.0;
        let [y, z] = [turn.sin(), 1.0 - turn.cos()];
        format!("X{:.4}Y{:.4}Z{:.4}", 20.0 + 0.2 * index as f64, y + 10.0, 0.5 * z)
    })
}

fn program() -> String {
    let begin = settings().chain(["G64 P0.05 G1 F6000 X20 Y10".into()]);
    let turns =
        ["X60", "Y0 F2000", "X50 Y6", "X52 Y-4", "G64", "G2 X56 I2 F6000", "G64 P0.2", "G1 X70", "G3 Y6 J5", "G1 X0"];
    begin.chain(wave()).chain(turns.map(String::from)).fold(String::new(), |text, line| text + &line + "\n")
}

/// Streams a program to the board, from far enough from the switches.
pub fn streamed(name: &str, port: Port, program: &str) -> Run {
    let test = format!("{name}-{port}");
    let path = root().join("target/emulated").join(format!("{test}.nc"));
    fs::create_dir_all(path.parent().expect("a folder")).unwrap();
    fs::write(&path, program).unwrap();
    let board = Board::stepped_by(port, &test).with(&["--start", "300,300,300", "--stream", "counting"]);
    let emulated = board.program(&path);
    assert!(emulated.ok, "{port}: {}", emulated.printed);
    emulated
}

fn are_exact(port: Port, jitter_max_ns: f64) {
    let emulated = streamed("blends", port, &program());
    let simulated = run(program().as_bytes(), &Config { port, ..emulated::config() }).unwrap();
    let blends = simulated.moves.iter().filter(|record| record.blend.is_some()).count();
    let comparison = compare::compare(&simulated, &emulated.edges).unwrap();
    println!("{port}: {blends} blends, edges at most {:.0} ns off (emulated)", comparison.all.max_ns);
    assert!(blends > moves(), "{blends} blends");
    assert!(comparison.all.max_ns <= jitter_max_ns, "{port}: {:?}", comparison.all);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn blends_are_where_the_simulation_has_them() {
    are_exact(Port::Pio, 50.0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn blends_by_the_timer_port_are_where_the_simulation_has_them() {
    are_exact(Port::Timer, 20_000.0);
}

/// Overrides up to 200 %, a hold among short blends, and a resume: no alarm, and no step lost.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn blends_are_overridden_and_held() {
    overridden_and_held(Port::Pio);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn blends_by_the_timer_port_are_overridden_and_held() {
    overridden_and_held(Port::Timer);
}

fn overridden_and_held(port: Port) {
    let begin = settings().chain(["G64 P0.05 G1 F3000 X20 Y10".into()]);
    let mut script = "expect Grbl\n".to_owned();
    let changes = ["91 91 91 91 91 91 91 91 91 91", "21\nwait-ms 500\nbytes 7e", "90", "92 92 92 92 92", "90"];
    let mut changes = changes.into_iter().cycle();
    for (index, line) in begin.chain(wave()).chain(["X50Y5Z1".into()]).enumerate() {
        writeln!(script, "send {line}\nexpect ok").unwrap();
        if index % 15 == 14 {
            writeln!(script, "bytes {}", changes.next().unwrap()).unwrap();
        }
    }
    script += "wait-idle\nbytes 3f\nexpect <Idle|MPos:50.000,5.000,1.000\n";
    let run = Board::stepped_by(port, &format!("blends-changed-{port}")).script(&script);
    assert!(run.ok, "{port}: {}", run.printed);
}

/// Pieces of a line that go straight on need no time for a blend, and may be briefer than the board plans any. Between bends,
/// nothing is late and no step is lost: where the moves that are known run short, the machine brakes.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn brief_pieces_of_lines_between_bends_are_made_in_time() {
    let straight = [[0.037_5, 0.0]; 8];
    let zigzag = (0..cases(40, 80))
        .flat_map(|index| straight.into_iter().chain([[0.1, if index % 2 == 0 { 0.012_5 } else { -0.012_5 }]]));
    let lines: Vec<_> = zigzag.map(|[x, y]| format!("X{x}Y{y}")).collect();
    for (name, words) in [("brief-pieces", "G64 P0.05 Q0"), ("brief-pieces-together", "G64 P0.05")] {
        let begin = (0..3).map(|axis| format!("${}=10000", 120 + axis)).chain([format!("{words} G91 G1 F6000 X20")]);
        let all = settings().chain(begin).chain(lines.iter().cloned());
        let program = all.fold(String::new(), |text, line| text + &line + "\n");
        let simulated = run(program.as_bytes(), &emulated::config()).unwrap();
        let emulated = streamed(name, Port::Pio, &program);
        let lasts_s = |edges: &[Edge]| (edges[edges.len() - 1].t_ns - edges[0].t_ns) as f64 * 1e-9;
        let [there_s, here_s] = [&emulated.edges, &simulated.edges].map(|edges| lasts_s(edges));
        println!("{} moves in {there_s:.3} s, and in {here_s:.3} s without waits (emulated)", simulated.moves.len());
        let place =
            |edges: &[Edge], axis| edges.iter().rev().find(|edge| edge.axis == axis).map(|edge| edge.position_steps);
        (0..2).for_each(|axis| assert_eq!(place(&emulated.edges, axis), place(&simulated.edges, axis), "{name}"));
        // Which moves are taken together depends on when their lines come.
        assert!(name != "brief-pieces" || emulated.edges.len() == simulated.edges.len(), "{name}");
    }
}
