//! Figures: their values, how finely they are measured, what flatters them and what is promised.

use isostep_report::pictures::bench;
use isostep_report::pictures::document::Picture;
use serde::{Deserialize, Serialize};

use super::errors::Errors;

/// Bars of a histogram.
const BARS: i64 = 80;

/// The figures of a board, and what was found beside them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Findings {
    /// The figures, in the order measured.
    pub figures: Vec<Figure>,
    /// The errors of the edges, rate by rate.
    pub edges: Vec<EdgeErrors>,
    /// Faults that no board may have, and this one had, in words.
    pub faults: Vec<String>,
    /// Measurements that were not made and edges that were not seen, in words.
    pub remarks: Vec<String>,
}

/// The better of two values: the lower or the higher one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Better {
    /// The lower one.
    Lower,
    /// The higher one.
    Higher,
    /// Neither: the figure says how the chip is, not how good.
    #[default]
    Neither,
    /// The figure says how much was measured, and is not compared.
    Unjudged,
}

/// A figure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Its name in every proof.
    pub key: String,
    /// Its name in words.
    pub what: String,
    /// Its unit.
    pub unit: String,
    /// Its value; none if it could not be measured.
    pub value: Option<f64>,
    /// Why it could not be.
    pub why_not: Option<String>,
    /// Its resolution, in words.
    pub resolution: String,
    /// The reasons why it looks better than it is, in words.
    pub flatters: String,
    /// The better of two values: the lower or the higher one.
    pub better: Better,
    /// Two values that differ by this fraction of the reference, or by `tolerance_least` if that is more, are equal.
    pub tolerance_ratio: f64,
    /// See there, in the figure's unit.
    pub tolerance_least: f64,
    /// The value that is promised: at most, or at least where higher is better.
    pub promised: Option<f64>,
}

/// The errors of the edges of one kind of move.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EdgeErrors {
    /// Of what, in words.
    pub what: String,
    /// The number of edges in the moves.
    pub made: u64,
    /// Each edge's distance from the closed form, of those that were stamped.
    pub errors: Errors,
    /// The resolution of the stamps, ns.
    pub unit_ns: f64,
}

impl Figure {
    /// A figure of this name, in words, with its unit.
    pub fn new(key: impl Into<String>, what: impl Into<String>, unit: &str) -> Self {
        Self { key: key.into(), what: what.into(), unit: unit.to_owned(), ..Self::default() }
    }

    /// Its value, and how finely that is measured.
    #[must_use]
    pub fn measured(self, value: f64, resolution: impl Into<String>) -> Self {
        Self { value: Some(value), resolution: resolution.into(), ..self }
    }

    /// It could not be measured, and why.
    #[must_use]
    pub fn missing(self, why_not: impl Into<String>) -> Self {
        Self { why_not: Some(why_not.into()), ..self }
    }

    /// The same figure, with the reasons why it looks better than it is.
    #[must_use]
    pub fn flattered_by(self, flatters: &str) -> Self {
        Self { flatters: flatters.to_owned(), ..self }
    }

    /// The better of two values, and the least difference that counts: a fraction, and at least so much.
    #[must_use]
    pub fn compared(self, better: Better, tolerance_ratio: f64, tolerance_least: f64) -> Self {
        Self { better, tolerance_ratio, tolerance_least, ..self }
    }

    /// The value that is promised.
    #[must_use]
    pub fn promised(self, promised: f64) -> Self {
        Self { promised: Some(promised), ..self }
    }

    /// Its value breaks the promise.
    pub fn is_broken(&self) -> bool {
        let (Some(value), Some(promised)) = (self.value, self.promised) else { return false };
        match self.better {
            Better::Higher => value < promised,
            Better::Lower | Better::Neither | Better::Unjudged => value > promised,
        }
    }

    /// The promise in words, such as `at most 10 us`.
    pub fn aim(&self) -> Option<String> {
        let promised = Self { value: Some(self.promised?), ..self.clone() };
        let bound = if self.better == Better::Higher { "at least" } else { "at most" };
        Some(format!("{bound} {}", promised.text()))
    }

