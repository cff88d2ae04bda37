//! Turns lines into commands. Keeps the modal state and the position at which the program expects the machine.

mod arcs;
mod coordinates;
mod cycles;
mod probes;
mod tools;

pub use cycles::CycleFault;

use crate::{
    AXES, Arc, Block, BlockMove, Command, Coolant, Coordinates, Error, Explanation, Modal, MotionMode, PathControl,
    Rate, Refusal, ReportedState, Settings, SpindleMode, ToolChange, ToolEntry, ToolTable,
    axes::Z,
    command::Jog,
    length,
    refusal::Unused,
    rotary,
    words::block::{AxisCommand, BlockWords, NonModal},
};

/// Targets must be within this distance of zero on every axis.
pub const MAX_COORDINATE_PM: i64 = 10_000_000_000_000;
/// The slowest feed. As in Grbl a feed above 0 that is slower counts as this.
pub const MIN_FEED_MM_MIN: f32 = 1.0;

const INCH_MM: f32 = 25.4;

/// Interprets one line at a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Interpreter {
    coordinates: Coordinates,
    modal: Modal,
    cycles: cycles::Cycles,
    position_pm: [i64; AXES],
    /// Offset of G92.
    shift_pm: [i64; AXES],
    /// Offset of G43 to G43.2, along Z.
    tool_length_pm: i64,
    tools: ToolTable,
    /// The number of the tool in the spindle, the one of the last M6; 0 for none.
    tool_in_spindle: u32,
    /// Position at which the last probe ended.
    touched_pm: [i64; AXES],
    /// True if the probe's contact changed there.
    touched: bool,
}

impl Interpreter {
    /// The modal state of power-up, at machine position zero.
    pub fn new() -> Self {
        Self::default()
    }

    /// The modal state after the last accepted line.
    pub fn modal(&self) -> &Modal {
        &self.modal
    }

    /// Work offsets and stored positions.
    pub fn coordinates(&self) -> &Coordinates {
        &self.coordinates
    }

    /// Replaces the work offsets and stored positions.
    pub fn set_coordinates(&mut self, coordinates: Coordinates) {
        self.coordinates = coordinates;
    }

    /// The offset of G92.
    pub fn shift_pm(&self) -> [i64; AXES] {
        self.shift_pm
    }

    /// The offset of G43 to G43.2, along Z.
    pub fn tool_length_pm(&self) -> i64 {
        self.tool_length_pm
    }

    /// The table of tools.
    pub fn tools(&self) -> &ToolTable {
        &self.tools
    }

    /// Sets the tool in the spindle: 0 while it is being changed, or if nobody knows it.
    pub fn set_tool_in_spindle(&mut self, number: u32) {
        self.tool_in_spindle = number;
    }

    /// Puts a measured length in force, and into the table, as that of the tool of this number, 0 for one without a number.
    ///
    /// # Errors
    /// [`Error::InvalidTarget`] for a length over 10 m, [`Error::ToolNumber`] if the table is full: then it is in force, but not in the table.
    #[cold]
    pub fn set_measured_length_pm(&mut self, number: u32, length_pm: i64) -> Result<(), Error> {
        self.tool_length_pm = within(length_pm)?;
        if number == 0 { Ok(()) } else { self.tools.put(ToolEntry { length_pm, ..self.tools.tool(number) }) }
    }

    /// Replaces the table of tools. The offset in force stays.
    #[cold]
    pub fn set_tools(&mut self, tools: &ToolTable) {
        self.tools = *tools;
    }

    /// The number of the tool in the spindle, the one of the last M6; 0 for none.
    pub fn tool_in_spindle(&self) -> u32 {
        self.tool_in_spindle
    }

    /// Work zero in machine coordinates: the work coordinate system, G92 and the tool's length together.
    pub fn work_offset_pm(&self) -> [i64; AXES] {
        let system_pm = self.coordinates.work_offsets_pm[usize::from(self.modal.system)];
        let mut offset_pm = core::array::from_fn(|axis| system_pm[axis] + self.shift_pm[axis]);
        if let Some(z_pm) = offset_pm.get_mut(Z) {
            *z_pm += self.tool_length_pm;
        }
        offset_pm
    }

    /// End position of the last accepted move, in machine coordinates.
    pub fn position_pm(&self) -> [i64; AXES] {
        self.position_pm
    }

    /// Sets the position: after an accepted jog, after homing or a reset, or when a move was refused or cut short.
    pub fn set_position_pm(&mut self, position_pm: [i64; AXES]) {
        self.position_pm = position_pm;
    }

