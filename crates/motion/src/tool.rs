//! The tool: a spindle or a laser with its PWM output, enable and direction, and coolant.
//!
//! # Design
//! What the outputs are to be is part of the machine's state, and changes in one critical section with it: an alarm and
//! a reset switch all of them off. One task ([`run`]) sets the outputs to what the state says. A stop does not wait for
//! that task. It engages the outputs' inhibit, in whatever context it comes from, and the task releases the inhibit when it
//! has switched the outputs off itself.
//!
//! A spindle turns at one speed until another is asked for. A laser shines only in moves. As steps are queued for the
//! ports, strokes of time with a level (`Stroke`) are queued for the laser ahead of time. Where there is no stroke
//! it is dark. So if anything goes wrong, the laser goes out at the end of what was planned.

mod beam;
mod duty;
pub(crate) mod power;
pub(crate) mod spindle;
pub(crate) mod stroke;

use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer};

pub(crate) use self::beam::BeamStream;
pub use self::duty::Duties;
use self::power::Asked;
pub use self::power::{Level, Power};
use self::spindle::ToolWanted;
pub use self::spindle::{Outputs, Spindle, SpindleWanted, ToolConfig};
use self::stroke::Stroke;
use crate::machine::Machine;
use crate::port::Inhibit;

/// The outputs that are on or off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Switches {
    /// The spindle is to turn, or the laser may shine.
    pub enable: bool,
    /// Counter-clockwise. A laser leaves it off.
    pub counter_clockwise: bool,
    /// Flood coolant.
    pub flood: bool,
    /// Mist coolant.
    pub mist: bool,
}

/// The outputs of a tool.
pub trait ToolPort {
    /// The inhibit of all outputs. Engaged (`true`) it keeps them off, whatever is asked of them, until it is released.
    /// It may be called in any context, interrupts included.
    fn inhibit(&self) -> Inhibit;

    /// Switches outputs.
    fn switch(&mut self, switches: Switches);

    /// Sets the frequency of the PWM output, Hz; its duty stays.
    fn set_frequency(&mut self, hz: u32);

    /// The time before an instant at which the tool's task has to be woken, so that a duty changes at that instant: the time
    /// that the wake-up takes.
    fn lead(&self) -> Duration;

    /// Sets the duty of the PWM output, of 65,535. With `new_period` a new period begins with it now; otherwise the
    /// present period ends first.
    fn set_duty(&mut self, duty: u16, new_period: bool);
}

/// The period at which a level that changes linearly is set.
const UPDATE: Duration = Duration::from_micros(500);

/// A stroke begins a PWM period of its own if it lasts at least this many periods. A shorter stroke would be brighter
/// by that.
const PERIODS_MIN: u32 = 2;

/// Sets the outputs to what the machine's state says, for ever. Spawn it at a priority that few tasks delay: a level is
/// as late as this task is. If it is late, the first steps of a move are made with the level before, and nothing else
/// goes wrong.
///
/// # Cancellation
/// Dropping it leaves the outputs as they are until a stop engages their inhibit; nothing moves.
pub async fn run(machine: &Machine, mut port: impl ToolPort) -> ! {
    machine.fit_tool(port.inhibit());
    let mut state = Driven::NEW;
    loop {
        let wanted = machine.tool_wanted();
        if state.stops != wanted.stops {
            // The motion that the strokes belong to is over, or is not to shine any more.
            (state.stops, state.asked, state.stroke) = (wanted.stops, Asked::NOTHING, None);
            machine.strokes().clear();
        }
        state.switch(&wanted, &mut port);
        // The level of a laser comes from the strokes of its moves only.
        let asked = if wanted.config.laser { state.asked } else { Asked::even(wanted.outputs.level) };
        state.set(asked, &wanted, machine, &mut port);
        machine.release_tool(wanted.stops);
        if wanted.config.laser {
            select(machine.wait_tool(), shine(&wanted, machine, &mut state, &mut port)).await;
        } else {
            machine.wait_tool().await;
        }
    }
}

/// The values that were set at the port last.
struct Driven {
    switches: Switches,
    pwm_hz: u32,
    duty: u16,
    /// The number of times that the inhibit had been engaged.
    stops: u32,
    /// The request.
    asked: Asked,
    /// The instant at which the time for that ends. For a laser.
    lit_until: Instant,
    /// The stroke under way, or the next.
    stroke: Option<Stroke>,
}

