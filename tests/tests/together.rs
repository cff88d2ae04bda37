//! Short moves that are taken together: paths of short chords are smooth, lie where they were asked for, and keep every limit, and
//! whatever interferes loses no step. Places and speeds are those of the edges alone, distances those from the program's points.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use embassy_time::Duration;
use isostep_motion::{AXES, State};
use isostep_sim::measure::across;
use isostep_sim::{Config, Outcome, Sim, verify};
use isostep_tests::bench::all_cases;
use isostep_trials::{cases_that_count, stride};
use oorandom::Rand64;

use crate::talk::powered_up;

/// The deviation of the corners.
const DEVIATION_MM: f64 = 0.01;
/// A place on the path is compared with what was asked for so many lines before and behind.
const NEAR: usize = 4;
/// By what fraction the edges may show more than a limit that is kept.
const GRAIN: f64 = 0.02;

type Place = [f64; 2];

/// A fast machine whose travel is ample.
fn machine(steps_per_mm: f32, more: &str) -> Config {
    let mut config = Config::default();
    let settings = &mut config.settings;
    (settings.soft_limits, settings.hard_limits, settings.homing) = (false, false, false);
    settings.steps_per_mm = [steps_per_mm; AXES];
    settings.max_rate_mm_min = [12_000.0; AXES];
    settings.accel_mm_s2 = [2_000.0; AXES];
    settings.travel_mm = [10_000.0; AXES];
    settings.blend_deviation_mm = DEVIATION_MM as f32;
    for line in more.lines() {
        let (number, value) = line[1..].split_once('=').unwrap();
        assert!(settings.set(number.parse().unwrap(), value.parse().unwrap()), "{line}");
    }
    config
}

/// The program of a path, on which feeds are `feed_mm_min`.
fn program(path: &[Place], feed_mm_min: u32) -> String {
    let [x, y] = path[0];
    let mut lines = format!("G90 G0 X{x:.4} Y{y:.4}\nG1 F{feed_mm_min}\n");
    for [x, y] in &path[1..] {
        writeln!(lines, "X{x:.4} Y{y:.4}").unwrap();
    }
    lines
}

fn circle(r_mm: f64, chord_mm: f64, turns: f64) -> Vec<Place> {
    let chords = (TAU * r_mm * turns / chord_mm).round() as usize;
    let at = |index: usize| {
        let (sin, cos) = (index as f64 * chord_mm / r_mm).sin_cos();
        [r_mm * cos, r_mm * sin]
    };
    (0..=chords).map(at).collect()
}

/// A straight line whose points are beside it by as much as a CAM program rounds, or a probe is off.
fn noisy(points: usize, chord_mm: f64, noise_mm: f64) -> Vec<Place> {
    let mut random = Rand64::new(1);
    let mut off_mm = || between(&mut random, [-noise_mm, noise_mm]);
    (0..points).map(|index| [index as f64 * chord_mm + off_mm(), off_mm()]).collect()
}

fn made(config: &Config, lines: &str) -> Outcome {
    let mut sim = powered_up(config);
    sim.send(lines.as_bytes());
    sim.run_until_idle().unwrap();
    judged(&sim, lines)
}

/// What a machine has made, of which every promise must be kept. Steps are not lost here, because there is no motor.
fn judged(sim: &Sim, name: &str) -> Outcome {
    let outcome = sim.outcome();
    for verdict in verify::verdicts(&outcome, &verify::moves(&outcome).collect()) {
        let is_of_motors = ["no step lost", "final position exact"].contains(&verdict.promise);
        assert!(verdict.kept || is_of_motors, "{} {}, {name}", verdict.promise, verdict.detail);
    }
    outcome
}

/// The places of the first two axes, mm, each at its edges, which are half a step from whole ones, and between them in proportion.
struct Seen {
    edges: [Vec<(f64, f64)>; 2],
}

impl Seen {
    fn of(outcome: &Outcome) -> Self {
        let edges = [0, 1].map(|axis| {
            let of_axis = outcome.edges.iter().filter(|edge| edge.axis == axis);
            let at = |edge: &isostep_sim::world::Edge| {
                let steps = f64::from(edge.position_steps) - 0.5 * f64::from(edge.direction);
                (edge.t_ns as f64 * 1e-9, steps / outcome.steps_per_mm[axis])
            };
            of_axis.map(at).collect()
        });
        Self { edges }
    }

