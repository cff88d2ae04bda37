//! Coloured lines as compact SVG: one element for all lines of a class, in whole units of the picture. Rapids have
//! elements of their own, with dashes.
//!
//! Invisible details are left out: pieces shorter than the least length are drawn as one, with the colour of what they
//! have together, and points on a straight line between others of their colour are dropped.

use std::fmt::Write;

/// The largest number of points on one straight line that are checked together.
const CHECKED: usize = 32;
/// The largest distance of a dropped point from the line, units.
const ASIDE: f64 = 1.0;

/// To reach a limit of bytes, the length below which pieces are drawn as one is doubled up to this, units. After that,
/// pieces are left out.
const LEAST_MAX: f64 = 16.0;

/// A point in the picture, units.
pub type Point = [f64; 2];
type Node = [i32; 2];

/// A scale by which values of a path become colours, in classes.
pub trait Scale: Copy {
    /// The value of a piece.
    type Value: Copy;
    /// Number of classes. Lines of the first are drawn on top: they are what readers look for.
    const CLASSES: usize;
    /// The name of the value that short pieces have together, for a caption.
    const TOGETHER: &str;

    /// The class of a value, from 0.
    fn class(&self, value: Self::Value) -> usize;
    /// The value that two pieces have together that follow each other.
    fn together(one: Self::Value, next: Self::Value) -> Self::Value;
    /// The CSS variable of the colour of a class.
    fn variable(class: usize) -> String;
    /// The width of the lines of a class, where the least is `width`.
    fn width(_class: usize, width: u32) -> u32 {
        width
    }
}

/// A straight piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece<V> {
    /// The place where it begins, units.
    pub from: Point,
    /// The place where it ends, units.
    pub to: Point,
    /// The value that gives it its colour.
    pub value: V,
    /// True if it is part of a rapid.
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
pub struct Strokes<S: Scale> {
    scale: S,
    least: f64,
    /// The data of the path element of each class, of cuts and then of rapids.
    paths: Vec<String>,
    /// A piece that is too short to be drawn alone.
    waiting: Option<Piece<S::Value>>,
    line: Option<Line>,
}

impl<S: Scale> Strokes<S> {
    /// Draws in the colours of `scale`. Pieces shorter than `least` units are drawn together.
    pub fn new(scale: S, least: f64) -> Self {
        Self { scale, least, paths: vec![String::new(); 2 * S::CLASSES], waiting: None, line: None }
    }

    /// Size of the output so far, bytes.
    pub fn bytes(&self) -> usize {
        self.paths.iter().map(String::len).sum()
    }

    /// Adds the next piece.
    pub fn take(&mut self, piece: &Piece<S::Value>) {
        let is_other =
            |waiting: Piece<S::Value>| waiting.is_rapid != piece.is_rapid || far(waiting.to, piece.from) > self.least;
        if self.waiting.is_some_and(is_other) {
            self.flush();
        }
        let waiting = match self.waiting {
            None => *piece,
            Some(waiting) => Piece {
                from: waiting.from,
                to: piece.to,
                value: S::together(waiting.value, piece.value),
                is_rapid: piece.is_rapid,
            },
        };
        self.waiting = Some(waiting);
        if far(waiting.from, waiting.to) >= self.least {
            self.flush();
        }
    }

    /// The SVG, with lines at least `width` units wide.
    pub fn finish(mut self, width: u32) -> String {
        self.flush();
        self.end_line();
        let mut svg =
            format!("<g fill=\"none\" stroke-width=\"{width}\" stroke-linejoin=\"round\" stroke-linecap=\"round\">");
        // Cuts are on top of rapids.
        for (element, path) in self.paths.iter().enumerate().rev().filter(|(_, path)| !path.is_empty()) {
            let class = element % S::CLASSES;
            let dashes = if element < S::CLASSES { String::new() } else { format!(" {}", dashes(width)) };
            let wide = match S::width(class, width) {
                wide if wide == width => String::new(),
                wide => format!(" stroke-width=\"{wide}\""),
            };
            let _ = write!(svg, "<path stroke=\"var({})\"{wide}{dashes} d=\"{path}\"/>", S::variable(class));
        }
        svg + "</g>"
    }

    fn flush(&mut self) {
        let Some(piece) = self.waiting.take() else { return };
        let [from, to] = [node(piece.from), node(piece.to)];
        let class = self.scale.class(piece.value);
        let element = class + if piece.is_rapid { S::CLASSES } else { 0 };
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
    /// True if all points between the anchor and `to` can be dropped.
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

/// Draws the pieces, simplified until they are small enough, and says in a sentence what was simplified. Pieces shorter
/// than `least` units are drawn together at first; a pixel has `unit` units.
pub fn bounded<S: Scale>(
    scale: S,
    [mut least, unit]: [f64; 2],
    bytes_max: usize,
    pieces: impl Fn(&mut dyn FnMut(&Piece<S::Value>)),
) -> (Strokes<S>, Option<String>) {
    let mut stride = 1;
    loop {
        let mut strokes = Strokes::new(scale, least);
        let mut number = 0_usize;
        pieces(&mut |piece| {
            number += 1;
            if number.is_multiple_of(stride) && strokes.bytes() <= bytes_max {
                strokes.take(piece);
            }
        });
        if strokes.bytes() <= bytes_max {
            return (strokes, simplified::<S>(least / unit, stride));
        }
        if least < LEAST_MAX { least *= 2.0 } else { stride *= 2 }
    }
}

fn simplified<S: Scale>(pixels: f64, stride: usize) -> Option<String> {
    let unit = if pixels == 1.0 { "pixel" } else { "pixels" };
    let drawn = format!("What is shorter than {pixels} {unit} is drawn as one, with its {}", S::TOGETHER);
    match stride {
        1 if pixels < 0.5 => None,
        1 => Some(format!("{drawn}.")),
        _ => Some(format!("{drawn}, and of all pieces only one in {stride} is drawn.")),
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
    use super::super::scales::{Made, SpeedScale};
    use super::*;
    use crate::pace;
    use isostep_sim::{Config, lines_of_moves, run};

    fn scale() -> SpeedScale {
        let outcome = run(b"G91 G1 F600 X10\n", &Config { only_time: true, ..Config::default() }).unwrap();
        let sources = lines_of_moves::of_moves(&outcome);
        SpeedScale::of(pace::phases::phases(&outcome, &sources))
    }

    fn drawn(points: &[(f64, f64, f64)], least: f64) -> String {
        let mut strokes = Strokes::new(scale(), least);
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|(x, y, _)| [x, y]);
            strokes.take(&Piece { from, to, value: Made { distance_mm: pair[1].2, span_s: 1.0 }, is_rapid: false });
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
