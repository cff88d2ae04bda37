//! The HTML page with the pictures.

use std::fmt::Display;

use isostep_console::{SETTING_TABLE, report};

use super::document::{Page, Picture, Section, Table};
use super::theme::AXIS_NAMES;
use super::{by_accel, engraving, errors, kinematics, moves, path, plane, ringing, speed, time};
use crate::again::Rule;
use crate::figures::Figures;
use crate::kinematics::OfLimit;
use isostep_motion::Axis;
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves;
use isostep_sim::{Board, MoveRecord};

/// Number of moves shown as pictures.
const PICTURES_MAX: usize = 8;
/// The same for a program of more than [`LONG`] moves.
const PICTURES_OF_LONG: usize = 4;
/// A program with more moves than this is long.
const LONG: usize = 100;

/// The largest number of losses and of violations listed.
const LINES: usize = 20;

/// File name of the picture of what a laser engraved, which is stored beside the page.
const ENGRAVING: &str = "engraving.png";

/// A run, and the same program by the other rule at corners: what both make of it, drawn once, for the page and for the files
/// beside it.
pub struct BothRules {
    pub(super) by_accel: Option<by_accel::Picture>,
    pub(super) ringing: Vec<ringing::Row>,
}

impl BothRules {
    /// Looks at a run, and at the `other` one that [`other_rule`](crate::again::other_rule) asks for, if there is one.
    pub fn of(outcome: &Outcome, other: Option<Outcome>) -> Self {
        let runs = [Some((Rule::of(outcome), outcome)), other.as_ref().map(|other| (Rule::of_other(other), other))];
        let mut runs: Vec<_> = runs.into_iter().flatten().collect();
        // Grbl's rule is to the left.
        runs.sort_by_key(|(rule, _)| rule.blends);
        let ringing = runs.iter().flat_map(|(rule, run)| ringing::rows(rule, run)).collect();
        Self { by_accel: by_accel::picture(&runs), ringing }
    }
}

/// The whole page, with its pictures and the picture of what a laser engraved, an image beside it.
pub fn page(outcome: &Outcome, both: &BothRules, figures: &Figures) -> Page {
    let engraved = engraving::picture(outcome).filter(|_| !figures.moves.is_empty());
    let of_moves = if figures.moves.is_empty() {
        Vec::new()
    } else {
        of_moves(outcome, both, figures, engraved.as_ref().map(engraving::Picture::caption))
    };
    Page {
        title: format!("{}: simulated", figures.program),
        lead: vec![format!("Run on the controller in virtual time: {}", summary(figures))],
        command: figures.replay.clone(),
        sections: [checks(figures)].into_iter().chain(of_moves).chain([settings(outcome)]).collect(),
        images: engraved.map(|picture| (ENGRAVING.to_owned(), picture.png)).into_iter().collect(),
    }
}

fn summary(figures: &Figures) -> String {
    let seconds = |ns: u64| ns as f64 * 1e-9;
    let place: Vec<_> = Axis::ALL.iter().zip(figures.position_mm).map(|(axis, mm)| format!("{axis} {mm:.2}")).collect();
    let homing = match figures.homing_ns {
        0 => String::new(),
        ns => format!(" ({:.3} s of it homing)", seconds(ns)),
    };
    format!(
        "{} steps, by ticks of {:.0} ns, in {:.3} s of machine time{homing}, resting at {} mm.",
        figures.steps_total,
        figures.tick_ns,
        seconds(figures.duration_ns),
        place.join(", "),
    )
}

fn checks(figures: &Figures) -> Section {
    let rows = figures.verdicts.iter().map(|verdict| {
        let kept = if verdict.kept { "kept" } else { "broken" };
        vec![kept.to_owned(), verdict.promise.to_owned(), verdict.detail.clone()]
    });
    let lists = [list("Steps lost", &figures.losses), list("Driver timing not kept", &figures.violations)];
    let table = Table::new(&["", "promise", "found"], rows.collect());
    Section::new("Checks").with_tables([table]).with_tables(lists.into_iter().flatten())
}

/// A table of the first of these lines; `None` if there is none.
fn list(caption: &str, lines: &[impl Display]) -> Option<Table> {
    let rows = lines.iter().take(LINES).map(|line| vec![line.to_string()]).collect();
    (!lines.is_empty()).then(|| Table::new(&[""], rows).captioned(caption))
}

