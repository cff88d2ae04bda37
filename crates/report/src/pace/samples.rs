//! Samples for pictures: the speed along the path over time.

use super::course::{Phase, end_s, phases};
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;

/// The speed along the path in a span of time, mm/s. At standstill it is 0, and so is the speed asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When the span begins, s from the start of the first move.
    pub begin_s: f64,
    /// When it ends.
    pub end_s: f64,
    /// The lowest speed.
    pub lowest_mm_s: f64,
    /// The mean speed.
    pub mean_mm_s: f64,
    /// The highest speed.
    pub highest_mm_s: f64,
    /// The highest of the speeds asked for.
    pub asked_mm_s: f64,
}

/// The speed in `bins` equal spans of time, from the start of the first move to the end of the last one; empty without
/// a move.
pub fn samples(outcome: &Outcome, sources: &[Option<Source>], bins: usize) -> Vec<Sample> {
    let Some(total_s) = end_s(outcome) else { return Vec::new() };
    let bin_s = total_s / bins as f64;
    let mut sums = vec![Sum::default(); bins];
    for phase in phases(outcome, sources) {
        let mut made_mm = 0.0;
        let mut from_s = phase.begin_s;
        let bin = |t_s: f64| ((t_s / bin_s) as usize).min(bins - 1);
        for (number, sum) in sums.iter_mut().enumerate().take(bin(phase.end_s()) + 1).skip(bin(phase.begin_s)) {
            let to_s = if number + 1 == bins { phase.end_s() } else { phase.end_s().min((number + 1) as f64 * bin_s) };
            let to_mm = phase.made_mm(to_s);
            sum.add(&phase, [from_s, to_s], to_mm - made_mm);
            (from_s, made_mm) = (to_s, to_mm);
        }
    }
    sums.iter().enumerate().map(|(number, sum)| sum.sample(number, bin_s)).collect()
}

/// The values of a span so far.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    moving_s: f64,
    distance_mm: f64,
    asked_mm_s: f64,
    lowest_mm_s: Option<f64>,
    highest_mm_s: f64,
}

impl Sum {
    fn add(&mut self, phase: &Phase, [from_s, to_s]: [f64; 2], distance_mm: f64) {
        let span_s = (to_s - from_s).max(0.0);
        self.moving_s += span_s;
        self.distance_mm += distance_mm;
        self.asked_mm_s = self.asked_mm_s.max(phase.asked.mm_s);
        // In a phase the speed rises, stays constant or falls, so its extremes are at the ends.
        let [one, other] = [from_s, to_s].map(|t_s| phase.speed_mm_s(t_s));
        self.lowest_mm_s = Some(self.lowest_mm_s.unwrap_or(f64::INFINITY).min(one).min(other));
        self.highest_mm_s = self.highest_mm_s.max(one).max(other);
    }

    fn sample(&self, number: usize, bin_s: f64) -> Sample {
        let stands = self.moving_s < bin_s * (1.0 - 1e-6);
        Sample {
            begin_s: number as f64 * bin_s,
            end_s: (number + 1) as f64 * bin_s,
            lowest_mm_s: if stands { 0.0 } else { self.lowest_mm_s.unwrap_or(0.0) },
            mean_mm_s: self.distance_mm / bin_s,
            highest_mm_s: self.highest_mm_s,
            asked_mm_s: self.asked_mm_s,
        }
    }
}
