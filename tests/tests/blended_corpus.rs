//! Programs of other people with blends, in virtual time: from the edges alone, no axis exceeds its acceleration anywhere.
//! The programs are not part of the project: `ISOSTEP_CORPUS` names a folder with `lines/`. Without it there is nothing to
//! test.

use std::fs;
use std::path::PathBuf;

use isostep_sim::measure::across;
use isostep_sim::{Config, run};
use isostep_tests::root;

/// How far blends may leave a corner, mm.
const DEVIATION_MM: f64 = 0.01;
/// By what fraction the edges may show more than a limit that is kept.
const GRAIN: f64 = 0.02;
/// Steps/mm at which windows of 1 ms resolve a limit, on the fast machine.
const FINE: u32 = 1_000;
/// Longer programs are left out there, in moves.
const FINE_LINES: usize = 4_000;

/// With every feed that of 12,000 mm/min.
fn at_top_feed(program: &str) -> String {
    let word = |word: &str| if word.starts_with('F') { "F12000".to_owned() } else { word.to_owned() };
    program.lines().map(|line| line.split(' ').map(word).collect::<Vec<_>>().join(" ") + "\n").collect()
}

/// Runs a program and returns the highest acceleration of any axis, as a fraction of its limit.
fn highest(name: &str, settings: &str, program: &str) -> f64 {
    let text = format!("{settings}\n$904={DEVIATION_MM}\n{program}");
    let outcome = run(text.as_bytes(), &Config::default()).unwrap();
    assert!(outcome.refusals.is_empty(), "{name}: {:?}", outcome.refusals);
    let blends = outcome.moves.iter().filter(|record| record.blend.is_some()).count();
    let most = across::highest(&outcome).expect("moves");
    let [least_s, most_s] = across::spans_s(&outcome);
    println!(
        "{name}: {blends} blends, {} edges: at most {:.4} of an acceleration, over {:.1} to {:.1} ms",
        outcome.edges.len(),
        most.ratio,
        least_s * 1e3,
        most_s * 1e3
    );
    assert!(most.ratio < 1.0 + GRAIN, "{name}: {most:?}");
    most.ratio
}

#[test]
fn programs_of_others_keep_every_acceleration() {
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
            }
        }
    }
    println!("at most {most:.4} of an acceleration");
}
