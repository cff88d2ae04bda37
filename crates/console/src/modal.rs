//! The modes that stay in force from one block to the next.

/// The mode by which axis words without another code move. Its value is the G-code's number; G38.2 to G38.5 have Grbl's
/// numbers 140 to 143.
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
    /// G80: no motion mode; axis words go on with the G0 or G1 before it, and are refused if there was another.
    Cancelled = 80,
    /// G73: drill by pecks, and go up by a little after each.
    BreakChips = 73,
    /// G81: drill.
    Drill = 81,
    /// G82: drill, and dwell at the bottom.
    DrillDwell = 82,
    /// G83: drill by pecks, and go up to R after each.
    Peck = 83,
    /// G85: bore, and go up at the feed.
    Bore = 85,
    /// G86: bore, and go up with the spindle stopped.
    BoreStop = 86,
    /// G89: bore, dwell at the bottom, and go up at the feed.
    BoreDwell = 89,
    /// G38.2: probe until the contact closes; it must close.
    ProbeToward = 140,
    /// G38.3: probe until the contact closes; it need not close.
    ProbeTowardIfAny = 141,
    /// G38.4: probe until the contact opens; it must open.
    ProbeAway = 142,
    /// G38.5: probe until the contact opens; it need not open.
    ProbeAwayIfAny = 143,
}

impl MotionMode {
    pub(crate) const fn is_arc(self) -> bool {
        matches!(self, Self::ClockwiseArc | Self::CounterClockwiseArc)
    }

    /// G0, G1.
    pub(crate) const fn is_straight(self) -> bool {
        matches!(self, Self::Rapid | Self::Linear)
    }

    /// True if it is a canned cycle: G73, G81 to G83, G85, G86, G89.
    pub const fn is_cycle(self) -> bool {
        self.is_of_cycles() && !matches!(self, Self::Cancelled)
    }

    /// True for canned cycles and for G80, which ends them.
    pub(crate) const fn is_of_cycles(self) -> bool {
        matches!(self as u8, 73..=89)
    }

    /// G73, G83.
    pub(crate) const fn pecks(self) -> bool {
        matches!(self, Self::BreakChips | Self::Peck)
    }

    /// G82, G86, G89.
    pub(crate) const fn dwells(self) -> bool {
        matches!(self, Self::DrillDwell | Self::BoreStop | Self::BoreDwell)
    }

    /// True if its moves are made at the feed.
    pub(crate) const fn feeds(self) -> bool {
        !matches!(self, Self::Rapid | Self::Cancelled)
    }

    /// True if it is one of G38.2 to G38.5.
    pub(crate) const fn probes(self) -> bool {
        self as u8 >= Self::ProbeToward as u8
    }

    /// G38.4, G38.5: whether the contact must open instead of close.
    pub(crate) const fn probes_away(self) -> bool {
        matches!(self, Self::ProbeAway | Self::ProbeAwayIfAny)
    }

    /// G38.2, G38.4: whether it is an alarm if the contact does not change.
    pub(crate) const fn must_touch(self) -> bool {
        matches!(self, Self::ProbeToward | Self::ProbeAway)
    }

    /// The number after G, as `$G` prints it: the integer part, then the decimals, if any.
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

/// The way in which moves follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum PathControl {
    /// G64: by blends that leave the corners by the setting's deviation.
    #[default]
    Blend,
    /// G64 P Q.
    BlendWithin {
        /// P: the distance by which the path may leave a corner, mm; 0 is G61.
        deviation_mm: f32,
        /// Q: how much of it short moves may use that are made as one, mm; `None` for half of P.
        together_mm: Option<f32>,
    },
    /// G61: along the path exactly; at a corner axes change their speed at once.
    Exact,
    /// G61.1: every move ends in a stop.
    Stop,
}

impl PathControl {
    /// True if every move ends in a stop.
    pub const fn stops(self) -> bool {
        matches!(self, Self::Stop)
    }

    /// The distance by which the path may leave a corner, mm; 0 if it goes there exactly. `setting_mm` is that of the setting.
    pub const fn deviation_mm(self, setting_mm: f32) -> f32 {
        match self {
            Self::Blend => setting_mm,
            Self::BlendWithin { deviation_mm, .. } => deviation_mm,
            Self::Exact | Self::Stop => 0.0,
        }
    }

