//! Speed along the path over time, compared with the speed asked for.

use super::chart::{self, Axis, Band, Chart, Curve, Label, Place, Style};
use super::theme::{AXIS, BOUND, CURVE, Colour};
use crate::pace::{Sample, Second, samples};
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::Source;

/// Number of time spans, each with its lowest and its highest speed.
const SPANS: usize = 760;
/// The speed asked for is shown up to this multiple of the highest speed.
const ASKED_MAX: f64 = 1.5;
/// The mark of a second is at least this fraction of the picture wide.
const SEEN: f64 = 0.004;

/// How much of the colour of a mark is seen.
const MARK: f64 = 0.25;

/// Draws the picture; `sources` are those of all moves, `seconds` are the slowest and the busiest.
pub fn picture(outcome: &Outcome, sources: &[Option<Source>], seconds: [Option<Second>; 2]) -> String {
    let key = [
        (AXIS[0], "planned speed along the path: mean, lowest to highest".to_owned()),
        (BOUND, "asked for: the feed, or what the top speeds allow".to_owned()),
    ];
    let chart = chart(&samples(outcome, sources, SPANS), seconds);
    chart::picture("Speed along the path over time", &key, 1, 340, &[chart])
}

fn chart(samples: &[Sample], extremes: [Option<Second>; 2]) -> Chart {
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

/// Where the mark of a second ends, so that it is wide enough to be visible.
fn mark_end_s(from_s: f64, end_s: f64) -> f64 {
    (from_s + (SEEN * end_s).max(1.0)).min(end_s)
}

/// The seconds that are marked: names, starts and colours.
fn marks([slowest, busiest]: [Option<Second>; 2]) -> Vec<(&'static str, f64, Colour)> {
    let slowest = slowest.map(|second| ("slowest second", second.start_s, CURVE[4]));
    let busiest = busiest.map(|second| ("busiest second", second.start_s, AXIS[2]));
    [busiest, slowest].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pace::Pace;
    use isostep_sim::{Config, lines_of_moves, run};

    /// By hand: 20 mm/s over 20 mm, from and to rest at 50 mm/s2.
    #[test]
    fn the_chart_has_the_speed_and_what_was_asked_for() {
        let outcome = run(b"G1 X20 F1200\n", &Config::default()).unwrap();
        let sources = lines_of_moves::of_moves(&outcome);
        let pace = Pace::of(&outcome);
        let chart = chart(&samples(&outcome, &sources, SPANS), [pace.slowest_second, pace.busiest_second]);
        let [asked, band, mean] = &chart.curves[..] else { panic!("{:?}", chart.curves) };
        assert!(asked.points[1..asked.points.len() - 1].iter().all(|point| (point.1 - 20.0).abs() < 1e-9));
        let highest = mean.points.iter().map(|point| point.1).fold(0.0, f64::max);
        assert!((highest - 20.0).abs() < 1e-6 && mean.points[0].1 < 0.2, "{highest}");
        assert_eq!(band.points.len(), 2 * mean.points.len());
        let (_, end_s) = chart.x.range.unwrap();
        let way_mm = mean.points.iter().map(|point| point.1).sum::<f64>() * end_s / SPANS as f64;
        assert!((way_mm - 20.0).abs() < 0.01, "{way_mm}");
        assert!(chart.bands.iter().zip(&chart.labels).all(|(band, label)| band.to == label.at.0), "{:?}", chart.labels);
    }
}
