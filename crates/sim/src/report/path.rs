//! The path in the XY plane, coloured by speed, with the travel where the machine was homed.

use std::fmt::Write;

use plotters::prelude::*;

use super::rack;
use super::speed_scale::SpeedScale;
use super::strokes::{Piece, Point, Strokes};
use super::theme::{self, Area, BOUND, Drawn, GRID, INK};
use crate::lines_of_moves::Source;
use crate::moves::MoveRecord;
use crate::outcome::Outcome;
use crate::pace::course::{Change, Phase, phases};

/// Up to this number of moves, the path is drawn through the edges.
const MOVES_BY_EDGES: usize = 5_000;
/// Number of points per move in this case.
const POINTS_PER_MOVE: usize = 200;
/// Up to this number of moves, the ends of moves are drawn as dots.
const MOVES_WITH_DOTS: usize = 200;
/// The largest number of pieces of a ramp, each with one colour.
const PIECES_PER_RAMP: usize = 24;
/// Limit of the size of the path's lines, bytes: they are in the page and in a separate file.
const BYTES_MAX: usize = 1_500_000;
/// To reach the limit, the length below which pieces are drawn as one is doubled up to this, in fine pixels. After
/// that, pieces are left out.
const LEAST_MAX: f64 = 16.0;

/// plotters rounds points to whole pixels, which would distort straight lines. Drawn at this scale, the error is not
/// visible.
const FINE: u32 = 4;
/// Size of the area inside the labels, in fine pixels.
const INNER: (f64, f64) = (2_704.0, 2_592.0);
/// Height of the key above, pixels.
const KEY: u32 = 40;

/// A picture and how it was drawn.
pub struct Picture {
    /// The SVG element.
    pub svg: String,
    /// Whether it was drawn through the edges and not from the plans.
    pub by_edges: bool,
    /// Whether ends of moves are drawn as dots.
    pub with_dots: bool,
    /// A sentence about what was left out to limit the size, if anything was.
    pub simplified: Option<String>,
    /// The least and greatest positions, mm: X and Y.
    pub extent_mm: [(f64, f64); 2],
}

/// Draws the picture; `sources` are those of all moves.
pub fn picture(outcome: &Outcome, sources: &[Option<Source>]) -> Picture {
    let course = || phases(outcome, sources);
    let moves = outcome.moves.iter().filter(|record| !record.homing).count();
    let extent_mm = extent_mm(outcome);
    let plane = Plane::new(outcome, extent_mm);
    let by_edges = moves <= MOVES_BY_EDGES && !outcome.edges.is_empty();
    let with_dots = moves <= MOVES_WITH_DOTS;
    let scale = SpeedScale::of(course());
    let (mut lines, simplified) = lines(moves, scale, if with_dots { 3 * FINE } else { FINE * 3 / 2 }, |take| {
        if by_edges {
            pieces_by_edges(outcome, course(), &plane, take)
        } else {
            pieces(outcome, course(), &plane, take)
        }
    });
    lines += &dots(outcome, &plane, with_dots);
    let size = (760 * FINE, (720 + KEY) * FINE);
    let svg = theme::svg(size, "Path in the XY plane, coloured by speed", |area| draw(area, outcome, &plane));
    let key = scale.key([120 * FINE, 14 * FINE], FINE);
    let svg = svg.replace("</svg>", &format!("{lines}{key}</svg>"));
    Picture { svg, by_edges, with_dots, simplified, extent_mm }
}

/// Converts millimetres to positions in the picture.
struct Plane {
    homed: bool,
    /// Whether the machine is the parking gantry, whose rack is shown.
    has_rack: bool,
    x_mm: (f64, f64),
    y_mm: (f64, f64),
}

/// The upper left corner inside the labels, in fine pixels.
const CORNER: Point = [((12 + 60) * FINE) as f64, ((12 + KEY) * FINE) as f64];