    fn at(&self, t_s: f64) -> Place {
        [0, 1].map(|axis| {
            let edges = &self.edges[axis];
            if edges.len() < 2 {
                return 0.0;
            }
            let after = edges.partition_point(|edge| edge.0 <= t_s).clamp(1, edges.len() - 1);
            let [(from_s, from), (to_s, to)] = [edges[after - 1], edges[after]];
            from + (to - from) * ((t_s - from_s) / (to_s - from_s)).clamp(0.0, 1.0)
        })
    }

    /// The speeds over `span_s`, at instants of a part of the time from the last rest on.
    fn speeds_mm_s(&self, [from_s, to_s]: [f64; 2], span_s: f64) -> Vec<f64> {
        let mut speeds = Vec::new();
        let mut t_s = from_s;
        while t_s + span_s < to_s {
            let [one, other] = [self.at(t_s), self.at(t_s + span_s)];
            speeds.push(distance(one, other) / span_s);
            t_s += span_s / 2.0;
        }
        speeds
    }
}

fn distance([x, y]: Place, [other_x, other_y]: Place) -> f64 {
    (x - other_x).hypot(y - other_y)
}

/// The mean, and how far the speeds are from it, as the root of the mean square, as a fraction of it.
fn ripple(speeds_mm_s: &[f64]) -> [f64; 2] {
    let mean =
        |of: &dyn Fn(f64) -> f64| speeds_mm_s.iter().map(|&mm_s| of(mm_s)).sum::<f64>() / speeds_mm_s.len() as f64;
    let mean_mm_s = mean(&|mm_s| mm_s);
    [mean_mm_s, mean(&|mm_s| (mm_s / mean_mm_s - 1.0).powi(2)).sqrt()]
}

/// A part of the time of the program's moves but the first, which goes to where the path begins, s.
fn middle_s(outcome: &Outcome, [from, to]: [f64; 2]) -> [f64; 2] {
    let [begin_s, end_s] = [1, outcome.moves.len() - 1].map(|index| outcome.moves[index].begin_ns() as f64 * 1e-9);
    [from, to].map(|part| begin_s + part * (end_s - begin_s))
}

fn together(outcome: &Outcome) -> verify::Together {
    verify::moves(outcome).collect::<verify::Findings>().together()
}

/// With 0.002 mm of noise on chords of 0.05 mm a path from point to point would go at 26 to 51 mm/s, at full acceleration all the
/// time.
#[test]
fn noise_of_the_points_is_none_of_the_speed() {
    for steps_per_mm in [80.0, 1_000.0] {
        let outcome = made(&machine(steps_per_mm, ""), &program(&noisy(3_000, 0.05, 0.002), 12_000));
        let found = together(&outcome);
        assert!(found.moves > 2_990 && found.lines < 200 && found.farthest_mm < 0.0075, "{found:?}");
        let seen = Seen::of(&outcome);
        let [mean_mm_s, ripple] = ripple(&seen.speeds_mm_s(middle_s(&outcome, [0.3, 0.8]), 4e-3));
        println!("{steps_per_mm} steps/mm: {mean_mm_s:.1} mm/s, {:.2} % of ripple", ripple * 100.0);
        assert!(mean_mm_s > 155.0 && ripple < 0.015, "{mean_mm_s} mm/s, ripple of {ripple}");
        // A speed that does not change asks for no acceleration, but for that of the noise which is left.
        let [from_s, to_s] = middle_s(&outcome, [0.3, 0.8]).map(|s| s * 1e9);
        let of_middle = across::windows(&outcome)
            .filter(|window| (from_s..to_s).contains(&(window.at_ns as f64)))
            .map(|window| window.ratio);
        let most = of_middle.fold(0.0, f64::max);
        assert!(most < 0.35, "{most} of an acceleration, {steps_per_mm} steps/mm");
    }
}