    /// The distance by which the path may be beside the ends of short moves that are made as one, mm: Q, but no more than half
    /// of the deviation, which is also what it is without Q; 0 if none are. `setting_mm` is the deviation of the setting.
    ///
    /// The blends at both ends of such a line have what is left of the deviation.
    pub fn together_mm(self, setting_mm: f32) -> f32 {
        let deviation_mm = self.deviation_mm(setting_mm);
        match self {
            Self::BlendWithin { together_mm: Some(together_mm), .. } => together_mm.min(0.5 * deviation_mm),
            _ => 0.5 * deviation_mm,
        }
    }

    /// The distance by which the path may leave the corners between an arc's chords, mm. With exact stops it stops at the end of
    /// the arc, not in it.
    pub const fn chords_deviation_mm(self, setting_mm: f32) -> f32 {
        if self.stops() { setting_mm } else { self.deviation_mm(setting_mm) }
    }

    /// The code, as `$G` prints it. Without blends G61 and G64 are the same, and Grbl, which knows G61 alone, never
    /// reports it.
    pub(crate) fn word(self, setting_mm: f32) -> &'static str {
        match self {
            Self::Stop => " G61.1",
            _ if self.deviation_mm(setting_mm) > 0.0 => " G64",
            _ if setting_mm > 0.0 => " G61",
            _ => "",
        }
    }
}

/// The state to which the program has switched the spindle or the laser. The value is the M-code's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum SpindleMode {
    /// M3.
    Clockwise = 3,
    /// M4.
    CounterClockwise = 4,
    /// M5.
    #[default]
    Off = 5,
}

/// What M6 does, by the numbers of `$341`. Wherever it waits, `~` ends that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolChange {
    /// 0: waits where it stands.
    Wait,
    /// 1: goes up and waits; the tool is measured where a person has jogged it, by `$TPW`.
    Manual,
    /// 2: goes to G59.3 and waits; the tool is measured there, by `$TPW`.
    ManualAtSetter,
    /// 3: goes up and waits, and then measures the tool at G59.3.
    AutomaticAtSetter,
    /// 4: does not wait.
    Ignore,
}

impl ToolChange {
    pub(crate) const fn of(number: u16) -> Self {
        match number {
            1 => Self::Manual,
            2 => Self::ManualAtSetter,
            3 => Self::AutomaticAtSetter,
            4 => Self::Ignore,
            _ => Self::Wait,
        }
    }

    /// True if it moves to a place where the tool can be changed, and measures it.
    pub const fn measures(self) -> bool {
        matches!(self, Self::Manual | Self::ManualAtSetter | Self::AutomaticAtSetter)
    }
}

/// The coolant that the program has switched on.
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
    /// The coolant state with flood and mist each on or off.
    pub const fn of(flood: bool, mist: bool) -> Self {
        match (flood, mist) {
            (false, false) => Self::Off,
            (false, true) => Self::Mist,
            (true, false) => Self::Flood,
            (true, true) => Self::Both,
        }
    }

    /// M8: whether flood is on.
    pub const fn flood(self) -> bool {
        matches!(self, Self::Flood | Self::Both)
    }

    /// M7: whether mist is on.
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

    /// Combines both: M7 and M8 add to each other.
    pub(crate) const fn and(self, other: Self) -> Self {
        Self::of(self.flood() || other.flood(), self.mist() || other.mist())
    }
}

/// The modal state. Its default is that after power-up or reset. G40 and G91.1 are always in force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Modal {
    /// G0 to G3, G38.2 to G38.5, G73 to G89.
    pub motion: MotionMode,
    /// The work coordinate system: 0 for G54 to 5 for G59, 6 for G59.1 to 8 for G59.3.
    pub system: u8,
    /// The plane of arcs: 0 for G17, 1 for G18, 2 for G19.
    pub plane: u8,
    /// G20 if true, G21 if false.
    pub inches: bool,
    /// G91 if true, G90 if false.
    pub incremental: bool,
    /// G93 if true, G94 if false. With G93, F is the reciprocal of the duration of the move in minutes, and holds for
    /// its block only.
    pub inverse_time: bool,
    /// G99 if true, G98 if false: canned cycles leave a hole at R, not where their series began.
    pub retracts_to_r: bool,
    /// G61, G61.1 or G64.
    pub path: PathControl,
    /// F, in mm/min, or with G93 in 1/min; 0 until one is given.
    pub feed: f32,
    /// M3, M4 or M5.
    pub spindle: SpindleMode,
    /// S.
    pub speed_rpm: f32,
    /// M7, M8 or M9.
    pub coolant: Coolant,
    /// T: M6 asks the operator to put it in.
    pub tool: u32,
}

impl Modal {
    /// Resets what M2 and M30 reset; units, feed, speed and tool stay.
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
