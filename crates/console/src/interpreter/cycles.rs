//! Interprets the words of canned cycles, G73, G81 to G83, G85, G86 and G89.

use core::fmt;

use super::{Interpreter, coordinates::given_pm, within};
use crate::{
    AXES, Coordinate, Cycle, Error, Fixed, MotionMode, Settings, length,
    words::block::{AxisCommand, BlockWords},
};

/// The most holes of a line, L.
const HOLES_MAX: f32 = 9_999.0;
/// The most pecks of a line.
const PECKS_MAX: i64 = 99_999;

/// What stays in force from a line of a canned cycle to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct CycleSeries {
    /// The code of the line before; one that is no cycle at first.
    mode: MotionMode,
    plane: u8,
    /// R, Z and Q as they were given, and P, s.
    near_pm: i64,
    depth_pm: i64,
    peck_pm: i64,
    dwell_s: f32,
    /// The height at which the series began.
    initial_pm: i64,
}

/// The series under way, and the motion mode before it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Cycles {
    /// The motion mode before canned cycles and G80.
    mode_before: MotionMode,
    series: CycleSeries,
    /// The last line that was accepted.
    cycle: Cycle,
}

impl Interpreter {
    /// The holes of a line that was accepted with [`Block::drills`](crate::Block).
    pub fn cycle(&self) -> &Cycle {
        &self.cycles.cycle
    }

    /// A line of a canned cycle or of G80. Axis words behind G80 go on with the straight motion mode before it and before the
    /// cycles, as programs for Fanuc controls expect. Returns what was before, for [`take_back_cycles`](Self::take_back_cycles).
    #[cold]
    #[inline(never)]
    pub(super) fn begin_or_end_cycles(&mut self, words: &mut BlockWords) -> (MotionMode, CycleSeries) {
        let before = self.modal.motion;
        let undo = (self.cycles.mode_before, self.cycles.series);
        if !before.is_cycle() {
            self.cycles.series = CycleSeries::default();
        }
        if !before.is_of_cycles() {
            self.cycles.mode_before = before;
        }
        let moves = words.axis_command == Some(AxisCommand::Motion) && words.non_modal.is_none();
        if words.modal.motion == MotionMode::Cancelled && moves && self.cycles.mode_before.is_straight() {
            words.modal.motion = self.cycles.mode_before;
        }
        undo
    }

    /// Undoes what a refused line of cycles has changed.
    #[cold]
    #[inline(never)]
    pub(super) fn take_back_cycles(&mut self, before: (MotionMode, CycleSeries)) {
        (self.cycles.mode_before, self.cycles.series) = before;
    }

    /// The cycle of a block whose motion mode is one, if its axis words are for that mode. Returns whether there is one.
    #[cold]
    #[inline(never)]
    pub(super) fn drill(&mut self, words: &mut BlockWords, settings: &Settings) -> Result<bool, Error> {
        if words.axis_command != Some(AxisCommand::Motion) {
            return Ok(false);
        }
        let cycle = self.planned(words, settings).map_err(|fault| fault.error())?;
        words.check_all_used()?;
        self.cycles.cycle = cycle;
        Ok(true)
    }

    /// Why `line` makes no cycle: for a line of G-code that was refused with [`Error::BadCycle`].
    pub(super) fn cycle_fault(&self, line: &str, settings: &Settings) -> Option<CycleFault> {
        let (mut at_line, mut words) = (*self, BlockWords::new(self.modal, settings.rotary()));
        words.read(&mut line.as_bytes()).ok()?;
        at_line.begin_or_end_cycles(&mut words);
        at_line.modes(&mut words).ok()?;
        if let Some(length) = words.tool_length {
            at_line.tool_length(length, &mut words).ok()?;
        }
        at_line.planned(&mut words, settings).err().filter(|fault| !matches!(fault, CycleFault::Other(_)))
    }

    fn planned(&mut self, words: &mut BlockWords, settings: &Settings) -> Result<Cycle, CycleFault> {
        self.check_feed()?;
        if self.modal.inverse_time {
            return Err(CycleFault::InverseTime);
        }
        if !words.has_axes() {
            return Err(Error::AxisWordsMissing.into());
        }
        let mode = self.modal.motion;
        let mut cycle = Cycle { mode, plane: self.modal.plane, from_pm: self.position_pm, ..Cycle::default() };
        let axis = cycle.axis();
        self.take_values(words, axis)?;
        let CycleSeries { initial_pm, near_pm, depth_pm, peck_pm, dwell_s, .. } = self.cycles.series;
        (cycle.near_pm, cycle.bottom_pm) = self.heights_pm(axis)?;
        let way_pm = cycle.near_pm - cycle.bottom_pm;
        if way_pm < 0 {
            return Err(CycleFault::BelowZ { near_pm, depth_pm });
        }
        cycle.clear_pm = if self.modal.retracts_to_r { cycle.near_pm } else { cycle.near_pm.max(initial_pm) };
        cycle.peck_pm = way_pm;
        self.place_holes(&mut cycle, words)?;
        if mode.pecks() {
            if peck_pm <= 0 || way_pm / peck_pm > PECKS_MAX / i64::from(cycle.holes) {
                return Err(CycleFault::Pecks { peck_pm });
            }
            cycle.peck_pm = peck_pm;
        }
        cycle.clearance_pm = length::from_mm(settings.peck_clearance_mm.into());
        cycle.dwell_s = if mode.dwells() { dwell_s } else { 0.0 };
        cycle.mm_min = self.modal.feed.max(super::MIN_FEED_MM_MIN);
        Ok(cycle)
    }