    /// The place where the last probe ended, in machine coordinates, and whether its contact changed there. At first zero and
    /// `false`.
    pub fn touched(&self) -> ([i64; AXES], bool) {
        (self.touched_pm, self.touched)
    }

    /// Sets where a probe has ended, in machine coordinates, and whether its contact changed there.
    pub fn set_touched(&mut self, place_pm: [i64; AXES], touched: bool) {
        (self.touched_pm, self.touched) = (place_pm, touched);
    }

    /// Switches spindle and coolant off in the modal state, as M5 and M9 do. For use after an alarm.
    pub fn stop_tool(&mut self) {
        (self.modal.spindle, self.modal.coolant) = (SpindleMode::Off, Coolant::Off);
    }

    /// Sets which coolant is on, after an override has switched it.
    pub fn set_coolant(&mut self, coolant: Coolant) {
        self.modal.coolant = coolant;
    }

    /// Resets the modal state to that of power-up and clears G92 and the tool's length in force. Keeps the position, the
    /// coordinates, the tools and the result of the last probe.
    pub fn reset(&mut self) {
        (self.modal, self.cycles) = (Modal::default(), cycles::Cycles::default());
        (self.shift_pm, self.tool_length_pm) = ([0; AXES], 0);
    }

    /// Interprets a line from [`LineAssembler`](crate::LineAssembler), if `state` allows it. On success, takes over its
    /// modal state, its coordinates and its end position. A [`Command::Jog`] changes nothing: the caller that begins
    /// the jog sets the position with [`set_position_pm`](Self::set_position_pm).
    ///
    /// # Errors
    /// Grbl's reason. Nothing has changed then.
    pub fn interpret<'l>(
        &mut self,
        line: &'l str,
        state: ReportedState,
        settings: &Settings,
    ) -> Result<Command<'l>, Error> {
        match line.strip_prefix('$') {
            Some(statement) => self.statement(statement, state, settings),
            None if Self::is_mark(line.as_bytes()) => Ok(Command::Block(Block::default())),
            #[cfg(feature = "trinamic")]
            None if line == "M122" => Ok(Command::ShowDrivers),
            None => {
                state.takes_gcode()?;
                let mut command = Command::Block(Block::default());
                if let Command::Block(block) = &mut command {
                    self.read(line, settings, block)?;
                }
                Ok(command)
            }
        }
    }

    /// True if a line says nothing to the machine: it is empty, marks an end of a program (`%`, whatever is written behind it), or names
    /// the program (`O1234`, `:1234`).
    pub(crate) fn is_mark(line: &[u8]) -> bool {
        match line {
            [] | [b'%', ..] => true,
            [b'O' | b':', number @ ..] => !number.is_empty() && number.iter().all(u8::is_ascii_digit),
            _ => false,
        }
    }

    /// Interprets a line of G-code in any state.
    ///
    /// # Errors
    /// As [`interpret`](Self::interpret).
    #[cold]
    pub fn gcode(&mut self, line: &str, settings: &Settings) -> Result<Block, Error> {
        let mut block = Block::default();
        self.read(line, settings, &mut block).map(|()| block)
    }

    /// Interprets a line of G-code as `block`, which is empty. Blocks are written in place: a returned one would be
    /// copied on every line.
    fn read(&mut self, line: &str, settings: &Settings, block: &mut Block) -> Result<(), Error> {
        let mut words = BlockWords::new(self.modal, settings.rotary());
        words.read(&mut line.as_bytes())?;
        // Only codes of group 0 change coordinates, and these are large.
        let coordinates = words.non_modal.is_some().then_some(self.coordinates);
        let before = (self.modal, self.position_pm, self.shift_pm, self.tool_length_pm, self.tool_in_spindle);
        let cycles = words.modal.motion.is_of_cycles().then(|| self.begin_or_end_cycles(&mut words));
        let result = self.block(&mut words, coordinates.as_ref(), settings, block);
        if result.is_err() {
            if let Some(cycles) = cycles {
                self.take_back_cycles(cycles);
            }
            self.coordinates = coordinates.unwrap_or(self.coordinates);
            (self.modal, self.position_pm, self.shift_pm, self.tool_length_pm, self.tool_in_spindle) = before;
        }
        result
    }

    /// The fault of `line` beside what its error says, if it was refused with that. It may be any line from a
    /// [`LineAssembler`](crate::LineAssembler).
    #[must_use]
    pub fn explain<'l>(&self, line: &'l str, error: Error, settings: &Settings) -> Option<Explanation<'l>> {
        if let Some(refusal) = Refusal::of(line, error) {
            return Some(Explanation::Word(refusal));
        }
        match error {
            Error::InvalidTarget | Error::RadiusTooSmall => self.misfit(line, settings).map(Explanation::Arc),
            Error::BadCycle => self.cycle_fault(line, settings).map(Explanation::Cycle),
            Error::UnusedWords => self.unused(line, settings).map(Explanation::Unused),
            _ => None,
        }
    }

    /// A word of `line` that no code uses: for a line of G-code that was refused with [`Error::UnusedWords`].
    fn unused(&self, line: &str, settings: &Settings) -> Option<Unused> {
        let mut words = BlockWords::new(self.modal, settings.rotary());
        words.read(&mut line.as_bytes()).ok()?;
        let (is_of_arc, has_radius) = (words.modal.motion.is_arc(), words.has_radius());
        let mut at_line = *self;
        at_line.begin_or_end_cycles(&mut words);
        let refused = at_line.block(&mut words, None, settings, &mut Block::default()).err()?;
        let letter = words.unused().filter(|_| refused == Error::UnusedWords)?;
        Some(Unused { letter, is_of_arc, has_radius })
    }

    /// Interprets what follows `$J=`.
    pub(crate) fn jog(&self, line: &str, settings: &Settings) -> Result<Jog, Error> {
        let modal = Modal { motion: MotionMode::Linear, ..self.modal };
        let mut words = BlockWords::new(modal, settings.rotary());
        words.read(&mut line.as_bytes())?;
        words.line_number()?;
        let mm_min = in_mm_min(words.take(b'F').ok_or(Error::NoFeed)?, &words.modal);
        if !words.has_axes() {
            return Err(Error::AxisWordsMissing);
        }
        let target_pm = self.target_pm(&words)?;
        if mm_min <= 0.0 {
            return Err(Error::NoFeed);
        }
        // Grbl checks an arc's words before it refuses to jog along an arc.
        self.arc(&mut words)?;
        words.check_all_used()?;
        let mm_min = words.rotary.along_path(mm_min, self.way_pm(target_pm), None, words.modal.inches);
        if words.may_jog() { Ok(Jog { target_pm, mm_min: mm_min.max(MIN_FEED_MM_MIN) }) } else { Err(Error::BadJog) }
    }

    /// Applies a block to this state, in Grbl's order of checking. On failure, the caller restores the state. `before`
    /// are the coordinates before the block, if it can change them.
    fn block(
        &mut self,
        words: &mut BlockWords,
        before: Option<&Coordinates>,
        settings: &Settings,
        block: &mut Block,
    ) -> Result<(), Error> {
        block.line_number = words.line_number()?;
        block.switches_spindle = words.modal.spindle != self.modal.spindle;
        block.switches_coolant = words.modal.coolant != self.modal.coolant;
        block.changes_speed = self.modes(words)?;
        // The P of G4 and of G10 is theirs.
        if words.blends && !matches!(words.non_modal, Some(NonModal::Dwell | NonModal::Set)) {
            self.blend(words)?;
        }
        if words.changes_tool {
            block.tool_change = self.change_tool(settings);
        }
        if words.non_modal == Some(NonModal::Dwell) {
            block.dwell_s = Some(words.take(b'P').ok_or(Error::ValueMissing)?);
        }
        if let Some(length) = words.tool_length {
            self.tool_length(length, words)?;
        }
        self.non_modal(words, block)?;
        block.changes_parameters |= before.is_some_and(|before| *before != self.coordinates);
        if self.modal.motion.probes() {
            self.probe(words, &mut block.probe)?;
        } else if self.modal.motion.is_cycle() {
            block.drills = self.drill(words, settings)?;
        } else {
            self.motion(words, &mut block.motion)?;
        }
        words.check_all_used()?;
        if let Some(BlockMove { target_pm, .. }) = &block.motion {
            self.position_pm = *target_pm;
        }
        if block.drills {
            self.position_pm = self.cycle().end_pm();
        }
        block.ends_program = words.ends_program;
        if words.ends_program {
            self.modal.end_program();
        }
        // If M6 has already held, M0 holds again only if something was done in between.
        let switches = block.switches_spindle || block.changes_speed || block.switches_coolant;
        let acts =
            switches || block.dwell_s.is_some() || block.motion.is_some() || block.probe.is_some() || block.drills;
        block.pauses = words.pauses && (block.tool_change.is_none() || acts);
        Ok(())
    }

    /// M6. Returns the tool to wait for.
    #[cold]
    #[inline(never)]
    fn change_tool(&mut self, settings: &Settings) -> Option<u32> {
        let before = core::mem::replace(&mut self.tool_in_spindle, self.modal.tool);
        // Without a number it may be any other.
        let is_other = before != self.modal.tool || before == 0;
        (is_other && settings.tool_change() != ToolChange::Ignore).then_some(self.modal.tool)
    }

    /// Takes over the modes of the block and the values that stay in force. Returns whether S changed.
    fn modes(&mut self, words: &mut BlockWords) -> Result<bool, Error> {
        let Modal { inverse_time: was_inverse, feed: before, .. } = self.modal;
        self.modal = words.modal;
        let given = words.take(b'F');
        self.modal.feed = match given {
            Some(feed) if self.modal.inverse_time => feed,
            Some(feed) => in_mm_min(feed, &self.modal),
            // An inverse-time feed holds for its own block only.
            None if self.modal.inverse_time || was_inverse => 0.0,
            None => before,
        };
        let speed_rpm = words.take(b'S');
        // Compared only if S is present: most lines have none.
        let changes_speed = speed_rpm.is_some_and(|speed_rpm| speed_rpm != self.modal.speed_rpm);
        self.modal.speed_rpm = speed_rpm.unwrap_or(self.modal.speed_rpm);
        self.modal.tool = words.take(b'T').map_or(self.modal.tool, |tool| tool as u32);
        let feeds = words.axis_command == Some(AxisCommand::Motion) && self.modal.motion.feeds();
        if feeds && self.modal.inverse_time && given.is_none() { Err(Error::NoFeed) } else { Ok(changes_speed) }
    }

    /// The P and Q of G64, if there are any: how far the path may leave the corners, and the ends of short moves.
    fn blend(&mut self, words: &mut BlockWords) -> Result<(), Error> {
        if let Some(deviation) = words.take(b'P') {
            let together_pm = words.take_length_pm(b'Q');
            if together_pm.is_some_and(|pm| pm < 0) {
                return Err(Error::Negative);
            }
            let together_mm = together_pm.map(|pm| length::to_mm(pm) as f32);
            self.modal.path = PathControl::BlendWithin { deviation_mm: in_mm_min(deviation, &self.modal), together_mm };
        }
        Ok(())
    }

    /// The move of a block whose motion mode is not a probe, if its axis words are for that mode.
    fn motion(&self, words: &mut BlockWords, motion: &mut Option<BlockMove>) -> Result<(), Error> {
        let Modal { motion: mode, path, .. } = self.modal;
        if words.axis_command != Some(AxisCommand::Motion) {
            return Ok(());
        }
        if mode == MotionMode::Cancelled {
            return Err(Error::UnusedAxisWords);
        }
        if mode.feeds() {
            self.check_feed()?;
        }
        if !words.has_axes() && !mode.is_arc() {
            return Ok(());
        }
        if mode.is_arc() {
            let arc = self.arc(words)?;
            let target_pm = self.target_pm(words)?;
            let rate = Rate::Feed { mm_min: self.feed_mm_min(target_pm, arc.as_ref(), words) };
            *motion = Some(BlockMove { target_pm, rate, arc, path });
            return Ok(());
        }
        let target_pm = self.target_pm(words)?;
        let rate =
            if mode.feeds() { Rate::Feed { mm_min: self.feed_mm_min(target_pm, None, words) } } else { Rate::Rapid };
        *motion = Some(BlockMove { target_pm, rate, arc: None, path });
        Ok(())
    }

    /// Checks that a feed is in force.
    fn check_feed(&self) -> Result<(), Error> {
        if self.modal.feed <= 0.0 { Err(Error::NoFeed) } else { Ok(()) }
    }

    fn feed_mm_min(&self, target_pm: [i64; AXES], arc: Option<&Arc>, words: &BlockWords) -> f32 {
        let mm_min = if self.modal.inverse_time {
            self.modal.feed * rotary::length_mm(self.way_pm(target_pm), arc)
        } else {
            words.rotary.along_path(self.modal.feed, self.way_pm(target_pm), arc, self.modal.inches)
        };
        // `f32::max` would be a call.
        if mm_min > MIN_FEED_MM_MIN { mm_min } else { MIN_FEED_MM_MIN }
    }

    /// From here straight to `target_pm`.
    fn way_pm(&self, target_pm: [i64; AXES]) -> [i64; AXES] {
        core::array::from_fn(|axis| target_pm[axis] - self.position_pm[axis])
    }
}

/// Converts a feed from the units in force to mm/min, or a length to mm.
fn in_mm_min(feed: f32, modal: &Modal) -> f32 {
    if modal.inches { feed * INCH_MM } else { feed }
}

/// Checks that a coordinate is within the allowed range.
fn within(pm: i64) -> Result<i64, Error> {
    if pm.abs() <= MAX_COORDINATE_PM { Ok(pm) } else { Err(Error::InvalidTarget) }
}
