//! The tool: a spindle or a laser by a PWM output, its enable and direction, and coolant.
//!
//! # Design
//! What the outputs are to be is part of the machine's state, and changes in one critical section with it: an alarm and a
//! reset put all of them off. One task ([`run`]) does what the state says. A stop does not wait for that task: it puts on the
//! outputs' brake, in whatever context it comes from, and the task takes the brake off when it has switched them off itself.
//!
//! A spindle turns at one speed until another is asked for. A laser is dark but in a move, of which it is told beforehand, as
//! the ports are told of steps, by stretches of time (`Stretch`). Where no stretch is, it is dark: so whatever goes wrong, it
//! goes out at the end of what was planned.

mod beam;
mod duty;
mod power;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant, Timer};

pub(crate) use self::beam::BeamStream;
pub use self::duty::Duties;
pub(crate) use self::power::Tag;
pub use self::power::{Level, Power};
use crate::machine::Machine;
use crate::port::Brake;

/// What a machine's tool is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolConfig {
    /// A laser: dark at rest and in rapid moves.
    pub laser: bool,
    /// Which duty makes which level.
    pub duties: Duties,
    /// PWM frequency, Hz; above 0.
    pub pwm_hz: u32,
    /// How long a spindle takes to its speed: so long nothing moves.
    pub spin_up: Duration,
}

/// Whether a spindle turns, and which way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spindle {
    /// It stands still.
    #[default]
    Off,
    /// M3. Of a laser: its level is as asked for.
    Clockwise,
    /// M4. Of a laser: its level follows the speed along the path.
    CounterClockwise,
}

/// What the outputs are to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// Enable and direction.
    pub spindle: Spindle,
    /// The spindle's speed; a laser's is each move's own ([`Power`]).
    pub level: Level,
    /// Flood coolant.
    pub flood: bool,
    /// Mist coolant.
    pub mist: bool,
}

impl Outputs {
    /// All off.
    pub const OFF: Self = Self { spindle: Spindle::Off, level: Level::ZERO, flood: false, mist: false };

    pub(crate) fn without_spindle(self) -> Self {
        Self { spindle: Spindle::Off, level: Level::ZERO, ..self }
    }
}

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
    /// Puts all outputs off (`true`), whatever is asked of them, until it is released. In any context, interrupts included.
    fn brake(&self) -> Brake;

    /// Switches outputs.
    fn switch(&mut self, switches: Switches);

    /// Gives the PWM output another frequency, Hz; its duty stays.
    fn set_frequency(&mut self, hz: u32);

    /// How long before an instant its task is to be woken, so that a duty changes at it: what waking takes on the whole.
    fn lead(&self) -> Duration;

    /// Gives the PWM output another duty, of 65,535. `anew` begins a period with it now; otherwise the present one ends first.
    fn set_duty(&mut self, duty: u16, anew: bool);
}

/// How strongly a laser shines for some time: from one level evenly to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stretch {
    pub begin: Instant,
    pub end: Instant,
    pub from: Level,
    pub to: Level,
}

/// Stretches queued: 30 ms of a thousand short moves a second, of which each may have two.
const QUEUE_STRETCHES: usize = 64;

/// A laser's stretches on their way to its task.
pub(crate) type StretchQueue = Channel<CriticalSectionRawMutex, Stretch, QUEUE_STRETCHES>;

/// While a level changes evenly it is set anew so often.
const UPDATE: Duration = Duration::from_micros(500);

/// A stretch begins a PWM period if it holds so many of them: a shorter one would make it brighter.
const PERIODS_MIN: u32 = 2;

/// Does with the outputs what the machine's state says, for ever. Spawn it at a priority that few delay: a level is as late as
/// this task is. A miss makes a move's first steps with the level before, and no more.
///
/// # Cancellation
/// Dropping it leaves the outputs as they are until a stop puts on their brake; nothing moves.
pub async fn run(machine: &Machine, mut port: impl ToolPort) -> ! {
    machine.fit_tool(port.brake());
    let mut state = Driven::NEW;
    loop {
        let wanted = machine.tool_wanted();
        if state.stops != wanted.stops {
            // The motion that they belong to is over, or shines no more.
            (state.stops, state.asked, state.stretch) = (wanted.stops, Level::ZERO, None);
            machine.stretches().clear();
        }
        state.switch(&wanted, &mut port);
        // Of a laser only what is told of a move.
        let asked = if wanted.config.laser { state.asked } else { wanted.outputs.level };
        state.set(asked, &wanted, machine, &mut port);
        machine.release_tool(wanted.stops);
        if wanted.config.laser {
            select(machine.wait_tool(), shine(&wanted, machine, &mut state, &mut port)).await;
        } else {
            machine.wait_tool().await;
        }
    }
}

