//! The HTML page with the pictures.

use maud::{Markup, PreEscaped, html};

use isostep_report::pictures::theme;

/// Cells with more bytes than this are broken into lines.
const LONG: usize = 24;

/// The content of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Its title.
    pub title: String,
    /// Introduction: its subject, and what its figures depend on.
    pub lead: Vec<String>,
    /// The command that prints it.
    pub command: String,
    /// The sections, in the order shown.
    pub sections: Vec<Section>,
}

/// A section of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Its heading.
    pub heading: String,
    /// What is compared, and how.
    pub text: Vec<String>,
    /// Figures that are compared.
    pub comparisons: Vec<Comparison>,
    /// The pictures, in the order shown.
    pub pictures: Vec<Picture>,
    /// The tables.
    pub tables: Vec<Table>,
}

/// A figure of a paper and our figure, as text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The quantity.
    pub figure: String,
    /// Where it is in the paper.
    pub place: String,
    /// The paper's value.
    pub theirs: String,
    /// How the paper obtained this value.
    pub basis: String,
    /// Our value.
    pub ours: String,
    /// The difference.
    pub difference: String,
}

/// A picture and its caption.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Name of its file, without the extension.
    pub name: String,
    /// The SVG, drawn by [`charts`](super::charts).
    pub svg: String,
    /// Colours, by their index in [`Curve`](super::Curve), and their meanings.
    pub key: Vec<(usize, String)>,
    /// The caption.
    pub caption: String,
}

/// A table of text.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Table {
    /// The caption.
    pub caption: String,
    /// The headings of its columns.
    pub head: Vec<String>,
    /// The rows, each with one cell per column.
    pub rows: Vec<Vec<String>>,
}

/// The page as HTML.
pub fn page(page: &Page) -> String {
    let body = html! {
        h1 { (page.title) }
        @for text in &page.lead { p { (text) } }
        p { code { (page.command) } }
        ul { @for (index, section) in page.sections.iter().enumerate() {
            li { a href=(format!("#part-{index}")) { (section.heading) } }
        } }
        @for (index, each) in page.sections.iter().enumerate() { (section(index, each)) }
    };
    theme::document(&page.title, &body)
}

/// Every picture of `page` as a separate file, by name: SVG in light colours.
pub fn files(page: &Page) -> Vec<(String, String)> {
    let pictures = page.sections.iter().flat_map(|section| &section.pictures);
    pictures.map(|picture| (format!("{}.svg", picture.name), theme::standalone(&picture.svg))).collect()
}

fn section(index: usize, section: &Section) -> Markup {
    html! {
        h2 id=(format!("part-{index}")) { (section.heading) }
        @for text in &section.text { p { (text) } }
        @if !section.comparisons.is_empty() { (comparisons(&section.comparisons)) }
        @for picture in &section.pictures {
            figure { (PreEscaped(&picture.svg)) figcaption { (key(&picture.key)) (picture.caption) } }
        }
        @for each in &section.tables { (table(each)) }
    }
}

fn comparisons(rows: &[Comparison]) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "figure" } th { "paper" } th { "ours" } th { "difference" } } }
            tbody { @for row in rows { tr.first {
                td.found { (row.figure) br; small { (row.place) } }
                td class=[wraps(&row.theirs)] { (row.theirs) br; small { (row.basis) } }
                td class=[wraps(&row.ours)] { (row.ours) }
                td { (row.difference) }
            } } }
        } }
    }
}

fn table(table: &Table) -> Markup {
    html! {
        @if !table.caption.is_empty() { h3 { (table.caption) } }
        div.scroll { table {
            thead { tr { @for name in &table.head { th { (name) } } } }
            tbody { @for row in &table.rows { tr { @for cell in row {
                td class=[wraps(cell)] { (cell) }
            } } } }
        } }
    }
}

/// The CSS class of a cell that is broken into lines.
fn wraps(cell: &str) -> Option<&'static str> {
    (cell.len() > LONG).then_some("found")
}

/// The key, in a separate line above the caption.
fn key(names: &[(usize, String)]) -> Markup {
    html! {
        @for (colour, name) in names {
            span.key style=(format!("background: var({})", theme::variable(theme::CURVE[colour % theme::CURVE.len()]))) {}
            " " (name) " "
        }
        @if !names.is_empty() { br; }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Chart, Curve, Style, charts};
    use super::*;

    fn example() -> Page {
        let curve = Curve { colour: 6, style: Style::Line, points: vec![(0.0, 0.0), (1.0, 2.0)] };
        let chart = Chart { curves: vec![curve], ..Chart::default() };
        let picture = Picture {
            name: "speed".to_owned(),
            svg: charts("Speed", 1, 200, &[chart]),
            key: vec![(6, "ours".to_owned())],
            caption: "What <it> shows.".to_owned(),
        };
        let table = Table {
            caption: "Numbers".to_owned(),
            head: vec!["paper".to_owned()],
            rows: vec![vec!["4.725".to_owned()]],
        };
        let section = Section {
            heading: "All".to_owned(),
            text: vec!["Everything.".to_owned()],
            comparisons: vec![Comparison { difference: "-2.3 s".to_owned(), ..Comparison::default() }],
            pictures: vec![picture],
            tables: vec![table],
        };
        Page {
            title: "Papers".to_owned(),
            lead: vec!["simulated".to_owned()],
            command: "cargo xtask papers".to_owned(),
            sections: vec![section],
        }
    }

    #[test]
    fn a_page_has_its_pictures_and_numbers() {
        let html = page(&example());
        assert_eq!(html.matches("<svg").count(), 1);
        for part in [
            "<h2 id=\"part-0\">All</h2>",
            "href=\"#part-0\"",
            "<td>4.725</td>",
            "<td>-2.3 s</td>",
            "What &lt;it&gt; shows.",
        ] {
            assert!(html.contains(part), "{part}");
        }
        assert!(html.contains("background: var(--curve-7)"));
    }

    #[test]
    fn pictures_are_files_without_variables() {
        let files = files(&example());
        assert_eq!(files[0].0, "speed.svg");
        assert!(files[0].1.starts_with("<svg") && !files[0].1.contains("var("));
    }
}
