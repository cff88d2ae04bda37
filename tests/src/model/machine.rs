//! The state of the machine, and the effect of each line and each byte.

use std::collections::BTreeMap;

use super::arcs::Reach;
use super::block::{Axes, Block, Refused, near};
use super::cycles::{Series, is_cycle};
use super::modes::Modes;
use super::settings::SettingValues;
use super::tools::Tool;
use super::words::{ONE, Word};

/// A place, angstroms, X, Y, Z.
pub type Place = [i64; 3];

/// The state of the machine at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Idle.
    Idle,
    /// G-code is only checked.
    Check,
    /// Locked by the alarm with this number.
    Alarm(u8),
    /// Locked by settings that do not work together.
    Unfit,
}

/// The feed, rapid and spindle override, percent.
pub type Overrides = [i64; 3];

/// The model of the machine.
#[derive(Clone, Debug)]
pub struct Model {
    /// The modes.
    pub modes: Modes,
    /// The motion mode before canned cycles and G80.
    pub before_cycles: i64,
    /// The series of a canned cycle that is under way.
    pub series: Option<Series>,
    /// G54 to G59, G59.1 to G59.3.
    pub systems: [Place; 9],
    /// Of G28 and G30.
    pub places: [Place; 2],
    /// Of G92.
    pub shift: Place,
    /// Of G43, G43.1 and G43.2.
    pub tool_length: i64,
    /// The tool table, by the numbers of its tools.
    pub tools: BTreeMap<i64, Tool>,
    /// The tool of the last M6; 0 for none.
    pub in_spindle: i64,
    /// The same before check mode, which changes no tool.
    pub in_spindle_before_check: i64,
    /// The place of the program, in machine coordinates.
    pub position: Place,
    /// The place of the carriages.
    pub carriage: Place,
    /// The place where the last probe ended, and true if it touched.
    pub probed: (Place, bool),
    /// Axes whose zero is known.
    pub homed: [bool; 3],
    /// Overrides.
    pub overrides: Overrides,
    /// The state.
    pub state: State,
    /// The settings.
    pub settings: SettingValues,
    /// `$N0`, `$N1`.
    pub startup: [Startup; 2],
    /// `$I=`.
    pub build: String,
    /// The places to which the last line has led.
    pub path: Vec<Place>,
    /// The reach of the last arc, and the difference of its radii, angstroms.
    pub bend: Option<(Reach, f64)>,
    /// True if the program counts from where the carriages stand, which is a whole number of steps.
    pub on_steps: bool,
    /// The tool that M6 has the machine wait for.
    pub prompt: Option<i64>,
    /// The number of times that the line waits for `~`.
    pub waits: usize,
}

/// A start-up line: its words, and how it is listed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Startup {
    /// Words.
    pub words: Vec<Word>,
    /// Text, without spaces.
    pub text: String,
}

impl Model {
    /// A machine at its first power-up.
    #[must_use]
    pub fn new(settings: SettingValues) -> Self {
        Self {
            modes: Modes::START,
            before_cycles: 0,
            series: None,
            systems: [[0; 3]; 9],
            places: [[0; 3]; 2],
            shift: [0; 3],
            tool_length: 0,
            tools: BTreeMap::new(),
            in_spindle: 0,
            in_spindle_before_check: 0,
            position: [0; 3],
            carriage: [0; 3],
            probed: ([0; 3], false),
            homed: [false; 3],
            overrides: [100; 3],
            state: State::Idle,
            settings,
            startup: Default::default(),
            build: String::new(),
            path: Vec::new(),
            bend: None,
            on_steps: false,
            prompt: None,
            waits: 0,
        }
    }

    /// Work zero in machine coordinates.
    #[must_use]
    pub fn work_zero(&self) -> Place {
        let system = self.systems[self.modes.system];
        std::array::from_fn(|axis| system[axis] + self.shift[axis] + if axis == 2 { self.tool_length } else { 0 })
    }

    /// Has the program go on from where the carriages stand.
    pub fn follow_carriage(&mut self) {
        self.position = self.carriage;
        self.on_steps = true;
    }

    /// The welcome, and what the start-up lines answer, after a reset.
    pub fn reset(&mut self) -> Vec<String> {
        (self.before_cycles, self.series) = (0, None);
        (self.modes, self.shift, self.tool_length, self.overrides) = (Modes::START, [0; 3], 0, [100; 3]);
        self.follow_carriage();
        if self.state == State::Check {
            (self.state, self.in_spindle) = (State::Idle, self.in_spindle_before_check);
        }
        let mut said = vec!["Grbl 1.1h ['$' for help]".to_owned()];
        said.extend(self.start_up());
        said
    }

