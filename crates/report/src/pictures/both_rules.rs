//! What both rules at corners make of a program: drawn once, for the page and for the files beside it.

use super::by_accel;
use super::other_rule::Rule;
use super::ringing::{self, Row};
use isostep_sim::Outcome;

/// A run, and the same program by the other rule at corners.
pub struct BothRules {
    pub(super) by_accel: Option<by_accel::Picture>,
    pub(super) ringing: Vec<Row>,
}

impl BothRules {
    /// Looks at a run, and at the `other` one that [`other_rule`](super::other_rule()) asks for, if there is one.
    pub fn of(outcome: &Outcome, other: Option<Outcome>) -> Self {
        let runs = [Some((Rule::of(outcome), outcome)), other.as_ref().map(|other| (Rule::of_other(other), other))];
        let mut runs: Vec<_> = runs.into_iter().flatten().collect();
        // Grbl's rule is to the left.
        runs.sort_by_key(|(rule, _)| rule.blends);
        let ringing = runs.iter().flat_map(|(rule, run)| ringing::rows(rule, run)).collect();
        Self { by_accel: by_accel::picture(&runs), ringing }
    }
}
