//! From arcs to the machine's motions, chord by chord.

use embassy_futures::yield_now;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::{Arc, Error};
use isostep_motion::{AXES, Motion, Move, beside_steps, whole_steps};

use crate::controller::Controller;

/// The greatest error of a chord, steps of the finer axis. Smaller errors would not change the motion.
const CHORD_ERROR_MAX_STEPS: f64 = 0.25;

impl<F: NorFlash> Controller<'_, F> {
    /// Asks for an arc that is within the travel, by chords that are as `last`, the last of them. Anything that ends the program
    /// ends the arc, too.
    pub(crate) async fn follow(&self, arc: &Arc, last: &Move) -> Result<(), Error> {
        let steps_per_mm = self.machine.config().steps_per_mm;
        let steps = |place_mm: [f64; AXES]| {
            core::array::from_fn::<_, AXES, _>(|axis| whole_steps(place_mm[axis], steps_per_mm[axis]))
        };
        let beside = |place_mm: [f64; AXES]| match last.deviation_mm {
            0.0 => [0; AXES],
            _ => core::array::from_fn(|axis| beside_steps(place_mm[axis], steps_per_mm[axis])),
        };
        let mut place_steps = steps(arc.start_mm());
        // A chord is asked for only when the next one is known, because the last one is not like the others.
        let mut ahead = None;
        for end_mm in arc.chords(self.tolerance_mm(arc, steps_per_mm)) {
            let target_steps = steps(end_mm);
            if target_steps == place_steps {
                continue;
            }
            place_steps = target_steps;
            if let Some((target_steps, offsets)) = ahead.replace((target_steps, beside(end_mm))) {
                let chord = Move { target_steps, offsets, exact_stop: false, in_arc: true, ..*last };
                self.submit(Motion::Move(chord)).await?;
                // The ports' queues are filled between chords, however many chords there are.
                yield_now().await;
            }
        }
        let Some((target_steps, offsets)) = ahead else { return Ok(()) };
        let offsets = if last.exact_stop { [0; AXES] } else { offsets };
        self.submit(Motion::Move(Move { target_steps, offsets, ..*last })).await
    }

    /// The least and the greatest place of every axis on an arc, steps.
    pub(crate) fn bounds_steps(&self, arc: &Arc) -> [[i32; AXES]; 2] {
        let (bounds_mm, steps_per_mm) = (arc.bounds_mm(), self.machine.config().steps_per_mm);
        [0, 1].map(|end| core::array::from_fn(|axis| whole_steps(bounds_mm[axis][end], steps_per_mm[axis])))
    }

    fn tolerance_mm(&self, arc: &Arc, steps_per_mm: [f64; AXES]) -> f64 {
        let [first, second, ..] = arc.axes();
        let finest_mm = CHORD_ERROR_MAX_STEPS / steps_per_mm[first].max(steps_per_mm[second]);
        self.with(|program| f64::from(program.settings.arc_tolerance_mm)).min(finest_mm)
    }
}
