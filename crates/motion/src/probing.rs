//! Probing: a straight move until a contact closes, or opens.
//!
//! The instant of the contact is known. From it the plan gives the step at which the contact came, because edges are
//! where the plan has them. After the contact the machine brakes on its path, so it stands at another place.

use core::convert::Infallible;

use embassy_time::{Duration, Instant};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal_async::digital::Wait;

use crate::axes::AXES;
use crate::chunks::Chunks;
use crate::clock::seconds;
use crate::coordinator::Coordinator;
use crate::coordinator::Purpose;
use crate::event::{Alarm, Finish};
use crate::limit::wait_level;
use crate::machine::{Machine, ProbeMove, Probed};

/// Watches the probe for ever. Its input is low or high while it touches, as configured. The later this task runs after
/// an edge, the larger is the error of the contact's place.
///
/// # Cancellation
/// Dropping it leaves the probe unwatched: a probing motion goes on to its end.
pub async fn watch<I: InputPin<Error = Infallible> + Wait>(machine: &Machine, mut input: I) -> ! {
    let Ok(mut is_low) = input.is_low();
    loop {
        machine.probe_edge(is_low);
        is_low = !is_low;
        wait_level(&mut input, is_low).await;
    }
}

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(crate::event::Event),
{
    /// Moves until the contact, and stops a little behind it.
    pub(crate) async fn probe(&mut self, probe: ProbeMove) -> Result<(), Alarm> {
        let ProbeMove { target_steps, feed_mm_s, away, must, line } = probe;
        let kinematics = self.machine.config().kinematics;
        let (target_steps, origin_steps) = (kinematics.motors(target_steps), self.machine.motor_steps());
        let steps = core::array::from_fn(|axis| target_steps[axis].wrapping_sub(origin_steps[axis]));
        if let Some(motor) = self.machine.onto_switch(kinematics.axes(steps)) {
            return Err(Alarm::HardLimit { motor });
        }
        self.machine.set_probed(Probed { touched: false, position_steps: kinematics.axes(origin_steps) });
        if !self.machine.seek_contact(!away) {
            return Err(Alarm::ProbeInitial);
        }
        self.contact_steps = None;
        let finish = if steps == [0; AXES] {
            Finish::Done
        } else {
            self.begin_chain(Purpose::Probe);
            self.push(steps, feed_mm_s, line)?;
            let finish = self.seek(origin_steps).await;
            self.chain.clear();
            finish
        };
        let made_steps = self.contact_steps.take();
        let position_steps = match made_steps {
            Some(made_steps) => kinematics.axes(core::array::from_fn(|axis| origin_steps[axis] + made_steps[axis])),
            None => self.machine.position_steps(),
        };
        let touched = made_steps.is_some();
        self.machine.set_probed(Probed { touched, position_steps });
        match finish {
            Finish::Stopped | Finish::Fault { .. } => Err(self.stop_alarm()),
            Finish::Done | Finish::Held if touched || !must || self.machine.is_to_forget() => Ok(()),
            Finish::Done | Finish::Held => Err(Alarm::ProbeContact),
        }
    }

    /// Makes the move until the contact, however often it is held.
    async fn seek(&mut self, origin_steps: [i32; AXES]) -> Finish {
        loop {
            let finish = self.make(Purpose::Probe).await;
            let goes_on = finish == Finish::Held && self.contact_steps.is_none() && self.machine.outlast_hold().await;
            if !goes_on {
                return finish;
            }
            if self.machine.contact_at().is_some() {
                // The contact came while the machine stood still.
                let motor_steps = self.machine.motor_steps();
                self.contact_steps = Some(core::array::from_fn(|axis| motor_steps[axis] - origin_steps[axis]));
                return finish;
            }
        }
    }

    /// Looks whether the contact has come in the run that started at `start`, and if so notes the steps that each axis
    /// had made by then. Returns whether it has come.
    #[cold]
    pub(crate) fn note_contact(&mut self, start: Instant) -> bool {
        if self.contact_steps.is_none()
            && let Some(at) = self.machine.contact_at()
        {
            // Instants are rounded down to whole ticks: the step that made the contact came before the next tick.
            let t_s = seconds(at.saturating_duration_since(start) + Duration::from_ticks(1));
            self.contact_steps = Some(made_steps(self.chunks, t_s));
        }
        self.contact_steps.is_some()
    }
}

/// The signed steps that each axis has made by `t_s`, by the plan of a run's only move.
fn made_steps(chunks: &Chunks, t_s: f64) -> [i32; AXES] {
    let Some(line) = chunks.under_way_at(t_s).and_then(|chunk| chunk.plan.line()) else { return [0; AXES] };
    let place_steps = line.place_at(t_s);
    core::array::from_fn(|axis| {
        let made = line.steps_before(axis, place_steps) as i32;
        made * line.steps[axis].signum()
    })
}