fn of_moves(outcome: &Outcome, both: &BothRules, figures: &Figures, engraved: Option<String>) -> Vec<Section> {
    let sources = lines_of_moves::of_moves(outcome);
    let with = |heading: &str, picture: Picture| Section::new(heading).with_pictures([picture]);
    let sides = path::SIDES.into_iter().filter(|_| path::has_sides(outcome));
    let planes = [plane::XY].into_iter().chain(sides);
    let paths = planes.map(|axes| path_of(axes, path::picture(outcome, &sources, axes), figures));
    let path = Section::new("Path").with_pictures(paths);
    let by_accel = both.by_accel.as_ref().map(|drawn| {
        let picture = Picture::new("path-by-acceleration", drawn.svg.clone(), drawn.caption.clone());
        with("Acceleration over its limit", picture)
    });
    let engraving = engraved.map(|caption| {
        let image = format!("<img src=\"{ENGRAVING}\" alt=\"What the laser engraved\">");
        with("Engraving", Picture::new("engraving", image, caption))
    });
    let seconds = [figures.pace.slowest_second, figures.pace.busiest_second];
    let caption = "The line is the mean of each span of time, the band its lowest to highest. A strip at the bottom is where moves were \
                   taken together.";
    let speed = Picture::new("speed", speed::picture(outcome, &sources, seconds), caption);
    let speed = with("Speed along the program", speed);
    let shaping = figures.shaping.as_ref().map(|shaping| Section::new("Shaping").with_text(format!("{shaping}.")));
    let ringing = ringing::section(outcome, &both.ringing, &figures.ringing_unshaped);
    let caption = "How far the steps were from the closed form of their moves: each bar spans the earliest to the latest of its time. \
                   Dashed: one tick of the step port.";
    let errors = with("Step instants", Picture::new("errors", errors::picture(outcome), caption));
    [Some(path), by_accel, engraving, Some(speed), Some(time::shares(&figures.pace)), time::slow_places(&figures.pace)]
        .into_iter()
        .chain([Some(axes(figures)), shaping, ringing, Some(moves::section(figures))])
        .chain([Some(kinematics(outcome, figures)), Some(errors)])
        .flatten()
        .collect()
}

fn path_of(axes: plane::Axes, path: path::Picture, figures: &Figures) -> Picture {
    let plane = plane::letters(axes);
    let [right, up] = axes.map(|axis| AXIS_NAMES[axis]);
    let [x, y] = path.extent_mm.map(|(low, high)| format!("{:.2} to {:.2}", low + 0.0, high + 0.0));
    let what =
        if path.by_edges { "Where the edges say the carriage went, in the" } else { "The path as planned, in the" };
    let mut caption = format!(
        "{what} {plane} plane, coloured by the planned speed along it; slow places are drawn over fast ones. {right} {x}, {up} {y} mm."
    );
    for (holds, text) in [
        (path.with_rapids, " Dashed lines are rapids."),
        (path.with_dots, " Dots end lines of the program."),
        (figures.homing_ns > 0, " The dashed frame is the travel."),
        (
            path.with_together,
            " The wide band is where short moves were taken together: each made as a part of a longer line.",
        ),
    ] {
        caption += if holds { text } else { "" };
    }
    caption.extend(path.simplified.map(|simplified| format!(" {simplified}")));
    let name = if axes == plane::XY { "path".to_owned() } else { format!("path-{}", plane.to_lowercase()) };
    Picture { name, svg: path.svg, caption }
}

fn kinematics(outcome: &Outcome, figures: &Figures) -> Section {
    let longest = if figures.moves_total > LONG { " Here are the longest moves." } else { "" };
    let about = "One profile drives every axis of a move, so all accelerate, cruise and decelerate over the same intervals, shaded.";
    let pictures = shown(outcome).into_iter().map(|(number, record)| {
        Picture::new(
            format!("move-{number}"),
            kinematics::of_move(outcome, record),
            format!(
                "Move {number}, {} steps. Lines are planned, dots measured from the edges.",
                record.plan.steps.map(|n| n.to_string()).join(", ")
            ),
        )
    });
    Section::new("Speed and acceleration").with_text(format!("{about}{longest}")).with_pictures(pictures)
}

