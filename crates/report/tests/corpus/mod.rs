//! Programs of other people, planned with blends: how long they take beside Grbl, how far that is from the fastest on the
//! same path, and whether every axis keeps its limits. The programs are not part of the project: `ISOSTEP_CORPUS` names a
//! folder with `grbl_times.csv` and `lines/`. Without it there is nothing to test.

mod two_passes;

use std::collections::BTreeMap;
use std::path::PathBuf;

use isostep_console::Settings;
use isostep_motion::{AXES, Config, Move};
use isostep_profile::chain::{Chain, ChainConfig, Chunk, Effort, Plan, Request};
use isostep_profile::{IntervalSplit, Limits, OFFSET_PARTS, SpeedProfile};
use isostep_report::fastest::Path;

/// The distance by which blends may leave a corner, mm.
const DEVIATION_MM: f32 = 0.01;
/// The least time that a move lasts on the emulated board with shapers, and with boxes, s (`least_times` of isostep-controller);
/// a standstill lasts as much longer as the shaper is long: a ZV of 40 Hz, a box of 10 ms.
const CARRIED: [(&str, f64, f64); 3] =
    [("blends", 0.98e-3, 0.0), ("with ZV", 1.64e-3, 12.5e-3), ("with a box", 3.6e-3, 10e-3)];
/// The number of moves of a program that are planned offline, and in a chain that knows all of them.
const OFFLINE_MOVES: usize = 700;
/// The number of moves that the controller knows ahead.
const KNOWN: usize = 64;

/// A machine of `grbl_times.csv`; its axes are alike.
pub struct Machine {
    name: &'static str,
    steps_per_mm: f64,
    top_mm_s: f64,
    accel_mm_s2: f64,
}

const MACHINES: [Machine; 3] = [
    Machine { name: "A", steps_per_mm: 50.0, top_mm_s: 48.0, accel_mm_s2: 50.0 },
    Machine { name: "B", steps_per_mm: 80.0, top_mm_s: 5000.0 / 60.0, accel_mm_s2: 500.0 },
    Machine { name: "C", steps_per_mm: 80.0, top_mm_s: 200.0, accel_mm_s2: 2000.0 },
];

impl Machine {
    fn limits(&self) -> Limits {
        Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: self.top_mm_s * self.steps_per_mm,
            accel_steps_s2: self.accel_mm_s2 * self.steps_per_mm,
            decel_steps_s2: self.accel_mm_s2 * self.steps_per_mm,
            jerk_steps_s3: f64::INFINITY,
        }
    }

    fn config(&self) -> Config {
        let config = isostep_controller::config(&Settings::DEFAULT);
        Config { limits: [self.limits(); AXES], steps_per_mm: [self.steps_per_mm; AXES], ..config }
    }
}

/// The moves of a program of G0 and G1 lines, with every feed, or with that of 12,000 mm/min.
fn moves(text: &str, steps_per_mm: f64, is_top: bool) -> Vec<Move> {
    let (mut at, mut target, mut feed, mut is_rapid) = ([0; AXES], [0.0; AXES], 0.0, true);
    let mut moves = Vec::new();
    for line in text.lines() {
        let mut moves_on = false;
        for word in line.split_whitespace() {
            let value: f64 = word[1..].parse().unwrap();
            match (&word[..1], value) {
                ("G", 0.0) => is_rapid = true,
                ("G", 1.0) => is_rapid = false,
                ("F", _) => feed = if is_top { 200.0 } else { value / 60.0 },
                ("X" | "Y" | "Z", _) => {
                    target["XYZ".find(&word[..1]).unwrap()] = value;
                    moves_on = true;
                }
                _ => {}
            }
        }
        let steps = target.map(|mm| (mm * steps_per_mm).round() as i32);
        let offsets = target
            .map(|mm| ((mm * steps_per_mm - (mm * steps_per_mm).round()) * f64::from(OFFSET_PARTS)).round() as i8);
        if moves_on && steps != at {
            let feed_mm_s = if is_rapid { f64::INFINITY } else { feed };
            moves.push(Move { offsets, feed_mm_s, deviation_mm: DEVIATION_MM, ..Move::to(steps) });
            at = steps;
        }
    }
    moves
}

