//! Statistics of the errors of many edges in little memory: how many there are of each, the extremes, and a fitted drift.

use std::collections::BTreeMap;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

/// Number of edges at the beginning and at the end of a move that are averaged.
const END_EDGES: u64 = 1_000;

/// Errors of edges, ns, counted by the nearest whole number. Late is positive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// The number of edges of each error.
    #[serde(deserialize_with = "bins")]
    bins: BTreeMap<i64, u64>,
    #[serde(default)]
    earliest_ns: f64,
    #[serde(default)]
    latest_ns: f64,
}

/// A line fitted to errors over time by least squares, and the mean errors at both ends of the move.
#[derive(Clone, Debug)]
pub struct Drift {
    /// Number of edges in the move.
    total: u64,
    count: u64,
    mean_s: f64,
    mean_ns: f64,
    spread_s2: f64,
    both_s_ns: f64,
    first_ns: f64,
    last_ns: f64,
}

/// The summary of the drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriftFigures {
    /// Slope of the fitted line, ns of error per second.
    pub slope_ns_s: f64,
    /// Mean error of the last edges minus that of the first edges, ns.
    pub last_less_first_ns: f64,
    /// Number of edges that count as the last, and as the first.
    pub end_edges: u64,
}

impl Errors {
    /// Adds an edge.
    pub fn add(&mut self, error_ns: f64) {
        *self.bins.entry(error_ns.round() as i64).or_default() += 1;
        self.earliest_ns = self.earliest_ns.min(error_ns);
        self.latest_ns = self.latest_ns.max(error_ns);
    }

    /// The number of edges.
    pub fn count(&self) -> u64 {
        self.bins.values().sum()
    }

    /// The largest error in either direction, ns; 0 without edges.
    pub fn max_ns(&self) -> f64 {
        self.latest_ns.max(-self.earliest_ns)
    }

    /// The error of the earliest edge, at most 0, and of the latest, at least 0, ns.
    pub fn extremes_ns(&self) -> [f64; 2] {
        [self.earliest_ns, self.latest_ns]
    }

    /// The smallest whole number of ns within which that ratio of the edges lies.
    pub fn quantile_ns(&self, ratio: f64) -> f64 {
        let mut by_size: BTreeMap<u64, u64> = BTreeMap::new();
        for (ns, count) in &self.bins {
            *by_size.entry(ns.unsigned_abs()).or_default() += count;
        }
        let wanted = (self.count() as f64 * ratio).ceil() as u64;
        let mut seen = 0;
        let within = by_size.iter().find(|(_, count)| {
            seen += **count;
            seen >= wanted
        });
        within.map_or(0.0, |(ns, _)| *ns as f64)
    }

    /// Bins for a picture: the middle of each, ns, and its fraction of the edges; at most about `most` of them.
    pub fn histogram(&self, most: i64) -> Vec<(f64, f64)> {
        let (Some(low), Some(high)) = (self.bins.keys().next(), self.bins.keys().next_back()) else {
            return Vec::new();
        };
        let width = ((high - low) / most).max(0) + 1;
        let count = self.count() as f64;
        let bins = (0..=(high - low) / width).map(|index| {
            let from = low + index * width;
            let edges: u64 = self.bins.range(from..from + width).map(|(_, count)| count).sum();
            (from as f64 + (width - 1) as f64 / 2.0, edges as f64 / count)
        });
        bins.collect()
    }
}

impl Drift {
    /// For a move with `total` edges.
    pub fn new(total: u64) -> Self {
        Self { total, count: 0, mean_s: 0.0, mean_ns: 0.0, spread_s2: 0.0, both_s_ns: 0.0, first_ns: 0.0, last_ns: 0.0 }
    }