/// What the machine's state asks of the outputs.
#[derive(Clone, Copy)]
pub(crate) struct ToolWanted {
    pub config: ToolConfig,
    pub outputs: Outputs,
    /// Of a level, percent.
    pub percent: u8,
    /// How often the brake was put on.
    pub stops: u32,
}

impl ToolWanted {
    /// What becomes of a level that is asked for.
    fn level(&self, level: Level) -> Level {
        if self.outputs.spindle == Spindle::Off { Level::ZERO } else { level.times(self.percent) }
    }
}

/// What the port was told last.
struct Driven {
    switches: Switches,
    pwm_hz: u32,
    duty: u16,
    /// How often the brake had been put on.
    stops: u32,
    /// The level that was asked for.
    asked: Level,
    /// Until when that is for, of a laser.
    lit_until: Instant,
    /// The stretch under way, or the next.
    stretch: Option<Stretch>,
}

impl Driven {
    /// All off.
    const NEW: Self = Self {
        switches: Switches { enable: false, counter_clockwise: false, flood: false, mist: false },
        pwm_hz: 0,
        duty: 0,
        stops: 0,
        asked: Level::ZERO,
        lit_until: Instant::MIN,
        stretch: None,
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

    /// The stretch under way, or the next; dark where none is.
    async fn next_stretch(&mut self, wanted: &ToolWanted, machine: &Machine, port: &mut impl ToolPort) -> Stretch {
        loop {
            let is_lit = self.asked != Level::ZERO;
            let goes_out = Timer::at(self.lit_until.saturating_sub(port.lead()));
            match self.stretch {
                Some(stretch) if !is_lit || stretch.begin <= self.lit_until => return stretch,
                Some(_) => {
                    goes_out.await;
                    self.set(Level::ZERO, wanted, machine, port);
                }
                None if !is_lit => self.stretch = Some(machine.stretches().receive().await),
                None => match select(machine.stretches().receive(), goes_out).await {
                    Either::First(stretch) => self.stretch = Some(stretch),
                    Either::Second(()) => self.set(Level::ZERO, wanted, machine, port),
                },
            }
        }
    }

    fn set(&mut self, asked: Level, wanted: &ToolWanted, machine: &Machine, port: &mut impl ToolPort) {
        self.give(Prepared::of(asked, wanted), true, machine, port);
    }

    fn give(&mut self, prepared: Prepared, anew: bool, machine: &Machine, port: &mut impl ToolPort) {
        let Prepared { asked, level, duty } = prepared;
        self.asked = asked;
        if self.duty != duty {
            self.duty = duty;
            port.set_duty(duty, anew);
        }
        machine.note_level(level);
    }
}

/// A level that is asked for, what becomes of it, and its duty.
struct Prepared {
    asked: Level,
    level: Level,
    duty: u16,
}

impl Prepared {
    fn of(asked: Level, wanted: &ToolWanted) -> Self {
        let level = wanted.level(asked);
        let duties = wanted.config.duties;
        Self { asked, level: duties.made(level), duty: duties.duty(level) }
    }
}

/// Makes the stretches of a laser. What it needs for a level is reckoned before its instant.
///
/// # Cancellation
/// Safe: the stretch under way is kept, and goes on with the next call.
async fn shine(wanted: &ToolWanted, machine: &Machine, state: &mut Driven, port: &mut impl ToolPort) {
    let lead = port.lead();
    let lasting = Duration::from_hz(u64::from(wanted.config.pwm_hz)) * PERIODS_MIN;
    loop {
        let stretch = state.next_stretch(wanted, machine, port).await;
        let mut from = Instant::now().max(stretch.begin);
        let mut anew = from == stretch.begin && stretch.end >= stretch.begin + lasting;
        while from < stretch.end {
            // A level that changes is set to what it is in the midst of the time that it is set for.
            let until = if stretch.from == stretch.to { stretch.end } else { stretch.end.min(from + UPDATE) };
            let asked = stretch.level_at(from + (until - from) / 2);
            let prepared = Prepared::of(asked, wanted);
            Timer::at(from.saturating_sub(lead)).await;
            state.give(prepared, anew, machine, port);
            (state.lit_until, from, anew) = (until, until, false);
        }
        state.stretch = None;
    }
}

impl Stretch {
    fn level_at(&self, at: Instant) -> Level {
        let (passed, lasts) = ((at - self.begin).as_micros(), (self.end - self.begin).as_micros());
        self.from.towards(self.to, passed as u32, lasts as u32)
    }
}
