//! The path in the plane of two axes, coloured by speed, rapids dashed, with the travel where the machine was homed.

use std::fmt::Write;

use isostep_console::Rate;

use super::plane::{Axes, FINE, Plane, Room, XY, letters, moves_in};
use super::scales::{Made, SpeedScale};
use super::strokes::{self, Piece};
use super::theme;
use super::together::{self, Band};
use crate::pace::phases::{Change, Phase, phases};
use isostep_motion::AXES;
use isostep_sim::MoveRecord;
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;

/// Up to this number of moves, the path is drawn through the edges.
const MOVES_BY_EDGES: usize = 5_000;
/// Number of points per move in this case.
const POINTS_PER_MOVE: usize = 200;
/// Up to this number of moves, the ends of moves are drawn as dots.
const MOVES_WITH_DOTS: usize = 200;
/// The largest number of pieces of a ramp, each with one colour.
const PIECES_PER_RAMP: usize = 24;
/// Limit of the size of the path's lines in the XY plane, bytes: they are in the page and in a separate file. Each of
/// the other planes has a part of it.
const BYTES_MAX: usize = 1_500_000;
const SIDE_BYTES_MAX: usize = BYTES_MAX / 4;
/// The room of the XY plane; a flat path from a side is lower.
const ROOM: Room = Room { inner: (2_704.0, 2_592.0), lowest: 2_592.0, above: KEY, with_rack: true };
const SIDE_ROOM: Room = Room { lowest: 800.0, ..ROOM };
/// Height of the key above, pixels.
const KEY: u32 = 40;

/// The planes that are drawn if the path leaves XY.
pub const SIDES: [Axes; 2] = [[0, 2], [1, 2]];

/// True if the program moves Z, so that it has sides to look at.
pub fn has_sides(outcome: &Outcome) -> bool {
    outcome.program_moves().any(|record| record.plan.steps.get(2).is_some_and(|&steps| steps != 0))
}

/// A picture and how it was drawn.
pub struct Picture {
    /// The SVG element.
    pub svg: String,
    /// True if it was drawn through the edges and not from the plans.
    pub by_edges: bool,
    /// True if ends of moves are drawn as dots.
    pub with_dots: bool,
    /// A sentence about what was left out to limit the size, if anything was.
    pub simplified: Option<String>,
    /// True if there are rapids, drawn as dashes.
    pub with_rapids: bool,
    /// True if a band marks where moves were taken together.
    pub with_together: bool,
    /// The least and greatest positions on both axes, mm.
    pub extent_mm: [(f64, f64); 2],
}

/// Draws the picture of the plane of two axes; `sources` are those of all moves.
pub fn picture(outcome: &Outcome, sources: &[Option<Source>], axes: Axes) -> Picture {
    let phases_of = || phases(outcome, sources);
    let moves = outcome.program_moves().count();
    let rapids = rapids(sources);
    let together = together::key(outcome);
    let room = if axes == XY { ROOM } else { SIDE_ROOM };
    let above = room.above + together.as_ref().map_or(0, |_| together::KEY);
    let plane = Plane::new(outcome, axes, Room { above, ..room });
    let with_rapids = rapids.contains(&true);
    let by_edges = moves <= MOVES_BY_EDGES && !outcome.edges.is_empty();
    let with_dots = moves <= MOVES_WITH_DOTS;
    let scale = SpeedScale::of(phases_of());
    let width = if with_dots { 3 * FINE } else { FINE * 3 / 2 };
    let bytes_max = if axes == XY { BYTES_MAX } else { SIDE_BYTES_MAX };
    let least = if with_dots { 0.5 } else { f64::from(FINE) / 2.0 };
    let drawn = strokes::bounded(scale, [least, f64::from(FINE)], bytes_max, |take| {
        if by_edges {
            pieces_by_edges(outcome, phases_of(), (&plane, &rapids), take)
        } else {
            pieces(outcome, phases_of(), (&plane, &rapids), take)
        }
    });
    let (strokes, simplified) = drawn;
    let ends = if with_dots { ends(outcome, sources, &plane) } else { String::new() };
    let band = together.as_ref().map_or(String::new(), |_| {
        let several = || phases_of().filter(|phase| together::is_several(outcome, phase));
        let (strokes, _) = strokes::bounded(Band, [least, f64::from(FINE)], SIDE_BYTES_MAX, |take| {
            pieces(outcome, several(), (&plane, &rapids), &mut |piece| take(&Band::piece(piece)));
        });
        together::band(strokes, width)
    });
    let lines = band + &strokes.finish(width) + &ends + &plane.start(outcome, "--y");
    let title = format!("Path in the {} plane, coloured by speed", letters(axes));
    let svg = theme::svg(plane.size(), &title, |area| plane.draw(area, outcome));
    let key = scale.key([120 * FINE, 14 * FINE]) + &if with_rapids { key_of_lines(width) } else { String::new() };
    let with_together = together.is_some();
    let place = [120 * FINE, (KEY + 12) * FINE];
    let key = key + &together.map_or(String::new(), |words| together::key_of_band(place, width, &words));
    let svg = svg.replace("</svg>", &format!("{lines}{key}</svg>"));
    Picture { svg, by_edges, with_dots, simplified, with_rapids, with_together, extent_mm: plane.extent_mm }
}