impl Plane {
    /// Chooses the area that is shown, with the same scale in both directions.
    fn new(outcome: &Outcome, [mut x, mut y]: [(f64, f64); 2]) -> Self {
        let homed = outcome.moves.iter().any(|record| record.homing);
        let has_rack = homed && rack::is_of(outcome);
        if has_rack {
            let (rack_x, rack_y) = rack::extent_mm();
            x = (x.0.min(rack_x.0), x.1.max(rack_x.1));
            y = (y.0.min(rack_y.0), y.1.max(rack_y.1));
        }
        let scale = ((x.1 - x.0) / INNER.0).max((y.1 - y.0) / INNER.1).max(1e-3) * 1.08;
        let around = |range: (f64, f64), pixels: f64| {
            let middle = (range.0 + range.1) / 2.0;
            (middle - scale * pixels / 2.0, middle + scale * pixels / 2.0)
        };
        Self { homed, has_rack, x_mm: around(x, INNER.0), y_mm: around(y, INNER.1) }
    }

    fn fine_per_mm(&self) -> f64 {
        INNER.0 / (self.x_mm.1 - self.x_mm.0)
    }

    fn point(&self, mm: [f64; 3]) -> Point {
        let scale = self.fine_per_mm();
        [CORNER[0] + (mm[0] - self.x_mm.0) * scale, CORNER[1] + (self.y_mm.1 - mm[1]) * scale]
    }
}

/// The lines, simplified until they are small enough, and a sentence about the simplification.
fn lines(
    moves: usize,
    scale: SpeedScale,
    width: u32,
    pieces: impl Fn(&mut dyn FnMut(&Piece)),
) -> (String, Option<String>) {
    let (mut least, mut stride) = (if moves <= MOVES_WITH_DOTS { 0.5 } else { FINE as f64 / 2.0 }, 1);
    loop {
        let mut strokes = Strokes::new(scale, least);
        let mut number = 0_usize;
        pieces(&mut |piece| {
            number += 1;
            if number.is_multiple_of(stride) && strokes.bytes() <= BYTES_MAX {
                strokes.take(piece);
            }
        });
        if strokes.bytes() <= BYTES_MAX {
            return (strokes.finish(width), simplified(least / f64::from(FINE), stride));
        }
        if least < LEAST_MAX { least *= 2.0 } else { stride *= 2 }
    }
}

fn simplified(pixels: f64, stride: usize) -> Option<String> {
    let drawn = format!("What is shorter than {pixels} pixels is drawn as one, with its mean speed");
    match stride {
        1 if pixels < 0.5 => None,
        1 => Some(format!("{drawn}.")),
        _ => Some(format!("{drawn}, and of all pieces only one in {stride} is drawn.")),
    }
}

/// The phases as planned, with ramps divided into pieces of about one colour.
fn pieces<'a>(
    outcome: &'a Outcome,
    phases: impl Iterator<Item = Phase<'a>>,
    plane: &Plane,
    take: &mut dyn FnMut(&Piece),
) {
    for phase in phases {
        let [x, y, _] = phase.asked.direction;
        let fine = phase.distance_mm * x.hypot(y) * plane.fine_per_mm();
        let count = match phase.change {
            _ if fine == 0.0 => continue,
            Change::Level => 1,
            Change::Up | Change::Down => (fine / f64::from(2 * FINE)).ceil().min(PIECES_PER_RAMP as f64) as usize,
        };
        let mut made_mm = 0.0;
        for number in 1..=count {
            let to_mm = phase.made_mm(phase.begin_s + phase.span_s * number as f64 / count as f64);
            let [from, to] = [made_mm, to_mm].map(|mm| plane.point(phase.place_mm(outcome, mm)));
            take(&Piece { from, to, distance_mm: to_mm - made_mm, span_s: phase.span_s / count as f64 });
            made_mm = to_mm;
        }
    }
}

/// The path by the positions of the edges, with the planned speed.
fn pieces_by_edges<'a>(
    outcome: &'a Outcome,
    phases: impl Iterator<Item = Phase<'a>>,
    plane: &Plane,
    take: &mut dyn FnMut(&Piece),
) {
    let phases: Vec<_> = phases.collect();
    for phases in phases.chunk_by(|one, next| one.index == next.index) {
        let record = &outcome.moves[phases[0].index];
        let points = points(outcome, record);
        if points.iter().all(|(_, mm)| mm[..2] == points[0].1[..2]) {
            continue;
        }
        let begin_s = phases[0].begin_s;
        for pair in points.windows(2) {
            let middle_s = begin_s + (pair[0].0 + pair[1].0) / 2.0;
            let phase = phases.iter().find(|phase| middle_s < phase.end_s()).unwrap_or(&phases[phases.len() - 1]);
            let [from, to] = [pair[0].1, pair[1].1].map(|mm| plane.point(mm));
            // The planned speed is used because the steps of the edges are not even.
            take(&Piece { from, to, distance_mm: phase.speed_mm_s(middle_s), span_s: 1.0 });
        }
    }
}

