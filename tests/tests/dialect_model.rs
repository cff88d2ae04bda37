//! Random programs on the simulated machine and on the model of the dialect.

use std::ops::Range;

use isostep_tests::model;
use isostep_trials::{cases, window};

/// The variable that names the only seed to run.
const SEED: &str = "ISOSTEP_MODEL_SEED";

fn seeds(count: u32) -> Range<u64> {
    let only = std::env::var(SEED).ok().map(|seed| seed.parse().expect("a seed is a number"));
    only.map_or(window(count), |seed| seed..seed + 1)
}

/// Runs the program of each seed and adds up what it returns.
fn sum_of<T: Default + std::ops::AddAssign>(seeds: Range<u64>, run: impl Fn(u64) -> Result<T, String>) -> T {
    let mut sum = T::default();
    for seed in seeds {
        match run(seed) {
            Ok(one) => sum += one,
            Err(difference) => {
                panic!("{difference}\nseed {seed}: {SEED}={seed} cargo test -p isostep-tests dialect_model")
            }
        }
    }
    sum
}

#[test]
fn the_machine_reports_what_the_model_says() {
    sum_of(seeds(cases(200, 1_400)), |seed| model::run(seed).map(|()| 0));
}

/// The console alone: each place to which a line of holes leads, in order.
#[test]
fn holes_are_where_the_model_says() {
    let seeds = seeds(cases(500, 20_000));
    let programs = (seeds.end - seeds.start) as usize;
    let drilled = sum_of(seeds, model::run_holes);
    assert!(drilled > 15 * programs, "{drilled} lines of {programs} programs drilled");
}

/// The console alone: each place to which a line leads on which the lengths of tools have an effect.
#[test]
fn lengths_of_tools_count_where_the_model_says() {
    let seeds = seeds(cases(500, 20_000));
    let programs = (seeds.end - seeds.start) as usize;
    let full = sum_of(seeds, |seed| model::run_lengths(seed).map(|tools| usize::from(tools == model::TOOLS_MAX)));
    assert!(programs == 1 || full > programs / 10, "the table was full in {full} of {programs} programs");
}