    /// The same after the power was off. The machine is not homed then, and stands at zero.
    pub fn power_cycle(&mut self) -> Vec<String> {
        (self.homed, self.carriage, self.state) = ([false; 3], [0; 3], State::Idle);
        self.judge_settings();
        (self.probed, self.in_spindle) = (([0; 3], false), 0);
        self.reset()
    }

    /// The answers of the start-up lines.
    pub fn start_up(&mut self) -> Vec<String> {
        if self.state != State::Idle {
            return Vec::new();
        }
        let lines = self.startup.clone();
        lines
            .iter()
            .filter(|line| !line.text.is_empty())
            .map(|line| {
                let answer = self.block(&line.words).err().map_or("ok".to_owned(), |code| format!("error:{code}"));
                format!(">{}:{answer}", line.text)
            })
            .collect()
    }

    /// Locks the machine if its settings do not work together, until they do.
    pub fn judge_settings(&mut self) {
        let fit = self.settings.check().is_ok();
        match self.state {
            State::Idle if !fit => self.state = State::Unfit,
            State::Unfit if fit => self.state = State::Idle,
            _ => {}
        }
        if !fit {
            self.modes.stop_tool();
        }
    }

    /// Locks the machine.
    pub fn lock(&mut self, alarm: u8) {
        self.state = State::Alarm(alarm);
        self.follow_carriage();
    }

    /// A line of G-code.
    ///
    /// # Errors
    /// The number of the error; nothing has changed then, except that a target outside the travel locks the machine.
    pub fn block(&mut self, words: &[Word]) -> Result<(), Refused> {
        if words.is_empty() {
            return Ok(());
        }
        if matches!(self.state, State::Alarm(_) | State::Unfit) {
            return Err(9);
        }
        let mut after = self.clone();
        (after.prompt, after.waits, after.bend) = (None, 0, None);
        match after.carry_out(words) {
            Ok(()) => {
                *self = after;
                Ok(())
            }
            Err(Stop::Refused(code)) => Err(code),
            // What the line asks for before its target counts.
            Err(Stop::OutsideTravel) => {
                *self = after;
                self.lock(2);
                Err(9)
            }
        }
    }

    fn carry_out(&mut self, words: &[Word]) -> Result<(), Stop> {
        let mut block = Block::read(words, self.modes)?;
        if block.take('N').is_some_and(|number| number > 10_000_000 * ONE) {
            return Err(Stop::Refused(27));
        }
        let (before, in_spindle_before) = (self.modes, self.in_spindle);
        self.modes = block.modes;
        self.begin_or_end_cycles(&block, before.motion);
        let motion = self.modes.motion;
        let feeds = matches!(motion, 10..=30 | 382..=385) || is_cycle(motion);
        self.modes.feed = match block.take('F') {
            Some(feed) if self.modes.inverse_time => feed,
            Some(feed) => self.modes.length(feed),
            None if self.modes.inverse_time && block.axes == Axes::Motion && feeds => return Err(Stop::Refused(22)),
            None if self.modes.inverse_time || before.inverse_time => 0,
            None => before.feed,
        };
        self.modes.speed = block.take('S').unwrap_or(self.modes.speed);
        self.modes.tool = block.take('T').map_or(self.modes.tool, |tool| tool / ONE);
        if block.once == Some(40) && block.take('P').is_none() {
            return Err(Stop::Refused(28));
        }
        if block.changes_tool {
            self.in_spindle = self.modes.tool;
        }
        if let Some(code) = block.tool_length {
            self.set_tool_length(code, &mut block)?;
        }
        let places = self.act_once(&mut block)?;
        let is_motion = block.axes == Axes::Motion;
        let holes = if is_motion && is_cycle(self.modes.motion) { self.drill(&mut block)? } else { Vec::new() };
        let (target, is_arc) = match self.modes.motion {
            motion if is_cycle(motion) => (None, false),
            800 if is_motion => return Err(Stop::Refused(31)),
            800 | 0 if !is_motion || !block.has("XYZ") => (None, false),
            _ if !is_motion => (None, false),
            0 => (Some(self.target(&block)?), false),
            _ if self.modes.feed < if self.modes.inverse_time { 1 } else { ONE } => return Err(Stop::Refused(22)),
            10 if !block.has("XYZ") => (None, false),
            20 | 30 if block.has("IJK") && !block.has("R") => (Some(self.arc(&mut block)?), true),
            _ if !block.has("XYZ") => return Err(Stop::Refused(26)),
            20 | 30 => (Some(self.arc(&mut block)?), true),
            382..=385 => (Some(self.probe_target(&block)?), false),
            _ => (Some(self.target(&block)?), false),
        };
        if block.groups().contains(&"path") {
            let deviation = block.take('P');
            if deviation.is_some() {
                block.take('Q');
            }
            // The P of G4 and of G10 is theirs.
            let is_own = !matches!(block.once, Some(40 | 100));
            self.modes.blends &= !is_own || deviation.is_none_or(|deviation| deviation > 0);
        }
        block.all_used()?;
        self.pause_for_tool(
            &block,
            &before,
            in_spindle_before,
            target.is_some() || places.is_some() || !holes.is_empty(),
        );
        let modes = self.modes;
        if block.ends {
            self.modes.end_program();
        }
        for place in places.into_iter().flatten() {
            self.go_to(place, false)?;
        }
        // No hole is begun if one is outside.
        if holes.iter().any(|&place| self.is_outside(place)) {
            return Err(Stop::OutsideTravel);
        }
        for place in holes {
            self.go_to(place, false)?;
        }
        match target {
            Some(target) if matches!(modes.motion, 382..=385) => self.probe(target, modes.motion)?,
            Some(target) => self.go_to(target, is_arc)?,
            None => {}
        }
        if block.ends {
            self.overrides = [100; 3];
        }
        Ok(())
    }

