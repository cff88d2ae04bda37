//! The figures as rows of a table, and as a page of pictures and tables.

use isostep::measure::{Figure, Findings, table};
use isostep_report::pictures::bench::{self, Series};
use isostep_report::pictures::document::{Page, Picture, Section, Table};

use super::port::Port;
use super::{Figures, chip::Chip};

/// The columns of [`rows`].
pub const HEAD: [&str; 5] =
    ["figure", Chip::AsItIs.name(), Chip::IdealFlash.name(), Chip::CostlyMiss.name(), "target, how finely"];

/// A row for each figure: measured on each chip, and whether the first meets the target.
pub fn rows(figures: &Figures) -> Vec<[String; 5]> {
    let all = table::by_key([&figures.chip, &figures.ideal_flash, &figures.miss_costs_twice]);
    let row = |row: [Option<&Figure>; 3]| {
        let [chip, ideal, costly] = row;
        let missed = |figure: &Figure| figure.promised.is_some() && (figure.value.is_none() || figure.is_broken());
        let other = |cell: Option<&Figure>| table::value(cell) + if cell.is_some_and(missed) { " NOT MET" } else { "" };
        [
            table::name(&row),
            table::value(chip),
            other(ideal),
            other(costly),
            row.into_iter().flatten().next().map_or_else(String::new, note),
        ]
    };
    all.into_iter().map(row).collect()
}