/// The figures of a program in the chain.
#[derive(Debug, Default)]
struct Made {
    total_s: f64,
    blends: usize,
    /// The largest acceleration and speed of an axis over its limit, and the largest jump of speed.
    accel: f64,
    speed: f64,
    jump_mm_s: f64,
}

struct Watch<'a> {
    machine: &'a Machine,
    made: Made,
    speeds_mm_s: [f64; AXES],
}

impl Watch<'_> {
    fn see(&mut self, chunk: &Chunk<AXES>, from_s: f64) {
        let mm = |steps: f64| steps / self.machine.steps_per_mm;
        let speeds: [[f64; AXES]; 2] = match &chunk.plan {
            Plan::Line(line) => {
                let profile = line.profile;
                let ends = [from_s.max(line.begin_s()), chunk.until_s].map(|t_s| {
                    if t_s >= line.end_s() {
                        profile.exit_speed_steps_s()
                    } else {
                        line.speed_at(t_s.max(line.end_s() - profile.duration_s()))
                    }
                });
                let shares: [f64; AXES] = std::array::from_fn(|axis| line.axis_steps(axis) / line.distance_steps());
                let fastest = shares.iter().map(|share| mm(profile.cruise_speed_steps_s() * share.abs()));
                self.made.speed = fastest.fold(self.made.speed, |most, mm_s| most.max(mm_s / self.machine.top_mm_s));
                ends.map(|steps_s| shares.map(|share| mm(steps_s * share)))
            }
            Plan::Blend(blend) => {
                self.made.blends += 1;
                let accels = (0..AXES).map(|axis| mm(blend.accel_steps_s2(axis).abs()));
                self.made.accel =
                    accels.fold(self.made.accel, |most, mm_s2| most.max(mm_s2 / self.machine.accel_mm_s2));
                [blend.begin_s(), blend.end_s()].map(|t_s| std::array::from_fn(|axis| mm(blend.speed_at(axis, t_s))))
            }
        };
        for (mm_s, before_mm_s) in speeds[0].iter().zip(self.speeds_mm_s) {
            self.made.jump_mm_s = self.made.jump_mm_s.max((mm_s - before_mm_s).abs());
        }
        self.speeds_mm_s = speeds[1];
    }
}

fn make(machine: &Machine, moves: &[Move], deviation_mm: f32) -> Made {
    make_carried::<KNOWN>(machine, moves, deviation_mm, 0.0)
}

/// The same where no move may last less than `move_s`, and so many are known ahead.
fn make_carried<const AHEAD: usize>(machine: &Machine, moves: &[Move], deviation_mm: f32, move_s: f64) -> Made {
    let per_mm = machine.steps_per_mm;
    let config = ChainConfig::new(
        [machine.limits(); AXES],
        [1.0 / per_mm; AXES],
        0.01,
        IntervalSplit::Fastest,
        SpeedProfile::Trapezoid,
    );
    let effort = Effort { move_s, ..Effort::NONE };
    let mut chain = Chain::<AXES, AHEAD>::new(if move_s > 0.0 { config.with_effort(effort) } else { config });
    let mut watch = Watch { machine, made: Made::default(), speeds_mm_s: [0.0; AXES] };
    let (mut at, mut moves) = ([0; AXES], moves.iter());
    loop {
        while !chain.is_full()
            && let Some(&Move { target_steps, offsets, feed_mm_s, .. }) = moves.next()
        {
            let steps = std::array::from_fn(|axis| target_steps[axis] - at[axis]);
            let feed_mm_s = feed_mm_s.is_finite().then_some(feed_mm_s);
            let request = Request { offsets, feed_mm_s, deviation_mm, ..Request::new(steps) };
            at = target_steps;
            chain.push(request).unwrap();
        }
        let from_s = chain.at_s();
        let Some(chunk) = chain.advance(0.015) else { break };
        if deviation_mm > 0.0 {
            watch.see(&chunk, from_s);
        }
    }
    assert!(chain.is_empty());
    Made { total_s: chain.at_s(), ..watch.made }
}

