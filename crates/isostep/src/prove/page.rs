//! The page: the table, the histograms of errors emulated and measured, and what a stranger needs to judge them.

use isostep_report::pictures::document::{Page, Section, Table};

use super::judge::PROMISE_NS;
use super::proof::Proof;
use super::tables;
use crate::measure::{EdgeErrors, Figure};

const COMMAND: &str = "isostep prove";

/// The whole page.
pub fn page(proof: &Proof, emulated: Option<&Proof>) -> Page {
    let conditions = format!(
        "{}. Chip {} is SYSINFO's CHIP_ID and the version of the ROM; the image keeps {} stamps of a pad at a time.",
        tables::heading(proof),
        proof.board.chip,
        proof.board.window
    );
    Page {
        title: "Isostep, proved on a board".to_owned(),
        lead: vec![conditions],
        command: COMMAND.to_owned(),
        sections: vec![figures(proof, emulated), found(proof), edges(proof, emulated), method(proof)],
        ..Page::default()
    }
}

fn figures(proof: &Proof, emulated: Option<&Proof>) -> Section {
    Section {
        heading: "Figures".to_owned(),
        text: vec![
            "Emulated is what the same verb measures on the emulated board, by the same image. A verdict names the tolerance within \
             which both count as equal."
                .to_owned(),
        ],
        tables: vec![Table::new(
            &tables::HEAD,
            tables::cells(proof, emulated).into_iter().map(|row| row.to_vec()).collect(),
        )],
        ..Section::default()
    }
}

fn found(proof: &Proof) -> Section {
    let row = |kind: &str, line: &String| vec![kind.to_owned(), line.clone()];
    let broken = proof.found.broken();
    let rows: Vec<_> = broken
        .iter()
        .map(|line| row("broken", line))
        .chain(proof.found.remarks.iter().map(|line| row("not seen", line)))
        .collect();
    let text = if broken.is_empty() {
        "No promise is broken."
    } else {
        "Promises that are broken, each by its edge or figure."
    };
    let tables = if rows.is_empty() { Vec::new() } else { vec![Table::new(&["", "what"], rows)] };
    Section { heading: "Promises".to_owned(), text: vec![text.to_owned()], tables, ..Section::default() }
}

fn edges(proof: &Proof, emulated: Option<&Proof>) -> Section {
    let measured = proof.found.edges.iter().enumerate().filter(|(_, edges)| edges.errors.count() > 0);
    let pictures = measured.flat_map(|(index, edges)| {
        let same = emulated.and_then(|emulated| emulated.found.edges.iter().find(|other| other.what == edges.what));
        let picture = |kind: &str, of: &EdgeErrors, colour| {
            of.picture(format!("errors-{index}-{kind}"), &format!(", {kind}"), PROMISE_NS + of.unit_ns, colour)
        };
        let reference = same.filter(|other| other.errors.count() > 0).map(|other| picture("emulated", other, 1));
        reference.into_iter().chain([picture("measured", edges, 0)])
    });
    Section {
        heading: "Edges against the closed form".to_owned(),
        text: vec![
            "The closed form is computed by this tool alone, from the settings that the board was sent; the board says only when its \
             edges came. The start of each move is the one unknown: it is the median of the errors. Dashed: the promise and a stamp."
                .to_owned(),
        ],
        pictures: pictures.collect(),
        ..Section::default()
    }
}

fn method(proof: &Proof) -> Section {
    let row = |figure: &Figure| vec![figure.what.clone(), figure.resolution.clone(), figure.flatters.clone()];
    let rows = proof.found.figures.iter().filter(|figure| figure.value.is_some()).map(row).collect();
    Section {
        heading: "How finely, and what flatters".to_owned(),
        text: vec!["Every figure's resolution, and what makes it look better than it is.".to_owned()],
        tables: vec![Table::new(&["figure", "resolution", "flattered by"], rows)],
        ..Section::default()
    }
}
