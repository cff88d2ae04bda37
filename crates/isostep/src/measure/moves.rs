//! Short moves carried a second: a curve of them, sent as far ahead as the window of characters allows, at a feed
//! that the core cannot keep.

use anyhow::Result;

use super::board::Board;
use super::figure::{Better, Figure, Findings};

/// The blends may leave the corners by so much, mm: more than they need, so that they meet in the middle of each move.
const BLEND_MM: f64 = 0.05;
/// The resolution and the limits of the machine, none of which keeps the moves back.
const STEPS_PER_MM: f64 = 80.0;
const ACCEL_MM_S2: f64 = 10_000.0;
const CORNER_DEVIATION_MM: f64 = 1.0;

/// The ways to take the corners between the moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corners {
    /// Exactly.
    Exact,
    /// By blends, each move by itself.
    Blends,
    /// By blends, and moves taken together.
    Together,
    /// By blends, each move by itself, with a ZV shaper of the default frequency on every axis.
    Zv,
    /// The same, and moves taken together.
    ZvTogether,
    /// By blends, each move by itself, with a box of 10 ms on every axis.
    Box,
    /// The same, and moves taken together.
    BoxTogether,
}

/// A curve of short moves.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The place where it begins, mm.
    pub begin_mm: [f64; 3],
    /// The requested speed, and the top speed of the axes, mm/min.
    pub feed_mm_min: f64,
    /// A line for each move.
    pub lines: Vec<String>,
    /// The steps of all axes up to the end of each move; empty where they are not known.
    pub steps: Vec<u64>,
}

/// Lines that are sent as far ahead as there is room for them.
#[derive(Clone, Debug)]
pub struct Stream {
    /// Lines before, each of which is sent when the one before is answered.
    pub before: Vec<String>,
    /// The lines.
    pub lines: Vec<String>,
    /// The steps of all axes up to the end of each line; empty where they are not known.
    pub steps: Vec<u64>,
    /// The most steps that the motion leaves out where an axis turns within a few of them, %: a shaper does, and so do moves that are
    /// taken together, which end beside their places.
    pub leaves_out_percent: usize,
}

/// The lines of a stream, carried.
#[derive(Clone, Debug)]
pub struct Carried {
    /// When each line was carried, s.
    pub at_s: Vec<f64>,
    /// The events that say so, in words.
    pub by: &'static str,
    /// The fraction of the time during which the core was awake, where it is measured.
    pub awake_ratio: Option<f64>,
}

impl Corners {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Exact, Self::Blends, Self::Together, Self::Zv, Self::ZvTogether, Self::Box, Self::BoxTogether];

    fn key(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Blends => "blends",
            Self::Together => "together",
            Self::Zv => "zv",
            Self::ZvTogether => "zv-together",
            Self::Box => "box",
            Self::BoxTogether => "box-together",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Exact => "with exact corners",
            Self::Blends => "with blends",
            Self::Together => "with blends and taken together",
            Self::Zv => "with blends and ZV",
            Self::ZvTogether => "with blends and ZV and taken together",
            Self::Box => "with blends and a box",
            Self::BoxTogether => "with blends and a box and taken together",
        }
    }

    /// The settings of every axis's shaper, by the number of the first axis's.
    fn shaper(self) -> &'static [(u16, f64)] {
        match self {
            Self::Exact | Self::Blends | Self::Together => &[],
            Self::Zv | Self::ZvTogether => &[(950, 1.0)],
            Self::Box | Self::BoxTogether => &[(950, 5.0), (960, 100.0)],
        }
    }
}

impl Stream {
    /// The stream that takes the corners of a curve in this way.
    pub fn new(curve: &Curve, corners: Corners) -> Self {
        let limits = [(100, STEPS_PER_MM), (110, curve.feed_mm_min), (120, ACCEL_MM_S2)];
        let per_axis = limits.iter().chain(corners.shaper());
        let settings =
            per_axis.flat_map(|&(number, value)| (0..3).map(move |axis| format!("${}={value}", number + axis)));
        let [x, y, z] = curve.begin_mm;
        let word = match corners {
            Corners::Exact => "G61".to_owned(),
            Corners::Together | Corners::ZvTogether | Corners::BoxTogether => format!("G64P{BLEND_MM}"),
            Corners::Blends | Corners::Zv | Corners::Box => format!("G64P{BLEND_MM}Q0"),
        };
        let begin = [
            format!("$11={CORNER_DEVIATION_MM}"),
            format!("G92X{x}Y{y}Z{z}"),
            format!("G21G90G94G1F{}{word}", curve.feed_mm_min),
        ];
        let (lines, steps) = (curve.lines.clone(), curve.steps.clone());
        let is_together = matches!(corners, Corners::Together | Corners::ZvTogether | Corners::BoxTogether);
        let leaves_out_percent = usize::from(is_together) + usize::from(!corners.shaper().is_empty());
        Self { before: settings.chain(begin).collect(), lines, steps, leaves_out_percent }
    }
}

