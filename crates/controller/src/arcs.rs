//! From arcs to the machine's motions, side by side of a polygon.

use embassy_futures::yield_now;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::{Arc, Error, Polygon, Within};
use isostep_motion::{AXES, Motion, Move, beside_steps, whole_steps};
use isostep_profile::{IntervalSplit, SpeedProfile};

use crate::controller::Controller;

/// The greatest error of a side, steps of the finer axis. Smaller errors would not change the motion.
const ERROR_MAX_STEPS: f64 = 0.25;
/// The time that a blend may last at the speed that is asked for, s. A hold waits for the end of one.
const BLEND_MAX_S: f64 = 0.1;

impl<F: NorFlash> Controller<'_, F> {
    /// Asks for an arc that is within the travel, by moves that are as `last`, the last of them: by sides outside of it, if blends
    /// make it of them, or by chords. Anything that ends the program ends the arc, too.
    pub(crate) async fn follow(&self, arc: &Arc, last: &Move) -> Result<(), Error> {
        let steps_per_mm = self.machine.config().steps_per_mm;
        let tolerance_mm = self.tolerance_mm(arc, steps_per_mm);
        let within = Within {
            tolerance_mm,
            deviation_mm: if self.blends() { last.deviation_mm.into() } else { 0.0 },
            side_mm: BLEND_MAX_S * last.feed_mm_s,
        };
        let (ends_mm, lead_mm, reach_mm) = match arc.polygon(&within) {
            Some(Polygon { vertices, lead_mm, reach_mm }) => (vertices, lead_mm, reach_mm),
            None => (arc.chords(tolerance_mm), 0.0, 0.0),
        };
        let steps = |place_mm: [f64; AXES]| {
            core::array::from_fn::<_, AXES, _>(|axis| whole_steps(place_mm[axis], steps_per_mm[axis]))
        };
        let beside = |place_mm: [f64; AXES]| match last.deviation_mm {
            0.0 => [0; AXES],
            _ => core::array::from_fn(|axis| beside_steps(place_mm[axis], steps_per_mm[axis])),
        };
        let mut place_steps = steps(arc.start_mm());
        let mut own_mm = lead_mm as f32;
        // A side is asked for only when the next one is known, because the last one is not like the others.
        let mut ahead = None;
        for end_mm in ends_mm {
            let target_steps = steps(end_mm);
            if target_steps == place_steps {
                continue;
            }
            place_steps = target_steps;
            if let Some((target_steps, offsets)) = ahead.replace((target_steps, beside(end_mm))) {
                let side = Move { target_steps, offsets, exact_stop: false, in_arc: true, reach_mm: own_mm, ..*last };
                self.submit(Motion::Move(side)).await?;
                own_mm = reach_mm as f32;
                // The ports' queues are filled between sides, however many there are.
                yield_now().await;
            }
        }
        let Some((target_steps, offsets)) = ahead else { return Ok(()) };
        let offsets = if last.exact_stop { [0; AXES] } else { offsets };
        self.submit(Motion::Move(Move { target_steps, offsets, reach_mm: own_mm, ..*last })).await
    }

    /// The least and the greatest place of every axis on an arc, steps.
    ///
    /// The vertices of a polygon are outside, by less than the deviation of blends. The path does not go there, but comes to rest on
    /// a side if it is held.
    pub(crate) fn bounds_steps(&self, arc: &Arc) -> [[i32; AXES]; 2] {
        let (bounds_mm, steps_per_mm) = (arc.bounds_mm(), self.machine.config().steps_per_mm);
        [0, 1].map(|end| core::array::from_fn(|axis| whole_steps(bounds_mm[axis][end], steps_per_mm[axis])))
    }

    /// True if there are blends at all: without them the path goes to the vertices.
    fn blends(&self) -> bool {
        let config = self.machine.config();
        config.interval_split == IntervalSplit::Fastest
            && config.speed_profile == SpeedProfile::Trapezoid
            && config.limits.iter().all(|limits| limits.start_speed_steps_s == 0.0)
    }

    fn tolerance_mm(&self, arc: &Arc, steps_per_mm: [f64; AXES]) -> f64 {
        let [first, second, ..] = arc.axes();
        let finest_mm = ERROR_MAX_STEPS / steps_per_mm[first].max(steps_per_mm[second]);
        self.with(|program| f64::from(program.settings.arc_tolerance_mm)).min(finest_mm)
    }
}
