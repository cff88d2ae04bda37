//! Combines the chip's figures with those of the ideal chip, which are shown below the chip's where they differ.

use super::chip::Chip;

/// The rows of a table. Each row of `rows` is followed by the row of `ideal` with the same first `key` cells, unless
/// the other cells are the same too. Rows that only the ideal chip has come last.
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

/// The row for the ideal chip, with the other key cells left empty because the row above shows them.
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
