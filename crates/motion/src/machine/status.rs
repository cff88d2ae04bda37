//! The report of a machine on itself.

use embassy_time::Instant;
use isostep_profile::chain::Plan;
use isostep_profile::{Blend, SyncMove};

use super::{Door, Machine};
use crate::axes::{AXES, Axis};
use crate::clock::seconds;
use crate::event::State;
use crate::motor::LimitInput;
use crate::tag::Chunk;
use crate::tool::power::Level;
use crate::tool::spindle::Outputs;

/// The machine's status at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Status {
    /// Its state.
    pub state: State,
    /// The places where each axis stands, steps: the exact count of emitted edges, or with crossed belts what follows from that.
    pub position_steps: [i32; AXES],
    /// The switches that are pressed, debounced: each axis's first.
    pub pressed: [bool; AXES],
    /// The second motor's switch is pressed, if there is a second motor: the axis that it moves.
    pub second_pressed: Option<Axis>,
    /// True if a drive is in alarm.
    pub drive_alarm: bool,
    /// True if the emergency stop is pressed.
    pub emergency_stop: bool,
    /// The axes that have been homed and not lost their position since.
    pub homed: [bool; AXES],
    /// The number of moves, or jogs, that can be asked for without waiting: [`MOVES_AHEAD`](super::MOVES_AHEAD) at most.
    pub queue_free: usize,
    /// Speed along the path at this instant, mm/s.
    pub speed_mm_s: f64,
    /// The line of the move under way; 0 for none.
    pub line: u32,
    /// The outputs as they are; off where a hold or the safety door keeps them off.
    pub outputs: Outputs,
    /// The level that the PWM output has now, with the override applied.
    pub level: Level,
    /// The probe touches.
    pub probe_touches: bool,
    /// The state of the safety door.
    pub door: Door,
    /// The button of the feed hold, and that of the cycle start, are pressed, in this order.
    pub buttons: [bool; 2],
}

/// The chunk under way, for [`Status`]; at most 15 ms out of date.
#[derive(Clone, Copy)]
pub(crate) struct CurrentChunk {
    pub start: Instant,
    pub chunk: Chunk,
    /// The program line that it comes from; of several, the one under way.
    pub line: u32,
}

/// Speed along the path of a blend at `t_s` from the start of the run, mm/s.
pub(crate) fn path_speed_mm_s(blend: &Blend<AXES>, t_s: f64, steps_per_mm: &[f64; AXES]) -> f64 {
    let axes_mm_s = (0..AXES).map(|axis| blend.speed_at(axis, t_s) / steps_per_mm[axis]);
    libm::sqrt(axes_mm_s.map(|mm_s| mm_s * mm_s).sum())
}

/// Speed of the longest axis of a line at `t_s` from the start of the run, steps/s; that at its end from there on.
#[cold]
pub(crate) fn plan_speed_steps_s(plan: &SyncMove<AXES>, t_s: f64) -> f64 {
    if t_s < plan.end_s() { plan.speed_at(t_s) } else { plan.profile.exit_speed_steps_s() }
}

impl CurrentChunk {
    /// Speed along the path now, mm/s.
    fn speed_mm_s(&self, steps_per_mm: &[f64; AXES]) -> f64 {
        let Chunk { plan, mm_per_step, .. } = &self.chunk;
        let t_s = seconds(Instant::now().saturating_duration_since(self.start));
        // The chunk is known a little before it begins, and may have ended.
        let t_s = t_s.max(plan.begin_s()).min(plan.end_s());
        match plan {
            Plan::Line(line) => plan_speed_steps_s(line, t_s) * mm_per_step,
            Plan::Blend(blend) => path_speed_mm_s(blend, t_s, steps_per_mm),
        }
    }
}

impl Machine {
    /// The state of the machine, its place and its speed.
    #[must_use]
    #[cold]
    pub fn status(&self) -> Status {
        let (homed, current, room) = self.with(|inner| (inner.homed, inner.current, inner.room));
        let life = self.life();
        let (outputs, buttons, squared) = self.with(|inner| (inner.effective(), inner.buttons, inner.config.squared));
        let (kinematics, steps_per_mm) = self.with(|inner| (inner.config.kinematics, inner.config.steps_per_mm));
        // What it takes lies in flash, which no critical section may wait for.
        let steps_per_mm = kinematics.motor_steps_per_mm(steps_per_mm);
        Status {
            state: life.state,
            position_steps: self.position_steps(),
            pressed: Axis::ALL.map(|axis| self.switch(LimitInput::Of(axis)).is_pressed()),
            second_pressed: squared
                .map(|squared| squared.axis)
                .filter(|_| self.switch(LimitInput::Second).is_pressed()),
            drive_alarm: self.is_drive_in_alarm(),
            emergency_stop: life.emergency,
            homed,
            queue_free: self.queue_free() + if life.is_to_brake() { 0 } else { room },
            speed_mm_s: current.map_or(0.0, |current| current.speed_mm_s(&steps_per_mm)),
            line: current.map_or(0, |current| current.line),
            outputs,
            level: self.tool.level(),
            probe_touches: self.probe_touches(),
            door: life.door,
            buttons,
        }
    }

    pub(crate) fn set_current(&self, current: Option<CurrentChunk>) {
        self.with(|inner| inner.current = current);
    }

    /// Sets the program line under way, within the same chunk.
    pub(crate) fn set_line(&self, line: u32) {
        self.with(|inner| inner.current.iter_mut().for_each(|current| current.line = line));
    }
}
