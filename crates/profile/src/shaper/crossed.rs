//! The motors of crossed belts (CoreXY) in a shaped run: what is shaped are the two axes that they move together, each by its own
//! shaper. A motor makes half the sum, or half the difference, of the two.
//!
//! The two axes are read in half steps, so that their places are whole numbers: the sum and the difference of the motors' steps. Until
//! the next phase of either axis begins, a motor has one acceleration, or one jerk. It is counted by itself, and where both axes
//! have come to the end its count is that of theirs.

use super::ShapedPart;
use super::phase_counter::PhaseCounter;
use super::sum::{AT_ONCE_S, Sum};
use crate::phase::{AxisPhase, CountedPhase, SAME_S};

/// The number of motors, and of axes that they move.
const TWO: usize = 2;

/// What an axis does next.
pub enum NextPart {
    /// This.
    Part(ShapedPart),
    /// It stands still to the end of the run, by when it has made so many half steps.
    Over(i32),
    /// That is not known yet.
    Unknown,
}

/// The two motors in a run.
#[derive(Clone, Debug)]
pub struct Crossed {
    /// The parts of the axes that are under way.
    axes: [ShapedPart; TWO],
    counters: [PhaseCounter; TWO],
    /// Up to when it has been taken, s from the start of the run.
    t_s: f64,
    /// The motor that has not taken its last phase yet, and that phase.
    behind: Option<(usize, CountedPhase)>,
}

impl Crossed {
    const REST: ShapedPart = ShapedPart {
        sum: Sum { phase: AxisPhase::rest(0.0, 0.0), jerk_steps_s3: 0.0 },
        end_s: 0.0,
        base_steps: 0,
        last_steps: None,
        is_last: false,
    };

    /// Nothing is known of any motion.
    #[must_use]
    pub const fn empty() -> Self {
        Self { axes: [Self::REST; TWO], counters: [PhaseCounter::NONE; TWO], t_s: 0.0, behind: None }
    }

    /// Begins a run of motors with these top speeds.
    #[cold]
    pub fn begin(&mut self, tops_steps_s: [f64; TWO]) {
        *self = Self { counters: tops_steps_s.map(PhaseCounter::new), ..Self::empty() };
    }

    /// Up to when the phases of `motor` have been taken, s from the start of the run.
    #[must_use]
    #[cold]
    pub fn taken_s(&self, motor: usize) -> f64 {
        match &self.behind {
            Some((behind, counted)) if *behind == motor => counted.phase.begin_s,
            _ => self.t_s,
        }
    }

    /// True if `motor` has taken its last phase: both axes stand still to the end of the run.
    #[must_use]
    #[cold]
    pub fn is_over(&self, motor: usize) -> bool {
        let is_behind = self.behind.is_some_and(|(behind, _)| behind == motor);
        !is_behind && self.axes.iter().all(|axis| axis.end_s == f64::INFINITY)
    }

    /// The next phase of `motor`, 0 or 1; `None` if that is not known yet, if the other motor has not taken its last one yet, or if it
    /// is over. `next` tells what the axis with this index does next.
    #[cold]
    pub fn next_phase(&mut self, motor: usize, mut next: impl FnMut(usize) -> NextPart) -> Option<CountedPhase> {
        if let Some((behind, counted)) = self.behind {
            return (behind == motor).then(|| {
                self.behind = None;
                counted
            });
        }
        for axis in 0..TWO {
            while self.axes[axis].end_s <= self.t_s + SAME_S {
                self.pass(axis, next(axis))?;
            }
        }
        let mut end_s = self.axes[0].end_s.min(self.axes[1].end_s);
        if end_s == f64::INFINITY {
            return None;
        }
        let sums = [0, 1].map(|motor| self.sum_of(motor));
        for sum in sums.iter().filter(|sum| sum.is_curved()) {
            let turns_s = self.t_s + sum.turns_after_s();
            end_s = if turns_s < end_s - AT_ONCE_S { turns_s } else { end_s };
        }
        let last_steps = self.half_steps_at_end(end_s).map(|[x, y]| [x.wrapping_add(y) / 2, x.wrapping_sub(y) / 2]);
        let [own, other] = [motor, 1 - motor].map(|motor| {
            let base_steps = self.counters[motor].made_steps();
            self.counters[motor].count(sums[motor], end_s, base_steps, last_steps.map(|steps| steps[motor]))
        });
        (self.t_s, self.behind) = (end_s, Some((1 - motor, other)));
        Some(own)
    }

    /// Has an axis go on to its next part. `None` if that is not known.
    #[cold]
    fn pass(&mut self, axis: usize, next: NextPart) -> Option<()> {
        let ended = &self.axes[axis];
        self.axes[axis] = match next {
            NextPart::Part(part) => part,
            NextPart::Over(half_steps) => {
                let place_steps = ended.sum.at(ended.end_s).0;
                let phase = AxisPhase::rest(ended.end_s, place_steps);
                let sum = Sum { phase, jerk_steps_s3: 0.0 };
                ShapedPart { sum, end_s: f64::INFINITY, last_steps: Some(half_steps), is_last: true, ..*ended }
            }
            NextPart::Unknown => return None,
        };
        Some(())
    }

    /// The motion of a motor from now on. Its place counts from the whole step where it is.
    #[cold]
    fn sum_of(&self, motor: usize) -> Sum {
        let sign = if motor == 0 { 1.0 } else { -1.0 };
        let [x, y] = [0, 1].map(|axis| {
            let Sum { phase, jerk_steps_s3 } = self.axes[axis].sum;
            let (place_steps, speed_steps_s) = self.axes[axis].sum.at(self.t_s);
            let accel_steps_s2 = phase.accel_steps_s2 + jerk_steps_s3 * (self.t_s - phase.begin_s);
            (AxisPhase { begin_s: self.t_s, place_steps, speed_steps_s, accel_steps_s2 }, jerk_steps_s3)
        });
        let half = |x: f64, y: f64| 0.5 * (x + sign * y);
        let [x_base, y_base] = [0, 1].map(|axis| i64::from(self.axes[axis].base_steps));
        let base = if motor == 0 { x_base + y_base } else { x_base - y_base };
        let from = base - 2 * i64::from(self.counters[motor].made_steps());
        let phase = AxisPhase {
            begin_s: self.t_s,
            place_steps: half(x.0.place_steps, y.0.place_steps) + 0.5 * from as f64,
            speed_steps_s: half(x.0.speed_steps_s, y.0.speed_steps_s),
            accel_steps_s2: half(x.0.accel_steps_s2, y.0.accel_steps_s2),
        };
        Sum { phase, jerk_steps_s3: half(x.1, y.1) }
    }

    /// The half steps of the axes at the end of the run, if both come there at `end_s` or are there. Where they come to rest before, the
    /// motors are where a whole step of each is surely the nearest.
    #[cold]
    fn half_steps_at_end(&self, end_s: f64) -> Option<[i32; TWO]> {
        let at_end = |axis: usize| {
            let ShapedPart { sum, end_s: ends_s, last_steps, is_last, .. } = &self.axes[axis];
            let comes = *ends_s <= end_s + SAME_S || sum.phase.is_rest() && !sum.is_curved();
            last_steps.filter(|_| *is_last && comes)
        };
        Some([at_end(0)?, at_end(1)?])
    }
}
