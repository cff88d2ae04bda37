//! Reduces a failure: leaves out acts as long as the same promise is broken.

use super::{Failure, Scenario, run};

/// The largest number of runs of a scenario for this.
const RUNS_MAX: u32 = 300;

/// The smallest set of acts found, by index, that breaks the same promise as all acts together.
#[must_use]
pub fn shrink(scenario: &Scenario, failure: &Failure) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..failure.act.map_or(scenario.acts.len(), |act| act + 1)).collect();
    let mut runs = 0;
    let mut breaks = |kept: &[usize]| {
        runs += 1;
        let again = run(&scenario.keeping(kept));
        (runs, again.is_err_and(|other| other.promise == failure.promise))
    };
    if !breaks(&kept).1 {
        // The failure needs acts that come after the one at which it was found.
        kept = (0..scenario.acts.len()).collect();
    }
    let mut size = kept.len().div_ceil(2);
    while size > 0 {
        let mut from = 0;
        let before = kept.len();
        while from < kept.len() {
            let without: Vec<_> = kept[..from].iter().chain(kept.iter().skip(from + size)).copied().collect();
            match breaks(&without) {
                (RUNS_MAX.., _) => return kept,
                (_, true) => kept = without,
                (_, false) => from += size,
            }
        }
        // With single acts, repeat until none can be left out.
        size = if size == 1 && kept.len() < before { 1 } else { size / 2 };
    }
    kept
}
