//! Statistics of the errors of many edges in little memory: a histogram with bins of 1 ns, the extremes, and a fitted
//! drift.

use serde::Serialize;

/// Range of the histogram, ns; the outer bins hold all errors beyond it. No port may be so late and continue.
const REACH_NS: i64 = 300_000;
/// Number of edges at the beginning and at the end of a move that are averaged.
const END_EDGES: u64 = 1_000;

/// The deviations of edges from their instants, ns. Late is positive.
#[derive(Clone, Debug)]
pub struct Errors {
    /// Bins from -REACH_NS to REACH_NS.
    bins: Vec<u64>,
    count: u64,
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

impl Default for Errors {
    fn default() -> Self {
        Self { bins: vec![0; 2 * REACH_NS as usize + 1], count: 0, earliest_ns: 0.0, latest_ns: 0.0 }
    }
}

impl Errors {
    pub fn add(&mut self, error_ns: f64) {
        let bin = (error_ns.round() as i64).clamp(-REACH_NS, REACH_NS) + REACH_NS;
        self.bins[bin as usize] += 1;
        self.count += 1;
        self.earliest_ns = self.earliest_ns.min(error_ns);
        self.latest_ns = self.latest_ns.max(error_ns);
    }

    pub fn figures(&self) -> ErrorFigures {
        ErrorFigures {
            edges: self.count,
            median_ns: self.quantile_ns(0.5),
            p99_ns: self.quantile_ns(0.99),
            max_ns: self.max_ns(),
            earliest_ns: self.earliest_ns,
            latest_ns: self.latest_ns,
        }
    }

    /// The largest absolute error.
    pub fn max_ns(&self) -> f64 {
        self.latest_ns.max(-self.earliest_ns)
    }

    /// The smallest whole number of ns within which that ratio of the edges lies.
    fn quantile_ns(&self, ratio: f64) -> f64 {
        let wanted = (self.count as f64 * ratio).ceil() as u64;
        let mut seen = 0;
        let within = (0..=REACH_NS).find(|&ns| {
            let below = if ns == 0 { 0 } else { self.bins[(REACH_NS - ns) as usize] };
            seen += self.bins[(REACH_NS + ns) as usize] + below;
            seen >= wanted
        });
        within.unwrap_or(REACH_NS) as f64
    }

    /// A histogram in `bins` equal parts from the earliest to the latest: the middle of each bin, ns, and the fraction
    /// of the edges in it.
    pub fn histogram(&self, bins: usize) -> Vec<(f64, f64)> {
        let (low, high) = (self.earliest_ns.round() as i64, self.latest_ns.round() as i64);
        let (low, high) = (low.max(-REACH_NS), high.min(REACH_NS));
        let within = &self.bins[(low + REACH_NS) as usize..=(high + REACH_NS) as usize];
        let width = within.len().div_ceil(bins);
        let all = within.chunks(width);
        let middles = (0..).map(|index| low as f64 + index as f64 * width as f64 + (width - 1) as f64 / 2.0);
        middles.zip(all.map(|bins| bins.iter().sum::<u64>() as f64 / self.count as f64)).collect()
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
    fn percentiles_count_both_sides() {
        let figures = errors((1..=100).map(|n| if n % 2 == 0 { f64::from(n) } else { -f64::from(n) })).figures();
        assert_eq!((figures.edges, figures.median_ns, figures.p99_ns, figures.max_ns), (100, 50.0, 99.0, 100.0));
        assert_eq!((figures.earliest_ns, figures.latest_ns), (-99.0, 100.0));
    }

    #[test]
    fn an_error_beyond_reach_is_still_the_greatest() {
        let figures = errors([0.0, 0.0, 1e7]).figures();
        assert_eq!((figures.median_ns, figures.p99_ns, figures.max_ns), (0.0, REACH_NS as f64, 1e7));
    }

    #[test]
    fn a_histogram_has_every_edge() {
        let histogram = errors([-3.0, -2.0, 0.2, 0.4, 4.0]).histogram(4);
        assert_eq!(histogram, [(-2.5, 0.4), (-0.5, 0.4), (1.5, 0.0), (3.5, 0.2)]);
        assert_eq!(errors([0.0; 3]).histogram(50), [(0.0, 1.0)]);
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