/// The target of a figure and whether it is met, or why there is no figure; and how finely it is measured.
fn note(figure: &Figure) -> String {
    let aim = figure.aim().map(|aim| {
        let met = figure.value.is_some() && !figure.is_broken();
        format!("{}: {aim}", if met { "met" } else { "NOT MET" })
    });
    let parts = [aim, figure.why_not.clone(), Some(figure.resolution.clone()).filter(|words| !words.is_empty())];
    parts.into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// The page.
pub fn page(figures: &Figures) -> Page {
    let text = "On the chip as it is, on one whose flash reads like RAM, and on one on which what flash's cache does not hold takes \
                twice as long to come.";
    let all = Section {
        heading: "Figures".to_owned(),
        text: vec![text.to_owned()],
        tables: vec![Table::new(&HEAD, rows(figures).into_iter().map(|row| row.to_vec()).collect())],
        ..Section::default()
    };
    let pictures = Section { heading: "Pictures".to_owned(), pictures: pictures(&figures.chip), ..Section::default() };
    Page {
        title: "Step ports on the emulated board".to_owned(),
        lead: vec![figures.conditions.clone()],
        command: figures.command.clone(),
        sections: vec![all, pictures],
        ..Page::default()
    }
}

fn pictures(chip: &Findings) -> Vec<Picture> {
    let groups = ["1 axis", "2 axes", "3 axes"].map(str::to_owned);
    let rates = bars(chip, "Highest rate sustained", "steps/s of each axis", &groups, &ports(), |port, group| {
        format!("{port}.rate.{}", group + 1)
    });
    let load = Port::ALL.map(|port| Series {
        name: port.name().to_owned(),
        values: port
            .load_rates_steps_s()
            .iter()
            .filter_map(|rate| Some((f64::from(*rate), value(chip, &format!("{}.load.{rate}", port.key()))?)))
            .collect(),
    });
    let histograms = chip.edges.iter().enumerate().filter_map(|(index, edges)| {
        let (of, _) = edges.what.split_once(':')?;
        let port = Port::ALL.into_iter().find(|port| of.starts_with(port.name()))?;
        let name = format!("errors-{}", of.to_lowercase().replace(", ", "-").replace(' ', "-"));
        Some(edges.picture(name, "", port.error_bound_ns(), index))
    });
    let generators: Vec<String> = chip
        .figures
        .iter()
        .filter_map(|figure| Some(figure.key.strip_prefix("generator.")?.strip_suffix(".cycles")?.to_owned()))
        .collect();
    let names: Vec<String> = generators.iter().map(|name| name.replace('.', "\n")).collect();
    let of_generators = |title: &str, unit: &str, parts: &[(&str, &str)]| {
        bars(chip, title, unit, &names, parts, |part, group| format!("generator.{}.{part}", generators[group]))
    };
    let errors = [("error", "whole ramp"), ("error.fast", "above a tenth of the top speed")];
    let mut all = vec![
        Picture::new("rates", rates, "The highest rate of each axis, over a logarithmic scale."),
        Picture::new(
            "load",
            bench::curves("Load of the core", "steps/s of each of 3 axes", "awake, %", &load),
            "Cruising at the rate.",
        ),
    ];
    all.extend(histograms);
    if !generators.is_empty() {
        let speed = of_generators("Worst speed error", "worst speed error, %", &errors);
        all.push(Picture::new("speed-errors", speed, "The worst error of one interval's speed."));
        let cycles = of_generators("Cycles a step", "cycles a step", &[("cycles", "cycles a step")]);
        all.push(Picture::new("cycles", cycles, "The average of a step; isostep's with its share of compiling."));
    }
    all
}

/// The beginnings of the ports' keys, and their names.
fn ports() -> [(&'static str, &'static str); 2] {
    Port::ALL.map(|port| (port.key(), port.name()))
}

/// Bars of the figures that `key` names for each series and group.
fn bars(
    chip: &Findings,
    title: &str,
    unit: &str,
    groups: &[String],
    series: &[(&str, &str)],
    key: impl Fn(&str, usize) -> String,
) -> String {
    let of = |(part, name): &(&str, &str)| Series {
        name: (*name).to_owned(),
        values: (0..groups.len()).map(|group| value(chip, &key(part, group))).collect(),
    };
    bench::bars(title, unit, groups, &series.iter().map(of).collect::<Vec<_>>())
}

fn value(chip: &Findings, key: &str) -> Option<f64> {
    chip.figure(key)?.value
}

#[cfg(test)]
mod tests {
    use isostep::measure::{Better, EdgeErrors};

    use super::*;

    fn on(measured: [Option<f64>; 3]) -> Findings {
        let of = |key: &str, better, value: Option<f64>, target| {
            let figure = Figure::new(format!("pio.{key}"), key, "us").compared(better, 0.0, 0.0).promised(target);
            match value {
                Some(value) => figure.measured(value, "finely"),
                None => figure.missing("not carried"),
            }
        };
        let [rate, error, stop] = measured;
        let figures = vec![
            of("rate.3", Better::Higher, rate, 1e6),
            of("error", Better::Lower, error, 50.0),
            of("stop", Better::Lower, stop, 10.0),
        ];
        Findings { figures, ..Findings::default() }
    }

    fn figures() -> Figures {
        let mut costly = on([Some(900_000.0), None, Some(9.0)]);
        costly.figures.pop();
        Figures {
            command: String::new(),
            conditions: String::new(),
            chip: on([Some(1_200_000.0), Some(52.126), None]),
            ideal_flash: on([Some(1_300_000.0), Some(40.0), Some(2.0)]),
            miss_costs_twice: costly,
        }
    }

    #[test]
    fn rows_say_whether_targets_are_met_and_by_which_chip() {
        let words: Vec<String> = rows(&figures()).iter().map(|row| row.join(" | ")).collect();
        assert_eq!(
            words[0],
            "rate.3 | 1,200,000 us | 1,300,000 us | 900,000 us NOT MET | met: at least 1,000,000 us; finely"
        );
        assert_eq!(words[1], "error | 52.1 us | 40 us | - NOT MET | NOT MET: at most 50 us; finely");
        assert_eq!(words[2], "stop | - | 2 us | - | NOT MET: at most 10 us; not carried");
    }

    #[test]
    fn a_page_has_the_pictures_of_its_figures() {
        let mut figures = figures();
        let mut edges =
            EdgeErrors { what: "PioPort: Edges".to_owned(), made: 1, unit_ns: 8.0, ..EdgeErrors::default() };
        edges.errors.add(3.0);
        figures.chip.edges.push(edges);
        let page = page(&figures);
        let names: Vec<&str> = page.sections[1].pictures.iter().map(|picture| picture.name.as_str()).collect();
        assert_eq!(names, ["rates", "load", "errors-pioport"]);
        assert!(page.html().contains("1,200,000 us"));
    }
}
