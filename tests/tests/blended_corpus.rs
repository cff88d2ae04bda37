//! Programs of other people with blends, in virtual time: from the edges alone, no axis exceeds its acceleration or its speed
//! anywhere, and the path leaves no corner by more than was asked for; with shapers behind the blends, no limit either.
//! The programs are not part of the project: `ISOSTEP_CORPUS` names a folder with `lines/`. Without it there is nothing to
//! test.

use std::fs;
use std::path::PathBuf;

use isostep_motion::AXES;
use isostep_profile::SyncMove;
use isostep_sim::measure::across;
use isostep_sim::{Config, Outcome, run};
use isostep_tests::root;

/// The distance by which blends may leave a corner, mm.
const DEVIATION_MM: f64 = 0.01;
/// By what fraction the edges may show more than a limit that is kept.
const GRAIN: f64 = 0.02;
/// The same for speeds, which two steps tell.
const SPEED_GRAIN: f64 = 0.005;
/// Steps/mm at which windows of 1 ms resolve a limit, on the fast machine.
const FINE: u32 = 1_000;
/// Longer programs are left out there, in moves.
const FINE_LINES: usize = 4_000;

/// With every feed that of 12,000 mm/min.
fn at_top_feed(program: &str) -> String {
    let word = |word: &str| if word.starts_with('F') { "F12000".to_owned() } else { word.to_owned() };
    program.lines().map(|line| line.split(' ').map(word).collect::<Vec<_>>().join(" ") + "\n").collect()
}

/// The highest speed of an axis between two steps in one direction, as a fraction of its top speed.
fn highest_speed(outcome: &Outcome) -> f64 {
    let speeds = (0..AXES).flat_map(|axis| {
        let edges = || outcome.edges.iter().filter(move |edge| edge.axis == axis);
        let pairs = edges().zip(edges().skip(1)).filter(|(one, next)| one.direction == next.direction);
        pairs.map(move |(one, next)| 1e9 / (next.t_ns - one.t_ns) as f64 / outcome.limits[axis].top_speed_steps_s)
    });
    speeds.fold(0.0, f64::max)
}

/// The farthest that the axes are from the corners and lines of the program, mm, and the largest error of a place of whole
/// steps, half of one of each axis.
fn farthest_mm(outcome: &Outcome) -> [f64; 2] {
    let mm =
        |steps: [f64; AXES]| -> [f64; AXES] { std::array::from_fn(|axis| steps[axis] / outcome.steps_per_mm[axis]) };
    let end_of = |index: usize, place: fn(&SyncMove<AXES>) -> f64| {
        let record = &outcome.moves[index];
        let corner = record.corner_steps();
        mm(std::array::from_fn(|axis| f64::from(corner[axis]) + record.plan.axis_place(axis, place(&record.plan))))
    };
    let mut corners: Vec<_> = (0..outcome.moves.len()).map(|index| end_of(index, |_| 0.0)).collect();
    corners.push(end_of(outcome.moves.len() - 1, SyncMove::distance_steps));
    let (mut steps, mut farthest_mm) = ([0.0; AXES], 0.0_f64);
    for (index, record) in outcome.moves.iter().enumerate() {
        for edge in outcome.edges_of(record) {
            steps[edge.axis] = f64::from(edge.position_steps);
            let place = mm(steps);
            let lines = index.saturating_sub(1)..(index + 2).min(outcome.moves.len());
            let off = lines.map(|line| from_line(&place, &corners[line], &corners[line + 1]));
            farthest_mm = farthest_mm.max(off.fold(f64::INFINITY, f64::min));
        }
    }
    [farthest_mm, size(&mm([0.5; AXES]))]
}

fn size(of: &[f64; AXES]) -> f64 {
    of.iter().map(|each| each * each).sum::<f64>().sqrt()
}

