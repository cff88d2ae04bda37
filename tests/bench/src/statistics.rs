//! Statistics of the errors of many edges in little memory: how many there are of each, the extremes, and a fitted drift.

use isostep::prove::errors;
use serde::Serialize;

/// Number of edges at the beginning and at the end of a move that are averaged.
const END_EDGES: u64 = 1_000;

/// The deviations of edges from their instants, ns. Late is positive.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    /// To whole ns.
    counted: errors::Errors,
    earliest_ns: f64,
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

/// The summary of the errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorFigures {
    /// Number of edges.
    pub edges: u64,
    /// Median of the absolute error, ns.
    pub median_ns: f64,
    /// 99th percentile of the absolute error, ns.
    pub p99_ns: f64,
    /// Largest absolute error, ns.
    pub max_ns: f64,
    /// The earliest edge, ns; negative.
    pub earliest_ns: f64,
    /// The latest edge, ns.
    pub latest_ns: f64,
}

/// The summary of the drift.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DriftFigures {
    /// Slope of the fitted line, ns of error per second.
    pub slope_ns_s: f64,
    /// Mean error of the last edges minus that of the first edges, ns.
    pub last_less_first_ns: f64,
    /// Number of edges that count as the last, and as the first.
    pub end_edges: u64,
}

impl Errors {
    pub fn add(&mut self, error_ns: f64) {
        self.counted.add(error_ns);
        self.earliest_ns = self.earliest_ns.min(error_ns);
        self.latest_ns = self.latest_ns.max(error_ns);
    }

    pub fn figures(&self) -> ErrorFigures {
        ErrorFigures {
            edges: self.counted.count(),
            median_ns: self.counted.quantile_ns(0.5),
            p99_ns: self.counted.quantile_ns(0.99),
            max_ns: self.max_ns(),
            earliest_ns: self.earliest_ns,
            latest_ns: self.latest_ns,
        }
    }

    /// The largest absolute error.
    pub fn max_ns(&self) -> f64 {
        self.latest_ns.max(-self.earliest_ns)
    }

    /// At most about `most` bins for a picture: the middle of each, ns, and the fraction of the edges in it.
    pub fn histogram(&self, most: i64) -> Vec<(f64, f64)> {
        self.counted.histogram(most)
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

    pub fn figures(&self) -> DriftFigures {
        let slope_ns_s = if self.spread_s2 > 0.0 { self.both_s_ns / self.spread_s2 } else { 0.0 };
        DriftFigures { slope_ns_s, last_less_first_ns: self.last_ns - self.first_ns, end_edges: self.end_edges() }
    }

    fn end_edges(&self) -> u64 {
        END_EDGES.min(self.total)
    }
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
    fn extremes_are_exact_and_percentiles_whole() {
        let figures =
            errors((1..=100).map(|n| if n % 2 == 0 { f64::from(n) } else { -f64::from(n) } * 0.96875)).figures();
        assert_eq!((figures.edges, figures.median_ns, figures.p99_ns, figures.max_ns), (100, 48.0, 96.0, 96.875));
        assert_eq!((figures.earliest_ns, figures.latest_ns), (-95.90625, 96.875));
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