/// The moves that are rapids. A move whose line is unknown counts as a cut.
fn rapids(sources: &[Option<Source>]) -> Vec<bool> {
    sources.iter().map(|source| source.is_some_and(|source| source.rate == Rate::Rapid)).collect()
}

/// The key of the lines, to the right of that of the colours.
fn key_of_lines(width: u32) -> String {
    let (left, y, long) = (640 * FINE, 19 * FINE, 26 * FINE);
    let line = |y: u32, dashes: &str, name: &str| {
        let drawn = format!("<path d=\"M{left} {y}h{long}\" stroke=\"var(--ink)\" stroke-width=\"{width}\"{dashes}/>");
        drawn + &theme::text([left + long + 8 * FINE, y + 5 * FINE], 14, "", name)
    };
    line(y - 6 * FINE, "", "cut") + &line(y + 10 * FINE, &format!(" {}", strokes::dashes(width)), "rapid")
}

/// The phases as planned, with ramps divided into pieces of about one colour.
fn pieces<'a>(
    outcome: &'a Outcome,
    phases: impl Iterator<Item = Phase<'a>>,
    (plane, rapids): (&Plane, &[bool]),
    take: &mut dyn FnMut(&Piece<Made>),
) {
    for phase in phases {
        let [right, up] = plane.axes.map(|axis| phase.asked.along[axis]);
        let fine = phase.distance_mm * right.hypot(up) * plane.fine_per_mm();
        let is_rapid = rapids[phase.index];
        let count = match phase.change {
            _ if fine == 0.0 => continue,
            Change::Level => 1,
            Change::Up | Change::Down => (fine / f64::from(2 * FINE)).ceil().min(PIECES_PER_RAMP as f64) as usize,
        };
        let mut made_mm = 0.0;
        for number in 1..=count {
            let to_mm = phase.made_mm(phase.begin_s + phase.span_s * number as f64 / count as f64);
            let [from, to] = [made_mm, to_mm].map(|mm| plane.point(phase.place_mm(outcome, mm)));
            take(&Piece {
                from,
                to,
                value: Made { distance_mm: to_mm - made_mm, span_s: phase.span_s / count as f64 },
                is_rapid,
            });
            made_mm = to_mm;
        }
    }
}

/// The path by the positions of the edges, with the planned speed.
fn pieces_by_edges<'a>(
    outcome: &'a Outcome,
    phases: impl Iterator<Item = Phase<'a>>,
    (plane, rapids): (&Plane, &[bool]),
    take: &mut dyn FnMut(&Piece<Made>),
) {
    let phases: Vec<_> = phases.collect();
    let stands_steps = stands_steps(outcome);
    for phases in phases.chunk_by(|one, next| one.index == next.index) {
        let record = &outcome.moves[phases[0].index];
        let points = points(outcome, record, stands_steps[phases[0].index]);
        let is_rapid = rapids[phases[0].index];
        if points.iter().all(|(_, mm)| plane.axes.iter().all(|&axis| mm[axis] == points[0].1[axis])) {
            continue;
        }
        let begin_s = phases[0].begin_s;
        for pair in points.windows(2) {
            let middle_s = begin_s + (pair[0].0 + pair[1].0) / 2.0;
            let phase = phases.iter().find(|phase| middle_s < phase.end_s()).unwrap_or(&phases[phases.len() - 1]);
            let [from, to] = [pair[0].1, pair[1].1].map(|mm| plane.point(mm));
            // The planned speed is used because the steps of the edges are not even.
            take(&Piece { from, to, value: Made { distance_mm: phase.speed_mm_s(middle_s), span_s: 1.0 }, is_rapid });
        }
    }
}