/// Instants from the beginning of a move, s, and the positions at its edges, mm.
fn points(outcome: &Outcome, record: &MoveRecord) -> Vec<(f64, [f64; 3])> {
    let edges = &outcome.edges[record.edges.clone()];
    let stride = edges.len().div_ceil(POINTS_PER_MOVE).max(1);
    let begin_s = record.plan.begin_s();
    let mut at = record.origin_steps;
    let mut points = vec![(0.0, outcome.mm(at))];
    for (number, edge) in edges.iter().enumerate() {
        at[edge.axis] += edge.direction;
        if number % stride == 0 || number + 1 == edges.len() {
            points.push(((edge.t_ns - record.start_ns) as f64 * 1e-9 - begin_s, outcome.mm(at)));
        }
    }
    points
}

/// Dots for the start and, if wanted, the ends of moves.
fn dots(outcome: &Outcome, plane: &Plane, with_ends: bool) -> String {
    let mut svg = String::new();
    let program = outcome.moves.iter().filter(|record| !record.homing);
    let moved = |record: &&MoveRecord| record.origin_steps[..2] != record.end_steps[..2];
    let mut program = program.filter(moved).peekable();
    let start = program.peek().map(|record| plane.point(outcome.mm(record.origin_steps)));
    for record in program.filter(|_| with_ends) {
        let [x, y] = plane.point(outcome.mm(record.end_steps));
        let _ = write!(svg, "<circle cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"{}\" fill=\"var(--ink)\"/>", 4 * FINE);
    }
    if let Some([x, y]) = start {
        let is_low = y + 96.0 > CORNER[1] + INNER.1;
        let (left, below, size) = (x - 64.0, if is_low { y - 44.0 } else { y + 96.0 }, 14 * FINE);
        let _ = write!(svg, "<circle cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"{}\" fill=\"var(--y)\"/>", 7 * FINE);
        let _ = write!(
            svg,
            "<text x=\"{left:.0}\" y=\"{below:.0}\" font-family=\"sans-serif\" font-size=\"{size}\" fill=\"var(--ink)\">start</text>"
        );
    }
    svg
}

fn draw(area: &Area, outcome: &Outcome, plane: &Plane) -> Drawn {
    let (x, y) = (plane.x_mm, plane.y_mm);
    let decimals = theme::decimals_of(x.1 - x.0);
    let label = |mm: &f64| format!("{mm:.decimals$}");
    let mut chart = ChartBuilder::on(area)
        .margin(12 * FINE)
        .margin_top((12 + KEY) * FINE)
        .x_label_area_size(48 * FINE)
        .y_label_area_size(60 * FINE)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(FINE))
        .axis_style(INK.stroke_width(FINE))
        .label_style(theme::font(14 * FINE))
        .axis_desc_style(theme::font(15 * FINE))
        .set_all_tick_mark_size(5 * FINE)
        .x_desc("X, mm")
        .y_desc("Y, mm")
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .draw()?;
    if plane.has_rack {
        chart.draw_series(rack::bays(FINE))?;
        chart.draw_series(rack::names(FINE))?;
    }
    if plane.homed {
        let far = (outcome.travel_mm[0], outcome.travel_mm[1]);
        chart.draw_series(DashedLineSeries::new(
            [(0.0, 0.0), (far.0, 0.0), far, (0.0, far.1), (0.0, 0.0)],
            6 * FINE,
            5 * FINE,
            BOUND.stroke_width(FINE),
        ))?;
    }
    Ok(())
}

