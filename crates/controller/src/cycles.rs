//! From canned cycles to the machine's motions, part by part.

use embassy_futures::yield_now;
use embassy_time::Duration;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_console::{CyclePart, CycleProgress, Error, SpindleMode};
use isostep_motion::Motion;

use crate::beyond::Beyond;
use crate::controller::Controller;
use crate::output::Message;

/// What a part of a cycle asks the machine for.
enum OfCycle {
    Motion(Motion),
    SpindleOff,
    SpindleOn,
}

impl<F: NorFlash> Controller<'_, F> {
    /// Asks for the holes of the line that the interpreter has accepted. None is begun if one is beyond the travel.
    /// Anything that ends the program ends the cycle, too.
    pub(crate) async fn drill(&self, line: u32, checks: bool, text: &mut Message) -> Result<(), Error> {
        if let Some(beyond) = self.beyond_holes() {
            return Err(self.refuse_target(beyond, false, text).await);
        }
        if checks {
            return Ok(());
        }
        let mut progress = self.with(|program| program.interpreter.cycle().begin());
        while let Some(asked) = self.next_of_cycle(&mut progress, line) {
            match asked {
                OfCycle::Motion(motion) => self.submit(motion).await?,
                // A laser shines in no rapid, and a spindle that stands is not stopped.
                OfCycle::SpindleOff | OfCycle::SpindleOn if !self.spindle_turns() => {}
                OfCycle::SpindleOff => {
                    self.settled().await?;
                    self.machine.stop_spindle_at_rest();
                }
                OfCycle::SpindleOn => self.switch_tool(false).await?,
            }
            // The ports' queues are filled between parts, however many there are.
            yield_now().await;
        }
        Ok(())
    }

    /// A place of the holes that is beyond the travel.
    fn beyond_holes(&self) -> Option<Beyond> {
        let bounds_pm = self.with(|program| program.interpreter.cycle().bounds_pm());
        bounds_pm.into_iter().find_map(|place_pm| self.target_steps(place_pm, None).1)
    }

    // What is asked for is smaller than a part, and a line's future keeps it.
    fn next_of_cycle(&self, progress: &mut CycleProgress, line: u32) -> Option<OfCycle> {
        let part = self.with(|program| program.interpreter.cycle().next(progress))?;
        Some(match part {
            CyclePart::Move(one) => OfCycle::Motion(Motion::Move(self.like(&one, self.steps(one.target_pm), line))),
            CyclePart::Dwell(dwell_s) => OfCycle::Motion(Motion::Dwell(dwell(dwell_s))),
            CyclePart::SpindleOff => OfCycle::SpindleOff,
            CyclePart::SpindleOn => OfCycle::SpindleOn,
        })
    }

    /// True if there is a spindle, and the modes say that it turns.
    pub(crate) fn spindle_turns(&self) -> bool {
        self.with(|program| !program.settings.laser_mode && program.interpreter.modal().spindle != SpindleMode::Off)
    }
}

/// The time of a dwell.
pub(crate) fn dwell(dwell_s: f32) -> Duration {
    Duration::from_micros((f64::from(dwell_s) * 1e6) as u64)
}
