//! Speed along the path over time, compared with the speed asked for.

use super::chart::{self, Axis, Band, Chart, Curve, Label, Place, Style};
use super::theme::{AXIS, BOUND, CURVE, Colour};
use super::together;
use crate::pace::Second;
use crate::pace::phases::{Phase, end_s, phases};
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;

/// Number of time spans, each with its lowest and its highest speed.
const SPANS: usize = 760;
/// The speed asked for is shown up to this multiple of the highest speed.
const ASKED_MAX: f64 = 1.5;
/// The mark of a second is at least this fraction of the picture wide.
const SEEN: f64 = 0.004;

/// The opacity of a mark.
const MARK: f64 = 0.25;

/// Draws the picture; `sources` are those of all moves, `seconds` are the slowest and the busiest.
pub fn picture(outcome: &Outcome, sources: &[Option<Source>], seconds: [Option<Second>; 2]) -> String {
    let mut key = vec![
        (AXIS[0], "planned speed along the path: mean, lowest to highest".to_owned()),
        (BOUND, "asked for: the feed, or what the top speeds allow".to_owned()),
    ];
    key.extend(together::key(outcome).map(|words| (together::COLOUR, words)));
    let gap_s = end_s(outcome).unwrap_or(0.0) / SPANS as f64;
    let together_s = together::spans_s(outcome, phases(outcome, sources), gap_s);
    let chart = chart(&samples(outcome, sources, SPANS), seconds, &together_s);
    chart::picture("Speed along the path over time", &key, 1, 340, &[chart])
}

fn chart(samples: &[Sample], extremes: [Option<Second>; 2], together_s: &[[f64; 2]]) -> Chart {
    let end_s = samples.last().map_or(1.0, |sample| sample.end_s);
    let highest_mm_s = samples.iter().map(|sample| sample.highest_mm_s).fold(1e-3, f64::max);
    let asked_mm_s = samples.iter().map(|sample| sample.asked_mm_s).fold(0.0, f64::max);
    let top_mm_s = 1.12 * highest_mm_s.max(asked_mm_s.min(ASKED_MAX * highest_mm_s));
    let asked = samples.iter().flat_map(|sample| [sample.begin_s, sample.end_s].map(|t_s| (t_s, sample.asked_mm_s)));
    let asked = [(0.0, 0.0)].into_iter().chain(asked).chain([(end_s, 0.0)]);
    let at = |sample: &Sample, mm_s: f64| ((sample.begin_s + sample.end_s) / 2.0, mm_s);
    let above = samples.iter().map(|sample| at(sample, sample.highest_mm_s));
    let below = samples.iter().rev().map(|sample| at(sample, sample.lowest_mm_s));
    let curves = vec![
        Curve::new(Style::Area, BOUND, asked).faint(0.3),
        together::strip(together_s, top_mm_s),
        Curve::new(Style::Area, AXIS[0], above.chain(below)).faint(0.35),
        Curve::line(AXIS[0], samples.iter().map(|sample| at(sample, sample.mean_mm_s))),
    ];
    let marks = marks(extremes);
    let label = |(rank, &(name, from_s, _)): (usize, &(&str, f64, Colour))| {
        let is_left = from_s < 0.8 * end_s;
        let (at_s, place) = if is_left { (mark_end_s(from_s, end_s), Place::Right) } else { (from_s, Place::Left) };
        // The second is a line lower, so that both can be read.
        Label::new((at_s, top_mm_s), place, "\n".repeat(rank) + name)
    };
    let labels = marks.iter().enumerate().map(label).collect();
    let band =
        |&(_, from, colour): &(&str, f64, Colour)| Band { from, to: mark_end_s(from, end_s), colour, opacity: MARK };
    let x = Axis::from("time from the start of the first move, s").within(0.0, end_s);
    let y = Axis::from("speed, mm/s").within(0.0, top_mm_s);
    Chart { bands: marks.iter().map(band).collect(), labels, ..Chart::new(x, y, curves) }
}

/// The place where the mark of a second ends, so that it is wide enough to be visible.
fn mark_end_s(from_s: f64, end_s: f64) -> f64 {
    (from_s + (SEEN * end_s).max(1.0)).min(end_s)
}

