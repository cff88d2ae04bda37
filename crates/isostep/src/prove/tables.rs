//! A proof as text: each figure beside the emulated board's, or beside another board's, with what to think of it.

use super::proof::Proof;
use crate::measure::table::{by_key, found, name, text, value};

/// The columns of [`cells`].
pub const HEAD: [&str; 4] = ["figure", "emulated", "measured", "verdict"];

/// The table on the screen.
pub fn shown(proof: &Proof, emulated: Option<&Proof>) -> String {
    format!("{}\n{}{}", heading(proof), text(HEAD, cells(proof, emulated)), found(&proof.found))
}

/// The board and the tool that a proof is of, in one line.
pub fn heading(proof: &Proof) -> String {
    let board = &proof.board;
    let what = if proof.is_emulated { "The emulated board" } else { "This board" };
    let part = if proof.is_quick { ", a part of the edges" } else { "" };
    format!("{what}: flash id {}, chip {}, steps by {}, isostep {}{part}", board.id, board.chip, board.port, proof.tool)
}

/// A row for each figure.
pub fn cells(proof: &Proof, emulated: Option<&Proof>) -> Vec<[String; 4]> {
    let row = |figure: &crate::measure::Figure| {
        let reference = emulated.and_then(|emulated| emulated.found.figure(&figure.key));
        [figure.what.clone(), value(reference), figure.text(), figure.verdict(reference)]
    };
    proof.found.figures.iter().map(row).collect()
}

/// Two proofs side by side: each figure of both, and the verdict on the second, for which the first is the reference.
pub fn compared(one: &Proof, other: &Proof) -> String {
    let rows = by_key([&one.found, &other.found]).into_iter().map(|row| {
        let verdict = match row {
            // The words of a verdict are those of an emulated reference.
            [Some(reference), Some(figure)] => figure.verdict(Some(reference)).replace("as emulated", "as A"),
            [None, Some(_)] => "not in A".to_owned(),
            [_, None] => "not in B".to_owned(),
        };
        [name(&row), value(row[0]), value(row[1]), verdict]
    });
    let table = text(["figure", "A", "B", "B beside A"], rows.collect());
    let faults = [("A", one), ("B", other)].map(|(name, proof)| {
        proof.found.faults.iter().map(|fault| format!("found in {name}: {fault}\n")).collect::<String>()
    });
    format!("A: {}\nB: {}\n\n{table}{}", heading(one), heading(other), faults.concat())
}

/// The letter that somebody can send to the project: what was measured, on what, and how finely.
pub fn letter(proof: &Proof, emulated: Option<&Proof>) -> String {
    let mut text = "Isostep, measured on a board by `isostep prove`\n\n".to_owned() + &shown(proof, emulated);
    text += "\nhow finely each was measured, and what flatters it\n";
    for figure in proof.found.figures.iter().filter(|figure| figure.value.is_some()) {
        text += &format!("  {}: {}", figure.key, figure.resolution);
        if !figure.flatters.is_empty() {
            text += &format!("; flattered by: {}", figure.flatters);
        }
        text += "\n";
    }
    text + "\nproof.json beside this text has every figure and the histograms; please send it too.\n"
}
