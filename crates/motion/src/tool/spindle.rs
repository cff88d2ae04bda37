//! A spindle or a laser, and coolant: what it is, and what its outputs are to be.

use embassy_time::Duration;

use super::duty::Duties;
use super::power::{Asked, Level};

/// The tool of a machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolConfig {
    /// A laser: dark at rest and in rapid moves.
    pub laser: bool,
    /// The duty that makes each level.
    pub duties: Duties,
    /// PWM frequency, Hz; above 0.
    pub pwm_hz: u32,
    /// The time that a spindle takes to reach its speed. Nothing moves during that time.
    pub spin_up: Duration,
    /// Instead of that time nothing moves until it is [reported](crate::Machine::spindle_at_speed) that the spindle has its speed.
    pub reports_speed: bool,
}

/// A spindle that has its speed at once, by the whole range of a PWM of 1 kHz. It serves a machine without a tool too.
impl Default for ToolConfig {
    fn default() -> Self {
        Self {
            laser: false,
            duties: Duties::new(Level::ZERO, 0, u16::MAX),
            pwm_hz: 1_000,
            spin_up: Duration::from_ticks(0),
            reports_speed: false,
        }
    }
}

/// The state of a spindle: whether it turns, and in which direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spindle {
    /// It stands still.
    #[default]
    Off,
    /// M3. The level of a laser is as asked for.
    Clockwise,
    /// M4. The level of a laser follows the speed along the path.
    CounterClockwise,
}

/// The outputs as they are to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// Enable and direction.
    pub spindle: Spindle,
    /// The spindle's speed; at zero it stands, with enable off. The level of a laser belongs to each move
    /// ([`Power`](crate::Power)).
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

/// How a spindle is to turn that is not turned by the outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SpindleWanted {
    /// Whether, and in which direction.
    pub spindle: Spindle,
    /// Its speed, with the override applied; zero only if it is to stand.
    pub level: Level,
    /// The number of times that it was to turn otherwise, or to stand, without those of overrides.
    pub turns: u32,
}

/// The outputs that the machine's state asks for.
#[derive(Clone, Copy)]
pub(crate) struct ToolWanted {
    pub config: ToolConfig,
    pub outputs: Outputs,
    /// The override of a level, percent.
    pub percent: u8,
    /// The number of times that the inhibit was engaged.
    pub stops: u32,
    /// See [`SpindleWanted::turns`].
    pub turns: u32,
}

impl ToolWanted {
    /// The level that is made of what is asked for.
    pub fn level(&self, asked: Asked) -> Level {
        if self.outputs.spindle == Spindle::Off { Level::ZERO } else { asked.made(self.percent) }
    }
}
