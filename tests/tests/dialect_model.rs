//! Random programs on the simulated machine and on the model of the dialect.

use isostep_tests::model;
use isostep_trials::{cases, window};

/// The variable that names the only seed to run.
const SEED: &str = "ISOSTEP_MODEL_SEED";

#[test]
fn the_machine_reports_what_the_model_says() {
    let only = std::env::var(SEED).ok().map(|seed| seed.parse().expect("a seed is a number"));
    let seeds = only.map_or(window(cases(200, 1_400)), |seed| seed..seed + 1);
    for seed in seeds {
        if let Err(difference) = model::run(seed) {
            panic!("{difference}\nseed {seed}: {SEED}={seed} cargo test -p isostep-tests dialect_model");
        }
    }
}

/// The console alone: each place to which a line of holes leads, in order.
#[test]
fn holes_are_where_the_model_says() {
    let only = std::env::var(SEED).ok().map(|seed| seed.parse().expect("a seed is a number"));
    let seeds = only.map_or(window(cases(500, 20_000)), |seed| seed..seed + 1);
    let (programs, mut drilled) = (seeds.end - seeds.start, 0);
    for seed in seeds {
        match model::run_holes(seed) {
            Ok(lines) => drilled += lines,
            Err(difference) => {
                panic!("{difference}\nseed {seed}: {SEED}={seed} cargo test -p isostep-tests dialect_model")
            }
        }
    }
    assert!(drilled > 15 * programs as usize, "{drilled} lines of {programs} programs drilled");
}