    /// A series of cycles begins anew behind other motion. Axis words behind G80 go on with the G0 or G1 before it.
    fn begin_or_end_cycles(&mut self, block: &Block, before: i64) {
        let motion = self.modes.motion;
        if !is_cycle(motion) && motion != 800 {
            return;
        }
        if !is_cycle(before) {
            self.series = None;
            self.before_cycles = if before == 800 { self.before_cycles } else { before };
        }
        let moves = block.axes == Axes::Motion && block.once.is_none();
        if motion == 800 && moves && matches!(self.before_cycles, 0 | 10) {
            self.modes.motion = self.before_cycles;
        }
    }

    /// M6 and M0. M6 does not wait for the tool that is in the spindle, and for one without a number it always does. M0 does not wait a second time unless the line does something else.
    fn pause_for_tool(&mut self, block: &Block, before: &Modes, in_spindle_before: i64, moves: bool) {
        if self.state == State::Check {
            return;
        }
        let modes = &self.modes;
        let switches = (modes.spindle, modes.flood, modes.mist, modes.speed)
            != (before.spindle, before.flood, before.mist, before.speed);
        let is_new = self.in_spindle == 0 || self.in_spindle != in_spindle_before;
        let waits_for_tool = block.changes_tool && is_new && self.settings.get(341) == 0.0;
        if waits_for_tool {
            self.prompt = Some(self.modes.tool);
            self.waits += 1;
        }
        let acts = moves || switches || block.once == Some(40);
        if block.pauses && (!waits_for_tool || acts) {
            self.waits += 1;
        }
    }

    /// A code of group 0. Returns the places to which G28 and G30 lead.
    fn act_once(&mut self, block: &mut Block) -> Result<Option<Vec<Place>>, Stop> {
        let lengths = block.lengths();
        match block.once {
            Some(100) => self.set_system(block)?,
            Some(920) if !block.has("XYZ") => return Err(Stop::Refused(26)),
            Some(920) => {
                let system = self.systems[self.modes.system];
                for axis in 0..3 {
                    if let Some(length) = lengths[axis] {
                        self.shift[axis] = near(self.position[axis] - self.tip(axis) - system[axis] - length)?;
                    }
                }
            }
            Some(921) => self.shift = [0; 3],
            Some(code @ (281 | 301)) => self.places[usize::from(code == 301)] = self.position,
            Some(code @ (280 | 300)) => {
                let place = self.places[usize::from(code == 300)];
                if !block.has("XYZ") {
                    return Ok(Some(vec![place]));
                }
                // Only the axes that are named go to the place, by way of the point that is given.
                let to = std::array::from_fn(|axis| lengths[axis].map_or(self.position[axis], |_| place[axis]));
                return Ok(Some(vec![self.target(block)?, to]));
            }
            Some(530) if !matches!(self.modes.motion, 0 | 10) => return Err(Stop::Refused(30)),
            _ => {}
        }
        Ok(None)
    }

    fn set_system(&mut self, block: &mut Block) -> Result<(), Stop> {
        if let Some(kind @ (1 | 10 | 11)) = block.get('L').map(|kind| kind / ONE) {
            block.take('L');
            return Ok(self.set_tool(kind, block)?);
        }
        if !block.has("XYZ") {
            return Err(Stop::Refused(26));
        }
        let (Some(number), Some(kind)) = (block.take('P'), block.take('L')) else { return Err(Stop::Refused(28)) };
        if number % ONE != 0 {
            return Err(Stop::Refused(23));
        }
        let system = match number / ONE {
            0 => self.modes.system,
            number @ 1..=9 => number as usize - 1,
            _ => return Err(Stop::Refused(29)),
        };
        for (axis, length) in block.lengths().into_iter().enumerate() {
            let Some(length) = length else { continue };
            self.systems[system][axis] = near(match kind / ONE {
                2 => length,
                20 => self.position[axis] - self.shift[axis] - self.tip(axis) - length,
                _ => return Err(Stop::Refused(20)),
            })?;
        }
        Ok(())
    }

