//! What stays in force from one block to the next.

/// The mode that bare axis words move by; its value is the G-code's number, and for G38.2 to G38.5 Grbl's own, 140 to
/// 143.
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
    /// G38.2: probe until the contact closes, which it must.
    ProbeToward = 140,
    /// G38.3: the same, if it closes at all.
    ProbeTowardIfAny = 141,
    /// G38.4: probe until the contact opens, which it must.
    ProbeAway = 142,
    /// G38.5: the same, if it opens at all.
    ProbeAwayIfAny = 143,
}

impl MotionMode {
    pub(crate) const fn is_arc(self) -> bool {
        matches!(self, Self::ClockwiseArc | Self::CounterClockwiseArc)
    }

    /// Whether its moves are made at the feed.
    pub(crate) const fn feeds(self) -> bool {
        !matches!(self, Self::Rapid | Self::Cancelled)
    }

    /// G38.2 to G38.5.
    pub(crate) const fn probes(self) -> bool {
        self as u8 >= Self::ProbeToward as u8
    }

    /// G38.4, G38.5: until the contact opens rather than closes.
    pub(crate) const fn probes_away(self) -> bool {
        matches!(self, Self::ProbeAway | Self::ProbeAwayIfAny)
    }

    /// G38.2, G38.4: no contact is an alarm.
    pub(crate) const fn must_touch(self) -> bool {
        matches!(self, Self::ProbeToward | Self::ProbeAway)
    }

    /// The number after G, as `$G` prints it: the whole part, then the decimal if there is one.
    pub(crate) const fn number(self) -> (u8, &'static str) {
        match self {
            Self::ProbeToward => (38, ".2"),
            Self::ProbeTowardIfAny => (38, ".3"),
            Self::ProbeAway => (38, ".4"),
            Self::ProbeAwayIfAny => (38, ".5"),
            _ => (self as u8, ""),
        }
    }
}

/// How the program has the spindle, or the laser; its value is the M-code's number.
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

/// Which coolant the program has on.
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
    /// What is on, of the two.
    pub const fn of(flood: bool, mist: bool) -> Self {
        match (flood, mist) {
            (false, false) => Self::Off,
            (false, true) => Self::Mist,
            (true, false) => Self::Flood,
            (true, true) => Self::Both,
        }
    }

    /// M8: flood is on.
    pub const fn flood(self) -> bool {
        matches!(self, Self::Flood | Self::Both)
    }

    /// M7: mist is on.
    pub const fn mist(self) -> bool {
        matches!(self, Self::Mist | Self::Both)
    }

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
        Self::of(self.flood() || other.flood(), self.mist() || other.mist())
    }
}

/// The modal state, by default as after power-up or reset. G40 and G91.1 are always in force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Modal {
    /// G0 to G3, G38.2 to G38.5 or G80.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coolant_is_flood_and_mist_each_on_or_off() {
        for (flood, mist, word) in
            [(false, false, "M9"), (false, true, "M7"), (true, false, "M8"), (true, true, "M7 M8")]
        {
            let coolant = Coolant::of(flood, mist);
            assert_eq!((coolant.flood(), coolant.mist(), coolant.word()), (flood, mist, word));
            assert_eq!(coolant.and(Coolant::Off), coolant);
            assert_eq!(coolant.and(Coolant::Both), Coolant::Both);
        }
        assert_eq!(Coolant::Mist.and(Coolant::Flood), Coolant::Both);
        assert_eq!(Coolant::Mist.and(Coolant::Mist), Coolant::Mist);
    }
}