/// The places where every axis stands before the edges of each move, steps. In a shaped run that is not where the move begins.
fn stands_steps(outcome: &Outcome) -> Vec<[i32; AXES]> {
    let runs = outcome.moves.chunk_by(|one, next| one.run == next.run);
    let stands_of = |run: &[MoveRecord]| {
        let mut at = run[0].origin_steps;
        let stands = run.iter().map(move |record| {
            let stands = at;
            outcome.edges_of(record).iter().for_each(|edge| at[edge.axis] += edge.direction);
            stands
        });
        stands.collect::<Vec<_>>()
    };
    runs.flat_map(stands_of).collect()
}

/// Instants from the beginning of a move, s, and the positions at its edges, mm.
fn points(outcome: &Outcome, record: &MoveRecord, stands_steps: [i32; AXES]) -> Vec<(f64, [f64; AXES])> {
    let edges = outcome.edges_of(record);
    let stride = edges.len().div_ceil(POINTS_PER_MOVE).max(1);
    let mut at = stands_steps;
    let mut points = vec![(0.0, outcome.mm(at))];
    for (number, edge) in edges.iter().enumerate() {
        at[edge.axis] += edge.direction;
        if number % stride == 0 || number + 1 == edges.len() {
            points.push((record.passed_s(edge.t_ns), outcome.mm(at)));
        }
    }
    points
}

