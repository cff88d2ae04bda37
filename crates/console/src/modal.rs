//! What stays in force from one block to the next.

/// The mode that bare axis words move by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MotionMode {
    /// G0.
    #[default]
    Rapid,
    /// G1.
    Linear,
    /// G80: none; axis words are refused.
    Cancelled,
}

impl MotionMode {
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Rapid => "G0",
            Self::Linear => "G1",
            Self::Cancelled => "G80",
        }
    }
}

/// What the program believes of a spindle. The gantry has none: the words are kept for `$G` alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spindle {
    /// M3.
    Clockwise,
    /// M4.
    CounterClockwise,
    /// M5.
    #[default]
    Off,
}

impl Spindle {
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Clockwise => "M3",
            Self::CounterClockwise => "M4",
            Self::Off => "M5",
        }
    }
}

/// What the program believes of coolant. The gantry has none: the words are kept for `$G` alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coolant {
    /// M9.
    #[default]
    Off,
    /// M7.
    Mist,
    /// M8.
    Flood,
    /// M7 and M8.
    Both,
}

impl Coolant {
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Off => "M9",
            Self::Mist => "M7",
            Self::Flood => "M8",
            Self::Both => "M7 M8",
        }
    }

    /// M7 and M8 add to each other; M9 ends both.
    pub(crate) const fn then(self, next: Self) -> Self {
        match (self, next) {
            (_, Self::Off) => Self::Off,
            (Self::Off, next) => next,
            (Self::Mist, Self::Mist) => Self::Mist,
            (Self::Flood, Self::Flood) => Self::Flood,
            _ => Self::Both,
        }
    }
}

/// The modal state, by default as after power-up or reset. G17, G40, G49, G54, G61, G91.1 and G94 are always in force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Modal {
    /// G0, G1 or G80.
    pub motion: MotionMode,
    /// G20 rather than G21.
    pub inches: bool,
    /// G91 rather than G90.
    pub incremental: bool,
    /// F; 0 until one was given.
    pub feed_mm_min: f32,
    /// M3, M4 or M5.
    pub spindle: Spindle,
    /// S.
    pub speed_rpm: f32,
    /// M7, M8 or M9.
    pub coolant: Coolant,
    /// T.
    pub tool: u8,
}

impl Modal {
    /// What M2 and M30 put back; units, feed, speed and tool stay.
    pub(crate) fn end_program(&mut self) {
        self.motion = MotionMode::Linear;
        self.incremental = false;
        self.spindle = Spindle::Off;
        self.coolant = Coolant::Off;
    }
}
