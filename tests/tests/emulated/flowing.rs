//! Consecutive moves streamed to the board, with corners by Grbl's rule. They must be made as the chain plans them,
//! whenever the lines come.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;

use isostep_report::compare;
use isostep_sim::run;
use isostep_sim::world::Edge;
use isostep_tests::emulated::{self, Board, Run};
use isostep_tests::root;
use isostep_trials::cases;

/// Machine C of `programs/machines`, a little faster, as settings with their values.
const MACHINE: [(u32, u32); 3] = [(100, 80), (110, 12_500), (120, 2_000)];
const MOVE_MM: f64 = 0.2;
/// The start is far from the switches, which are at the origin.
const START_MM: &str = "900,900,900";
const STEPS_PER_MM: f64 = 80.0;

/// A program that is written line by line, beginning where the machine stands.
struct Program {
    text: String,
    place_mm: [f64; 3],
    /// Number of moves of the curve so far.
    moves: u32,
    /// For each line, the number of steps of all axes up to its end.
    steps: Vec<usize>,
}

impl Program {
    fn new(feed_mm_min: u32, deviation_mm: f64) -> Self {
        let mut text = format!("$11={deviation_mm}\n");
        for (number, value) in
            MACHINE.into_iter().flat_map(|(first, value)| [0, 1, 2].map(|axis| (first + axis, value)))
        {
            writeln!(text, "${number}={value}").unwrap();
        }
        writeln!(text, "G61 G90 G17 G1 F{feed_mm_min}").unwrap();
        Self { text, place_mm: [0.0; 3], moves: 0, steps: Vec::new() }
    }

    /// Adds a line that moves each axis by `distance_mm`.
    fn line(&mut self, distance_mm: [f64; 3]) {
        let from_steps = self.place_steps();
        self.place_mm = [0, 1, 2].map(|axis| self.place_mm[axis] + distance_mm[axis]);
        let [x, y, z] = self.place_mm;
        writeln!(self.text, "G1X{x:.3}Y{y:.3}Z{z:.3}").unwrap();
        let ways = self.place_steps().into_iter().zip(from_steps).map(|(to, from)| to.abs_diff(from) as usize);
        self.steps.push(self.steps.last().unwrap_or(&0) + ways.sum::<usize>());
    }

    /// The position in steps. Lines give positions in thousandths of a millimetre.
    fn place_steps(&self) -> [i32; 3] {
        self.place_mm.map(|mm| ((mm * 1e3).round() * 1e-3 * STEPS_PER_MM).round() as i32)
    }

    /// Half a circle in X and Y.
    fn half_circle(&mut self, radius_mm: f64) {
        self.place_mm[0] += 2.0 * radius_mm;
        let [x, y, _] = self.place_mm;
        writeln!(self.text, "G2X{x:.3}Y{y:.3}I{radius_mm:.3}").unwrap();
    }

    /// A curve in three axes, in which every axis moves in both directions. Its bends are so wide that only the feed
    /// limits the speed.
    fn curve(&mut self, moves: u32) {
        for _ in 0..moves {
            let turn = f64::from(self.moves) / 400.0 * TAU;
            let (rise, flat) = (0.6 * (1.7 * turn).sin()).sin_cos();
            self.line([turn.cos() * flat, turn.sin() * flat, rise].map(|ratio| ratio * MOVE_MM));
            self.moves += 1;
        }
    }

    /// Fills the look-ahead. After that, the start and the end of the next moves are known, whenever their lines come.
    fn run_up(&mut self) {
        self.line([20.0, 0.0, 0.0]);
    }

    fn stream(&self, test: &str, options: &[&str]) -> Run {
        let path = root().join("target/emulated").join(format!("{test}.nc"));
        fs::create_dir_all(path.parent().expect("a folder")).unwrap();
        fs::write(&path, &self.text).unwrap();
        let run = Board::new(test).with(&["--start", START_MM]).with(options).program(&path);
        assert!(run.ok, "{}", run.printed);
        run
    }
}

