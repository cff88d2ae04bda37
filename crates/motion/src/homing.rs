//! Limit-switch homing, axis by axis: seek, back off, latch, pull off.
//!
//! The seek may stop abruptly, because only the slow latch measures. Both searches are bounded (by Grbl's factors): a
//! switch that is missing, stuck or wired wrongly raises an alarm that names it.

use core::convert::Infallible;
use core::pin::pin;

use embassy_time::Timer;
use embedded_hal::digital::OutputPin;

use crate::axes::{AXES, Axis};
use crate::coordinator::{Coordinator, alongside};
use crate::event::{Alarm, Event, Finish, HomingPhase, State};
use crate::port::Direction;

/// The seek gives up after this many times the travel.
const SEEK_TRAVELS: f64 = 1.5;
/// The latch gives up after this many times the pull-off.
const LATCH_PULL_OFFS: f64 = 5.0;

impl<E, F> Coordinator<'_, E, F>
where
    E: OutputPin<Error = Infallible>,
    F: FnMut(Event),
{
    /// Homes these axes in the configured order. Each then stands at its zero, a pull-off away from its switch. It
    /// does nothing if it is stopped before it begins.
    pub(crate) async fn home(&mut self, axes: [bool; AXES]) -> Result<(), Alarm> {
        while !self.machine.begin_homing() {
            if !self.machine.outlast_hold().await {
                return Ok(());
            }
        }
        self.report_state(State::Home);
        let asked = |axis: &Axis| axes[*axis as usize];
        for axis in Axis::ALL.into_iter().filter(asked) {
            self.machine.set_homed(axis, false);
        }
        for axis in self.machine.config().homing.order.into_iter().filter(asked) {
            self.home_axis(axis).await?;
        }
        Ok(())
    }

    async fn home_axis(&mut self, axis: Axis) -> Result<(), Alarm> {
        let homing = self.machine.config().homing;
        let travel_mm = self.machine.config().travel_mm[axis as usize];
        // A carriage that already stands on its switch has nothing to seek.
        if !self.machine.switch(axis).is_pressed() {
            self.phase(axis, HomingPhase::Seek);
            self.search(axis, SEEK_TRAVELS * travel_mm, homing.seek_mm_s).await?;
        }
        self.phase(axis, HomingPhase::BackOff);
        self.retreat(axis, homing.seek_mm_s).await?;
        self.phase(axis, HomingPhase::Latch);
        self.search(axis, LATCH_PULL_OFFS * homing.pull_off_mm, homing.latch_mm_s).await?;
        self.phase(axis, HomingPhase::PullOff);
        self.retreat(axis, homing.latch_mm_s).await?;
        self.machine.link(axis).odometer.zero();
        self.machine.set_homed(axis, true);
        self.report(Event::Homed { axis });
        Ok(())
    }

    fn phase(&mut self, axis: Axis, phase: HomingPhase) {
        self.report(Event::Homing { axis, phase });
    }

    /// Moves towards the switch until it is pressed.
    async fn search(&mut self, axis: Axis, distance_mm: f64, speed_mm_s: f64) -> Result<(), Alarm> {
        let machine = self.machine;
        let pressed = async {
            machine.switch(axis).wait_pressed().await;
            machine.halt();
        };
        // The move always answers, because the switch's halt ends it: it is never dropped half-way.
        let finish = {
            // The future is large. Pinned here it takes room in the task once, and not again in the future that it is
            // handed to.
            let moving = pin!(self.along(axis, distance_mm, true, speed_mm_s));
            alongside(moving, pressed).await?
        };
        match finish {
            _ if machine.cause().is_some() => Err(self.stop_alarm()),
            _ if machine.switch(axis).is_pressed() => Ok(()),
            _ => Err(Alarm::SwitchNotFound { axis }),
        }
    }

    /// Moves away from the switch by the pull-off; the switch must open.
    async fn retreat(&mut self, axis: Axis, speed_mm_s: f64) -> Result<(), Alarm> {
        let homing = self.machine.config().homing;
        match self.along(axis, homing.pull_off_mm, false, speed_mm_s).await? {
            Finish::Stopped | Finish::Fault { .. } => return Err(self.stop_alarm()),
            // Homing is never held.
            Finish::Done | Finish::Held => {}
        }
        // Long enough for the debounced level to follow.
        Timer::after(homing.debounce * 2).await;
        if self.machine.switch(axis).is_pressed() { Err(Alarm::SwitchStuck { axis }) } else { Ok(()) }
    }

    async fn along(&mut self, axis: Axis, mm: f64, to_switch: bool, speed_mm_s: f64) -> Result<Finish, Alarm> {
        let config = self.machine.config();
        let positive = (config.homing.towards[axis as usize] == Direction::Positive) == to_switch;
        let n = config.steps(axis, mm);
        let mut steps = [0; AXES];
        steps[axis as usize] = if positive { n } else { -n };
        self.travel(steps, speed_mm_s).await
    }
}
