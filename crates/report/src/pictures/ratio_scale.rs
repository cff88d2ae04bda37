//! An acceleration over its limit as a colour: quiet greys within the limit, loud colours and wider lines above it, and their
//! key. Each class is darker than the one before (in dark mode lighter), so that it does not take colours to tell them.

use std::fmt::Write;

use super::strokes::Scale;
use isostep_sim::measure::across::WITHIN;

/// The highest ratio of each class but the last, from the lowest: `--ratio-1` to `--ratio-7` of the style sheet.
const TOPS: [f64; 6] = [0.5, WITHIN, 1.5, 2.5, 5.0, 10.0];
/// Number of classes within the limit.
const QUIET: usize = 2;
/// How many times as wide the lines of each class are as those within the limit, from the lowest.
const WIDTHS: [f64; TOPS.len() + 1] = [1.0, 1.0, 2.0, 2.5, 3.0, 3.5, 4.0];

/// The scale, the same for all pictures, so that they can be compared.
#[derive(Clone, Copy, Debug)]
pub struct RatioScale;

impl Scale for RatioScale {
    type Value = f64;
    // The highest class is the first: what breaks the limit is drawn on top.
    const CLASSES: usize = TOPS.len() + 1;
    const TOGETHER: &str = "highest acceleration";

    fn class(&self, ratio: f64) -> usize {
        TOPS.len() - TOPS.partition_point(|top| *top < ratio)
    }

    fn together(one: f64, next: f64) -> f64 {
        one.max(next)
    }

    fn variable(class: usize) -> String {
        format!("--ratio-{}", Self::CLASSES - class)
    }

    fn width(class: usize, width: u32) -> u32 {
        (f64::from(width) * WIDTHS[TOPS.len() - class]).round() as u32
    }
}

/// The key as SVG, with its upper left corner at `x`, `y`; `unit` is the size of a pixel, `width` that of quiet lines.
pub fn key([x, y]: [u32; 2], unit: u32, width: u32) -> String {
    // A gap sets apart what is above the limit.
    let (wide, gap, middle) = (64 * unit, 16 * unit, y + 7 * unit);
    let left = |class: usize| x + class as u32 * wide + if class < QUIET { 0 } else { gap };
    let mut svg = String::new();
    let mut label = |x: u32, anchor: &str, text: &str| {
        let (y, size) = if anchor == "start" { (y + 12 * unit, 14 * unit) } else { (y + 31 * unit, 14 * unit) };
        let _ = write!(
            svg,
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" font-family=\"sans-serif\" font-size=\"{size}\" fill=\"var(--ink)\">{text}</text>"
        );
    };
    label(x, "middle", "0");
    for (class, top) in TOPS.into_iter().enumerate() {
        match class + 1 {
            QUIET => label(left(class) + wide + gap / 2, "middle", "1 (limit)"),
            _ => label(left(class) + wide, "middle", &top.to_string()),
        }
    }
    label(left(TOPS.len()) + wide + 10 * unit, "start", "acceleration / its limit");
    for class in 0..RatioScale::CLASSES {
        let (high, left) = (RatioScale::width(TOPS.len() - class, width).max(3 * unit), left(class));
        let (top, number) = (middle - high / 2, class + 1);
        let _ = write!(
            svg,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{wide}\" height=\"{high}\" fill=\"var(--ratio-{number})\"/>"
        );
    }
    let (mark, top) = (left(QUIET) - gap / 2, y - 4 * unit);
    let _ = write!(
        svg,
        "<path d=\"M{mark} {top}v{}\" stroke=\"var(--ink)\" stroke-width=\"{}\"/>",
        22 * unit,
        unit * 3 / 2
    );
    svg
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
}