/// The moves shown as pictures, with their numbers. Moves of several axes are preferred; for a long program, the
/// longest moves.
fn shown(outcome: &Outcome) -> Vec<(usize, &MoveRecord)> {
    let program = || (1..).zip(outcome.program_moves());
    let axes = |record: &MoveRecord| record.plan.steps.iter().filter(|n| **n != 0).count();
    let several = program().any(|(_, record)| axes(record) > 1);
    let candidates = program().filter(|(_, record)| !several || axes(record) > 1);
    if program().nth(LONG).is_none() {
        return candidates.take(PICTURES_MAX).collect();
    }
    let mut longest: Vec<_> = candidates.collect();
    longest.sort_by(|(_, one), (_, other)| other.plan.distance_steps().total_cmp(&one.plan.distance_steps()));
    longest.truncate(PICTURES_OF_LONG);
    longest.sort_by_key(|&(number, _)| number);
    longest
}

fn axes(figures: &Figures) -> Section {
    let of = |OfLimit { found, limit }: OfLimit| format!("{found:.2} of {limit:.2}");
    let or_dash = |text: Option<String>| text.unwrap_or("-".to_owned());
    let rows = figures.axes.iter().map(|one| {
        vec![
            one.axis.to_string(),
            of(one.speed_mm_s),
            of(one.accel_mm_s2),
            of(one.decel_mm_s2),
            or_dash(one.jump.map(|jump| of(OfLimit { found: jump.mm_s, limit: one.jump_limit_mm_s }))),
            or_dash(one.jump.map(|jump| format!("{:.0}", jump.mm_min))),
            or_dash(one.jump.map(|jump| jump.move_number.to_string())),
            or_dash(one.jump.and_then(|jump| jump.line).map(|line| line.to_string())),
        ]
    });
    let head =
        ["", "speed, mm/s", "accelerates, mm/s²", "decelerates, mm/s²", "jumps, mm/s", "mm/min", "to move", "line"];
    let about = "Within moves, from the edges of each axis alone, up to 1 % high. At a corner the speed of an axis jumps, as planned; at \
                 most by sqrt(8 x acceleration x $11), or twice the start speed.";
    let belts = figures.belts.map_or(String::new(), |belts| format!(" And {belts}."));
    Section::new("Axes and their limits")
        .with_text(format!("{about}{belts}"))
        .with_tables([Table::new(&head, rows.collect())])
}

fn settings(outcome: &Outcome) -> Section {
    let of_board = |row: &&isostep_console::Setting| !row.is_trinamic() || outcome.config.board == Board::SkrPico;
    let rows = SETTING_TABLE.iter().filter(of_board).flat_map(|row| {
        let cells = |line: &str| {
            let (number, value) = line.split_once('=').unwrap_or((line, ""));
            [number, value, row.unit, row.meaning()].map(str::to_owned).to_vec()
        };
        setting_lines(row, outcome).lines().map(cells).collect::<Vec<_>>()
    });
    let table = Table::new(&["setting", "value", "unit", "meaning"], rows.collect());
    Section::new("Settings at power-up").with_tables([table])
}

fn setting_lines(row: &isostep_console::Setting, outcome: &Outcome) -> String {
    let mut lines = String::new();
    report::setting(&mut lines, row, &outcome.config.settings).expect("a String takes any text");
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, run};

    #[test]
    fn the_path_is_drawn_from_the_sides_if_z_moves() {
        const PLANES: [&str; 3] = ["XY", "XZ", "YZ"];
        const FILES: [&str; 3] = ["path.svg", "path-xz.svg", "path-yz.svg"];
        for (program, expected) in [("G1 X10 Z1 F600\n", [true; 3]), ("G1 X10 Y5 F600\n", [true, false, false])] {
            let outcome = run(program.as_bytes(), &Config::default()).unwrap();
            let both = BothRules::of(&outcome, None);
            let page = page(&outcome, &both, &Figures::new("a.nc", &outcome));
            let (html, files) = (page.html(), page.files());
            let on_page = PLANES.map(|plane| html.contains(&format!("Path in the {plane} plane, coloured by speed")));
            let beside = FILES.map(|wanted| files.iter().any(|(name, _)| name == wanted));
            assert_eq!([on_page, beside], [expected; 2], "{program}");
        }
    }
}
