//! Values along a path as colours, and their keys. Each class is darker than the one before (in dark mode lighter), so that it
//! does not take colours to tell them.

use super::chart::short;
use super::strokes::Scale;
use super::theme::{FINE, text};
use crate::pace::phases::Phase;
use isostep_sim::measure::across::WITHIN;

/// A box of a key: where it begins, how wide and how high it is, fine pixels; and the variable of its colour.
struct Filled {
    left: u32,
    wide: u32,
    high: u32,
    variable: String,
}

/// The boxes of a key, all with their middles at `middle`.
fn filled(boxes: impl Iterator<Item = Filled>, middle: u32) -> String {
    let one = |Filled { left, wide, high, variable }: Filled| {
        let top = middle - high / 2;
        format!("<rect x=\"{left}\" y=\"{top}\" width=\"{wide}\" height=\"{high}\" fill=\"var({variable})\"/>")
    };
    boxes.map(one).collect()
}

/// A number below a key, with its middle at a point.
fn number(at: [u32; 2], number: &str) -> String {
    text(at, 14, " text-anchor=\"middle\"", number)
}

/// The highest ratio of each class but the last, from the lowest: `--ratio-1` to `--ratio-7` of the style sheet.
const RATIO_TOPS: [f64; 6] = [0.5, WITHIN, 1.5, 2.5, 5.0, 10.0];
/// Number of classes within the limit.
const QUIET: usize = 2;
/// The width of the lines of each class as a multiple of that within the limit, from the lowest.
const WIDTHS: [f64; RATIO_TOPS.len() + 1] = [1.0, 1.0, 2.0, 2.5, 3.0, 3.5, 4.0];

/// An acceleration over its limit: quiet greys within the limit, loud colours and wider lines above it. The scale is the same
/// for all pictures, so that they can be compared.
#[derive(Clone, Copy, Debug)]
pub struct RatioScale;

impl Scale for RatioScale {
    type Value = f64;
    // The highest class is the first: what breaks the limit is drawn on top.
    const CLASSES: usize = RATIO_TOPS.len() + 1;
    const TOGETHER: &str = "highest acceleration";

    fn class(&self, ratio: f64) -> usize {
        RATIO_TOPS.len() - RATIO_TOPS.partition_point(|top| *top < ratio)
    }

    fn together(one: f64, next: f64) -> f64 {
        one.max(next)
    }

    fn variable(class: usize) -> String {
        format!("--ratio-{}", Self::CLASSES - class)
    }

    fn width(class: usize, width: u32) -> u32 {
        (f64::from(width) * WIDTHS[RATIO_TOPS.len() - class]).round() as u32
    }
}

impl RatioScale {
    /// The key as SVG, with its upper left corner at `x`, `y`; `width` is that of quiet lines.
    pub fn key([x, y]: [u32; 2], width: u32) -> String {
        // A gap sets apart what is above the limit.
        let (wide, gap, middle) = (64 * FINE, 16 * FINE, y + 7 * FINE);
        let left = |class: usize| x + class as u32 * wide + if class < QUIET { 0 } else { gap };
        let below = |x: u32, text: &str| number([x, y + 31 * FINE], text);
        let tops = RATIO_TOPS.into_iter().enumerate().map(|(class, top)| match class + 1 {
            QUIET => below(left(class) + wide + gap / 2, "1 (limit)"),
            _ => below(left(class) + wide, &top.to_string()),
        });
        let last = left(RATIO_TOPS.len()) + wide + 10 * FINE;
        let boxes = (0..Self::CLASSES).map(|class| {
            let high = Self::width(RATIO_TOPS.len() - class, width).max(3 * FINE);
            Filled { left: left(class), wide, high, variable: format!("--ratio-{}", class + 1) }
        });
        let limit = format!(
            "<path d=\"M{} {}v{}\" stroke=\"var(--ink)\" stroke-width=\"{}\"/>",
            left(QUIET) - gap / 2,
            y - 4 * FINE,
            22 * FINE,
            FINE * 3 / 2
        );
        below(x, "0")
            + &tops.collect::<String>()
            + &text([last, y + 12 * FINE], 14, "", "acceleration / its limit")
            + &filled(boxes, middle)
            + &limit
    }
}

/// Number of classes of speeds: `--speed-1` to `--speed-8` of the style sheet.
const SPEEDS: usize = 8;
/// If half the distance is slower than this fraction of the fastest speed, the classes are logarithmic: each is twice
/// as fast as the one before.
const MOSTLY_SLOW: f64 = 0.25;
/// Bins for mean speeds, each an eighth of an octave wide, from 2^-16 mm/s on.
const BINS: usize = 256;

/// Speeds: eight classes, from the slowest to the fastest, each with its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedScale {
    /// The highest speed of each class, mm/s.
    tops_mm_s: [f64; SPEEDS],
}