    /// Its value as text, with the unit.
    pub fn text(&self) -> String {
        let Some(value) = self.value else { return "-".to_owned() };
        let number = if value.fract() == 0.0 && value.abs() < 1e15 {
            let sign = if value < 0.0 { "-" } else { "" };
            sign.to_owned() + &crate::screen::grouped(value.abs() as u64)
        } else if value.abs() < 10.0 {
            format!("{value:.3}")
        } else {
            format!("{value:.1}")
        };
        if self.unit.is_empty() { number } else { format!("{number} {}", self.unit) }
    }

    /// The comparison of its value with that of a reference, in words, with the tolerance.
    pub fn verdict(&self, reference: Option<&Self>) -> String {
        let Some(value) = self.value else {
            return self.why_not.clone().unwrap_or_else(|| "not measured".to_owned());
        };
        if let (true, Some(promised)) = (self.is_broken(), self.promised) {
            return format!("BROKEN: {promised} {} is promised", self.unit);
        }
        if self.better == Better::Unjudged {
            return self.resolution.clone();
        }
        let Some(reference) = reference.and_then(|reference| reference.value) else {
            return "nothing to compare with".to_owned();
        };
        let tolerance = (self.tolerance_ratio * reference.abs()).max(self.tolerance_least);
        let (apart, within) = (value - reference, self.tolerance(tolerance));
        match self.better {
            _ if apart.abs() <= tolerance => format!("as emulated (within {within})"),
            Better::Neither => format!("{apart:+.3} {} ({within} would be as emulated)", self.unit),
            Better::Lower if apart < 0.0 => "better".to_owned(),
            Better::Higher if apart > 0.0 => "better".to_owned(),
            Better::Lower | Better::Higher | Better::Unjudged => {
                format!("worse: by {}, {within} would be as emulated", self.tolerance(apart.abs()))
            }
        }
    }

    fn tolerance(&self, tolerance: f64) -> String {
        Self { value: Some((tolerance * 1e3).round() / 1e3), ..self.clone() }.text()
    }
}

impl Findings {
    /// Adds a figure.
    pub fn add(&mut self, figure: Figure) {
        self.figures.push(figure);
    }

    /// Adds what was found of a part of the whole, whose keys and names get the part's before them.
    pub fn add_part(&mut self, key: &str, name: &str, part: Self) {
        let named = |figure: Figure| {
            let (key, what) = (format!("{key}.{}", figure.key), format!("{name}: {}", figure.what));
            Figure { key, what, ..figure }
        };
        self.figures.extend(part.figures.into_iter().map(named));
        let edges = part.edges.into_iter();
        self.edges.extend(edges.map(|edges| EdgeErrors { what: format!("{name}: {}", edges.what), ..edges }));
        self.faults.extend(part.faults.into_iter().map(|fault| format!("{name}: {fault}")));
        self.remarks.extend(part.remarks.into_iter().map(|remark| format!("{name}: {remark}")));
    }

    /// Promises the value of the figure of this key, if there is one.
    pub fn promise(&mut self, key: &str, promised: f64) {
        if let Some(figure) = self.figures.iter_mut().find(|figure| figure.key == key) {
            figure.promised = Some(promised);
        }
    }

    /// The figure of this key.
    pub fn figure(&self, key: &str) -> Option<&Figure> {
        self.figures.iter().find(|figure| figure.key == key)
    }

    /// Takes from `other` the figures that are missing here, in their places, and everything that was found there: of a board
    /// with another wire.
    pub fn fill(&mut self, other: Self) {
        let mut place = 0;
        for figure in other.figures {
            let own = self.figures.iter().position(|own| own.key == figure.key);
            match own {
                Some(own) if self.figures[own].value.is_none() && figure.value.is_some() => self.figures[own] = figure,
                Some(_) => {}
                None => self.figures.insert(place, figure),
            }
            place = own.unwrap_or(place) + 1;
        }
        self.faults.extend(other.faults);
        self.remarks.extend(other.remarks);
    }