/// The seconds that are marked: names, starts and colours.
fn marks([slowest, busiest]: [Option<Second>; 2]) -> Vec<(&'static str, f64, Colour)> {
    let slowest = slowest.map(|second| ("slowest second", second.start_s, CURVE[4]));
    let busiest = busiest.map(|second| ("busiest second", second.start_s, AXIS[2]));
    [busiest, slowest].into_iter().flatten().collect()
}

/// The speed along the path in a span of time, mm/s. At standstill it is 0, and so is the speed asked for.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// The instant at which the span begins, s from the start of the first move.
    begin_s: f64,
    end_s: f64,
    moving_s: f64,
    lowest_mm_s: f64,
    mean_mm_s: f64,
    highest_mm_s: f64,
    /// The highest of the speeds asked for.
    asked_mm_s: f64,
}

impl Sample {
    /// A span without motion so far.
    fn new([begin_s, end_s]: [f64; 2]) -> Self {
        let [moving_s, mean_mm_s, highest_mm_s, asked_mm_s] = [0.0; 4];
        Self { begin_s, end_s, moving_s, lowest_mm_s: f64::INFINITY, mean_mm_s, highest_mm_s, asked_mm_s }
    }

    /// Adds the part of a phase between two instants, which is this part of the mean.
    fn add(&mut self, phase: &Phase, [from_s, to_s]: [f64; 2], mean_mm_s: f64) {
        self.moving_s += (to_s - from_s).max(0.0);
        self.mean_mm_s += mean_mm_s;
        self.asked_mm_s = self.asked_mm_s.max(phase.asked.mm_s);
        // In a phase the speed rises, stays constant or falls, so its extremes are at the ends.
        let [one, other] = [from_s, to_s].map(|t_s| phase.speed_mm_s(t_s));
        self.lowest_mm_s = self.lowest_mm_s.min(one).min(other);
        self.highest_mm_s = self.highest_mm_s.max(one).max(other);
    }
}

