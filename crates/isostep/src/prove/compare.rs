//! Two proofs side by side.

use super::proof::Proof;
use super::table;

/// Each figure of both, and the verdict on the second, for which the first is the reference.
pub fn text(one: &Proof, other: &Proof) -> String {
    let mut text = format!("A: {}\nB: {}\n\n", table::heading(one), table::heading(other));
    let keys = one.figures.iter().chain(&other.figures).map(|figure| figure.key.as_str());
    let mut seen = Vec::new();
    let mut rows = vec![["figure", "A", "B", "B beside A"].map(str::to_owned)];
    for key in keys {
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        let both = [one.figure(key), other.figure(key)];
        let [a, b] = both.map(|figure| figure.map_or("-".to_owned(), |figure| figure.text()));
        let what = both.into_iter().flatten().next().map_or("", |figure| figure.what.as_str());
        let verdict = both[1].map_or("not in B".to_owned(), |figure| match both[0] {
            // The words of a verdict are those of an emulated reference.
            Some(reference) => figure.verdict(Some(reference)).replace("as emulated", "as A"),
            None => "not in A".to_owned(),
        });
        rows.push([what.to_owned(), a, b, verdict]);
    }
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let [first, second, third] = [width(0), width(1), width(2)];
    for [what, a, b, verdict] in &rows {
        text += &format!("{what:<first$}  {a:>second$}  {b:>third$}  {verdict}\n");
    }
    for (name, proof) in [("A", one), ("B", other)] {
        text.extend(proof.faults.iter().map(|fault| format!("found in {name}: {fault}\n")));
    }
    text
}