impl Carried {
    /// Lines a second in the middle half, where the board's queue stays full; none if they came at one instant.
    pub fn rate_per_s(&self) -> Option<f64> {
        let middle = [self.at_s.len() / 4, self.at_s.len() * 3 / 4];
        let lasted_s = self.at_s.get(middle[1])? - self.at_s.get(middle[0])?;
        (lasted_s > 0.0).then(|| (middle[1] - middle[0]) as f64 / lasted_s)
    }
}

/// Streams a curve once for each way to take its corners.
///
/// # Errors
/// When the board is gone.
pub fn measure(board: &mut dyn Board, found: &mut Findings, curve: &Curve, ways: &[Corners]) -> Result<()> {
    for &corners in ways {
        let count = curve.lines.len();
        board.note(&format!("{count} short moves {}", corners.name()));
        let what = format!("short moves of 3 axes a second over USB, {}", corners.name());
        let key = format!("moves.{}", corners.key());
        let figure = Figure::new(&*key, what, "moves/s").flattered_by(board.method().moves);
        let figure = figure.compared(Better::Higher, 0.05, 0.0);
        let carried = board.stream(&Stream::new(curve, corners))?;
        match carried.as_ref().map(|carried| (carried.rate_per_s(), carried.awake_ratio)) {
            Ok((Some(per_s), awake_ratio)) => {
                found.add(figure.measured(
                    per_s.round(),
                    format!("by {} of {count} lines, in the middle half", carried.map_or("", |it| it.by)),
                ));
                found.figures.extend(awake_ratio.map(|ratio| {
                    let what = format!("core awake meanwhile, {}", corners.name());
                    let figure = Figure::new(format!("{key}.awake"), what, "%");
                    figure.measured((ratio * 1e4).round() / 100.0, "1 cycle").compared(Better::Neither, 0.05, 0.5)
                }));
            }
            Ok((None, _)) => found.add(figure.missing(format!("{count} lines were carried at one instant"))),
            Err(why_not) => found.add(figure.missing(why_not)),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_that_of_the_middle_half() {
        // Slow at the beginning and at the end, 1,000 a second between.
        let apart_s = |index: usize| if (10..30).contains(&index) { 0.001 } else { 0.1 };
        let at_s = (0..40).scan(0.0, |at_s, index| {
            let now_s = *at_s;
            *at_s += apart_s(index);
            Some(now_s)
        });
        let carried = Carried { at_s: at_s.collect(), by: "", awake_ratio: None };
        assert!((carried.rate_per_s().unwrap() - 1_000.0).abs() < 1e-6, "{carried:?}");
        assert_eq!(Carried { at_s: vec![1.0; 8], by: "", awake_ratio: None }.rate_per_s(), None);
    }

    #[test]
    fn a_stream_has_its_settings_and_its_moves() {
        let lines = vec!["X500.2".to_owned(); 8];
        let curve = Curve { begin_mm: [500.0; 3], feed_mm_min: 60_000.0, lines, steps: vec![1_000; 8] };
        let exact = Stream::new(&curve, Corners::Exact);
        assert_eq!(exact.before[..4], ["$100=80", "$101=80", "$102=80", "$110=60000"]);
        assert_eq!(exact.before[9..], ["$11=1", "G92X500Y500Z500", "G21G90G94G1F60000G61"]);
        assert_eq!((exact.lines.len(), exact.steps.len(), exact.leaves_out_percent), (8, 8, 0));
        let shaped = Stream::new(&curve, Corners::Zv);
        assert_eq!((shaped.before[9].as_str(), shaped.leaves_out_percent), ("$950=1", 1));
        assert!(shaped.before.last().unwrap().ends_with("G64P0.05Q0"));
        for corners in [Corners::Together, Corners::ZvTogether, Corners::BoxTogether] {
            let together = Stream::new(&curve, corners);
            assert!(together.before.last().unwrap().ends_with("G64P0.05") && together.leaves_out_percent > 0);
        }
    }
}
