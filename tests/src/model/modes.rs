//! The modes that a program leaves in force.

use super::words::{INCH_ANGSTROM, ONE};

/// The modes of docs/console.md, as `$G` lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Modes {
    /// The motion mode, tenths of its number: 0, 10, 20, 30, 382 to 385, 730 to 890.
    pub motion: i64,
    /// 0 for G54, 6 for G59.1.
    pub system: usize,
    /// 17, 18 or 19.
    pub plane: i64,
    /// G20.
    pub inches: bool,
    /// G91.
    pub incremental: bool,
    /// G93.
    pub inverse_time: bool,
    /// G61.1.
    pub exact_stop: bool,
    /// G99.
    pub leaves_at_r: bool,
    /// G64, alone or with a P above 0: the setting that is for G64 alone is above 0 here.
    pub blends: bool,
    /// 3, 4 or 5.
    pub spindle: i64,
    /// M8.
    pub flood: bool,
    /// M7.
    pub mist: bool,
    /// T.
    pub tool: i64,
    /// F, ten-millionths of mm/min, or of 1/min under G93.
    pub feed: i64,
    /// S, ten-millionths.
    pub speed: i64,
}

impl Modes {
    /// As after power-up and after a reset.
    pub const START: Self = Self {
        motion: 0,
        system: 0,
        plane: 17,
        inches: false,
        incremental: false,
        inverse_time: false,
        exact_stop: false,
        leaves_at_r: false,
        blends: true,
        spindle: 5,
        flood: false,
        mist: false,
        tool: 0,
        feed: 0,
        speed: 0,
    };

    /// A word's value as a length, angstroms.
    #[must_use]
    pub fn length(&self, value: i64) -> i64 {
        if self.inches { value * (INCH_ANGSTROM / 100) / (ONE / 100) } else { value }
    }

    /// The modes that M2 and M30 restore: G1 G17 G54 G64 G90 G94 M5 M9.
    pub fn end_program(&mut self) {
        *self = Self {
            motion: 10,
            inches: self.inches,
            tool: self.tool,
            feed: self.feed,
            speed: self.speed,
            ..Self::START
        };
    }

    /// M5 M9.
    pub fn stop_tool(&mut self) {
        (self.spindle, self.flood, self.mist) = (5, false, false);
    }

    /// The code of the work system in force.
    #[must_use]
    pub fn system_name(&self) -> String {
        match self.system {
            system @ 0..=5 => format!("G{}", 54 + system),
            system => format!("G59.{}", system - 5),
        }
    }

    /// The codes that `$G` lists, without F and S, whose last digits are rounded.
    #[must_use]
    pub fn listed(&self) -> String {
        let (whole, part) = (self.motion / 10, self.motion % 10);
        let motion = if part == 0 { format!("G{whole}") } else { format!("G{whole}.{part}") };
        let units = 21 - i64::from(self.inches);
        let distance = 90 + i64::from(self.incremental);
        let feed_mode = 94 - i64::from(self.inverse_time);
        let path = match (self.exact_stop, self.blends) {
            (true, _) => " G61.1",
            (false, true) => " G64",
            (false, false) => " G61",
        };
        let system = self.system_name();
        let retract = if self.leaves_at_r { " G99" } else { "" };
        let coolant = match (self.mist, self.flood) {
            (false, false) => "M9",
            (true, false) => "M7",
            (false, true) => "M8",
            (true, true) => "M7 M8",
        };
        format!(
            "{motion} {system} G{} G{units} G{distance} G{feed_mode}{path}{retract} M{} {coolant} T{}",
            self.plane, self.spindle, self.tool
        )
    }
}