fn folder() -> Option<PathBuf> {
    std::env::var_os("ISOSTEP_CORPUS").map(PathBuf::from)
}

/// The rows of the table, by their program.
fn table(folder: &std::path::Path) -> Vec<BTreeMap<String, String>> {
    let text = std::fs::read_to_string(folder.join("grbl_times.csv")).unwrap();
    let mut lines = text.lines();
    let names: Vec<_> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    lines.map(|line| names.iter().cloned().zip(line.split(',').map(str::to_owned)).collect()).collect()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn programs_take_hardly_longer_than_without_limits_at_corners() {
    let Some(folder) = folder() else { return };
    for machine in &MACHINES {
        for (suffix, is_top) in [("_max_feed_s", true), ("_s", false)] {
            let (mut ratios, mut roots, mut reached) = (Vec::new(), Vec::new(), Vec::new());
            let mut carried = CARRIED.map(|_| Vec::new());
            for row in table(&folder) {
                let name = &row["program"];
                let grbl_s: f64 = row[&format!("{}{suffix}", machine.name)].parse().unwrap();
                let text = std::fs::read_to_string(folder.join("lines").join(name)).unwrap();
                let moves = moves(&text, machine.steps_per_mm, is_top);
                let [sharp, bent] = [0.0, DEVIATION_MM].map(|deviation_mm| make(machine, &moves, deviation_mm));
                let firsts = &moves[..moves.len().min(OFFLINE_MOVES)];
                let path = Path::new(&machine.config(), [0; AXES], firsts);
                let first_s = make_carried::<OFFLINE_MOVES>(machine, firsts, DEVIATION_MM, 0.0).total_s;
                let by_roots = first_s / two_passes::time_s(&path, machine.accel_mm_s2);
                let by_reach = first_s / path.fastest_s();
                println!(
                    "{}{suffix} {name:34} {:5} moves {:5} blends: {:8.3} s, {:.4} of Grbl's, {:.4} of that to the corners; {by_roots:.4} of passes by roots, {by_reach:.4} of the fastest; of the limits {:.5}, {:.5}, a jump of {:.1e} mm/s",
                    machine.name,
                    moves.len(),
                    bent.blends,
                    bent.total_s,
                    bent.total_s / grbl_s,
                    bent.total_s / sharp.total_s,
                    bent.accel,
                    bent.speed,
                    bent.jump_mm_s,
                );
                assert!(bent.accel < 1.0 && bent.speed < 1.0 + 1e-9 && bent.jump_mm_s < 1e-5 * machine.top_mm_s);
                assert!(by_roots < 1.02, "{by_roots}");
                assert!(by_reach > 0.9999, "faster than the fastest: {by_reach}");
                roots.push(by_roots);
                reached.push(by_reach);
                ratios.push(bent.total_s / grbl_s);
                for (ratios, (_, move_s, stop_s)) in carried.iter_mut().zip(CARRIED) {
                    ratios
                        .push((make_carried::<KNOWN>(machine, &moves, DEVIATION_MM, move_s).total_s + stop_s) / grbl_s);
                }
            }
            let most = reached.iter().copied().fold(0.0, f64::max);
            let [ratio, root, reach] = [&mut ratios, &mut roots, &mut reached].map(|values| median(values));
            println!(
                "{}{suffix} median {ratio:.4}; {root:.4} of passes by roots; {reach:.4} of the fastest, {most:.4} at most",
                machine.name
            );
            for (ratios, (what, ..)) in carried.iter_mut().zip(CARRIED) {
                let ratio = median(ratios);
                println!("{}{suffix} as the board carries it, {what}: median {ratio:.4}", machine.name);
                assert!(ratio <= if is_top { 1.12 } else { 1.015 }, "{what}: {ratio}");
            }
            assert!(ratio <= if is_top { 1.06 } else { 1.015 }, "{ratio}");
        }
    }
}