    /// Takes R, Z, Q and P, which a series that begins needs and the lines behind may leave out.
    fn take_values(&mut self, words: &mut BlockWords, axis: usize) -> Result<(), Error> {
        let mode = self.modal.motion;
        let goes_on = self.cycles.series.mode.is_cycle() && self.cycles.series.plane == self.modal.plane;
        let begins = !goes_on || self.cycles.series.mode != mode;
        if !goes_on {
            self.cycles.series.initial_pm = self.position_pm[axis];
        }
        (self.cycles.series.mode, self.cycles.series.plane) = (mode, self.modal.plane);
        let or_kept = |given: Option<i64>, kept_pm: i64| match given {
            None if begins => Err(Error::ValueMissing),
            given => Ok(given.unwrap_or(kept_pm)),
        };
        self.cycles.series.near_pm = or_kept(words.take_length_pm(b'R'), self.cycles.series.near_pm)?;
        self.cycles.series.depth_pm = or_kept(words.axes_pm()[axis], self.cycles.series.depth_pm)?;
        if mode.pecks() {
            self.cycles.series.peck_pm = or_kept(words.take_length_pm(b'Q'), self.cycles.series.peck_pm)?;
        }
        if mode.dwells() {
            self.cycles.series.dwell_s = match words.take(b'P') {
                // The spindle of G86 may stop without a dwell.
                None if begins && mode == MotionMode::BoreStop => 0.0,
                None if begins => return Err(Error::ValueMissing),
                given => given.unwrap_or(self.cycles.series.dwell_s),
            };
        }
        Ok(())
    }

    /// The heights of R and of the bottom: in G91 R counts from where the series began, and Z from R.
    fn heights_pm(&self, axis: usize) -> Result<(i64, i64), Error> {
        let CycleSeries { initial_pm, near_pm, depth_pm, .. } = self.cycles.series;
        let zero_pm = self.work_offset_pm()[axis];
        let (near_pm, bottom_pm) = if self.modal.incremental {
            (initial_pm + near_pm, initial_pm + near_pm + depth_pm)
        } else {
            (zero_pm + near_pm, zero_pm + depth_pm)
        };
        Ok((within(near_pm)?, within(bottom_pm)?))
    }

    /// L holes, each as far from the one before as the axis words say in G91; in G90 all in one place.
    fn place_holes(&self, cycle: &mut Cycle, words: &mut BlockWords) -> Result<(), CycleFault> {
        let holes = words.take(b'L').unwrap_or(1.0);
        if !(1.0..=HOLES_MAX).contains(&holes) {
            return Err(CycleFault::Holes { holes });
        }
        cycle.holes = holes as u32;
        // Z as a distance is not one from here.
        let axis = cycle.axis();
        let mut hole_pm = cycle.from_pm;
        let zero_pm = self.work_offset_pm();
        for (index, pm) in given_pm(words).filter(|(index, _)| *index != axis) {
            if self.modal.incremental {
                cycle.step_pm[index] = pm;
            }
            hole_pm[index] = if self.modal.incremental { hole_pm[index] + pm } else { zero_pm[index] + pm };
        }
        hole_pm[axis] = cycle.near_pm;
        cycle.hole_pm = hole_pm;
        // The first hole before the last: from one that is near no number of holes leads beyond what can be counted.
        let are_within = |place_pm: [i64; AXES]| place_pm.into_iter().try_for_each(|pm| within(pm).map(|_| ()));
        are_within(cycle.hole_pm)?;
        are_within(cycle.end_pm())?;
        Ok(())
    }
}

/// Why a line makes no cycle. Displays as the text of a `[MSG:...]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CycleFault {
    /// R is below Z: the tool would go down as a rapid, below the bottom.
    BelowZ {
        /// R, in [picometres](crate::length).
        near_pm: i64,
        /// Z.
        depth_pm: i64,
    },
    /// Q is not above 0, or so small that the line's holes take more than 99,999 pecks.
    Pecks {
        /// Q.
        peck_pm: i64,
    },
    /// L is 0, or above 9,999.
    Holes {
        /// L.
        holes: f32,
    },
    /// G93: a feed by time cannot be that of several moves.
    InverseTime,
    /// The error says all.
    Other(Error),
}

impl CycleFault {
    fn error(self) -> Error {
        match self {
            Self::Other(error) => error,
            _ => Error::BadCycle,
        }
    }
}

impl From<Error> for CycleFault {
    fn from(error: Error) -> Self {
        Self::Other(error)
    }
}

impl fmt::Display for CycleFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = |pm: i64| Coordinate { pm, inches: false };
        match *self {
            Self::BelowZ { near_pm, depth_pm } => {
                write!(f, "R: {} mm is below Z, {} mm: give an R above the hole", mm(near_pm), mm(depth_pm))
            }
            Self::Pecks { peck_pm } => {
                write!(f, "Q: {} mm, too small for the 99999 pecks that a line may have: give a greater Q", mm(peck_pm))
            }
            Self::Holes { holes: value } => {
                write!(f, "L: {}, and 1 to 9999 holes are possible: correct L", Fixed { value, decimals: 0 })
            }
            Self::InverseTime => f.write_str("G93: a cycle is several moves, and needs a feed: add G94 and F"),
            Self::Other(error) => error.fmt(f),
        }
    }
}
