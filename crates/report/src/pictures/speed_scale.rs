//! Speeds as colours: eight classes, from the slowest to the fastest, and their key.

use std::fmt::Write;

use super::chart::short;
use super::strokes::Scale;
use crate::pace::course::Phase;

/// Number of classes: `--speed-1` to `--speed-8` of the style sheet.
const CLASSES: usize = 8;
/// If half the distance is slower than this fraction of the fastest speed, the classes are logarithmic: each is twice
/// as fast as the one before.
const MOSTLY_SLOW: f64 = 0.25;
/// Bins for mean speeds, each an eighth of an octave wide, from 2^-16 mm/s on.
const BINS: usize = 256;

/// The range of speeds of each class.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedScale {
    /// The highest speed of each class, mm/s.
    tops_mm_s: [f64; CLASSES],
}

/// What a piece of a path has made.
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
    const CLASSES: usize = CLASSES;
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
            true => 0.5_f64.powi((CLASSES - 1 - class) as i32),
            false => (class + 1) as f64 / CLASSES as f64,
        };
        Self { tops_mm_s: std::array::from_fn(|class| top_mm_s * share(class)) }
    }

    /// The class of a speed, from 0 for the slowest.
    fn class_of(&self, mm_s: f64) -> usize {
        self.tops_mm_s.partition_point(|top_mm_s| *top_mm_s < mm_s).min(CLASSES - 1)
    }

    /// The key as SVG, with its upper left corner at `x`, `y`; `unit` is the size of a pixel.
    pub fn key(&self, [x, y]: [u32; 2], unit: u32) -> String {
        let (width, height) = (56 * unit, 10 * unit);
        let mut svg = String::new();
        let mut label = |x: u32, anchor: &str, text: &str| {
            let (y, size) = (y + height + 15 * unit, 14 * unit);
            let _ = write!(
                svg,
                "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" font-family=\"sans-serif\" font-size=\"{size}\" fill=\"var(--ink)\">{text}</text>"
            );
        };
        label(x, "middle", "0");
        for (class, top_mm_s) in (1..).zip(self.tops_mm_s) {
            label(x + class * width, "middle", &short(top_mm_s));
        }
        label(x + CLASSES as u32 * width + 24 * unit, "start", "mm/s");
        for class in 0..CLASSES as u32 {
            let (left, number) = (x + class * width, class + 1);
            let _ = write!(
                svg,
                "<rect x=\"{left}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"var(--speed-{number})\"/>"
            );
        }
        svg
    }
}

fn bin(mm_s: f64) -> usize {
    (((mm_s.log2() + 16.0) * 8.0).max(0.0) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_even_or_double() {
        let even = SpeedScale::new(80.0, false);
        assert_eq!([0.0, 10.0, 10.1, 79.0, 81.0].map(|mm_s| even.class_of(mm_s)), [0, 0, 1, 7, 7]);
        let doubling = SpeedScale::new(128.0, true);
        assert_eq!([0.5, 1.5, 63.0, 65.0].map(|mm_s| doubling.class_of(mm_s)), [0, 1, 6, 7]);
    }
}
