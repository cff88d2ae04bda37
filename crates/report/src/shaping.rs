//! The cost of shaping: the time that runs take longer, and how far their path leaves that of the program.
//!
//! Shapers of different axes are of different lengths, and all of them round off what is not straight and even. The figures
//! are those of the closed form ([`Places`]), so they are the same whether or not edges are made. The path of the program is
//! that of its plans, blends included.

use std::collections::VecDeque;
use std::fmt;

use isostep_motion::AXES;
use serde::Serialize;

use crate::ringing::Deviation;
use isostep_sim::MoveRecord;
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;
use isostep_sim::places::Places;

/// At how many instants of the longest shaper the distance of both paths is computed.
const INSTANTS: f64 = 24.0;
/// Into how many straight pieces a blend is divided.
const PIECES: u32 = 8;

/// The cost of shaping in a program.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ShapingFigures {
    /// Number of shaped runs that came to their end: each ends with a stop.
    pub stops: usize,
    /// The time that the longest of these stops takes longer, s.
    pub stop_s: f64,
    /// The time that all of them take longer, s.
    pub time_s: f64,
    /// The farthest that the axes leave the path of the program; null if they do not move.
    pub deviation: Option<Deviation>,
}

impl fmt::Display for ShapingFigures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { stops, stop_s, time_s, .. } = self;
        let many = if *stops == 1 { "" } else { "s" };
        write!(f, "{time_s:.3} s more for {stops} stop{many}, {:.1} ms at most", stop_s * 1e3)?;
        let Some(Deviation { mm, move_number, line }) = self.deviation else { return Ok(()) };
        write!(f, "; the axes leave the path by up to {mm:.4} mm, at move {move_number}")?;
        line.map_or(Ok(()), |line| write!(f, ", line {line}"))
    }
}

impl ShapingFigures {
    /// The figures of a run whose moves have these sources; `None` if nothing is shaped.
    pub fn of(outcome: &Outcome, sources: &[Option<Source>]) -> Option<Self> {
        let runs = || outcome.runs().filter(|(_, run)| run[0].shaping.is_some());
        runs().next()?;
        let lasts = runs().map(|(_, run)| &run[run.len() - 1]);
        let lasts_s: Vec<f64> = lasts.filter(|last| last.is_whole()).map(MoveRecord::lasts_s).collect();
        let deviations = runs().filter_map(|(first, run)| farthest(outcome, first, run));
        let place = |(mm, index): (f64, usize)| Deviation {
            mm,
            move_number: outcome.move_number(index),
            line: sources[index].map(|source| source.line),
        };
        Some(Self {
            stops: lasts_s.len(),
            stop_s: lasts_s.iter().copied().fold(0.0, f64::max),
            time_s: lasts_s.iter().sum(),
            deviation: deviations.max_by(|one, other| one.0.total_cmp(&other.0)).map(place),
        })
    }
}

/// A place on the path of the program, mm, and when it would be passed unshaped, s from the start of the run.
type Point = (f64, [f64; AXES]);

/// The largest distance of a shaped run from the path of its plans, mm, and the index of the move there.
fn farthest(outcome: &Outcome, first: usize, run: &[MoveRecord]) -> Option<(f64, usize)> {
    let shaping = run[0].shaping.as_deref()?;
    let (places, last) = (Places::of(run, outcome.kinematics), &run[run.len() - 1]);
    let per_mm = outcome.config_of(&run[0]).steps_per_mm;
    let mut ahead = points(run, &per_mm).peekable();
    // Where the path was while the impulses passed, and one point to either side.
    let mut window: VecDeque<Point> = VecDeque::new();
    let count = (last.plan_s / shaping.lasts_s * INSTANTS).ceil() as usize;
    let instants = (1..count).map(|number| last.plan_s * number as f64 / count as f64);
    let mut under_way = 0;
    let distances_mm = instants.map(|t_s| {
        while window.back().is_none_or(|point| point.0 < t_s)
            && let Some(point) = ahead.next()
        {
            window.push_back(point);
        }
        while window.get(1).is_some_and(|point| point.0 <= t_s - shaping.lasts_s) {
            window.pop_front();
        }
        while run.get(under_way + 1).is_some_and(|next| next.begin_s() <= t_s - shaping.delay_s) {
            under_way += 1;
        }
        let at_mm = std::array::from_fn(|axis| places.steps(axis, t_s) / per_mm[axis]);
        let pieces = window.iter().zip(window.iter().skip(1));
        let mm = pieces.map(|(from, to)| distance_mm(&at_mm, &from.1, &to.1)).fold(f64::INFINITY, f64::min);
        (mm, first + under_way)
    });
    distances_mm.filter(|(mm, _)| mm.is_finite()).max_by(|one, other| one.0.total_cmp(&other.0))
}

