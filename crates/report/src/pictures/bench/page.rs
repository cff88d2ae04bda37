//! The page around a benchmark's pictures.

use maud::{Markup, PreEscaped, html};

use super::super::theme::{self, AXIS_NAMES};

/// Cells with more bytes than this are broken into lines.
const LONG: usize = 40;

/// A section of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Its heading.
    pub heading: String,
    /// What is measured, and how.
    pub text: String,
    /// The pictures, in the order shown.
    pub pictures: Vec<Picture>,
    /// The figures.
    pub table: Option<Table>,
}

/// A picture and its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Name of its file, without the extension.
    pub name: String,
    /// The SVG, drawn by one of this module's functions.
    pub svg: String,
    /// The names of its series, in the order of their colours.
    pub key: Vec<String>,
    /// What it shows.
    pub caption: String,
}

/// A table of text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The headings of its columns.
    pub head: Vec<String>,
    /// The rows, each with one cell per column.
    pub rows: Vec<Vec<String>>,
}

/// The whole page; `conditions` are those of all figures, and `command` is the command that prints them.
pub fn page(title: &str, conditions: &str, command: &str, sections: &[Section]) -> String {
    let body = html! {
        h1 { (title) }
        p { (conditions) }
        p { code { (command) } }
        @for each in sections { (section(each)) }
    };
    theme::document(title, &body)
}

/// Every picture as a separate file, by name: SVG in light colours.
pub fn files(sections: &[Section]) -> Vec<(String, String)> {
    let pictures = sections.iter().flat_map(|section| &section.pictures);
    pictures.map(|picture| (format!("{}.svg", picture.name), theme::standalone(&picture.svg))).collect()
}

fn section(section: &Section) -> Markup {
    html! {
        h2 { (section.heading) }
        p { (section.text) }
        @for picture in &section.pictures {
            figure { (PreEscaped(&picture.svg)) figcaption { (key(&picture.key)) (picture.caption) } }
        }
        @if let Some(table) = &section.table {
            div.scroll { table {
                thead { tr { @for name in &table.head { th { (name) } } } }
                tbody { @for row in &table.rows { tr { @for cell in row { td class=[(cell.len() > LONG).then_some("found")] { (cell) } } } } }
            } }
        }
    }
}

fn key(names: &[String]) -> Markup {
    html! {
        @for (index, name) in names.iter().enumerate() {
            span.key style=(format!("background: var(--{})", AXIS_NAMES[index % AXIS_NAMES.len()].to_lowercase())) {}
            " " (name) " "
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Series, bars, curves, histogram};
    use super::*;

    fn sections() -> Vec<Section> {
        let series = vec![Series { name: "one".to_owned(), values: vec![Some(5e5), None] }];
        let rates = bars("Rates", "steps/s", &["1 axis".to_owned(), "2 axes".to_owned()], &series);
        let load =
            curves("Load", "steps/s", "%", &[Series { name: "one".to_owned(), values: vec![(1e4, 1.0), (1e6, 50.0)] }]);
        let errors = histogram("Errors", &[(-8.0, 0.25), (0.0, 0.75)], 50.0, 0);
        let picture = |name: &str, svg: String| Picture {
            name: name.to_owned(),
            svg,
            key: vec!["one".to_owned()],
            caption: "What <it> shows.".to_owned(),
        };
        let table = Table { head: vec!["axes".to_owned()], rows: vec![vec!["3".to_owned()]] };
        vec![Section {
            heading: "All".to_owned(),
            text: "Everything.".to_owned(),
            pictures: vec![picture("rates", rates), picture("load", load), picture("errors", errors)],
            table: Some(table),
        }]
    }

    #[test]
    fn a_page_has_its_pictures_and_numbers() {
        let html = page("Benchmark", "emulated", "cargo xtask bench", &sections());
        assert_eq!(html.matches("<svg").count(), 3);
        for part in ["<h2>All</h2>", "<td>3</td>", "What &lt;it&gt; shows.", "cargo xtask bench", "500k"] {
            assert!(html.contains(part), "{part}");
        }
    }

    #[test]
    fn pictures_are_files_without_variables() {
        let files = files(&sections());
        assert_eq!(
            files.iter().map(|file| file.0.as_str()).collect::<Vec<_>>(),
            ["rates.svg", "load.svg", "errors.svg"]
        );
        assert!(files.iter().all(|(_, svg)| svg.starts_with("<svg") && !svg.contains("var(")));
    }
}