/// The range of X and Y over the moves that move X or Y, mm.
fn extent_mm(outcome: &Outcome) -> [(f64, f64); 2] {
    let program = outcome.moves.iter().filter(|record| !record.homing);
    let moved = program.filter(|record| record.origin_steps[..2] != record.end_steps[..2]);
    let ends = moved.flat_map(|record| [record.origin_steps, record.end_steps].map(|steps| outcome.mm(steps)));
    [0, 1].map(|axis| theme::range(ends.clone().map(|mm| mm[axis])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pace::course::phases;
    use crate::{Config, lines_of_moves, run};

    fn outcome(program: &str) -> Outcome {
        let mut config = Config::default();
        config.settings.soft_limits = false;
        run(program.as_bytes(), &config).unwrap()
    }

    fn picture_of(program: &str) -> Picture {
        let outcome = outcome(program);
        picture(&outcome, &lines_of_moves::of_moves(&outcome))
    }

    /// Long lines back and forth, whose number is not reduced by a least length.
    #[test]
    fn however_many_long_lines_there_are_the_picture_is_bounded() {
        let outcome = outcome("G91 G1 F600 X10\n");
        let sources = lines_of_moves::of_moves(&outcome);
        let scale = SpeedScale::of(phases(&outcome, &sources));
        let pieces = |take: &mut dyn FnMut(&Piece)| {
            let mut random = oorandom::Rand32::new(3);
            let mut from = [0.0; 2];
            for _ in 0..400_000 {
                let to = [random.rand_float(), random.rand_float()].map(|share| f64::from(share) * 2_700.0);
                take(&Piece { from, to, distance_mm: 1.0, span_s: f64::from(random.rand_float()) + 0.01 });
                from = to;
            }
        };
        let (svg, simplified) = lines(400_000, scale, 6, pieces);
        assert!(svg.len() < BYTES_MAX + 1_000 && svg.len() > BYTES_MAX / 8, "{}", svg.len());
        assert!(simplified.unwrap().contains("one in "));
    }

    #[test]
    fn a_short_program_has_dots_and_a_start_and_no_rack_unless_homed() {
        let picture = picture_of("G91 G1 F600 X10\nY5\n");
        assert!(picture.by_edges && picture.with_dots && picture.simplified.is_none());
        assert_eq!(picture.svg.matches("<circle").count(), 3);
        assert!(picture.svg.contains(">start</text>") && !picture.svg.contains("bay 1"));
        assert_eq!(picture.extent_mm, [(0.0, 10.0), (0.0, 5.0)]);
        let homed = picture_of("$H\nG90 G1 F600 X10\n");
        assert!(homed.svg.contains("bay 1") && homed.svg.contains("pick-up point"));
        let other = picture_of("$130=300\n$H\nG90 G1 F600 X10\n");
        assert!(!other.svg.contains("bay 1"), "another machine has no rack");
    }

    #[test]
    fn many_moves_have_no_dots_and_one_element_a_colour() {
        let picture = picture_of(&format!("G91 G1 F1200\n{}", "X0.5 Y0.2\nX0.5 Y-0.2\n".repeat(150)));
        assert!(!picture.with_dots && picture.svg.matches("<circle").count() == 1);
        assert!(picture.simplified.is_some());
        assert!((1..=8).contains(&picture.svg.matches("<path").count()), "{}", picture.svg);
    }

    /// Edges and plans give the same lines, within one step.
    #[test]
    fn edges_and_plans_draw_the_same_path() {
        let outcome = outcome("G91 G1 F1200 X20 Y10\nX-5 Y20\n");
        let sources = lines_of_moves::of_moves(&outcome);
        let plane = Plane::new(&outcome, extent_mm(&outcome));
        let (mut planned, mut made) = (Vec::new(), Vec::new());
        pieces(&outcome, phases(&outcome, &sources), &plane, &mut |piece| planned.push(*piece));
        pieces_by_edges(&outcome, phases(&outcome, &sources), &plane, &mut |piece| made.push(*piece));
        let top = |pieces: &[Piece]| pieces.iter().map(|piece| piece.to[0]).fold(0.0, f64::max);
        let ends = [&planned, &made].map(|pieces| (top(pieces), pieces.last().unwrap().to));
        let [(planned_top, planned), (made_top, made)] = ends;
        assert!((planned_top - made_top).abs() < 1e-6, "{planned_top} {made_top}");
        assert!((0..2).all(|at| (planned[at] - made[at]).abs() < 1e-6), "{planned:?} {made:?}");
    }
}