    /// Every promise that is broken, in words.
    pub fn broken(&self) -> Vec<String> {
        let figures = self.figures.iter().filter(|figure| figure.is_broken());
        let figures = figures.map(|figure| format!("{}, {}, {}", figure.what, figure.text(), figure.verdict(None)));
        figures.chain(self.faults.iter().cloned()).collect()
    }
}

impl EdgeErrors {
    /// A histogram of the errors, with dashed lines at the bound on either side; `colour` is its index.
    pub fn picture(&self, name: impl Into<String>, kind: &str, bound_ns: f64, colour: usize) -> Picture {
        let title = format!("{}{kind}", self.what);
        Picture::new(
            name,
            bench::histogram(&title, &self.errors.histogram(BARS), bound_ns, colour),
            format!(
                "{title}: {} of {} edges, by {}. Dashed: {} ns.",
                crate::screen::grouped(self.errors.count()),
                crate::screen::grouped(self.made),
                super::finely(self.unit_ns),
                crate::screen::grouped(bound_ns as u64),
            ),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(value: f64) -> Figure {
        Figure::new("a", "A figure", "ns").measured(value, "1 ns").compared(Better::Lower, 0.1, 2.0)
    }

    #[test]
    fn a_verdict_names_its_tolerance() {
        let verdict = |value: f64| figure(value).verdict(Some(&figure(10.0)));
        assert_eq!(verdict(12.0), "as emulated (within 2 ns)");
        assert_eq!(verdict(7.0), "better");
        assert_eq!(verdict(13.5), "worse: by 3.500 ns, 2 ns would be as emulated");
        assert_eq!(figure(3.0).verdict(None), "nothing to compare with");
        assert_eq!(Figure::new("a", "b", "ns").missing("needs a wire").verdict(None), "needs a wire");
        let higher = Figure { better: Better::Higher, ..figure(7.0) };
        assert!(higher.verdict(Some(&figure(10.0))).starts_with("worse"));
        let neither = Figure { better: Better::Neither, ..figure(15.0) };
        assert_eq!(neither.verdict(Some(&figure(10.0))), "+5.000 ns (2 ns would be as emulated)");
    }

    #[test]
    fn a_promise_is_at_most_or_at_least() {
        assert!(!figure(10.0).promised(10.0).is_broken() && figure(10.1).promised(10.0).is_broken());
        let higher = Figure { better: Better::Higher, ..figure(9.0) };
        assert!(higher.clone().promised(10.0).is_broken() && !higher.promised(9.0).is_broken());
        assert_eq!(figure(11.0).promised(10.0).verdict(None), "BROKEN: 10 ns is promised");
    }

    #[test]
    fn numbers_are_short() {
        let text = |value: f64| figure(value).text();
        assert_eq!(
            [text(2_300_000.0), text(0.126_6), text(-12.34), text(-5.0)],
            ["2,300,000 ns", "0.127 ns", "-12.3 ns", "-5 ns"]
        );
    }

    #[test]
    fn what_is_missing_comes_from_another_board() {
        let of = |figures| Findings { figures, ..Findings::default() };
        let named = |key: &str| Figure::new(key, key, "us");
        let mut found = of(vec![figure(1.0), named("b").missing("needs a wire"), named("d")]);
        let [b, c] = ["b", "c"].map(|key| named(key).measured(3.0, "16 ns"));
        found.fill(Findings { faults: vec!["found".to_owned()], ..of(vec![figure(9.0), b.clone(), c.clone()]) });
        assert_eq!((found.figures, found.faults), (vec![figure(1.0), b, c, named("d")], vec!["found".to_owned()]));
    }

    #[test]
    fn the_figures_of_a_part_have_its_name() {
        let mut found = Findings::default();
        found.add_part("pio", "PioPort", Findings { figures: vec![figure(1.0)], ..Findings::default() });
        found.promise("pio.a", 0.5);
        assert_eq!(found.broken(), ["PioPort: A figure, 1 ns, BROKEN: 0.5 ns is promised"]);
    }
}
