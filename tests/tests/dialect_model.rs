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
