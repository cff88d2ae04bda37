//! What stays in force from one block to the next.

/// The mode that bare axis words move by; its value is the G-code's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum MotionMode {
    /// G0.
    #[default]
    Rapid = 0,
    /// G1.
    Linear = 1,
    /// G2.
    ClockwiseArc = 2,
    /// G3.
    CounterClockwiseArc = 3,
    /// G80: none; axis words are refused.
    Cancelled = 80,
}

impl MotionMode {
    pub(crate) const fn is_arc(self) -> bool {
        matches!(self, Self::ClockwiseArc | Self::CounterClockwiseArc)
    }

    /// Whether its moves are made at the feed.
    pub(crate) const fn feeds(self) -> bool {
        matches!(self, Self::Linear) || self.is_arc()
    }
}

/// What the program believes of a spindle; its value is the M-code's number. The gantry has none: the words are kept
/// for `$G` alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Spindle {
    /// M3.
    Clockwise = 3,
    /// M4.
    CounterClockwise = 4,
    /// M5.
    #[default]
    Off = 5,
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

    /// M7 and M8 add to each other.
    pub(crate) const fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Off, other) => other,
            (Self::Mist, Self::Mist) => Self::Mist,
            (Self::Flood, Self::Flood) => Self::Flood,
            _ => Self::Both,
        }
    }
}

/// The modal state, by default as after power-up or reset. G40 and G91.1 are always in force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Modal {
    /// G0 to G3 or G80.
    pub motion: MotionMode,
    /// The work coordinate system: 0 for G54 to 5 for G59.
    pub system: u8,
    /// The plane of arcs: 0 for G17, 1 for G18, 2 for G19.
    pub plane: u8,
    /// G20 rather than G21.
    pub inches: bool,
    /// G91 rather than G90.
    pub incremental: bool,
    /// G93 rather than G94: F is how many of the move fit into a minute, and holds for its block alone.
    pub inverse_time: bool,
    /// G61.1 rather than G61 or G64: every move ends in a stop.
    pub exact_stop: bool,
    /// F, mm/min, or 1/min with G93; 0 until one was given.
    pub feed: f32,
    /// M3, M4 or M5.
    pub spindle: Spindle,
    /// S.
    pub speed_rpm: f32,
    /// M7, M8 or M9.
    pub coolant: Coolant,
    /// T: M6 tells the person to put it in.
    pub tool: u8,
}

impl Modal {
    /// What M2 and M30 put back; units, feed, speed and tool stay.
    pub(crate) fn end_program(&mut self) {
        let Self { inches, feed, speed_rpm, tool, .. } = *self;
        *self = Self { motion: MotionMode::Linear, inches, feed, speed_rpm, tool, ..Self::default() };
    }
}