/// Chords of a circle are inside it, and so were the lines and blends that they were made as. The mean of the path is on the points.
#[test]
fn a_circle_of_chords_is_as_large_as_it_was_asked_for_and_evenly_fast() {
    for (r_mm, chord_mm, turns, feed_mm_min) in [
        (10.0, 0.1, 3.0, 6_000),
        (10.0, 0.05, 3.0, 5_400),
        (1.0, 0.05, 12.0, 2_400),
        (1.0, 0.01, 8.0, 900),
        (0.2, 0.01, 30.0, 600),
    ] {
        for steps_per_mm in [80.0, 1_000.0] {
            let name = format!("r {r_mm}, chords {chord_mm}, {steps_per_mm} steps/mm");
            let outcome = made(&machine(steps_per_mm, ""), &program(&circle(r_mm, chord_mm, turns), feed_mm_min));
            let seen = Seen::of(&outcome);
            let [from_s, to_s] = middle_s(&outcome, [0.3, 0.9]);
            let [mean_mm_s, ripple] = ripple(&seen.speeds_mm_s([from_s, to_s], 4e-3));
            let instants = 20_000;
            let off_mm = (0..instants).map(|index| {
                let [x, y] = seen.at(from_s + (to_s - from_s) * f64::from(index) / f64::from(instants));
                x.hypot(y) - r_mm
            });
            let mean_off_mm = off_mm.sum::<f64>() / f64::from(instants);
            println!("{name}: {mean_mm_s:.2} mm/s, {:.2} % of ripple, {:.2} um off", ripple * 100.0, mean_off_mm * 1e3);
            assert!((mean_mm_s * 60.0 / f64::from(feed_mm_min) - 1.0).abs() < 0.02, "{name}: {mean_mm_s} mm/s");
            // Between edges of 80 steps/mm places are good to a part of a step only.
            let off_max_mm = if steps_per_mm == 80.0 { 2e-3 } else { 0.6e-3 };
            assert!(ripple < 0.015, "{name}: ripple of {ripple}");
            assert!(mean_off_mm.abs() < off_max_mm, "{name}: {mean_off_mm} mm");
        }
    }
}

#[test]
fn q_says_how_far_lines_may_be_beside_their_points() {
    let path = program(&circle(2.0, 0.02, 2.0), 6_000);
    let of = |words: &str| made(&machine(400.0, ""), &format!("{words}\n{path}"));
    for words in ["G61", "G64 P0", "G64 P0.01 Q0"] {
        assert_eq!(together(&of(words)).lines, 0, "{words}");
    }
    let with = ["G64 P0.02 Q0.001", "G64 P0.02 Q0.004", "G64 P0.02", "G64 P0.02 Q9"].map(|words| together(&of(words)));
    for (found, allowed_mm) in with.iter().zip([0.001, 0.004, 0.01, 0.01]) {
        assert!((found.allowed_mm - allowed_mm).abs() < 1e-8 && found.beyond == 0 && found.lines > 0, "{found:?}");
    }
    assert_eq!(with[2], with[3], "half of P at most");
    assert!(with[0].lines > with[1].lines, "{with:?}");
    let outcome = of("G64 P0.02");
    let none = of("G64 P0.02 Q0");
    assert!(outcome.motion_s < 0.7 * none.motion_s, "{} s, {} s without", outcome.motion_s, none.motion_s);
}

fn between(random: &mut Rand64, [from, to]: [f64; 2]) -> f64 {
    from + (to - from) * random.rand_float()
}

fn one_of<T: Copy>(random: &mut Rand64, values: &[T]) -> T {
    values[random.rand_range(0..values.len() as u64) as usize]
}

/// A random path in three axes, its lines, and where it ends, mm.
struct Path {
    lines: String,
    end_mm: [f64; 3],
}

impl Path {
    /// Curves, noise, corners and longer moves, with and without blends, dwells, and a laser.
    fn random(random: &mut Rand64, with_laser: bool) -> Self {
        let (mut lines, mut place_mm) = (String::from("G90 G1 F6000\n"), [0.0_f64; 3]);
        let mut heading: f64 = 0.0;
        for _ in 0..random.rand_range(2..8) {
            let chord_mm = one_of(random, &[0.005, 0.02, 0.05, 0.1, 0.3]);
            let noise_mm = one_of(random, &[0.0, 0.0, 0.001, 0.003, 0.02]);
            let turn = between(random, [-1.5, 1.5]) * chord_mm;
            let rise = one_of(random, &[0.0, 0.0, 1.0]) * between(random, [-0.3, 0.3]);
            match random.rand_range(0..8) {
                0 => lines += "G61\n",
                1 => lines += "G64\n",
                2 => {
                    let [p_mm, q_mm] = [between(random, [0.002, 0.1]), between(random, [0.0, 0.05])];
                    writeln!(lines, "G64 P{p_mm:.3} Q{q_mm:.3}").unwrap();
                }
                3 => lines += "G4 P0.01\n",
                4 => writeln!(lines, "F{}", random.rand_range(300..12_000)).unwrap(),
                5 => heading += between(random, [-3.0, 3.0]),
                6 => writeln!(lines, "G64 P{:.3}", between(random, [0.002, 0.1])).unwrap(),
                _ => {}
            }
            for index in 0..random.rand_range(1..250) {
                heading += turn;
                let mut noise = || between(random, [-noise_mm, noise_mm]);
                let along = [heading.cos(), heading.sin(), rise];
                let to_mm: [f64; 3] = std::array::from_fn(|axis| place_mm[axis] + chord_mm * along[axis]);
                let asked: [f64; 3] = std::array::from_fn(|axis| ((to_mm[axis] + noise()) * 1e4).round() / 1e4);
                place_mm = to_mm;
                let power = if with_laser { format!(" S{}", 100 + 37 * (index % 20)) } else { String::new() };
                writeln!(lines, "X{:.4} Y{:.4} Z{:.4}{power}", asked[0], asked[1], asked[2]).unwrap();
            }
        }
        // Whole steps of every machine here.
        let end_mm = [place_mm[0] + 3.0, place_mm[1], place_mm[2]].map(|mm| (mm * 10.0).round() / 10.0);
        writeln!(lines, "G1 X{:.4} Y{:.4} Z{:.4}", end_mm[0], end_mm[1], end_mm[2]).unwrap();
        Self { lines, end_mm }
    }
}

