//! The page: sections of text, pictures and tables as plain data, and the HTML of them.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::theme;

/// Cells with more bytes than this are broken into lines.
const LONG: usize = 24;

/// A page, and the files beside it.
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
    /// Images that pictures show but are not SVG: names and bytes.
    pub images: Vec<(String, Vec<u8>)>,
}

/// A section of the page: its text, then its pictures, then its tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// Its heading.
    pub heading: String,
    /// Paragraphs about it.
    pub text: Vec<String>,
    /// The pictures.
    pub pictures: Vec<Picture>,
    /// The tables.
    pub tables: Vec<Table>,
}

/// A picture and its caption.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Name of its file, without the extension.
    pub name: String,
    /// The SVG element, or one that shows an image of the page.
    pub svg: String,
    /// A text about what it shows and how to read it.
    pub caption: String,
}

/// A table of text. Below the first line of a cell, what follows is small. Rows whose first cell is empty belong to the
/// row above them.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Table {
    /// The caption.
    pub caption: String,
    /// The headings of its columns.
    pub head: Vec<String>,
    /// The rows, each with one cell per column.
    pub rows: Vec<Vec<String>>,
}

impl Picture {
    /// A picture of this name.
    pub fn new(name: impl Into<String>, svg: String, caption: impl Into<String>) -> Self {
        Self { name: name.into(), svg, caption: caption.into() }
    }
}

impl Table {
    /// A table without a caption.
    pub fn new(head: &[&str], rows: Vec<Vec<String>>) -> Self {
        Self { caption: String::new(), head: head.iter().map(ToString::to_string).collect(), rows }
    }

    /// The same with a caption.
    #[must_use]
    pub fn captioned(self, caption: impl Into<String>) -> Self {
        Self { caption: caption.into(), ..self }
    }
}

impl Section {
    /// A heading, with nothing below it yet.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), ..Self::default() }
    }

    /// The same with a paragraph more.
    #[must_use]
    pub fn with_text(mut self, text: impl Into<String>) -> Self {
        self.text.push(text.into());
        self
    }

    /// The same with these pictures more.
    #[must_use]
    pub fn with_pictures(mut self, pictures: impl IntoIterator<Item = Picture>) -> Self {
        self.pictures.extend(pictures);
        self
    }

    /// The same with these tables more.
    #[must_use]
    pub fn with_tables(mut self, tables: impl IntoIterator<Item = Table>) -> Self {
        self.tables.extend(tables);
        self
    }
}

impl Page {
    /// The page as HTML.
    #[must_use]
    pub fn html(&self) -> String {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(theme::STYLE_SHEET)) }
                }
                body {
                    h1 { (self.title) }
                    @for text in &self.lead { p { (text) } }
                    p { code { (self.command) } }
                    @if self.sections.len() > 1 {
                        ul { @for section in &self.sections { li { a href=(format!("#{}", section.id())) { (section.heading) } } } }
                    }
                    @for section in &self.sections { (section.markup()) }
                }
            }
        }
        .into_string()
    }

    /// The page, `index.html`, and every picture as a file of its own, by name: SVG in light colours, and the images.
    #[must_use]
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        let pictures = self.sections.iter().flat_map(|section| &section.pictures);
        let drawn = pictures.filter(|picture| picture.svg.starts_with("<svg"));
        let files =
            drawn.map(|picture| (format!("{}.svg", picture.name), theme::standalone(&picture.svg).into_bytes()));
        let page = [("index.html".to_owned(), self.html().into_bytes())];
        page.into_iter().chain(files).chain(self.images.clone()).collect()
    }
}

impl Section {
    /// The name by which the page's list of sections finds it.
    fn id(&self) -> String {
        self.heading.replace(|letter: char| !letter.is_alphanumeric(), "-")
    }

    fn markup(&self) -> Markup {
        html! {
            h2 id=(self.id()) { (self.heading) }
            @for text in &self.text { p { (text) } }
            @for picture in &self.pictures {
                figure { (PreEscaped(&picture.svg)) figcaption { (picture.caption) } }
            }
            @for table in &self.tables { (table.markup()) }
        }
    }
}

impl Table {
    fn markup(&self) -> Markup {
        let is_deep = |row: &Vec<String>| row[0].is_empty() || row.iter().any(|cell| cell.contains('\n'));
        let has_groups = self.rows.iter().any(is_deep);
        let begins = |row: &[String]| (has_groups && !row[0].is_empty()).then_some("first");
        html! {
            @if !self.caption.is_empty() { h3 { (self.caption) } }
            div.scroll { table {
                thead { tr { @for name in &self.head { th { (name) } } } }
                tbody { @for row in &self.rows { tr class=[begins(row)] { @for each in row { (cell(each)) } } } }
            } }
        }
    }
}

fn cell(text: &str) -> Markup {
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    let class = match text {
        "kept" | "broken" => Some(text),
        "-" => Some("number"),
        _ if text.parse::<f64>().is_ok() => Some("number"),
        _ => (text.len() > LONG).then_some("found"),
    };
    html! { td class=[class] {
        (first) @if !rest.is_empty() { br; small { (rest) } }
    } }
}

#[cfg(test)]
mod tests {
    use super::super::chart::{Chart, Curve, picture};
    use super::super::theme::CURVE;
    use super::*;

    fn example() -> Page {
        let chart = Chart::new("time, s", "speed", vec![Curve::line(CURVE[6], [(0.0, 0.0), (1.0, 2.0)])]);
        let key = [(CURVE[6], "ours".to_owned())];
        let picture = Picture::new("speed", picture("Speed", &key, 1, 200, &[chart]), "What <it> shows.");
        let cells = |cells: [&str; 2]| cells.map(str::to_owned).to_vec();
        let rows = vec![cells(["4.725", "s\nprinted"]), cells(["", "kept"])];
        let section = Section {
            heading: "All of it".to_owned(),
            text: vec!["Everything.".to_owned()],
            pictures: vec![picture],
            tables: vec![Table { caption: "Numbers".to_owned(), ..Table::new(&["paper", ""], rows) }],
        };
        Page {
            title: "Papers".to_owned(),
            lead: vec!["simulated".to_owned()],
            command: "cargo xtask papers".to_owned(),
            sections: vec![section.clone(), section],
            images: vec![("dose.png".to_owned(), vec![1, 2])],
        }
    }

    #[test]
    fn a_page_has_its_pictures_and_numbers() {
        let html = example().html();
        assert_eq!(html.matches("<svg").count(), 2);
        for part in [
            "<h2 id=\"All-of-it\">All of it</h2>",
            "href=\"#All-of-it\"",
            "<tr class=\"first\"><td class=\"number\">4.725</td><td>s<br><small>printed</small></td></tr>",
            "<tr><td></td><td class=\"kept\">kept</td></tr>",
            "<h3>Numbers</h3>",
            "What &lt;it&gt; shows.",
            "cargo xtask papers",
            "ours</text>",
        ] {
            assert!(html.replace('\n', "").contains(part), "{part}: {html}");
        }
    }

    #[test]
    fn pictures_are_files_without_variables() {
        let files = example().files();
        let names: Vec<_> = files.iter().map(|file| file.0.as_str()).collect();
        assert_eq!(names, ["index.html", "speed.svg", "speed.svg", "dose.png"]);
        let text = String::from_utf8(files[1].1.clone()).unwrap();
        assert!(text.starts_with("<svg") && !text.contains("var("));
    }
}