/// The distance of a place from the line between two others.
fn from_line(place: &[f64; AXES], from: &[f64; AXES], to: &[f64; AXES]) -> f64 {
    let [along, off]: [[f64; AXES]; 2] = [to, place].map(|each| std::array::from_fn(|axis| each[axis] - from[axis]));
    let product: f64 = (0..AXES).map(|axis| along[axis] * off[axis]).sum();
    let ratio = (product / size(&along).powi(2)).clamp(0.0, 1.0);
    size(&std::array::from_fn(|axis| off[axis] - ratio * along[axis]))
}

/// Runs a program, whose speeds must be right, and its corners unless they are shaped, and returns the highest acceleration of
/// any axis, as a fraction of its limit.
fn highest(name: &str, settings: &str, program: &str) -> f64 {
    let is_shaped = settings.contains("$950=");
    let text = format!("{settings}\n$904={DEVIATION_MM}\n{program}");
    let outcome = run(text.as_bytes(), &Config::default()).unwrap();
    assert!(outcome.refusals.is_empty(), "{name}: {:?}", outcome.refusals);
    let blends = outcome.moves.iter().filter(|record| record.blend.is_some()).count();
    let most = across::highest(&outcome).expect("moves");
    let [least_s, most_s] = across::spans_s(&outcome);
    let speed = highest_speed(&outcome);
    println!(
        "{name}: {blends} blends, {} edges: at most {:.4} of an acceleration, over {:.1} to {:.1} ms, and {speed:.4} of a speed",
        outcome.edges.len(),
        most.ratio,
        least_s * 1e3,
        most_s * 1e3
    );
    if !is_shaped {
        let [farthest_mm, grain_mm] = farthest_mm(&outcome);
        println!("  {farthest_mm:.4} mm off, {grain_mm:.4} of them by whole steps");
        assert!(farthest_mm <= DEVIATION_MM + grain_mm, "{name}: {farthest_mm} mm off");
    }
    assert!(speed < 1.0 + SPEED_GRAIN, "{name}: {speed} of a speed");
    assert!(most.ratio < 1.0 + GRAIN, "{name}: {most:?}");
    most.ratio
}

#[test]
fn programs_of_others_keep_every_limit_and_their_corners() {
    let Some(folder) = std::env::var_os("ISOSTEP_CORPUS").map(PathBuf::from) else { return };
    let mut programs: Vec<_> = fs::read_dir(folder.join("lines")).unwrap().map(|entry| entry.unwrap().path()).collect();
    programs.sort();
    let mut most = 0.0_f64;
    for path in programs {
        let (name, program) =
            (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read_to_string(&path).unwrap());
        for machine in ["a", "b", "c"] {
            let settings = fs::read_to_string(root().join(format!("programs/machines/{machine}.txt"))).unwrap();
            for (feeds, program) in [("own feeds", program.clone()), ("F12000", at_top_feed(&program))] {
                most = most.max(highest(&format!("{name}, {machine}, {feeds}"), &settings, &program));
            }
            if machine == "c" && program.lines().count() < FINE_LINES {
                let fine = (0..3).fold(settings, |text, axis| text + &format!("\n${}={FINE}", 100 + axis));
                most = most.max(highest(&format!("{name}, {machine}, {FINE} steps/mm"), &fine, &at_top_feed(&program)));
                for (kind, shaper) in [("ZV", 1), ("box", 5)] {
                    // 40 Hz, and a box of 10 ms: 200,000 mm/s3 at 2,000 mm/s2.
                    let hz = if kind == "box" { 100 } else { 40 };
                    let shaped = (0..3).fold(fine.clone(), |text, axis| {
                        text + &format!("\n${}={hz}\n${}={shaper}", 960 + axis, 950 + axis)
                    });
                    most = most.max(highest(&format!("{name}, {machine}, {kind}"), &shaped, &at_top_feed(&program)));
                }
            }
        }
    }
    println!("at most {most:.4} of an acceleration");
}
