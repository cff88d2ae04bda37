//! The steps that a motor makes in a shaped motion: they are counted from shaped phase to shaped phase.

use crate::fixed::{is_negative, is_zero};
use crate::phase::{AxisPhase, CountedPhase, turn, turns};
use crate::shaper::sum::{Sum, passed};

/// The steps made so far, and the top speed of the motor.
#[derive(Clone, Copy, Debug)]
pub(super) struct PhaseCounter {
    made_steps: i32,
    top_steps_s: f64,
}

impl PhaseCounter {
    pub(super) const NONE: Self = Self::new(0.0);

    /// Nothing is made yet.
    pub(super) const fn new(top_steps_s: f64) -> Self {
        Self { made_steps: 0, top_steps_s }
    }

    /// The steps made, from the beginning of the run.
    pub(super) fn made_steps(&self) -> i32 {
        self.made_steps
    }

    /// The shaped phase that is made of this sum up to `end_s`. Its place counts from the whole step `base_steps`. If it comes to rest
    /// then, it has made `last_steps` in all.
    pub(super) fn count(&mut self, sum: Sum, end_s: f64, base_steps: i32, last_steps: Option<i32>) -> CountedPhase {
        let last = last_steps.map(|steps| steps.wrapping_sub(base_steps));
        let counted = self.counted(sum, end_s, self.made_steps.wrapping_sub(base_steps), last);
        self.made_steps = counted.counts[2].wrapping_add(base_steps);
        counted
    }

    fn counted(&self, sum: Sum, end_s: f64, begin: i32, last: Option<i32>) -> CountedPhase {
        let (end_place_steps, end_speed_steps_s) = sum.at(end_s);
        let Sum { phase, jerk_steps_s3 } = sum;
        let (from_steps_s, to_steps_s) = (phase.speed_steps_s, end_speed_steps_s);
        let is_back = match sum.is_curved() {
            true => end_place_steps < phase.place_steps,
            false => is_negative(if is_zero(to_steps_s) { from_steps_s } else { to_steps_s }),
        };
        let end = last.unwrap_or_else(|| {
            if phase.is_rest() && !sum.is_curved() { begin } else { passed(end_place_steps, is_back) }
        });
        let mut counted =
            CountedPhase { phase, end_s, end_place_steps, end_speed_steps_s, jerk_steps_s3, counts: [begin, end, end] };
        if !sum.is_curved() && turns(from_steps_s, to_steps_s) {
            counted.counts[1] =
                turn(phase.place_steps, from_steps_s, phase.accel_steps_s2, [begin, end], self.top_steps_s);
        } else if end == begin || (end < begin) == is_back && (sum.is_curved() || !phase.is_rest()) {
            // It goes on in its direction.
        } else if last.is_none() {
            counted.counts = [begin; 3];
        } else {
            // Rounding has made a step too many, or one too few: the last shaped phase makes up for it.
            let speed_steps_s = f64::from(end - begin) / (end_s - phase.begin_s);
            counted.phase = AxisPhase { speed_steps_s, ..AxisPhase::rest(phase.begin_s, f64::from(begin)) };
            counted.jerk_steps_s3 = 0.0;
            (counted.end_place_steps, counted.end_speed_steps_s) = (f64::from(end), speed_steps_s);
        }
        counted
    }
}
