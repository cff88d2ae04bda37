//! The figures of edges against the closed form, however they were seen.

use super::errors::Errors;
use super::figure::{Better, EdgeErrors, Figure, Findings};
use super::finely;
use crate::screen::grouped;

/// Edges of one kind of move.
#[derive(Clone, Debug)]
pub struct Edges {
    /// The beginning of their figures' keys.
    pub key: String,
    /// The kind of move, in words.
    pub of: String,
    /// The resolution at which the edges are seen, ns.
    pub unit_ns: f64,
    /// The reason why the figure of the farthest edge looks better than it is.
    pub flatters: &'static str,
    /// Edges in a move.
    pub made: u64,
}

impl Edges {
    /// The figure of the farthest edge, without its value.
    pub fn worst(&self) -> Figure {
        self.figure("max", "farthest edge from the closed form", "ns").flattered_by(self.flatters).compared(
            Better::Lower,
            0.0,
            self.unit_ns,
        )
    }

    /// A figure of these edges, without its value.
    pub fn figure(&self, key: &str, what: &str, unit: &str) -> Figure {
        Figure::new(format!("{}.{key}", self.key), format!("{what}, {}", self.of), unit)
    }

    /// The resolution of an error, in words.
    pub fn resolution(&self) -> String {
        format!("{}, so up to {} of it may be rounding", finely(self.unit_ns), finely(self.unit_ns / 2.0))
    }

    /// Adds the figures of these errors, the first of which is promised.
    pub fn add(&self, found: &mut Findings, errors: Errors, promised_ns: Option<f64>) {
        let worst = self.worst().measured(errors.max_ns(), self.resolution());
        found.add(Figure { promised: promised_ns, ..worst });
        for (key, what, ratio) in
            [("p99", "99 % of the edges within", 0.99), ("median", "half of the edges within", 0.5)]
        {
            let figure = self.figure(key, what, "ns").measured(errors.quantile_ns(ratio), self.resolution());
            found.add(figure.compared(Better::Lower, 0.0, self.unit_ns));
        }
        let unseen = self.made.saturating_sub(errors.count());
        let reported = format!(
            "of {} in a move of three axes; {} were not looked at, or not seen",
            grouped(self.made),
            grouped(unseen)
        );
        let seen = self.figure("seen", "edges that were seen", "").measured(errors.count() as f64, reported);
        found.add(seen.compared(Better::Unjudged, 0.0, 0.0));
        let (what, made, unit_ns) = (format!("Edges, {}", self.of), self.made, self.unit_ns);
        found.edges.push(EdgeErrors { what, made, errors, unit_ns });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_the_edges_that_were_seen() {
        let edges =
            Edges { key: "edges".to_owned(), of: "of a test".to_owned(), unit_ns: 8.0, flatters: "", made: 1_100 };
        let (mut errors, mut found) = (Errors::default(), Findings::default());
        (1..=1_000).for_each(|ns| errors.add(f64::from(ns)));
        edges.add(&mut found, errors, Some(999.0));
        let value = |key: &str| found.figure(key).and_then(|figure| figure.value);
        let values = ["edges.max", "edges.p99", "edges.median", "edges.seen"].map(value);
        assert_eq!(values, [1_000.0, 990.0, 500.0, 1_000.0].map(Some));
        let is_broken = |key: &str| found.figure(key).map(Figure::is_broken);
        assert_eq!(["edges.max", "edges.p99"].map(is_broken), [true, false].map(Some), "the first alone is promised");
        let seen = found.figure("edges.seen").unwrap();
        assert_eq!(seen.resolution, "of 1,100 in a move of three axes; 100 were not looked at, or not seen");
        assert_eq!(found.edges.len(), 1);
    }
}
