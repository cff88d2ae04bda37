//! The path coloured by the largest acceleration of any axis over its limit, for both rules at corners side by side.

use isostep_motion::Axis;

use super::plane::{FINE, Plane, Room, XY, moves_in};
use super::scales::RatioScale;
use super::strokes::{self, Piece};
use super::theme;
use crate::again::Rule;
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves;
use isostep_sim::measure::across::{self, Slice, WITHIN};

/// Width of the area inside the labels of two pictures, or of one alone, and their height, fine pixels.
const WIDTHS: [f64; 2] = [3_664.0, 1_664.0];
const HEIGHTS: (f64, f64) = (600.0, 1_664.0);
/// Height of the key and of the titles below it, pixels.
const KEY: u32 = 48;
const TITLES: u32 = 46;
/// Up to this number of moves, lines are wide.
const MOVES_WITH_WIDE_LINES: usize = 200;
/// Limit of the size of the lines of one rule, bytes.
const BYTES_MAX: usize = 400_000;
/// Pieces shorter than this are drawn as one from the beginning, fine pixels.
const LEAST: f64 = 4.0;
/// Places that are no farther apart are the same, mm.
const SAME_MM: f64 = 1e-6;

/// A picture for the page.
pub struct Picture {
    /// The SVG element.
    pub svg: String,
    /// Sentences about what it shows and how to read it.
    pub caption: String,
}

/// Draws the path in XY of each of one or two runs of a program, side by side; `None` if they have no edges, or do not move
/// X or Y.
pub fn picture(runs: &[(Rule, &Outcome)]) -> Option<Picture> {
    let &(_, first) = runs.first()?;
    if first.edges.is_empty() || !first.program_moves().any(|record| moves_in(first, record, XY)) {
        return None;
    }
    let room =
        Room { inner: (WIDTHS[runs.len() - 1], HEIGHTS.1), lowest: HEIGHTS.0, above: KEY + TITLES, with_rack: false };
    let plane = Plane::new(first, XY, room);
    let is_wide = first.program_moves().count() <= MOVES_WITH_WIDE_LINES;
    let width = if is_wide { 2 * FINE } else { FINE * 5 / 4 };
    let (panel_wide, high) = plane.size();
    let size = (panel_wide * runs.len() as u32, high);
    let mut svg = theme::svg(size, "Path in the XY plane, coloured by acceleration over its limit", |area| {
        area.split_evenly((1, runs.len())).iter().try_for_each(|area| plane.draw(area, first))
    });
    let (mut lines, mut reported, mut simplified) = (String::new(), vec![how_to_read(first)], None);
    for (number, (rule, run)) in (0..).zip(runs) {
        let panel = Panel::new(rule, run, &plane, width);
        let shift = panel_wide * number;
        lines += &format!("<g transform=\"translate({shift} 0)\">{}{}</g>", panel.lines, panel.titles(&plane));
        reported.push(panel.reported());
        simplified = simplified.or(panel.simplified);
    }
    reported.extend(simplified);
    lines += &RatioScale::key([84 * FINE, 14 * FINE], width);
    svg.insert_str(svg.rfind("</svg>")?, &lines);
    Some(Picture { svg, caption: reported.join(" ") })
}

fn how_to_read(outcome: &Outcome) -> String {
    let spans_ms = across::spans_s(outcome).map(|s| format!("{:.1}", s * 1e3));
    let spans = if spans_ms[0] == spans_ms[1] { spans_ms[0].clone() } else { spans_ms.join(" to ") };
    format!(
        "The path in the XY plane as planned, coloured by the largest acceleration of any axis over its own limit ($120, $920). It \
         is the mean over twice {spans} ms, or two steps where they take longer, from the edges alone, corners included; where the \
         speed of an axis jumps, it is the jump over that time. Grey is within the limit, up to {WITHIN}, as the edges resolve no more. \
         A ring marks what is most above it."
    )
}

