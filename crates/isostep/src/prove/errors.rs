//! Errors of many edges in little memory: a histogram with bins of 1 ns.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Errors of edges, ns, counted by the nearest whole number. Late is positive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// How many edges there are of each error.
    bins: BTreeMap<i64, u64>,
}

impl Errors {
    /// Adds an edge.
    pub fn add(&mut self, error_ns: f64) {
        *self.bins.entry(error_ns.round() as i64).or_default() += 1;
    }

    /// The number of edges.
    pub fn count(&self) -> u64 {
        self.bins.values().sum()
    }

    /// The largest error in either direction, ns; 0 without edges.
    pub fn max_ns(&self) -> f64 {
        self.bins.keys().map(|ns| ns.unsigned_abs()).max().unwrap_or(0) as f64
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
}