    /// Adds the next edge, due at `t_s` of the move. The sums follow Welford's method, which avoids cancellation.
    pub fn add(&mut self, t_s: f64, error_ns: f64) {
        let ends = self.end_edges();
        if self.count < ends {
            self.first_ns += error_ns / ends as f64;
        }
        if self.count + ends >= self.total {
            self.last_ns += error_ns / ends as f64;
        }
        self.count += 1;
        let n = self.count as f64;
        let from_mean_s = t_s - self.mean_s;
        self.mean_s += from_mean_s / n;
        self.mean_ns += (error_ns - self.mean_ns) / n;
        self.spread_s2 += from_mean_s * (t_s - self.mean_s);
        self.both_s_ns += from_mean_s * (error_ns - self.mean_ns);
    }

    /// The summary.
    pub fn figures(&self) -> DriftFigures {
        let slope_ns_s = if self.spread_s2 > 0.0 { self.both_s_ns / self.spread_s2 } else { 0.0 };
        DriftFigures { slope_ns_s, last_less_first_ns: self.last_ns - self.first_ns, end_edges: self.end_edges() }
    }

    fn end_edges(&self) -> u64 {
        END_EDGES.min(self.total)
    }
}

/// Reads bins, whose keys are text in JSON; serde reads them as numbers only where nothing is flattened around them.
fn bins<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<i64, u64>, D::Error> {
    let bins = BTreeMap::<String, u64>::deserialize(deserializer)?.into_iter();
    bins.map(|(ns, count)| Ok((ns.parse().map_err(D::Error::custom)?, count))).collect()
}

/// The median of numbers; 0 if there are none.
pub fn median(mut numbers: Vec<f64>) -> f64 {
    if numbers.is_empty() {
        return 0.0;
    }
    let middle = numbers.len() / 2;
    let (_, median, _) = numbers.select_nth_unstable_by(middle, f64::total_cmp);
    *median
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(errors_ns: impl IntoIterator<Item = f64>) -> Errors {
        let mut all = Errors::default();
        errors_ns.into_iter().for_each(|ns| all.add(ns));
        all
    }

    #[test]
    fn percentiles_count_both_sides() {
        let all = errors((1..=100).map(|n| if n % 2 == 0 { f64::from(n) } else { -f64::from(n) }));
        assert_eq!((all.count(), all.quantile_ns(0.5), all.quantile_ns(0.99), all.max_ns()), (100, 50.0, 99.0, 100.0));
        assert_eq!((Errors::default().max_ns(), Errors::default().quantile_ns(0.5)), (0.0, 0.0));
    }

    #[test]
    fn a_histogram_has_every_edge() {
        assert_eq!(
            errors([-3.0, -2.0, 0.2, 0.4, 4.0]).histogram(4),
            [(-2.5, 0.4), (-0.5, 0.4), (1.5, 0.0), (3.5, 0.2)]
        );
        assert_eq!(errors([0.0; 3]).histogram(50), [(0.0, 1.0)]);
        assert!(Errors::default().histogram(50).is_empty());
    }

    #[test]
    fn a_median_is_in_the_middle() {
        assert_eq!((median(vec![3.0, -1.0, 2.0]), median(Vec::new())), (2.0, 0.0));
    }

    #[test]
    fn extremes_are_exact_and_percentiles_whole() {
        let all = errors((1..=100).map(|n| f64::from(n) * if n % 2 == 0 { 0.96875 } else { -0.96875 }));
        assert_eq!((all.count(), all.quantile_ns(0.5), all.quantile_ns(0.99)), (100, 48.0, 96.0));
        assert_eq!((all.extremes_ns(), all.max_ns()), ([-95.90625, 96.875], 96.875));
    }

    #[test]
    fn a_drift_is_found_under_noise() {
        let mut drift = Drift::new(100_000);
        for n in 0..100_000 {
            let t_s = f64::from(n) * 1e-4;
            drift.add(t_s, 2.0 * t_s + if n % 2 == 0 { 7.0 } else { -7.0 });
        }
        let figures = drift.figures();
        assert!((figures.slope_ns_s - 2.0).abs() < 1e-3, "{figures:?}");
        assert!((figures.last_less_first_ns - 19.8).abs() < 1e-6, "{figures:?}");
    }
}
