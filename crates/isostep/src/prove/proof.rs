//! The proof: every figure that was measured, with what it was measured on, as JSON.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

use super::session::Identity;
use crate::measure::Findings;

/// The version of the JSON.
pub const VERSION: u32 = 1;

/// The content of `proof.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Proof {
    /// The version of this format.
    pub version: u32,
    /// The version of the tool that measured.
    pub tool: String,
    /// It was the emulated board.
    pub is_emulated: bool,
    /// Only a part of the edges was looked at.
    pub is_quick: bool,
    /// The board's description of itself.
    pub board: Identity,
    /// The figures, and what was found beside them.
    #[serde(flatten)]
    pub found: Findings,
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::errors::Errors;
    use crate::measure::{Better, EdgeErrors, Figure};

    #[test]
    fn a_proof_is_read_as_it_was_written() {
        let mut errors = Errors::default();
        [-3.0, 0.0, 4.0].into_iter().for_each(|ns| errors.add(ns));
        let edges = EdgeErrors { what: "three".to_owned(), made: 3, errors, unit_ns: 16.0 };
        let figure = Figure::new("a", "A figure", "ns").measured(1.5, "1 ns").compared(Better::Lower, 0.1, 2.0);
        let found = Findings { figures: vec![figure], edges: vec![edges], ..Findings::default() };
        let proof = Proof { version: VERSION, found, ..Proof::default() };
        assert_eq!(Proof::parse(&serde_json::to_string(&proof).unwrap()).unwrap(), proof);
        let newer = serde_json::to_string(&Proof { version: 9, ..proof }).unwrap();
        assert!(format!("{:#}", Proof::parse(&newer).unwrap_err()).contains("version 9, this tool reads 1"));
        assert!(format!("{:#}", Proof::parse("{}").unwrap_err()).contains("no proof"));
    }
}