/// The path of a run as straight pieces: its corners, its end, and points of its blends.
fn points<'a>(run: &'a [MoveRecord], per_mm: &'a [f64; AXES]) -> impl Iterator<Item = Point> + 'a {
    let of = move |record: &MoveRecord, t_s: f64| {
        (t_s, std::array::from_fn(|axis| record.place_steps(axis, t_s) / per_mm[axis]))
    };
    let begins = run.iter().flat_map(move |record| {
        let bent = record.blend.into_iter().flat_map(move |blend| {
            let at_s = move |part| blend.corner_begins_s() + blend.corner_s() * f64::from(part) / f64::from(PIECES);
            (0..=PIECES).map(move |part| of(record, at_s(part)))
        });
        std::iter::once(of(record, record.begin_s())).chain(bent)
    });
    let last = &run[run.len() - 1];
    begins.chain([of(last, last.plan_s)])
}

/// The distance of a place from a straight piece of a path, mm.
fn distance_mm(at: &[f64; AXES], from: &[f64; AXES], to: &[f64; AXES]) -> f64 {
    let dot = |one: [f64; AXES], other: [f64; AXES]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
    let less =
        |one: &[f64; AXES], other: &[f64; AXES]| -> [f64; AXES] { std::array::from_fn(|axis| one[axis] - other[axis]) };
    let (way, beyond) = (less(to, from), less(at, from));
    let share = (dot(way, beyond) / dot(way, way).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let beside: [f64; AXES] = std::array::from_fn(|axis| beyond[axis] - share * way[axis]);
    dot(beside, beside).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use isostep_sim::{Config, lines_of_moves, run};

    fn figures(kind: u16, program: &str) -> Option<ShapingFigures> {
        let mut config = Config { only_time: true, ..Config::default() };
        let settings = &mut config.settings;
        (settings.steps_per_mm, settings.max_rate_mm_min) = ([80.0; AXES], [12_000.0; AXES]);
        (settings.accel_mm_s2, settings.soft_limits) = ([2_000.0; AXES], false);
        (settings.shaper_kind[0], settings.shaper_kind[1]) = (kind, kind);
        (settings.shaper_hz[0], settings.shaper_hz[1]) = (40.0, 40.0);
        settings.shaper_damping_ratio = [0.0; AXES];
        let outcome = run(program.as_bytes(), &config).unwrap();
        ShapingFigures::of(&outcome, &lines_of_moves::of_moves(&outcome))
    }

    #[test]
    fn nothing_is_reported_where_nothing_is_shaped() {
        assert_eq!(figures(0, "G1 X10 F6000\n"), None);
    }

    /// ZV lasts half a period, 12.5 ms. Two axes with equal shapers stay on a straight line.
    #[test]
    fn a_straight_line_costs_half_a_period_a_stop_and_no_deviation() {
        let found = figures(1, "G1 X10 Y5 F6000\nG4 P0.1\nX0 Y0\n").unwrap();
        assert_eq!(found.stops, 2);
        assert!((found.stop_s - 0.012_5).abs() < 1e-9 && (found.time_s - 0.025).abs() < 1e-9, "{found:?}");
        assert!(found.deviation.unwrap().mm < 1e-9, "{found:?}");
    }

    /// X has a speed of v up to where Y begins with v: for a time T, the half period, both move at v/2. In its middle X has v
    /// T/4 left to the corner, and Y has made as much: so far is the path from either line.
    #[test]
    fn a_corner_is_cut_by_what_the_shaper_makes_of_its_jump() {
        let found = figures(1, "$11=0.2\nG61 G1 X10 F1200\nY10\n").unwrap();
        let deviation = found.deviation.unwrap();
        // 20 mm/s is below what $11 allows.
        let expected_mm = 20.0 * 0.012_5 / 4.0;
        assert!((deviation.mm / expected_mm - 1.0).abs() < 0.01, "{deviation:?} for {expected_mm}");
        assert!(deviation.line == Some(2) || deviation.line == Some(3), "{deviation:?}");
    }
}
