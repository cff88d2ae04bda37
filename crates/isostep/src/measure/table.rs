//! Tables of figures on the screen: those of several boards side by side.

use super::figure::{Figure, Findings};

/// Rows below a head. The first and the last column are flush left, the others flush right.
pub fn text<const N: usize>(head: [&str; N], rows: Vec<[String; N]>) -> String {
    let rows: Vec<[String; N]> = [head.map(str::to_owned)].into_iter().chain(rows).collect();
    let widths: [usize; N] =
        std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
    let line = |row: &[String; N]| {
        let cells = row.iter().zip(widths).enumerate().map(|(column, (cell, width))| match column {
            0 => format!("{cell:<width$}"),
            _ if column + 1 == N => format!("  {cell}"),
            _ => format!("  {cell:>width$}"),
        });
        cells.collect::<String>().trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// The figures of several findings, those with the same key in one row, in the order in which the keys first come.
pub fn by_key<const N: usize>(of: [&Findings; N]) -> Vec<[Option<&Figure>; N]> {
    let mut keys: Vec<&str> = Vec::new();
    for figure in of.iter().flat_map(|found| &found.figures) {
        if !keys.contains(&figure.key.as_str()) {
            keys.push(&figure.key);
        }
    }
    keys.into_iter().map(|key| of.map(|found| found.figure(key))).collect()
}

/// The name of a row of [`by_key`].
pub fn name(row: &[Option<&Figure>]) -> String {
    row.iter().flatten().next().map_or_else(String::new, |figure| figure.what.clone())
}

/// The value of a cell of [`by_key`], with its unit.
pub fn value(cell: Option<&Figure>) -> String {
    cell.map_or("-".to_owned(), Figure::text)
}

/// Faults and remarks, a line each.
pub fn found(findings: &Findings) -> String {
    let of = |heading: &'static str, lines: &[String]| -> String {
        lines.iter().map(|line| format!("{heading}: {line}\n")).collect()
    };
    of("found", &findings.faults) + &of("not seen", &findings.remarks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_with_one_key_are_in_one_row() {
        let of = |keys: [&str; 2]| Findings {
            figures: keys.map(|key| Figure::new(key, format!("figure {key}"), "ns").measured(7.0, "1 ns")).to_vec(),
            ..Findings::default()
        };
        let [one, other] = [of(["a", "b"]), of(["b", "c"])];
        let rows = by_key([&one, &other]).into_iter().map(|row| [name(&row), value(row[0]), value(row[1])]);
        let shown = text(["figure", "A", "B"], rows.collect());
        assert_eq!(shown, "figure       A  B\nfigure a  7 ns  -\nfigure b  7 ns  7 ns\nfigure c     -  7 ns\n");
    }
}