/// The farthest that an edge is from the points and lines that were asked for around it, mm, above what is allowed there: the
/// deviation, half a step of each axis because edges are whole steps, and as much because a move that nothing follows yet is planned to
/// whole steps.
fn farthest_above_mm(outcome: &Outcome) -> f64 {
    let mm =
        |steps: [f64; AXES]| -> [f64; AXES] { std::array::from_fn(|axis| steps[axis] / outcome.steps_per_mm[axis]) };
    let mut points = vec![(mm([0.0; AXES]), 0.0)];
    let mut firsts = Vec::new();
    for record in &outcome.moves {
        firsts.push(points.len() - 1);
        for asked in &record.asked {
            let place = std::array::from_fn(|axis| {
                f64::from(asked.target_steps[axis]) + f64::from(asked.offsets[axis]) / 128.0
            });
            points.push((mm(place), f64::from(asked.deviation_mm)));
        }
    }
    firsts.push(points.len() - 1);
    let grain_mm = size(&mm([1.0; AXES]));
    let (mut steps, mut above_mm) = ([0.0; AXES], f64::MIN);
    for (index, record) in outcome.moves.iter().enumerate() {
        let near =
            firsts[index.saturating_sub(NEAR)]..firsts[(index + NEAR).min(firsts.len() - 1)].min(points.len() - 1);
        for edge in outcome.edges_of(record) {
            steps[edge.axis] = f64::from(edge.position_steps);
            let place = mm(steps);
            let above = near.clone().map(|line| {
                // A move's deviation is that of the corner where it begins.
                let allowed_mm = points[line + 1].1.max(points.get(line + 2).map_or(0.0, |next| next.1));
                from_line(&place, &points[line].0, &points[line + 1].0) - allowed_mm - grain_mm
            });
            above_mm = above_mm.max(above.fold(f64::INFINITY, f64::min));
        }
    }
    above_mm
}

fn size(of: &[f64; AXES]) -> f64 {
    of.iter().map(|each| each * each).sum::<f64>().sqrt()
}

fn from_line(place: &[f64; AXES], from: &[f64; AXES], to: &[f64; AXES]) -> f64 {
    let [along, off]: [[f64; AXES]; 2] = [to, place].map(|each| std::array::from_fn(|axis| each[axis] - from[axis]));
    let product: f64 = (0..AXES).map(|axis| along[axis] * off[axis]).sum();
    let square = size(&along).powi(2);
    let ratio = if square > 0.0 { (product / square).clamp(0.0, 1.0) } else { 0.0 };
    size(&std::array::from_fn(|axis| off[axis] - ratio * along[axis]))
}

/// A random machine for a path, and the path.
fn random_case(case: u64) -> (Config, Path) {
    let mut random = Rand64::new(case.into());
    let steps_per_mm = one_of(&mut random, &[80.0, 250.0, 1_000.0]);
    let (laser, shaper) = (random.rand_range(0..4) == 0, random.rand_range(0..6));
    let accels: String = (120..123).fold(String::new(), |mut lines, number| {
        writeln!(lines, "${number}={}", one_of(&mut random, &[300, 1_000, 3_000])).unwrap();
        lines
    });
    let shaping = match shaper {
        0 => "$950=1\n$960=40\n$951=2\n$961=60\n",
        1 => "$950=5\n$951=5\n$960=100\n$961=100\n",
        _ => "",
    };
    let mut path = Path::random(&mut random, laser);
    if laser {
        path.lines.insert_str(0, "M4 S0\n");
    }
    let config = machine(steps_per_mm, &format!("{accels}{shaping}$11=0\n$32={}", u8::from(laser)));
    (config, path)
}