/// One run.
struct Panel<'a> {
    rule: &'a Rule,
    /// The path.
    lines: String,
    /// A sentence about what was left out of it, if anything was.
    simplified: Option<String>,
    /// The place where the ratio is highest, and the line of the program.
    highest: Slice,
    line: Option<usize>,
    /// Time in motion, and the part of it above the limit, s.
    motion_s: f64,
    above_s: f64,
}

impl<'a> Panel<'a> {
    fn new(rule: &'a Rule, outcome: &Outcome, plane: &Plane, width: u32) -> Self {
        let mut pieces: Vec<Piece<f64>> = Vec::new();
        let (mut motion_s, mut above_s, mut highest) = (0.0, 0.0, None::<Slice>);
        for slice in across::slices(outcome) {
            motion_s += slice.span_s;
            above_s += if slice.ratio > WITHIN { slice.span_s } else { 0.0 };
            highest = highest.filter(|highest| highest.ratio >= slice.ratio).or(Some(slice));
            let [from, to] = [slice.from_mm, slice.to_mm].map(|mm| plane.point(mm));
            match pieces.last_mut().filter(|last| far(last.from, last.to) < LEAST && last.to == from) {
                Some(last) => (last.to, last.value) = (to, last.value.max(slice.ratio)),
                None => pieces.push(Piece { from, to, value: slice.ratio, is_rapid: false }),
            }
        }
        let highest = highest.expect("a program that moves has slices");
        let (strokes, simplified) = strokes::bounded(RatioScale, [LEAST, f64::from(FINE)], BYTES_MAX, |take| {
            pieces.iter().for_each(take);
        });
        let ring = if highest.ratio > WITHIN { ring(plane.point(highest.to_mm)) } else { String::new() };
        let lines = strokes.finish(width) + &plane.start(outcome, "--x") + &ring;
        let source = lines_of_moves::of_moves(outcome)[behind(outcome, &highest)];
        let line = source.map(|source| source.line);
        Self { rule, lines, simplified, highest, line, motion_s, above_s }
    }

    /// The place where it is highest, in words.
    fn place(&self) -> String {
        let line = self.line.map_or(String::new(), |line| format!(", line {line}"));
        format!("{}{line}", Axis::ALL[self.highest.axis])
    }

    fn above(&self) -> f64 {
        100.0 * self.above_s / self.motion_s.max(1e-9)
    }

    /// The name of the rule above the picture, and its figures.
    fn titles(&self, plane: &Plane) -> String {
        let [left, top] = plane.corner().map(|at| at as u32);
        let text = |up: u32, size: u32, weight: &str, text: &str| {
            theme::text([left, top - up * FINE], size, &format!(" font-weight=\"{weight}\""), text)
        };
        let Self { rule, highest, motion_s, .. } = self;
        let figures = match highest.ratio > WITHIN {
            true => format!(
                "at most {:.2} ({}), above 1 for {:.1} % of {motion_s:.1} s",
                highest.ratio,
                self.place(),
                self.above()
            ),
            false => format!("at most {:.2}: within the limit in all {motion_s:.1} s", highest.ratio),
        };
        text(28, 15, "bold", &format!("{}: {}", rule.name, rule.whose())) + &text(9, 13, "normal", &figures)
    }

    /// The sentences of the caption.
    fn reported(&self) -> String {
        let Self { rule, highest: Slice { ratio, to_mm, .. }, motion_s, above_s, .. } = self;
        let (name, whose, place) = (&rule.name, rule.whose(), self.place());
        let at: String = Axis::ALL.iter().zip(to_mm).take(3).map(|(axis, mm)| format!(" {axis}{mm:.2}")).collect();
        format!(
            "{name}, {whose}: at most {ratio:.2} times the limit ({place}, at{at}), and above the limit for \
             {above_s:.3} s of {motion_s:.3} s in motion."
        )
    }
}