/// Dots for the ends of moves.
fn ends(outcome: &Outcome, sources: &[Option<Source>], plane: &Plane) -> String {
    let mut svg = String::new();
    let ends_line = |source: &Option<Source>| !source.is_some_and(|source| source.in_arc);
    let moves = outcome
        .moves
        .iter()
        .zip(sources)
        .filter(|(record, source)| !record.homing && moves_in(outcome, record, plane.axes) && ends_line(source));
    for (record, _) in moves {
        let [x, y] = plane.point(outcome.mm(record.next_corner_steps()));
        let _ = write!(svg, "<circle cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"{}\" fill=\"var(--ink)\"/>", 4 * FINE);
    }
    svg
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pace::phases::phases;
    use isostep_sim::{Config, lines_of_moves, run};

    fn outcome(program: &str) -> Outcome {
        let mut config = Config::default();
        config.settings.soft_limits = false;
        run(program.as_bytes(), &config).unwrap()
    }

    fn picture_of(program: &str) -> Picture {
        let outcome = outcome(program);
        picture(&outcome, &lines_of_moves::of_moves(&outcome), XY)
    }

    /// Long lines back and forth, whose number is not reduced by a least length.
    #[test]
    fn however_many_long_lines_there_are_the_picture_is_bounded() {
        let outcome = outcome("G91 G1 F600 X10\n");
        let sources = lines_of_moves::of_moves(&outcome);
        let scale = SpeedScale::of(phases(&outcome, &sources));
        let pieces = |take: &mut dyn FnMut(&Piece<Made>)| {
            let mut random = oorandom::Rand32::new(3);
            let mut from = [0.0; 2];
            for _ in 0..400_000 {
                let to = [random.rand_float(), random.rand_float()].map(|share| f64::from(share) * 2_700.0);
                take(&Piece {
                    from,
                    to,
                    value: Made { distance_mm: 1.0, span_s: f64::from(random.rand_float()) + 0.01 },
                    is_rapid: false,
                });
                from = to;
            }
        };
        let (strokes, simplified) = strokes::bounded(scale, [2.0, 4.0], BYTES_MAX, pieces);
        let svg = strokes.finish(6);
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
        let outcome = outcome("G61 G91 G1 F1200 X20 Y10\nX-5 Y20\n");
        let sources = lines_of_moves::of_moves(&outcome);
        let (plane, rapids) = (Plane::new(&outcome, XY, ROOM), rapids(&sources));
        let (mut planned, mut made) = (Vec::new(), Vec::new());
        pieces(&outcome, phases(&outcome, &sources), (&plane, &rapids), &mut |piece| planned.push(*piece));
        pieces_by_edges(&outcome, phases(&outcome, &sources), (&plane, &rapids), &mut |piece| made.push(*piece));
        let top = |pieces: &[Piece<Made>]| pieces.iter().map(|piece| piece.to[0]).fold(0.0, f64::max);
        let ends = [&planned, &made].map(|pieces| (top(pieces), pieces.last().unwrap().to));
        let [(planned_top, planned), (made_top, made)] = ends;
        assert!((planned_top - made_top).abs() < 1e-6, "{planned_top} {made_top}");
        assert!((0..2).all(|at| (planned[at] - made[at]).abs() < 1e-6), "{planned:?} {made:?}");
    }

    /// A line, the short chords of a quarter of a circle, and a line.
    #[test]
    fn the_band_is_where_moves_were_taken_together() {
        const RADIUS_MM: f64 = 10.0;
        let point = |index: u32| {
            let (sin, cos) = (f64::from(index) * 0.005).sin_cos();
            format!("X{:.4} Y{:.4}\n", RADIUS_MM * cos, RADIUS_MM * sin)
        };
        let program = format!("G1 F3000 X20\nX10\n{}X-20 Y10\n", (1..=314).map(point).collect::<String>());
        let mut config = Config { only_time: true, ..Config::default() };
        let settings = &mut config.settings;
        (settings.soft_limits, settings.accel_mm_s2) = (false, [2_000.0; AXES]);
        settings.max_rate_mm_min = [12_000.0; AXES];
        let outcome = run(program.as_bytes(), &config).unwrap();
        let picture = picture(&outcome, &lines_of_moves::of_moves(&outcome), XY);
        let words = together::key(&outcome).unwrap();
        assert!(picture.svg.contains(&words), "{words}");
        let plane = Plane::new(&outcome, XY, Room { above: KEY + together::KEY, ..ROOM });
        let drawn = picture.svg.split("<g class=\"together\"").nth(1).unwrap().split("</g>").next().unwrap();
        let corners = |data: &str| {
            let numbers = data.replace('-', " -").replace(['M', 'l'], " ");
            let numbers: Vec<f64> = numbers.split_whitespace().map(|number| number.parse().unwrap()).collect();
            let ways = numbers.chunks(2).scan([0.0; 2], |at, way| {
                *at = [at[0] + way[0], at[1] + way[1]];
                Some(*at)
            });
            ways.collect::<Vec<_>>()
        };
        let lines: Vec<_> =
            drawn.split(" d=\"M").nth(1).unwrap().split('"').next().unwrap().split('M').map(corners).collect();
        // All of it lies on the circle, within a pixel, and it goes round nearly all of it.
        let centre = plane.point([0.0; AXES]);
        let radius = RADIUS_MM * plane.fine_per_mm();
        let mut around: Vec<_> = Vec::new();
        for [x, y] in lines.iter().flatten().map(|at| [at[0] - centre[0], centre[1] - at[1]]) {
            assert!((x.hypot(y) - radius).abs() < f64::from(2 * FINE), "{} of {radius}", x.hypot(y));
            around.push(y.atan2(x).to_degrees());
        }
        let several = outcome.moves.iter().filter(|record| record.asked.len() > 1);
        let ends = several.map(|record| [record.corner_steps(), record.next_corner_steps()].map(|at| outcome.mm(at)));
        let ends = ends.flatten().map(|mm| mm[1].atan2(mm[0]).to_degrees());
        let (drawn, wanted) = (theme::range(around.into_iter()), theme::range(ends));
        assert!((drawn.0 - wanted.0).abs() < 0.2 && (drawn.1 - wanted.1).abs() < 0.2, "{drawn:?}, not {wanted:?}");
        assert!(wanted.0 < 5.0 && wanted.1 > 85.0, "{wanted:?}");
        assert!(!picture_of("G91 G1 F600 X10\nY5\n").svg.contains("together"));
    }

    #[test]
    fn rapids_are_dashed_and_told_from_cuts_in_every_plane() {
        let outcome = outcome("G0 X10 Z5\nG1 Z-1 F600\nX20 Y10\nG0 Z5\n");
        let sources = lines_of_moves::of_moves(&outcome);
        assert!(has_sides(&outcome));
        for (axes, extent_mm) in [
            (XY, [(0.0, 20.0), (0.0, 10.0)]),
            (SIDES[0], [(0.0, 20.0), (-1.0, 5.0)]),
            (SIDES[1], [(0.0, 10.0), (-1.0, 5.0)]),
        ] {
            let picture = picture(&outcome, &sources, axes);
            assert_eq!(picture.extent_mm, extent_mm);
            assert!(
                picture.with_rapids && picture.svg.contains(">rapid</text>") && picture.svg.contains(">cut</text>")
            );
            assert!(picture.svg.contains(&format!("{} plane", letters(axes))));
            let dashed = picture.svg.matches("stroke-dasharray").count();
            assert!(dashed >= 2, "{dashed} in {axes:?}");
        }
        let cuts = picture_of("G91 G1 F600 X10\nY5\n");
        assert!(!cuts.with_rapids && !cuts.svg.contains(">rapid</text>"));
        assert!(!has_sides(&self::outcome("G91 G1 F600 X10\n")));
    }
}