    /// The length of the tool, along this axis.
    fn tip(&self, axis: usize) -> i64 {
        if axis == 2 { self.tool_length } else { 0 }
    }

    /// The target of the axis words.
    fn target(&self, block: &Block) -> Result<Place, Refused> {
        let (zero, mut target) = (self.work_zero(), self.position);
        for (axis, length) in block.lengths().into_iter().enumerate() {
            let Some(length) = length else { continue };
            target[axis] = near(match () {
                () if block.once == Some(530) => length,
                () if block.modes.incremental => self.position[axis] + length,
                () => zero[axis] + length,
            })?;
        }
        Ok(target)
    }

    /// The target of an arc. Its words are those of a whole arc, or lack something.
    fn arc(&mut self, block: &mut Block) -> Result<Place, Refused> {
        let (axes, offsets) = match self.modes.plane {
            17 => ("XY", "IJ"),
            18 => ("XZ", "IK"),
            _ => ("YZ", "JK"),
        };
        if !block.has(axes) && (block.has("R") || !block.has("IJK")) {
            return Err(32);
        }
        let target = self.target(block)?;
        let turns = block.take('R').is_some();
        let has_offsets = block.has(offsets);
        for letter in ['I', 'J', 'K'] {
            block.take(letter);
        }
        match () {
            () if turns && target == self.position => Err(33),
            () if !turns && !has_offsets => Err(35),
            () => {
                self.bend = Some(self.arc_reach(block, target)?);
                Ok(target)
            }
        }
    }

    fn probe_target(&self, block: &Block) -> Result<Place, Refused> {
        let target = self.target(block)?;
        if target == self.position { Err(33) } else { Ok(target) }
    }

    /// A probe that touches nothing. Without a contact G38.4 and G38.5 end where they begin.
    fn probe(&mut self, target: Place, motion: i64) -> Result<(), Stop> {
        let toward = matches!(motion, 382 | 383);
        if self.is_outside(target) {
            return Err(Stop::OutsideTravel);
        }
        if self.state == State::Check {
            self.position = target;
            return Ok(());
        }
        if !toward {
            self.path.push(target);
            self.lock(4);
            return Ok(());
        }
        self.go_to(target, false)?;
        self.probed = (target, false);
        match motion {
            382 => self.lock(5),
            _ => self.follow_carriage(),
        }
        Ok(())
    }

    fn go_to(&mut self, target: Place, is_arc: bool) -> Result<(), Stop> {
        if self.is_outside(target) {
            return Err(Stop::OutsideTravel);
        }
        self.position = target;
        if self.state != State::Check {
            self.carriage = target;
            if is_arc {
                self.path.clear();
            }
            self.path.push(target);
        }
        Ok(())
    }

    /// True if soft limits bar the way to a place.
    #[must_use]
    pub fn is_outside(&self, place: Place) -> bool {
        let beyond = |axis: usize| {
            let travel = (self.settings.get(130 + axis as u16) * ONE as f64) as i64;
            self.homed[axis] && !(0..=travel).contains(&place[axis])
        };
        self.settings.get(20) != 0.0 && (0..3).any(beyond)
    }

    /// A jog.
    ///
    /// # Errors
    /// The number of the error; nothing has changed then.
    pub fn jog(&mut self, words: &[Word]) -> Result<(), Refused> {
        if self.state != State::Idle {
            return Err(8);
        }
        let mut block = Block::read(words, Modes { motion: 10, inverse_time: false, ..self.modes })?;
        let feed = block.take('F').ok_or(22_u8)?;
        if !block.has("XYZ") {
            return Err(26);
        }
        let target = self.target(&block)?;
        if block.modes.length(feed) < ONE {
            return Err(22);
        }
        block.all_used()?;
        if block.groups().iter().any(|group| !["once", "distance", "units"].contains(group))
            || block.once.is_some_and(|once| once != 530)
        {
            return Err(16);
        }
        if self.is_outside(target) {
            return Err(15);
        }
        (self.position, self.carriage) = (target, target);
        self.path.push(target);
        Ok(())
    }
}

/// Why a block is not carried out to its end.
enum Stop {
    Refused(Refused),
    OutsideTravel,
}

impl From<Refused> for Stop {
    fn from(code: Refused) -> Self {
        Self::Refused(code)
    }
}