/// The speed in so many equal spans of time, from the start of the first move to the end of the last one; empty without a
/// move.
fn samples(outcome: &Outcome, sources: &[Option<Source>], spans: usize) -> Vec<Sample> {
    let Some(total_s) = end_s(outcome) else { return Vec::new() };
    let span_s = total_s / spans as f64;
    let ends_s = |number: usize| [number, number + 1].map(|number| number as f64 * span_s);
    let mut samples: Vec<_> = (0..spans).map(|number| Sample::new(ends_s(number))).collect();
    for phase in phases(outcome, sources) {
        let mut made_mm = 0.0;
        let mut from_s = phase.begin_s;
        let number = |t_s: f64| ((t_s / span_s) as usize).min(spans - 1);
        let (first, last) = (number(phase.begin_s), number(phase.end_s()));
        for (number, sample) in (first..).zip(&mut samples[first..=last]) {
            let to_s = if number + 1 == spans { phase.end_s() } else { phase.end_s().min(sample.end_s) };
            let to_mm = phase.made_mm(to_s);
            sample.add(&phase, [from_s, to_s], (to_mm - made_mm) / span_s);
            (from_s, made_mm) = (to_s, to_mm);
        }
    }
    for stands in samples.iter_mut().filter(|sample| sample.moving_s < span_s * (1.0 - 1e-6)) {
        stands.lowest_mm_s = 0.0;
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pace::Pace;
    use isostep_motion::AXES;
    use isostep_sim::{Config, lines_of_moves, run};

    /// By hand: 20 mm/s over 20 mm, from and to rest at 50 mm/s2.
    #[test]
    fn the_chart_has_the_speed_and_what_was_asked_for() {
        let outcome = run(b"G1 X20 F1200\n", &Config::default()).unwrap();
        let sources = lines_of_moves::of_moves(&outcome);
        let pace = Pace::of(&outcome);
        let chart = chart(&samples(&outcome, &sources, SPANS), [pace.slowest_second, pace.busiest_second], &[]);
        let [asked, together, band, mean] = &chart.curves[..] else { panic!("{:?}", chart.curves) };
        assert!(asked.points[1..asked.points.len() - 1].iter().all(|point| (point.1 - 20.0).abs() < 1e-9));
        assert!(together.points.is_empty());
        let highest = mean.points.iter().map(|point| point.1).fold(0.0, f64::max);
        assert!((highest - 20.0).abs() < 1e-6 && mean.points[0].1 < 0.2, "{highest}");
        assert_eq!(band.points.len(), 2 * mean.points.len());
        let (_, end_s) = chart.x.range.unwrap();
        let way_mm = mean.points.iter().map(|point| point.1).sum::<f64>() * end_s / SPANS as f64;
        assert!((way_mm - 20.0).abs() < 0.01, "{way_mm}");
        assert!(chart.bands.iter().zip(&chart.labels).all(|(band, label)| band.to == label.at.0), "{:?}", chart.labels);
    }

    /// A line, short moves of a circle, and a line.
    #[test]
    fn the_strip_is_where_moves_were_taken_together() {
        let point = |index: u32| {
            let (sin, cos) = (f64::from(index) * 0.005).sin_cos();
            format!("X{:.4} Y{:.4}\n", 10.0 * cos, 10.0 * sin)
        };
        let program = format!("G1 F3000 X20\nX10\n{}X-20 Y0\n", (1..400).map(point).collect::<String>());
        let mut config = Config { only_time: true, ..Config::default() };
        let settings = &mut config.settings;
        (settings.soft_limits, settings.accel_mm_s2) = (false, [2_000.0; AXES]);
        settings.max_rate_mm_min = [12_000.0; AXES];
        let outcome = run(program.as_bytes(), &config).unwrap();
        let sources = lines_of_moves::of_moves(&outcome);
        let spans_s = together::spans_s(&outcome, phases(&outcome, &sources), 0.0);
        let chart = chart(&samples(&outcome, &sources, SPANS), [None; 2], &spans_s);
        // Where lines of several moves are one behind the other, from the middle of a corner to that of another.
        let start_s = outcome.moves[0].begin_s();
        let corner_s = |index: usize| {
            let blend = outcome.moves[index].blend.unwrap();
            let [p, q] = [blend.corner_begins_s(), blend.end_s()].map(|t_s| outcome.blend_mm_s(&blend, t_s).sqrt());
            blend.corner_begins_s() + blend.corner_s() * p / (p + q) - start_s
        };
        let several: Vec<_> = outcome.moves.iter().map(|record| record.asked.len() > 1).collect();
        let changes = (1..several.len()).filter(|&index| several[index] != several[index - 1]);
        let wanted_s: Vec<_> = changes.map(corner_s).collect();
        let drawn_s: Vec<_> = chart.curves[1].points.iter().map(|point| point.0).collect();
        assert_eq!(drawn_s.len(), wanted_s.len(), "{drawn_s:?} {wanted_s:?}");
        assert!(drawn_s.iter().zip(&wanted_s).all(|(drawn_s, wanted_s)| (drawn_s - wanted_s).abs() < 1e-6));
        let whole_s: f64 = drawn_s.chunks(2).map(|span| span[1] - span[0]).sum();
        assert!((whole_s - 2.0 * 10.0 / 50.0).abs() < 0.05, "the chords of 20 mm at 50 mm/s take 0.4 s, not {whole_s}");
        let picture = picture(&outcome, &sources, [None; 2]);
        let words = format!("moves taken together: {}", isostep_sim::verify::Together::of_several(&outcome));
        assert!(picture.contains(&words) && words.contains("mm beside their ends at most, of 0.0050"), "{words}");
    }

    #[test]
    fn samples_have_the_whole_way_and_its_speeds() {
        let mut config = Config { only_time: true, ..Config::default() };
        let settings = &mut config.settings;
        (settings.max_rate_mm_min, settings.accel_mm_s2) = ([12_000.0; AXES], [2_000.0; AXES]);
        let outcome = run(b"G91 G1 F6000 X40\nG4 P0.2\nF3000 Y40\n", &config).unwrap();
        let samples = samples(&outcome, &lines_of_moves::of_moves(&outcome), 97);
        let way_mm: f64 = samples.iter().map(|sample| sample.mean_mm_s * (sample.end_s - sample.begin_s)).sum();
        assert!((way_mm - 80.0).abs() < 1e-6, "{way_mm}");
        assert!(samples.iter().all(|sample| sample.lowest_mm_s <= sample.mean_mm_s + 1e-9));
        assert!(samples.iter().all(|sample| sample.mean_mm_s <= sample.highest_mm_s + 1e-9));
        let highest_mm_s = samples.iter().map(|sample| sample.highest_mm_s).fold(0.0, f64::max);
        assert!((highest_mm_s - 100.0).abs() < 1e-6, "{highest_mm_s}");
        assert!(samples.iter().any(|sample| sample.asked_mm_s == 0.0) && samples[0].asked_mm_s == 100.0);
    }
}
