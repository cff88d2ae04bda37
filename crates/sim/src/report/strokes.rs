//! Coloured lines as compact SVG: one element for all lines of a speed class, in whole units of the picture. Rapids have
//! elements of their own, with dashes.
//!
//! Invisible details are left out: pieces shorter than the least length are drawn as one, with the colour of their mean
//! speed, and points on a straight line between others of their colour are dropped.

use std::fmt::Write;

use super::speed_scale::{CLASSES, SpeedScale};

/// The largest number of points on one straight line that are checked together.
const CHECKED: usize = 32;
/// The largest distance of a dropped point from the line, units.
const ASIDE: f64 = 1.0;

/// A point in the picture, units.
pub type Point = [f64; 2];
type Node = [i32; 2];

/// A straight piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Where it begins, units.
    pub from: Point,
    /// Where it ends, units.
    pub to: Point,
    /// Its distance, mm.
    pub distance_mm: f64,
    /// Its duration, s.
    pub span_s: f64,
    /// Whether it is part of a rapid.
    pub is_rapid: bool,
}

/// A line of one colour that is being drawn.
struct Line {
    /// The element that it goes into.
    element: usize,
    anchor: Node,
    /// Points on the line from the anchor to the end.
    dropped: Vec<Node>,
    end: Node,
}

/// Draws pieces in the given order.
pub struct Strokes {
    scale: SpeedScale,
    least: f64,
    /// The data of the path element of each class, of cuts and then of rapids.
    paths: [String; 2 * CLASSES],
    /// A piece that is too short to be drawn alone.
    waiting: Option<Piece>,
    line: Option<Line>,
}

impl Strokes {
    /// Draws in the colours of `scale`. Pieces shorter than `least` units are drawn together.
    pub fn new(scale: SpeedScale, least: f64) -> Self {
        Self { scale, least, paths: [const { String::new() }; 2 * CLASSES], waiting: None, line: None }
    }

    /// Size of the output so far, bytes.
    pub fn bytes(&self) -> usize {
        self.paths.iter().map(String::len).sum()
    }

    /// Adds the next piece.
    pub fn take(&mut self, piece: &Piece) {
        let is_other = |waiting: Piece| waiting.is_rapid != piece.is_rapid || far(waiting.to, piece.from) > self.least;
        if self.waiting.is_some_and(is_other) {
            self.flush();
        }
        let waiting = match self.waiting {
            None => *piece,
            Some(waiting) => Piece {
                from: waiting.from,
                to: piece.to,
                distance_mm: waiting.distance_mm + piece.distance_mm,
                span_s: waiting.span_s + piece.span_s,
                is_rapid: piece.is_rapid,
            },
        };
        self.waiting = Some(waiting);
        if far(waiting.from, waiting.to) >= self.least {
            self.flush();
        }
    }

    /// The SVG, with lines `width` units wide. Slow lines are on top of fast ones, because readers look for slow
    /// places.
    pub fn finish(mut self, width: u32) -> String {
        self.flush();
        self.end_line();
        let mut svg =
            format!("<g fill=\"none\" stroke-width=\"{width}\" stroke-linejoin=\"round\" stroke-linecap=\"round\">");
        // Cuts are on top of rapids.
        for (element, path) in self.paths.iter().enumerate().rev().filter(|(_, path)| !path.is_empty()) {
            let class = element % CLASSES + 1;
            let dashes = if element < CLASSES { String::new() } else { format!(" {}", dashes(width)) };
            let _ = write!(svg, "<path stroke=\"var(--speed-{class})\"{dashes} d=\"{path}\"/>");
        }
        svg + "</g>"
    }

    fn flush(&mut self) {
        let Some(piece) = self.waiting.take() else { return };
        let [from, to] = [node(piece.from), node(piece.to)];
        let class = self.scale.class(piece.distance_mm / piece.span_s.max(1e-12));
        let element = class + if piece.is_rapid { CLASSES } else { 0 };
        match &mut self.line {
            Some(line) if line.element == element && line.end == from => {
                if !line.goes_straight_to(to) {
                    line.turn(&mut self.paths[element]);
                }
                line.dropped.push(line.end);
                line.end = to;
            }
            _ => {
                self.end_line();
                let _ = write!(self.paths[element], "M{} {}l", from[0], from[1]);
                self.line = Some(Line { element, anchor: from, dropped: Vec::new(), end: to });
            }
        }
    }