/// With `$11` at 0 a corner without a blend is a stop, so that no speed jumps anywhere.
#[test]
fn random_paths_of_short_moves_keep_deviation_and_limits() {
    let (mut lines, mut moves) = (0, 0);
    let name = "random_paths_of_short_moves_keep_deviation_and_limits";
    let are_all = all_cases("together", name, cases_that_count(60, 10_000).into(), |case| {
        let (config, path) = random_case(case);
        let outcome = made(&config, &path.lines);
        assert!(outcome.refusals.is_empty(), "case {case}: {:?}", outcome.refusals);
        let expected = path.end_mm.map(|mm| (mm * f64::from(config.settings.steps_per_mm[0])).round() as i32);
        assert_eq!(outcome.counted_steps[..3], expected, "case {case}");
        let found = together(&outcome);
        (lines, moves) = (lines + found.lines, moves + found.moves);
        let most = across::highest(&outcome).expect("moves");
        assert!(most.ratio < 1.0 + GRAIN, "case {case}: {most:?}");
        if !path.lines.is_empty() && outcome.moves.iter().all(|record| record.shaping.is_none()) {
            let above_mm = farthest_above_mm(&outcome);
            assert!(above_mm < 1e-4, "case {case}: {above_mm} mm beyond the deviation");
        }
    });
    println!("{moves} moves as {lines} lines");
    assert!(!are_all || moves > 3 * lines, "{moves} moves as {lines} lines");
}

/// Holds, overrides, resets and the door, at instants all over a path that is taken together.
#[test]
fn whatever_interferes_with_moves_taken_together_loses_no_step() {
    let lines = program(&circle(3.0, 0.03, 2.0), 4_800);
    let whole = made(&machine(250.0, ""), &lines);
    let (end, lasts_ms) = (whole.counted_steps, (whole.motion_s * 1e3) as u64);
    let [mut held, mut off] = [0; 2];
    for (at_ms, act) in (20..lasts_ms).step_by(stride(5)).zip((0..5).cycle()) {
        let name = format!("act {act} at {at_ms} ms");
        let mut sim = powered_up(&machine(250.0, ""));
        sim.send(lines.as_bytes());
        sim.run_for(Duration::from_millis(at_ms)).unwrap();
        match act {
            0 | 1 => {
                sim.send(b"!");
                sim.run_until_state(|state| matches!(state, State::Idle | State::Hold { still: true })).unwrap();
                let still = sim.counted_steps();
                held += usize::from(sim.machine().state() == State::Hold { still: true });
                sim.run_for(Duration::from_millis(300)).unwrap();
                assert_eq!(sim.counted_steps(), still, "{name}");
                // On the path of the points: beyond the way there, on the circle.
                let [x, y] = [0, 1].map(|axis| f64::from(still[axis]) / 250.0);
                let beside_mm = (x.hypot(y) - 3.0).abs();
                if sim.outcome().moves.len() > 2 {
                    assert!(beside_mm < DEVIATION_MM + 0.003, "{name}: {beside_mm} mm beside the circle");
                    off += 1;
                }
                sim.send(b"~");
                if act == 1 {
                    sim.run_for(Duration::from_millis(30)).unwrap();
                    sim.send(b"!");
                    sim.run_until_state(|state| matches!(state, State::Idle | State::Hold { still: true })).unwrap();
                    sim.send(b"~");
                }
                sim.run_until_idle().unwrap();
                assert_eq!(sim.counted_steps(), end, "{name}");
            }
            2 | 3 => {
                sim.send(if act == 2 { &[0x92, 0x92, 0x92] } else { &[0x91, 0x91, 0x91, 0x91, 0x91] });
                sim.run_until_idle().unwrap();
                assert_eq!(sim.counted_steps(), end, "{name}");
            }
            _ => {
                sim.send(&[0x18]);
                sim.run_until_state(|state| matches!(state, State::Idle | State::Alarm(_))).unwrap();
                sim.run_for(Duration::from_millis(100)).unwrap();
                let still = sim.counted_steps();
                assert_eq!(sim.machine().position_steps(), still, "{name}");
                sim.send(b"$X\nG90 G1 F3000 X1 Y1\n");
                sim.run_until_idle().unwrap();
                assert_eq!(sim.counted_steps()[..2], [250, 250], "{name}");
            }
        }
        let outcome = judged(&sim, &name);
        let most = across::highest(&outcome).expect("moves");
        assert!(most.ratio < 1.0 + GRAIN, "{name}: {most:?}");
    }
    assert!(held > 5 && off > 4, "{held} held, {off} of them on the circle");
}
