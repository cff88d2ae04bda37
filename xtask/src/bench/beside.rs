//! The chip's figures, and beneath each the ideal chip's where it is another.

use super::chip::Chip;

/// `rows` of a table, each followed by that row of `ideal` whose first `key` cells are the same, unless its other cells are
/// the same too. What only the ideal chip has comes last.
pub fn beside(rows: Vec<Vec<String>>, ideal: Vec<Vec<String>>, key: usize) -> Vec<Vec<String>> {
    let mut ideal: Vec<_> = ideal.into_iter().map(Some).collect();
    let mut all = Vec::new();
    for row in rows {
        let same = ideal.iter_mut().find(|other| other.as_ref().is_some_and(|other| other[..key] == row[..key]));
        let other = same.and_then(Option::take).filter(|other| *other != row);
        all.push(row);
        all.extend(other.map(|other| beneath(other, key)));
    }
    let alone = ideal.into_iter().flatten().map(|mut row| {
        row[key - 1] += &format!(", {}", Chip::IdealFlash.name());
        row
    });
    all.extend(alone);
    all
}

/// The row above says what it is of.
fn beneath(mut row: Vec<String>, key: usize) -> Vec<String> {
    row[..key].fill(String::new());
    row[key - 1] = format!("  {}", Chip::IdealFlash.name());
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(rows: &[[&str; 3]]) -> Vec<Vec<String>> {
        rows.iter().map(|row| row.map(str::to_owned).to_vec()).collect()
    }

    #[test]
    fn what_differs_is_shown_beneath_and_what_does_not_once() {
        let chip = rows(&[["Pio", "1", "40"], ["Pio", "2", "30"], ["Timer", "1", "4"]]);
        let ideal = rows(&[["Pio", "1", "40"], ["Timer", "1", "5"], ["Timer", "2", "3"]]);
        let both = rows(&[
            ["Pio", "1", "40"],
            ["Pio", "2", "30"],
            ["Timer", "1", "4"],
            ["", "  ideal flash", "5"],
            ["Timer", "2, ideal flash", "3"],
        ]);
        assert_eq!(beside(chip, ideal, 2), both);
    }
}