/// The distance and the duration of a piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Made {
    /// Its distance, mm.
    pub distance_mm: f64,
    /// Its duration, s.
    pub span_s: f64,
}

impl Scale for SpeedScale {
    type Value = Made;
    // Readers look for slow places.
    const CLASSES: usize = SPEEDS;
    const TOGETHER: &str = "mean speed";

    fn class(&self, made: Made) -> usize {
        self.class_of(made.distance_mm / made.span_s.max(1e-12))
    }

    fn together(one: Made, next: Made) -> Made {
        Made { distance_mm: one.distance_mm + next.distance_mm, span_s: one.span_s + next.span_s }
    }

    fn variable(class: usize) -> String {
        format!("--speed-{}", class + 1)
    }
}

impl SpeedScale {
    /// The scale for these phases.
    pub fn of<'a>(phases: impl Iterator<Item = Phase<'a>>) -> Self {
        let mut top_mm_s = 1e-3_f64;
        let mut distances_mm = [0.0; BINS];
        for phase in phases {
            top_mm_s = phase.speeds_mm_s.into_iter().fold(top_mm_s, f64::max);
            distances_mm[bin(phase.distance_mm / phase.span_s)] += phase.distance_mm;
        }
        let slow_mm: f64 = distances_mm[..bin(MOSTLY_SLOW * top_mm_s)].iter().sum();
        Self::new(top_mm_s, slow_mm > distances_mm.iter().sum::<f64>() / 2.0)
    }

    fn new(top_mm_s: f64, doubles: bool) -> Self {
        let share = |class: usize| match doubles {
            true => 0.5_f64.powi((SPEEDS - 1 - class) as i32),
            false => (class + 1) as f64 / SPEEDS as f64,
        };
        Self { tops_mm_s: std::array::from_fn(|class| top_mm_s * share(class)) }
    }

    /// The class of a speed, from 0 for the slowest.
    fn class_of(&self, mm_s: f64) -> usize {
        self.tops_mm_s.partition_point(|top_mm_s| *top_mm_s < mm_s).min(SPEEDS - 1)
    }

    /// The key as SVG, with its upper left corner at `x`, `y`.
    pub fn key(&self, [x, y]: [u32; 2]) -> String {
        let (wide, high) = (56 * FINE, 10 * FINE);
        let base = y + high + 15 * FINE;
        let tops =
            (1..).zip(self.tops_mm_s).map(|(class, top_mm_s)| number([x + class * wide, base], &short(top_mm_s)));
        let left = (0..).map(|class: u32| x + class * wide);
        let boxes =
            left.zip(0..SPEEDS).map(|(left, class)| Filled { left, wide, high, variable: Self::variable(class) });
        number([x, base], "0")
            + &tops.collect::<String>()
            + &text([x + SPEEDS as u32 * wide + 24 * FINE, base], 14, "", "mm/s")
            + &filled(boxes, y + high / 2)
    }
}

fn bin(mm_s: f64) -> usize {
    (((mm_s.log2() + 16.0) * 8.0).max(0.0) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::super::strokes::{Piece, Strokes};
    use super::*;

    #[test]
    fn what_is_short_and_loud_is_drawn_loud() {
        let mut strokes = Strokes::new(RatioScale, 4.0);
        for (number, value) in [0.1, 3.0, 0.1, 0.1].into_iter().enumerate() {
            let [from, to] = [number, number + 1].map(|x| [x as f64, 0.0]);
            strokes.take(&Piece { from, to, value, is_rapid: false });
        }
        let svg = strokes.finish(2);
        assert!(svg.contains("<path stroke=\"var(--ratio-5)\" stroke-width=\"6\" d=\"M0 0l4 0\"/>"), "{svg}");
    }

    #[test]
    fn the_limit_parts_quiet_classes_from_loud_ones() {
        let number = |ratio: f64| RatioScale::CLASSES - RatioScale.class(ratio);
        assert_eq!([0.0, 0.5, 0.51, 1.0, 1.02].map(number), [1, 1, 2, 2, 2]);
        assert_eq!([1.03, 1.6, 2.6, 6.0, 11.0, 99.0].map(number), [3, 4, 5, 6, 7, 7]);
        assert_eq!(RatioScale::variable(RatioScale.class(99.0)), "--ratio-7");
        assert!(RatioScale::width(RatioScale.class(1.1), 10) > RatioScale::width(RatioScale.class(0.9), 10));
    }

    #[test]
    fn classes_are_even_or_double() {
        let even = SpeedScale::new(80.0, false);
        assert_eq!([0.0, 10.0, 10.1, 79.0, 81.0].map(|mm_s| even.class_of(mm_s)), [0, 0, 1, 7, 7]);
        let doubling = SpeedScale::new(128.0, true);
        assert_eq!([0.5, 1.5, 63.0, 65.0].map(|mm_s| doubling.class_of(mm_s)), [0, 1, 6, 7]);
    }
}
