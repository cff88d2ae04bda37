//! The proof: every figure that was measured, with what it was measured on, as JSON.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use super::board::Identity;
use super::errors::Errors;

/// The version of the JSON.
pub const VERSION: u32 = 1;

/// The content of `proof.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Proof {
    /// The version of this format.
    pub version: u32,
    /// The version of the tool that measured.
    pub tool: String,
    /// Whether it was the emulated board.
    pub is_emulated: bool,
    /// Whether only a part of the edges was looked at.
    pub is_quick: bool,
    /// What the board says of itself.
    pub board: Identity,
    /// The figures, in the order measured.
    pub figures: Vec<Figure>,
    /// The errors of the edges, rate by rate.
    pub edges: Vec<EdgeErrors>,
    /// What no board may do, and this one did, in words.
    pub faults: Vec<String>,
    /// What was not measured or not seen, in words.
    pub remarks: Vec<String>,
}

/// Which of two values is better.
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
    /// What names it in every proof.
    pub key: String,
    /// What it is, in words.
    pub what: String,
    /// Its unit.
    pub unit: String,
    /// Its value; none if it could not be measured.
    pub value: Option<f64>,
    /// Why it could not be.
    pub why_not: Option<String>,
    /// How finely it is measured, in words.
    pub resolution: String,
    /// What makes it look better than it is, in words.
    pub flatters: String,
    /// Which of two values is better.
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
    /// How many edges there were in the moves.
    pub made: u64,
    /// Each edge's distance from the closed form, of those that were stamped.
    pub errors: Errors,
    /// How finely they were stamped, ns.
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

    /// What makes it look better than it is.
    #[must_use]
    pub fn flattered_by(self, flatters: &str) -> Self {
        Self { flatters: flatters.to_owned(), ..self }
    }

    /// Which of two values is better, and from what difference on: a fraction, and at least so much.
    #[must_use]
    pub fn compared(self, better: Better, tolerance_ratio: f64, tolerance_least: f64) -> Self {
        Self { better, tolerance_ratio, tolerance_least, ..self }
    }

    /// The value that is promised.
    #[must_use]
    pub fn promised(self, promised: f64) -> Self {
        Self { promised: Some(promised), ..self }
    }

    /// Whether its value breaks the promise.
    pub fn is_broken(&self) -> bool {
        let (Some(value), Some(promised)) = (self.value, self.promised) else { return false };
        match self.better {
            Better::Higher => value < promised,
            Better::Lower | Better::Neither | Better::Unjudged => value > promised,
        }
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

    /// How this value stands to that of a reference, in words, with the tolerance.
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

impl Proof {
    /// Reads a proof.
    ///
    /// # Errors
    /// When it is none, or of a version that this tool does not know.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display();
        let text =
            std::fs::read_to_string(path).with_context(|| format!("{name} cannot be read: name a proof.json"))?;
        Self::parse(&text).with_context(|| name.to_string())
    }

    /// Reads the text of a proof.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse(text: &str) -> Result<Self> {
        let proof: Self = serde_json::from_str(text).context("it is no proof: `isostep prove` writes one")?;
        ensure!(proof.version == VERSION, "it is a proof of version {}, this tool reads {VERSION}", proof.version);
        Ok(proof)
    }

    /// The figure of this key.
    pub fn figure(&self, key: &str) -> Option<&Figure> {
        self.figures.iter().find(|figure| figure.key == key)
    }

    /// Takes from `other` the figures that are missing here, and everything that was found there: of a board with another
    /// wire.
    pub fn fill(&mut self, other: Self) {
        for figure in other.figures.into_iter().filter(|figure| figure.value.is_some()) {
            if let Some(own) = self.figures.iter_mut().find(|own| own.key == figure.key && own.value.is_none()) {
                *own = figure;
            }
        }
        self.faults.extend(other.faults);
        self.remarks.extend(other.remarks);
    }

    /// Every promise that is broken, in words.
    pub fn broken(&self) -> Vec<String> {
        let figures = self.figures.iter().filter(|figure| figure.is_broken());
        let figures = figures.map(|figure| format!("{}: {}, {}", figure.what, figure.text(), figure.verdict(None)));
        figures.chain(self.faults.iter().cloned()).collect()
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
    fn what_is_missing_comes_from_another_proof() {
        let of = |figures| Proof { figures, ..Proof::default() };
        let mut proof = of(vec![figure(1.0), Figure::new("b", "B", "us").missing("needs a wire")]);
        let measured = Figure::new("b", "B", "us").measured(3.0, "16 ns");
        proof.fill(Proof { faults: vec!["found".to_owned()], ..of(vec![figure(9.0), measured.clone()]) });
        assert_eq!((proof.figures, proof.faults), (vec![figure(1.0), measured], vec!["found".to_owned()]));
    }

    #[test]
    fn a_proof_is_read_as_it_was_written() {
        let mut errors = Errors::default();
        [-3.0, 0.0, 4.0].into_iter().for_each(|ns| errors.add(ns));
        let edges = EdgeErrors { what: "three".to_owned(), made: 3, errors, unit_ns: 16.0 };
        let proof = Proof { version: VERSION, figures: vec![figure(1.5)], edges: vec![edges], ..Proof::default() };
        assert_eq!(Proof::parse(&serde_json::to_string(&proof).unwrap()).unwrap(), proof);
        let newer = serde_json::to_string(&Proof { version: 9, ..proof }).unwrap();
        assert!(format!("{:#}", Proof::parse(&newer).unwrap_err()).contains("version 9, this tool reads 1"));
        assert!(format!("{:#}", Proof::parse("{}").unwrap_err()).contains("no proof"));
    }
}