/// The index of the move that the end of a slice belongs to: at a corner the one behind it.
fn behind(outcome: &Outcome, slice: &Slice) -> usize {
    let Some([record, next]) = outcome.moves.get(slice.index..slice.index + 2) else { return slice.index };
    let corner_mm = outcome.mm(record.next_corner_steps());
    let is_corner = slice.to_mm.iter().zip(corner_mm).all(|(mm, corner_mm)| (mm - corner_mm).abs() < SAME_MM);
    slice.index + usize::from(is_corner && next.run == record.run)
}

/// A mark round a point.
fn ring([x, y]: strokes::Point) -> String {
    let (radius, width) = (9 * FINE, FINE * 3 / 2);
    format!(
        "<circle cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"{radius}\" fill=\"none\" stroke=\"var(--ink)\" stroke-width=\"{width}\"/>"
    )
}

fn far(from: strokes::Point, to: strokes::Point) -> f64 {
    (to[0] - from[0]).hypot(to[1] - from[1])
}

#[cfg(test)]
mod tests {
    use super::super::strokes::Scale;
    use super::*;
    use crate::again::other_rule;
    use crate::pictures::BothRules;
    use isostep_sim::{Config, run};

    const CORNERS: &str = "G1 X10 F1200\nY10\nX3 Y3\nG2 X10 I3.5\n";

    fn both(program: &str) -> Picture {
        let outcome = run(program.as_bytes(), &Config::default()).unwrap();
        let other = other_rule(&outcome).map(|(lines, config)| run(&lines.join(&b'\n'), &config).unwrap());
        BothRules::of(&outcome, other).by_accel.unwrap()
    }

    /// The part of the picture that has one rule's lines.
    fn panel(picture: &Picture, number: usize) -> &str {
        picture.svg.split("<g transform=").nth(number + 1).unwrap().split("</text></g>").next().unwrap()
    }

    #[test]
    fn grbls_rule_is_loud_and_blends_are_quiet_whichever_was_run() {
        for (program, own) in
            [(format!("G61\n{CORNERS}"), 0), (CORNERS.to_owned(), 1), (format!("G64 P0.1\n{CORNERS}"), 1)]
        {
            let picture = both(&program);
            let loud = |number: usize| {
                (3..=7).filter(|class| panel(&picture, number).contains(&format!("--ratio-{class}"))).count()
            };
            assert!(loud(0) > 1 && loud(1) == 0, "{program}: {} and {}", loud(0), loud(1));
            let names = [0, 1].map(|number| panel(&picture, number).contains("this run"));
            assert_eq!(names, [own == 0, own == 1]);
            assert!(panel(&picture, 0).contains("Grbl's rule (G61, $11=0.01)"), "{}", picture.svg);
        }
    }

    #[test]
    fn the_caption_tells_the_worst_place_and_the_window() {
        let caption = both("G61 G1 X10 F1200\nY10\n").caption;
        assert!(
            caption.contains("twice 3.") && caption.contains("times the limit (Y, line 2, at X10.00 Y0.00 Z0.00)"),
            "{caption}"
        );
        assert!(caption.contains("Blends (G64 P0.01), for comparison: at most 1.0"), "{caption}");
        assert!(caption.contains("and above the limit for 0.000 s of 1.766 s in motion."), "{caption}");
    }

    /// In a large picture a corner is less than a pixel.
    #[test]
    fn the_highest_is_drawn_however_short_it_is() {
        let picture = both("G1 X300 F2400\nY1\nX0\n");
        let highest = picture.caption.split("this run: at most ").nth(1).unwrap().split(' ').next().unwrap();
        let variable = RatioScale::variable(RatioScale.class(highest.parse().unwrap()));
        assert!(panel(&picture, 0).contains(&variable), "{highest} is {variable}");
    }

    #[test]
    fn without_corners_there_is_one_rule_and_without_a_path_in_xy_nothing() {
        assert_eq!(both("G1 X10 F1200\nX20\n").svg.matches("<g transform=").count(), 1);
        let outcome = run(b"G1 Z10 F1200\n", &Config::default()).unwrap();
        assert!(BothRules::of(&outcome, None).by_accel.is_none());
    }
}
