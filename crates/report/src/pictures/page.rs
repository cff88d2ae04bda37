//! The HTML page with the pictures.

use isostep_console::{SETTING_TABLE, report};
use maud::{Markup, PreEscaped, html};

use super::theme::{self, AXIS_NAMES};
use super::{BothRules, engraving, errors, kinematics, moves, path, plane, ringing, speed, time};
use crate::figures::Figures;
use crate::kinematics::OfLimit;
use crate::pace;
use isostep_motion::{AXES, Axis};
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves;
use isostep_sim::{Board, MoveRecord};

/// Number of moves shown as pictures.
const PICTURES_MAX: usize = 8;
/// The same for a program of more than [`LONG`] moves.
const PICTURES_OF_LONG: usize = 4;
/// A program with more moves than this is long.
const LONG: usize = 100;

/// File name of the picture of what a laser engraved, which is stored beside the page.
const ENGRAVING: &str = "engraving.png";

/// The whole page.
pub fn page(outcome: &Outcome, both: &BothRules, figures: &Figures) -> String {
    let title = format!("{}: simulated", figures.program);
    let body = html! {
        h1 { (figures.program) }
        p { "Run on the controller in virtual time: " (summary(figures)) }
        p { code { (figures.replay) } }
        (verdicts(figures))
        @if !figures.moves.is_empty() { (body_of_moves(outcome, both, figures)) }
        (settings(outcome))
    };
    theme::document(&title, &body)
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

fn verdicts(figures: &Figures) -> Markup {
    html! {
        h2 { "Checks" }
        div.scroll { table {
            thead { tr { th { "" } th { "promise" } th { "found" } } }
            tbody {
                @for verdict in &figures.verdicts {
                    tr {
                        td class=(if verdict.kept { "kept" } else { "broken" }) { (if verdict.kept { "kept" } else { "broken" }) }
                        td { (verdict.promise) }
                        td.found { (verdict.detail) }
                    }
                }
            }
        } }
        @if !figures.losses.is_empty() {
            h3 { "Steps lost" }
            ul { @for loss in figures.losses.iter().take(20) { li { (loss) } } }
        }
        @if !figures.violations.is_empty() {
            h3 { "Driver timing not kept" }
            ul { @for violation in figures.violations.iter().take(20) { li { (violation) } } }
        }
    }
}

fn body_of_moves(outcome: &Outcome, both: &BothRules, figures: &Figures) -> Markup {
    let sources = lines_of_moves::of_moves(outcome);
    html! {
        h2 { "Path" }
        (path_of(plane::XY, path::picture(outcome, &sources, plane::XY), figures))
        @if path::has_sides(outcome) {
            @for axes in path::SIDES { (path_of(axes, path::picture(outcome, &sources, axes), figures)) }
        }
        @if let Some(picture) = &both.by_accel {
            h2 { "Acceleration over its limit" }
            figure { (PreEscaped(&picture.svg)) figcaption { (picture.caption) } }
        }
        @if let Some(picture) = engraving::picture(outcome) {
            h2 { "Engraving" }
            figure { img src=(ENGRAVING) alt="What the laser engraved"; figcaption { (picture.caption()) } }
        }
        h2 { "Speed along the program" }
        figure { (PreEscaped(speed::picture(outcome, &sources, [figures.pace.slowest_second, figures.pace.busiest_second]))) figcaption {
            span.key style="background: var(--x)" {} "planned speed along the path: the line is the mean of each span of time, the band its lowest to highest. "
            span.key style="background: var(--bound)" {} "asked for: the feed, or what the top speeds of the axes allow."
        } }
        (time::shares(&figures.pace))
        (time::slow_places(&figures.pace))
        (axes(figures))
        @if let Some(shaping) = &figures.shaping { h2 { "Shaping" } p { (shaping) "." } }
        @if let Some(section) = ringing::section(outcome, &both.ringing, &figures.ringing_unshaped) { (section) }
        (moves::table(figures))
        (pictures(outcome, figures))
    }
}

fn path_of(axes: plane::Axes, path: path::Picture, figures: &Figures) -> Markup {
    let plane = plane::letters(axes);
    let [right, up] = axes.map(|axis| AXIS_NAMES[axis]);
    let [x, y] = path.extent_mm.map(|(low, high)| format!("{:.2} to {:.2}", low + 0.0, high + 0.0));
    html! {
        figure { (PreEscaped(path.svg)) figcaption {
            (if path.by_edges { "Where the edges say the carriage went, in the " } else { "The path as planned, in the " })
            (plane) " plane, coloured by the planned speed along it; slow places are drawn over fast ones. "
            (right) " " (x) ", " (up) " " (y) " mm."
            @if path.with_rapids { " Dashed lines are rapids." }
            @if path.with_dots { " Dots end lines of the program." }
            @if figures.homing_ns > 0 { " The dashed frame is the travel." }
            @if let Some(simplified) = path.simplified { " " (simplified) }
        } }
    }
}

fn pictures(outcome: &Outcome, figures: &Figures) -> Markup {
    html! {
        h2 { "Speed and acceleration" }
        p { "One profile drives every axis of a move, so all accelerate, cruise and decelerate over the same intervals, shaded." @if figures.moves_total > LONG { " Here are the longest moves." } }
        @for (number, record) in shown(outcome) {
            figure {
                figcaption {
                    "Move " (number) ", " (steps_text(record.plan.steps)) " steps. "
                    (key(&moving(record.plan.steps))) "Lines are planned, dots measured from the edges."
                }
                (PreEscaped(kinematics::of_move(outcome, record)))
            }
        }
        h2 { "Step instants" }
        figure { (PreEscaped(errors::picture(outcome))) figcaption {
            (key(&Axis::ALL.map(|axis| axis as usize))) "How far the steps were from the closed form of their moves: each bar spans the earliest to the latest of its time. Dashed: one tick of the step port."
        } }
    }
}

/// The moves shown as pictures, with their numbers. Moves of several axes are preferred; for a long program, the
/// longest moves.
fn shown(outcome: &Outcome) -> Vec<(usize, &MoveRecord)> {
    let program = || (1..).zip(outcome.moves.iter().filter(|record| !record.homing));
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

/// The page's pictures of path, speed and moves as separate files, by name: SVG in light colours. Also the picture of
/// what a laser engraved, a PNG that the page shows.
pub fn files(outcome: &Outcome, both: &BothRules) -> Vec<(String, Vec<u8>)> {
    let moves = shown(outcome).into_iter();
    let moves = moves.map(|(number, record)| (format!("move-{number}.svg"), kinematics::of_move(outcome, record)));
    let sources = lines_of_moves::of_moves(outcome);
    let path = ("path.svg".to_owned(), path::picture(outcome, &sources, plane::XY).svg);
    let sides = path::SIDES.into_iter().filter(|_| path::has_sides(outcome)).map(|axes| {
        let name = format!("path-{}.svg", plane::letters(axes).to_lowercase());
        (name, path::picture(outcome, &sources, axes).svg)
    });
    let seconds = pace::extreme_seconds(outcome, &sources);
    let speed = ("speed.svg".to_owned(), speed::picture(outcome, &sources, seconds));
    let swings = ringing::picture(outcome).map(|picture| ("ringing.svg".to_owned(), picture));
    let by_accel = both.by_accel.as_ref().map(|picture| ("path-by-acceleration.svg".to_owned(), picture.svg.clone()));
    let drawn = moves
        .chain([path, speed])
        .chain(sides)
        .chain(by_accel)
        .chain(swings)
        .map(|(name, picture)| (name, theme::standalone(&picture).into_bytes()));
    drawn.chain(engraving::picture(outcome).map(|picture| (ENGRAVING.to_owned(), picture.png))).collect()
}

/// The key of axes and colours.
fn key(axes: &[usize]) -> Markup {
    html! {
        @for &axis in axes {
            span.key style=(format!("background: var(--{})", AXIS_NAMES[axis].to_lowercase())) {} (AXIS_NAMES[axis]) " "
        }
    }
}

fn moving(steps: [i32; AXES]) -> Vec<usize> {
    (0..AXES).filter(|&axis| steps[axis] != 0).collect()
}

fn axes(figures: &Figures) -> Markup {
    let of = |OfLimit { found, limit }: OfLimit| format!("{found:.2} of {limit:.2}");
    html! {
        h2 { "Axes and their limits" }
        p { "Within moves, from the edges of each axis alone, up to 1 % high. At a corner the speed of an axis jumps, as planned; at most by sqrt(8 x acceleration x $11), or twice the start speed." }
        div.scroll { table {
            thead { tr {
                th { "" } th { "speed, mm/s" } th { "accelerates, mm/s²" } th { "decelerates, mm/s²" }
                th { "jumps, mm/s" } th { "mm/min" } th { "to move" } th { "line" }
            } }
            tbody { @for one in &figures.axes {
                @let jump = one.jump.map(|jump| OfLimit { found: jump.mm_s, limit: one.jump_limit_mm_s });
                tr {
                    td { (one.axis) } td { (of(one.speed_mm_s)) } td { (of(one.accel_mm_s2)) } td { (of(one.decel_mm_s2)) }
                    td { (jump.map_or("-".to_owned(), of)) }
                    td { (one.jump.map_or("-".to_owned(), |jump| format!("{:.0}", jump.mm_min))) }
                    td { (one.jump.map_or("-".to_owned(), |jump| jump.move_number.to_string())) }
                    td { (one.jump.and_then(|jump| jump.line).map_or("-".to_owned(), |line| line.to_string())) }
                }
            } }
        } }
    }
}

fn settings(outcome: &Outcome) -> Markup {
    html! {
        h2 { "Settings at power-up" }
        div.scroll { table {
            thead { tr { th { "setting" } th { "value" } th { "unit" } th { "meaning" } } }
            tbody { @for row in SETTING_TABLE.iter().filter(|row| !row.is_trinamic() || outcome.config.board == Board::SkrPico) {
                @for line in setting_lines(row, outcome).lines() {
                    @let (number, value) = line.split_once('=').unwrap_or((line, ""));
                    tr { td { code { (number) } } td { (value) } td { (row.unit) } td { (row.meaning()) } }
                }
            } }
        } }
    }
}

fn setting_lines(row: &isostep_console::Setting, outcome: &Outcome) -> String {
    let mut lines = String::new();
    report::setting(&mut lines, row, &outcome.config.settings).expect("a String takes any text");
    lines
}

fn steps_text(steps: [i32; AXES]) -> String {
    steps.map(|n| n.to_string()).join(", ")
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
            let (page, files) = (page(&outcome, &both, &Figures::new("a.nc", &outcome)), files(&outcome, &both));
            let on_page = PLANES.map(|plane| page.contains(&format!("Path in the {plane} plane, coloured by speed")));
            let beside = FILES.map(|wanted| files.iter().any(|(name, _)| name == wanted));
            assert_eq!([on_page, beside], [expected; 2], "{program}");
        }
    }
}
