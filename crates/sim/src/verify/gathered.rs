//! The base of the promises of a run, gathered from the whole of it or piece by piece.

use isostep_motion::{Event, State};

use super::{Findings, Verdict, shaped};
use crate::driver::Violation;
use crate::losses::{self, LossFigures};
use crate::moves::MoveRecord;
use crate::outcome::Outcome;

/// The findings so far. Pieces are those of [`Streamed`](crate::Streamed), in order; the last is what was left at the end.
/// A piece does not know its program, so a loss is explained without its line.
#[derive(Clone, Debug, Default)]
pub struct Gathered {
    findings: Findings,
    runs: shaped::Findings,
    /// The last move.
    last: Option<MoveRecord>,
    pauses: usize,
    shortest_ns: Option<f64>,
    edges: usize,
    violations: usize,
    first_violation: Option<Violation>,
    steps_lost: u32,
    first_loss: Option<LossFigures>,
    homing: HomingTime,
}

/// The time spent homing, summed from the pieces of a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct HomingTime {
    total_ns: u64,
    /// Since when it has been homing, if it is.
    since_ns: Option<u64>,
}

impl HomingTime {
    /// Adds that of the next piece.
    pub fn add(&mut self, piece: &Outcome) {
        for &(t_ns, event) in &piece.events {
            match event {
                Event::State(State::Home) => self.since_ns = Some(t_ns),
                Event::State(_) => self.total_ns += self.since_ns.take().map_or(0, |since_ns| t_ns - since_ns),
                _ => {}
            }
        }
    }

    /// All of it, ns.
    #[must_use]
    pub fn total_ns(&self) -> u64 {
        self.total_ns
    }
}

impl Gathered {
    /// The findings of a whole run, of whose moves the `findings` are.
    pub(super) fn whole(outcome: &Outcome, findings: Findings) -> Self {
        let mut gathered = Self::default();
        gathered.add_all_but_moves(outcome);
        gathered.findings = findings;
        gathered
    }

    /// Adds the next piece.
    pub fn add(&mut self, piece: &Outcome) {
        self.add_all_but_moves(piece);
        super::moves(piece).for_each(|check| self.findings.add(&check));
    }

    fn add_all_but_moves(&mut self, piece: &Outcome) {
        self.runs = self.runs.and(shaped::Findings::of(piece));
        let befores = self.last.iter().chain(&piece.moves);
        // From the first move on, each with the one before it.
        let nexts = piece.moves.iter().skip(usize::from(self.last.is_none()));
        let pairs = befores.zip(nexts).filter(|(before, _)| before.is_whole());
        let pauses_ns: Vec<_> = pairs.map(|(before, next)| before.pause_ns(next)).collect();
        self.pauses += pauses_ns.len();
        self.shortest_ns = self.shortest_ns.into_iter().chain(pauses_ns).reduce(f64::min);
        self.last = piece.moves.last().cloned().or_else(|| self.last.take());
        self.edges += piece.edges.len();
        self.violations += piece.violations.len();
        self.first_violation = self.first_violation.or_else(|| piece.violations.first().copied());
        self.steps_lost += piece.losses.iter().map(|loss| loss.steps).sum::<u32>();
        self.first_loss = self.first_loss.take().or_else(|| self.explained(piece));
        self.homing.add(piece);
    }

    /// The first loss of a piece, its move counted from the beginning of the program.
    fn explained(&self, piece: &Outcome) -> Option<LossFigures> {
        let mut loss = losses::explained(piece, 1).pop()?;
        loss.move_number = loss.move_number.map(|number| self.findings.moves() + number);
        Some(loss)
    }

    /// Steps of all axes so far.
    pub fn edges(&self) -> usize {
        self.edges
    }

    /// Time spent homing so far, ns.
    pub fn homing_ns(&self) -> u64 {
        self.homing.total_ns()
    }

    /// Moves of the program so far, without homing.
    pub fn moves(&self) -> usize {
        self.findings.moves()
    }

    /// All promises, with their results for a run that ended as `end` says.
    pub fn verdicts(&self, end: &Outcome) -> Vec<Verdict> {
        let error_max_ns = self.findings.error_max_ns.max(self.runs.error_max_ns);
        let verdicts = [
            super::program(end),
            super::counts(&self.findings, &self.runs),
            super::instants(error_max_ns, end.config.port),
            super::straight(&self.findings),
            super::equal(&self.findings),
            super::lasting(self.shortest_ns, self.pauses),
            super::timing(self.first_violation.as_ref(), self.violations, self.edges),
            super::no_loss(self.first_loss.as_ref(), self.steps_lost, self.edges),
            super::position(end),
        ];
        verdicts.into_iter().chain(self.findings.together().verdict()).collect()
    }
}