    fn end_line(&mut self) {
        if let Some(mut line) = self.line.take() {
            line.turn(&mut self.paths[line.element]);
        }
    }
}

impl Line {
    /// Whether all points between the anchor and `to` can be dropped.
    fn goes_straight_to(&self, to: Node) -> bool {
        let [x, y] = [0, 1].map(|at| f64::from(to[at] - self.anchor[at]));
        let length = x.hypot(y);
        let is_beside = |point: &Node| {
            let [px, py] = [0, 1].map(|at| f64::from(point[at] - self.anchor[at]));
            let along = px * x + py * y;
            (px * y - py * x).abs() <= ASIDE * length && (0.0..=length * length).contains(&along)
        };
        self.dropped.len() < CHECKED && self.dropped.iter().chain([&self.end]).all(is_beside)
    }

    /// Writes the line so far; it continues in another direction.
    fn turn(&mut self, path: &mut String) {
        for at in [0, 1] {
            let by = self.end[at] - self.anchor[at];
            // A minus sign separates numbers as well as a space does.
            let gap = if by < 0 || path.ends_with('l') { "" } else { " " };
            let _ = write!(path, "{gap}{by}");
        }
        self.anchor = self.end;
        self.dropped.clear();
    }
}

/// The attributes of a rapid's line of this width.
pub fn dashes(width: u32) -> String {
    format!("stroke-dasharray=\"{} {}\" stroke-linecap=\"butt\"", 3 * width, 2 * width)
}

fn node(point: Point) -> Node {
    point.map(|at| at.round() as i32)
}

fn far(from: Point, to: Point) -> f64 {
    (to[0] - from[0]).hypot(to[1] - from[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Config, lines_of_moves, pace, run};

    fn scale() -> SpeedScale {
        let outcome = run(b"G91 G1 F600 X10\n", &Config { only_time: true, ..Config::default() }).unwrap();
        let sources = lines_of_moves::of_moves(&outcome);
        SpeedScale::of(pace::course::phases(&outcome, &sources))
    }

    fn drawn(points: &[(f64, f64, f64)], least: f64) -> String {
        let mut strokes = Strokes::new(scale(), least);
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|(x, y, _)| [x, y]);
            strokes.take(&Piece { from, to, distance_mm: pair[1].2, span_s: 1.0, is_rapid: false });
        }
        strokes.finish(4)
    }

    #[test]
    fn a_straight_line_of_one_colour_is_two_points() {
        let svg = drawn(&[(0.0, 0.0, 0.0), (5.0, 0.0, 10.0), (10.0, 0.0, 10.0), (10.0, -7.0, 10.0)], 1.0);
        assert!(svg.contains("<path stroke=\"var(--speed-8)\" d=\"M0 0l10 0 0-7\"/>"), "{svg}");
    }

    #[test]
    fn the_slow_is_drawn_over_the_fast() {
        let svg = drawn(&[(0.0, 0.0, 0.0), (5.0, 0.0, 1.0), (10.0, 0.0, 10.0)], 1.0);
        assert!(svg.find("speed-8").unwrap() < svg.find("speed-1").unwrap(), "{svg}");
        assert!(svg.contains("M0 0l5 0") && svg.contains("M5 0l5 0"), "{svg}");
    }

    #[test]
    fn what_is_too_short_is_drawn_together() {
        let points: Vec<_> = (0..=100).map(|i| (f64::from(i) * 0.1, 0.0, 10.0)).collect();
        assert!(drawn(&points, 2.0).contains("M0 0l10 0\""));
    }

    /// A circle of small pieces loses points, but stays round.
    #[test]
    fn a_curve_does_not_become_straight() {
        let on_circle = |i: i32| (f64::from(i) * 0.01).sin_cos();
        let points: Vec<_> = (0..=628).map(on_circle).map(|(s, c)| (400.0 * c, 400.0 * s, 10.0)).collect();
        let svg = drawn(&points, 2.0);
        let numbers = svg.split(['l', '"']).find(|text| text.contains("-1")).unwrap().split([' ', '-']).count();
        assert!((60..500).contains(&numbers), "{numbers}: {svg}");
    }
}
