//! The path in short stretches, each with the largest acceleration of any axis as a fraction of its limit.
//!
//! Places are those of the plans, accelerations those of the edges ([`across`]), which in a shaped run are late. A stretch has the highest ratio of all
//! windows whose middle is in it, and of those that were the last of their axis before it. So no window is lost, however
//! short it is.

use isostep_motion::{AXES, Finish};

use super::across::{self, Window};
use crate::moves::MoveRecord;
use crate::outcome::Outcome;

/// A ratio up to this is within the limit: the edges resolve 1 %, at either end of a span.
pub const WITHIN: f64 = 1.02;

/// A stretch of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Index of its move in [`Outcome::moves`].
    pub index: usize,
    /// Where it begins, mm.
    pub from_mm: [f64; AXES],
    /// Where it ends, mm.
    pub to_mm: [f64; AXES],
    /// How long it takes, s.
    pub span_s: f64,
    /// The axis whose acceleration is nearest to its limit, or most beyond it.
    pub axis: usize,
    /// That acceleration as a fraction of its limit.
    pub ratio: f64,
}

/// All stretches of the program, in order. Homing is left out. Each is at most half the shortest span long, and belongs
/// to one move, a blend to the move behind it.
pub fn stretches(outcome: &Outcome) -> impl Iterator<Item = Stretch> + '_ {
    let [span_s, _] = across::spans_s(outcome);
    across::runs(outcome).flat_map(move |(first, run)| {
        let mut windows = Latest::of(outcome, run);
        run.iter().enumerate().flat_map(move |(number, record)| {
            let (begin_s, end_s) = (record.begin_s(), end_s(record, run.get(number + 1)));
            let count = ((end_s - begin_s).max(0.0) / (span_s / 2.0)).ceil().max(1.0);
            let at_s = move |part: usize| begin_s + (end_s - begin_s) * part as f64 / count;
            let mut from_mm = across::place_mm(outcome, record, begin_s);
            let parts: Vec<_> = (1..=count as usize)
                .map(|part| {
                    let (axis, ratio) = windows.until(at_s(part) + record.delay_s());
                    let to_mm = across::place_mm(outcome, record, at_s(part));
                    let from_mm = std::mem::replace(&mut from_mm, to_mm);
                    let span_s = at_s(part) - at_s(part - 1);
                    Stretch { index: first + number, from_mm, to_mm, span_s, axis, ratio }
                })
                .collect();
            parts
        })
    })
}

/// When a move gives way to the next one of its run, or ends, s from the start of the run.
fn end_s(record: &MoveRecord, next: Option<&MoveRecord>) -> f64 {
    match next {
        Some(next) => next.begin_s(),
        None if matches!(record.finish, Finish::Done | Finish::Held) => record.plan_s,
        None => (record.end_ns - record.start_ns) as f64 * 1e-9,
    }
}

/// The windows of a run in the order of their middles, and the latest of each axis.
struct Latest {
    start_ns: u64,
    windows: std::iter::Peekable<std::vec::IntoIter<Window>>,
    ratios: [f64; AXES],
}

impl Latest {
    fn of(outcome: &Outcome, run: &[MoveRecord]) -> Self {
        let mut windows: Vec<_> = across::windows_of(outcome, run).collect();
        windows.sort_unstable_by_key(|window| (window.at_ns, window.axis));
        Self { start_ns: run[0].start_ns, windows: windows.into_iter().peekable(), ratios: [0.0; AXES] }
    }

    /// The highest ratio, with its axis, from where this was asked last until `t_s` from the start of the run.
    fn until(&mut self, t_s: f64) -> (usize, f64) {
        let end_ns = self.start_ns + (t_s * 1e9).ceil() as u64;
        let mut highest = self.ratios;
        while let Some(window) = self.windows.next_if(|window| window.at_ns <= end_ns) {
            self.ratios[window.axis] = window.ratio;
            highest[window.axis] = highest[window.axis].max(window.ratio);
        }
        highest.into_iter().enumerate().max_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((0, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Config, run};

    fn made(program: &str) -> Outcome {
        run(program.as_bytes(), &Config::default()).unwrap()
    }

    /// Whatever the windows find, a stretch has; and together the stretches are the path and its time.
    #[test]
    fn stretches_lose_no_window_no_time_and_no_place() {
        for program in ["G1 X10 F1200\nY10\nX3 Y3\n", "G64 P0.5\nG1 X10 F1200\nY10\nG2 X14 I2\nG4 P1\nX0 Y0\n"] {
            let outcome = made(program);
            let all: Vec<_> = stretches(&outcome).collect();
            let most = all.iter().map(|stretch| stretch.ratio).fold(0.0, f64::max);
            assert_eq!(most, across::highest(&outcome).unwrap().ratio, "{program}");
            let moving_s: f64 = outcome.moves.iter().map(|record| record.plan_s - record.begin_s()).sum();
            let early_s: f64 = outcome
                .moves
                .windows(2)
                .filter(|pair| pair[0].run == pair[1].run)
                .map(|pair| pair[0].plan_s - pair[1].begin_s())
                .sum();
            let found_s: f64 = all.iter().map(|stretch| stretch.span_s).sum();
            assert!((found_s - (moving_s - early_s)).abs() < 1e-9, "{program}: {found_s} of {moving_s} - {early_s}");
            for pair in all.windows(2) {
                let apart_mm = (0..AXES).map(|axis| (pair[1].from_mm[axis] - pair[0].to_mm[axis]).abs());
                assert!(apart_mm.fold(0.0, f64::max) < 1e-6, "{program}: {pair:?}");
            }
            let end_mm = all.last().unwrap().to_mm;
            assert!(
                (0..AXES).all(|axis| (end_mm[axis] - outcome.position_mm[axis]).abs() < 1e-6),
                "{program}: {end_mm:?}"
            );
        }
    }

    /// A window between two others counts for the stretch that has its middle, and the last one for the next stretch too.
    #[test]
    fn a_short_window_is_not_lost() {
        let window = |at_ns, ratio| Window { axis: 1, at_ns, ratio };
        let windows = vec![window(1, 0.5), window(2, 9.0), window(3, 1.0), window(8, 0.2)];
        let mut latest = Latest { start_ns: 0, windows: windows.into_iter().peekable(), ratios: [0.0; AXES] };
        assert_eq!([4e-9, 6e-9, 9e-9, 1.0].map(|t_s| latest.until(t_s)), [(1, 9.0), (1, 1.0), (1, 1.0), (1, 0.2)]);
    }

    /// A right angle by `$11` jumps at the corner: it is loud within two spans of it, and quiet elsewhere.
    #[test]
    fn what_is_above_the_limit_is_where_the_speed_jumps() {
        let outcome = made("G61 G1 X10 F1200\nY10\n");
        let [_, span_s] = across::spans_s(&outcome);
        let above: Vec<_> = stretches(&outcome).filter(|stretch| stretch.ratio > WITHIN).collect();
        assert!(!above.is_empty());
        for stretch in above {
            let far_mm = (stretch.from_mm[0] - 10.0).hypot(stretch.from_mm[1]);
            assert!(far_mm < 2.0 * span_s * 20.0, "{stretch:?}");
        }
    }
}