fn lasts_s(edges: &[Edge]) -> f64 {
    (edges[edges.len() - 1].t_ns - edges[0].t_ns) as f64 * 1e-9
}

fn awake_percent(run: &Run) -> f64 {
    100.0 * run.figures["moving"]["load"].as_f64().unwrap()
}

/// At F3000, moves of 0.2 mm are 250 per second, and braking takes 3 of them. What is known beyond those depends on
/// when lines come, but changes nothing. So every edge must be where the simulation has it, on one clock from the first
/// to the last.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn flowing_moves_are_the_simulations_and_within_50_ns() {
    let mut program = Program::new(3_000, 0.01);
    program.run_up();
    let moves = cases(50, 150);
    program.curve(moves);
    program.line([0.0, 7.0, 0.0]);
    program.curve(moves);
    program.half_circle(4.0);
    program.curve(moves);
    program.line([-3.0, -1.0, 0.5]);
    program.line([3.0, 1.0, -0.5]);
    program.line([0.0, 0.0, 2.0]);
    program.curve(2 * moves);
    let emulated = program.stream("flowing", &[]);
    let simulated = run(program.text.as_bytes(), &emulated::config()).unwrap();
    let runs: BTreeSet<_> = simulated.moves.iter().map(|record| record.run).collect();
    assert_eq!(runs.len(), 1, "one clock");
    let comparison = compare::compare(&simulated, &emulated.edges).unwrap();
    let [there_s, here_s] = [&emulated.edges, &simulated.edges].map(|edges| lasts_s(edges));
    println!(
        "{} moves in {there_s:.6} s, simulated {here_s:.6} s; {} steps at most {:.1} ns off; core awake {:.1} % (emulated)",
        simulated.moves.len(),
        comparison.all.steps,
        comparison.all.max_ns,
        awake_percent(&emulated),
    );
    assert!(comparison.all.max_ns <= 50.0, "{:?}", comparison.all);
    assert!((there_s / here_s - 1.0).abs() < 1e-6, "{there_s} s, {here_s} s");
}

/// Ten seconds of moves at F12500, or three if few cases are tried, sent by counting characters. Without waits that would be
/// 1,042 moves per second. Without the first second and the last, the machine must make 1,000 per second and never come
/// near to rest. The corner deviation is large, because whole steps make the corners sharper than the curve is.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn flows_at_1000_moves_a_second() {
    let mut program = Program::new(12_500, 0.3);
    program.run_up();
    // At the end of the curve the moves slow down.
    let seconds = u64::from(cases(1, 8));
    program.curve(1_160 * (seconds as u32 + 1));
    let emulated = program.stream("flows-at-1000", &["--stream", "counting"]);
    let edges = &emulated.edges;
    assert_eq!(Some(&edges.len()), program.steps.last());
    let [first, last] =
        [1, 1 + seconds].map(|s| edges.partition_point(|edge| edge.t_ns < edges[0].t_ns + s * 1_000_000_000));
    let [begun, ended] = [first, last].map(|made| program.steps.partition_point(|&steps| steps <= made));
    let moves_s = (ended - begun) as f64 / seconds as f64;
    let gaps_ns = edges[first..last].windows(2).map(|pair| pair[1].t_ns - pair[0].t_ns);
    let gap_ms = gaps_ns.max().unwrap() as f64 * 1e-6;
    println!(
        "{moves_s:.0} moves/s, {:.3} s in all; at most {gap_ms:.2} ms without an edge; core awake {:.1} % (emulated)",
        lasts_s(edges),
        awake_percent(&emulated)
    );
    assert!(moves_s >= 1_000.0, "{moves_s} moves/s");
    // An axis takes 2.5 ms for half a step from rest, and as long to stop.
    assert!(gap_ms < 2.0, "{gap_ms} ms");
}
