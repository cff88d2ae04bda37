//! Where moves were taken together: a band along the path, and a strip over time.

use super::chart::{Curve, Style};
use super::strokes::{Piece, Scale, Strokes};
use super::theme::{self, CURVE, Colour, FINE};
use crate::pace::phases::Phase;
use isostep_sim::Outcome;
use isostep_sim::verify::Together;

/// The colour of both, and its variable.
pub const COLOUR: Colour = CURVE[5];
const VARIABLE: &str = "--curve-6";
/// The band is this many times as wide as the path.
const WIDE: u32 = 4;
/// The part of a chart that the strip is high.
const HIGH: f64 = 0.035;
/// Height of the key of the band, pixels.
pub const KEY: u32 = 24;

/// The key of a picture that marks what was taken together; `None` if nothing was.
pub fn key(outcome: &Outcome) -> Option<String> {
    let together = Together::of_several(outcome);
    (together.lines > 0).then(|| format!("moves taken together: {together}"))
}

/// True if a phase is of a line that was made for several moves.
pub fn is_several(outcome: &Outcome, phase: &Phase) -> bool {
    outcome.moves[phase.index].asked.len() > 1
}

/// From when to when moves were taken together, s from the start of the first move. Gaps of up to `gap_s` are passed over.
pub fn spans_s<'a>(outcome: &Outcome, phases: impl Iterator<Item = Phase<'a>>, gap_s: f64) -> Vec<[f64; 2]> {
    let mut spans: Vec<[f64; 2]> = Vec::new();
    for phase in phases.filter(|phase| is_several(outcome, phase)) {
        match spans.last_mut() {
            Some(last) if phase.begin_s <= last[1] + gap_s => last[1] = phase.end_s(),
            _ => spans.push([phase.begin_s, phase.end_s()]),
        }
    }
    spans
}

/// The strip at the bottom of a chart over time whose highest value is `top`.
pub fn strip(spans_s: &[[f64; 2]], top: f64) -> Curve {
    Curve::new(Style::Bars, COLOUR, spans_s.iter().flat_map(|[from_s, to_s]| [(*from_s, 0.0), (*to_s, HIGH * top)]))
}

/// The band below a path whose lines are `width` wide, from its pieces.
pub fn band(strokes: Strokes<Band>, width: u32) -> String {
    format!("<g class=\"together\" opacity=\"0.4\">{}</g>", strokes.finish(WIDE * width))
}

/// The key of the band, with its left end at a point.
pub fn key_of_band([left, y]: [u32; 2], width: u32, words: &str) -> String {
    let long = 26 * FINE;
    let wide = WIDE * width;
    let drawn =
        format!("<path d=\"M{left} {y}h{long}\" stroke=\"var({VARIABLE})\" stroke-width=\"{wide}\" opacity=\"0.4\"/>");
    drawn + &theme::text([left + long + 8 * FINE, y + 5 * FINE], 14, "", words)
}

/// A path of one colour.
#[derive(Clone, Copy, Debug)]
pub struct Band;

impl Scale for Band {
    type Value = ();
    const CLASSES: usize = 1;
    const TOGETHER: &str = "colour";

    fn class(&self, (): ()) -> usize {
        0
    }

    fn together((): (), (): ()) {}

    fn variable(_class: usize) -> String {
        VARIABLE.to_owned()
    }
}

impl Band {
    /// The same piece of a path without its value.
    pub fn piece<V>(piece: &Piece<V>) -> Piece<()> {
        Piece { from: piece.from, to: piece.to, value: (), is_rapid: false }
    }
}
