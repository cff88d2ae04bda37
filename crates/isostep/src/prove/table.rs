//! The table on the screen: each figure, emulated and measured, and what to think of it.

use super::proof::Proof;

const HEAD: [&str; 4] = ["figure", "emulated", "measured", "verdict"];

/// The whole text.
pub fn text(proof: &Proof, emulated: Option<&Proof>) -> String {
    let mut text = heading(proof) + "\n";
    let mut rows = vec![HEAD.map(str::to_owned)];
    rows.extend(cells(proof, emulated));
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths = [width(0), width(1), width(2)];
    for [figure, emulated, measured, verdict] in &rows {
        let [first, second, third] = widths;
        text += &format!("{figure:<first$}  {emulated:>second$}  {measured:>third$}  {verdict}\n");
    }
    for (heading, lines) in [("found", &proof.faults), ("not seen", &proof.remarks)] {
        text.extend(lines.iter().map(|line| format!("{heading}: {line}\n")));
    }
    text
}

/// What was measured, in one line.
pub fn heading(proof: &Proof) -> String {
    let board = &proof.board;
    let what = if proof.is_emulated { "The emulated board" } else { "This board" };
    let part = if proof.is_quick { ", a part of the edges" } else { "" };
    format!("{what}: flash id {}, chip {}, steps by {}, isostep {}{part}", board.id, board.chip, board.port, proof.tool)
}

/// A row for each figure.
pub fn cells(proof: &Proof, emulated: Option<&Proof>) -> Vec<[String; 4]> {
    let row = |figure: &super::proof::Figure| {
        let reference = emulated.and_then(|emulated| emulated.figure(&figure.key));
        let emulated = reference.map_or("-".to_owned(), |reference| reference.text());
        [figure.what.clone(), emulated, figure.text(), figure.verdict(reference)]
    };
    proof.figures.iter().map(row).collect()
}
