//! The text that somebody can send to the project: what was measured, on what, and how finely.

use super::proof::Proof;
use super::table;

/// The whole letter.
pub fn text(proof: &Proof, emulated: Option<&Proof>) -> String {
    let mut text = "Isostep, measured on a board by `isostep prove`\n\n".to_owned() + &table::text(proof, emulated);
    text += "\nhow finely each was measured, and what flatters it\n";
    for figure in proof.figures.iter().filter(|figure| figure.value.is_some()) {
        text += &format!("  {}: {}", figure.key, figure.resolution);
        if !figure.flatters.is_empty() {
            text += &format!("; flattered by: {}", figure.flatters);
        }
        text += "\n";
    }
    text + "\nproof.json beside this text has every figure and the histograms; please send it too.\n"
}