impl Driven {
    /// All off.
    const NEW: Self = Self {
        switches: Switches { enable: false, counter_clockwise: false, flood: false, mist: false },
        pwm_hz: 0,
        duty: 0,
        stops: 0,
        asked: Asked::NOTHING,
        lit_until: Instant::MIN,
        stroke: None,
    };

    fn switch(&mut self, wanted: &ToolWanted, port: &mut impl ToolPort) {
        let ToolWanted { config, outputs, .. } = wanted;
        if self.pwm_hz != config.pwm_hz {
            self.pwm_hz = config.pwm_hz;
            port.set_frequency(config.pwm_hz);
        }
        let switches = Switches {
            enable: outputs.spindle != Spindle::Off,
            counter_clockwise: outputs.spindle == Spindle::CounterClockwise && !config.laser,
            flood: outputs.flood,
            mist: outputs.mist,
        };
        if self.switches != switches {
            self.switches = switches;
            port.switch(switches);
        }
    }

    /// The stroke under way, or the next one. While there is none the laser is made dark.
    async fn next_stroke(&mut self, wanted: &ToolWanted, machine: &Machine, port: &mut impl ToolPort) -> Stroke {
        loop {
            let is_lit = self.asked != Asked::NOTHING;
            let goes_out = Timer::at(self.lit_until.saturating_sub(port.lead()));
            match self.stroke {
                Some(stroke) if !is_lit || stroke.begin <= self.lit_until => return stroke,
                Some(_) => {
                    goes_out.await;
                    self.set(Asked::NOTHING, wanted, machine, port);
                }
                None if !is_lit => self.stroke = Some(machine.strokes().receive().await),
                None => match select(machine.strokes().receive(), goes_out).await {
                    Either::First(stroke) => self.stroke = Some(stroke),
                    Either::Second(()) => self.set(Asked::NOTHING, wanted, machine, port),
                },
            }
        }
    }

    fn set(&mut self, asked: Asked, wanted: &ToolWanted, machine: &Machine, port: &mut impl ToolPort) {
        self.give(Prepared::of(asked, wanted), true, machine, port);
    }

    fn give(&mut self, prepared: Prepared, new_period: bool, machine: &Machine, port: &mut impl ToolPort) {
        let Prepared { asked, level, duty } = prepared;
        self.asked = asked;
        if self.duty != duty {
            self.duty = duty;
            port.set_duty(duty, new_period);
        }
        machine.note_level(level);
    }
}

/// The request, the level that is made of it, and its duty.
struct Prepared {
    asked: Asked,
    level: Level,
    duty: u16,
}

impl Prepared {
    fn of(asked: Asked, wanted: &ToolWanted) -> Self {
        let level = wanted.level(asked);
        let duties = wanted.config.duties;
        Self { asked, level: duties.made(level), duty: duties.duty(level) }
    }
}

/// Makes the strokes of a laser. The duty for a level is computed before its instant.
///
/// What follows a level takes several times as long as setting it. So it is done in parts, between which a chip may serve
/// an interrupt that must not interrupt the setting: a stop waits for one part at most.
///
/// # Cancellation
/// Safe: the stroke under way is kept, and goes on with the next call.
async fn shine(wanted: &ToolWanted, machine: &Machine, state: &mut Driven, port: &mut impl ToolPort) {
    let lead = port.lead();
    let lasting = Duration::from_hz(u64::from(wanted.config.pwm_hz)) * PERIODS_MIN;
    loop {
        let stroke = state.next_stroke(wanted, machine, port).await;
        let mut from = Instant::now().max(stroke.begin);
        let mut new_period = stroke.lasts_until(from + lasting, machine.strokes());
        while from < stroke.end {
            yield_now().await;
            let until = if stroke.asked.is_even() { stroke.end } else { stroke.end.min(from + UPDATE) };
            let prepared = Prepared::of(stroke.asked_in([from, until]), wanted);
            yield_now().await;
            Timer::at(from.saturating_sub(lead)).await;
            state.give(prepared, new_period, machine, port);
            (state.lit_until, from, new_period) = (until, until, false);
        }
        state.stroke = None;
    }
}
