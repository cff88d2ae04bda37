//! Reads a program from its first line to its last without a machine, to find which lines would be refused, where the
//! program goes, and what it asks of the operator.
//!
//! # Design
//! Each line goes to the same interpreter as in the controller, in the state of a machine at rest. So a line that is
//! refused here is also refused there, with the same number. What only a machine can know is left out: switches, alarms
//! and the flash.
//!
//! A line with parameters, expressions or O-words that cannot be carried out makes none for the controller, and counts as refused.
//!
//! A refused line changes nothing, neither here nor in the controller. A sender stops at it, but a survey continues as
//! if the line had been removed.

mod room;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use isostep_console::{
    BlockMove, Command, Coordinates, Cycle, CyclePart, Error, Interpreter, PathControl, Rate, ReportedState, Settings,
    SpindleMode, Unfit, length,
};
use isostep_motion::{AXES, Axis, Direction};
use serde::Serialize;

pub use room::{Bounds, Fit, Room};

use isostep_program::{LineError, tool_comment};
use isostep_sim::program::{Program, ProgramError, acting, clean, message, stripped};

/// At most this many lines of one kind are listed one by one.
pub const LISTED_MAX: usize = 1_000;
/// Tolerance for comparing a position with the travel: half of the finest step that `$100` allows.
const SAME_MM: f64 = 0.5e-4;

/// A line that the controller would refuse.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Refused {
    /// Line number in the file, from 1.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// The number after `error:`; 0 for a line that must not be sent, or cannot be carried out.
    pub code: u8,
    /// The word at which reading stopped, if it was a word.
    pub word: Option<String>,
    /// The fault, and the remedy.
    pub remedy: String,
}

/// The first move that leaves the travel.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Outside {
    /// Line number in the program, from 1.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// The axis.
    pub axis: String,
    /// Its target, in machine coordinates.
    pub place_mm: f64,
    /// The nearest position within the travel.
    pub nearest_mm: f64,
    /// True if the axis is homed then, so that the machine itself refuses the move.
    pub homed: bool,
    /// The start with which the whole program would fit, if there is one.
    pub fit: Fit,
}

/// Knowledge about a program without running it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Survey {
    /// Number of lines for the controller, including empty ones.
    pub lines: usize,
    /// Number of lines of the file, if those for the controller are made from them.
    pub made_from: Option<usize>,
    /// Lines of G-code among them.
    pub blocks: usize,
    /// `$` lines among them.
    pub statements: usize,
    /// Lines without content, or with comments only, among them.
    pub empty: usize,
    /// Number of refused lines.
    pub refused_total: usize,
    /// The refused lines, at most [`LISTED_MAX`].
    pub refused: Vec<Refused>,
    /// The indices of all refused lines.
    #[serde(skip)]
    refused_lines: Vec<usize>,
    /// Number of refused lines for each cause.
    pub refused_by_word: BTreeMap<String, usize>,
    /// Lines that move something.
    pub moves: usize,
    /// Arcs among them.
    pub arcs: usize,
    /// The range of its moves, including their starts, relative to where the program begins or has been homed; `None`
    /// if nothing moves.
    pub extents_mm: Option<Bounds>,
    /// The least and the greatest feed asked for, mm/min.
    pub feeds_mm_min: Option<(f32, f32)>,
    /// Number of lines that wait for the operator: M0 and M6.
    pub pauses_total: usize,
    /// The numbers of these lines, at most [`LISTED_MAX`].
    pub pauses: Vec<usize>,
    /// Number of dwells for which the laser is on (M3) and yet dark, as it is wherever nothing moves.
    pub dark_dwells_total: usize,
    /// The numbers of these lines, at most [`LISTED_MAX`].
    pub dark_dwells: Vec<usize>,
    /// The tools that M6 asks for, each with the first line that does; 0 if no tool is named.
    pub tools: BTreeMap<u32, usize>,
    /// The comments of the program about them, of those that have one.
    pub tool_comments: BTreeMap<u32, String>,
    /// The numbers of the tools that T has named.
    #[serde(skip)]
    pub tool_numbers: BTreeSet<u32>,
    /// Number of lines that tell the operator something, by `(MSG, ...)`.
    pub messages: usize,
    /// The bytes in comments that act at once if a sender does not strip them, in words, with the numbers of the first lines.
    pub acting: BTreeMap<String, Vec<usize>>,
    /// The lines whose S is above `$30`, at most [`LISTED_MAX`].
    pub above_full: Vec<usize>,
    /// Number of these lines.
    pub above_full_total: usize,
    /// The highest S of them, and the `$30` there.
    pub highest_rpm: Option<(f32, f32)>,
    /// The lines that have axis words beside G28.1 or G30.1, at most [`LISTED_MAX`].
    pub moves_beside_places: Vec<usize>,
    /// Number of these lines.
    pub moves_beside_places_total: usize,
    /// True if the program homes.
    pub homes: bool,
    /// The line at which the program ends: M2 or M30.
    pub ends_at: Option<usize>,
    /// The settings in force after the last line.
    #[serde(skip)]
    pub settings: Settings,
    /// True if a spindle or a laser is still on after the last line.
    pub leaves_tool_on: bool,
    /// The first move that leaves the travel.
    pub outside: Option<Outside>,
}

impl Survey {
    /// Reads a program for a machine with these settings whose carriages are at `start_mm` from their switches.
    pub fn of(program: &Program, settings: &Settings, start_mm: [f64; AXES]) -> Self {
        let mut reader = read(program, settings, start_mm, Interpreter::new());
        if let Some(mut outside) = reader.survey.outside.take() {
            outside.fit = fit(program, settings, &reader, outside.homed);
            reader.survey.outside = Some(outside);
        }
        reader.survey
    }

    /// The program as it is sent, with empty lines in place of the refused ones.
    pub fn accepted(&self, program: &Program) -> Program {
        let mut lines: Vec<_> = program.iter().map(|line| clean(0, line).unwrap_or_default()).collect();
        self.refused_lines.iter().for_each(|index| lines[*index].clear());
        program.with_lines(lines)
    }
}

fn read(program: &Program, settings: &Settings, start_mm: [f64; AXES], interpreter: Interpreter) -> Reader {
    let mut reader = Reader {
        survey: Survey { lines: program.len(), made_from: program.made_from(), ..Survey::default() },
        interpreter,
        settings: *settings,
        start_mm,
        homed: [false; AXES],
        room: Room::before_homing(settings, start_mm),
        reach_mm: [[None; AXES]; 2],
        checks_from_pm: None,
        unfit: None,
        tool_indices: BTreeMap::new(),
        index: 0,
        number: 0,
        text: String::new(),
    };
    let mut errors = program.errors().peekable();
    for (index, line) in program.iter().enumerate() {
        while let Some((_, error)) = errors.next_if(|(before, _)| *before == index) {
            reader.pass_over(error);
        }
        reader.take(index, program.number(index + 1), line);
    }
    errors.for_each(|(_, error)| reader.pass_over(error));
    let comment = |(tool, index): (&u32, &usize)| Some((*tool, tool_comment(program, *index, *tool)?));
    reader.survey.tool_comments = reader.tool_indices.iter().filter_map(comment).collect();
    reader.survey.settings = reader.settings;
    reader.survey.leaves_tool_on = reader.interpreter.modal().spindle != SpindleMode::Off;
    reader
}

/// The places where the program that `reader` has read would fit. Before homing, the carriages can be moved; after it, the
/// origin.
fn fit(program: &Program, settings: &Settings, reader: &Reader, homed: bool) -> Fit {
    let start_mm = reader.start_mm;
    let room = if homed { Room::homed(&reader.settings) } else { Room::before_homing(&reader.settings, start_mm) };
    let shifts_mm = match room::shifts_mm(reader.reach_mm[usize::from(homed)], &room) {
        Ok(shifts_mm) => shifts_mm,
        Err(too_wide) => return too_wide,
    };
    let (start_mm, interpreter, fit) = if homed {
        let origin_mm = shifts_mm.map(room::rounded);
        (start_mm, with_origin(origin_mm), Fit::OriginAt(origin_mm))
    } else {
        let start_mm = moved_mm(&reader.settings, start_mm, shifts_mm);
        (start_mm, Interpreter::new(), Fit::StartAt(start_mm))
    };
    let fits = read(program, settings, start_mm, interpreter).survey.outside.is_none();
    if fits { fit } else { Fit::Nowhere }
}

/// An interpreter with the origin of G54 at `origin_mm`.
fn with_origin(origin_mm: [f64; AXES]) -> Interpreter {
    let mut coordinates = Coordinates::default();
    coordinates.work_offsets_pm[0] = origin_mm.map(length::from_mm);
    let mut interpreter = Interpreter::new();
    interpreter.set_coordinates(coordinates);
    interpreter
}

/// Start positions of the carriages that shift all positions by `shifts_mm`, mm from their switches.
fn moved_mm(settings: &Settings, start_mm: [f64; AXES], shifts_mm: [f64; AXES]) -> [f64; AXES] {
    let towards = isostep_controller::config(settings).homing.towards;
    std::array::from_fn(|axis| {
        let away = if towards[axis] == Direction::Negative { 1.0 } else { -1.0 };
        room::rounded(start_mm[axis] + away * shifts_mm[axis])
    })
}

/// The word at which the reading of a line stops, if it is a word.
pub fn stopping_word(line: &str) -> Option<String> {
    word(&stripped(line.as_bytes()).ok()?)
}

fn word(stripped: &str) -> Option<String> {
    isostep_console::stopped_at(stripped).map(|range| stripped[range].to_owned())
}

/// The cause by which refused lines are counted. For G and M it includes the number, for other letters only the letter.
pub fn kind(word: Option<&str>, error: Error) -> String {
    let named = word.map(|word| if word.starts_with(['G', 'M']) { word } else { word.get(..1).unwrap_or(word) });
    match named {
        Some(named) if error == Error::Unsupported => named.to_owned(),
        Some(named) => format!("error:{} {named}", error.code()),
        None => format!("error:{}", error.code()),
    }
}

/// A program, as far as it has been read.
struct Reader {
    survey: Survey,
    interpreter: Interpreter,
    settings: Settings,
    start_mm: [f64; AXES],
    homed: [bool; AXES],
    /// The places where the axes can go at present.
    room: Room,
    /// The least and the greatest position of each axis before it is homed, and after that.
    reach_mm: [[Option<(f64, f64)>; AXES]; 2],
    /// In check mode, the position at which it began: nothing moves.
    checks_from_pm: Option<[i64; AXES]>,
    /// The error and the words of settings that do not work together, whichever step outputs there are.
    unfit: Option<(Error, String)>,
    /// The indices of the first lines that ask for each tool.
    tool_indices: BTreeMap<u32, usize>,
    /// The line that is being read: its index, and the line of the file that it is made from.
    index: usize,
    number: usize,
    text: String,
}

impl Reader {
    fn take(&mut self, index: usize, number: usize, bytes: &[u8]) {
        (self.index, self.number) = (index, number);
        self.text.clear();
        self.text.push_str(&String::from_utf8_lossy(bytes));
        self.note_comments(bytes);
        if let Err(error) = clean(number, bytes) {
            self.survey.blocks += 1;
            return self.refuse_to_send(&error);
        }
        let line = match stripped(bytes) {
            Ok(line) => line,
            Err(error) => {
                self.survey.blocks += 1;
                return self.refuse("", error, None);
            }
        };
        match line.as_bytes() {
            [] | [b'%'] => self.survey.empty += 1,
            [b'$', ..] => self.survey.statements += 1,
            _ => {
                self.survey.blocks += 1;
                // The program has not ended if another block follows.
                self.survey.ends_at = None;
            }
        }
        let from_pm = self.interpreter.position_pm();
        let state = match self.unfit {
            Some(_) => ReportedState::Alarm,
            None if self.checks_from_pm.is_some() => ReportedState::Check,
            None => ReportedState::Idle,
        };
        match (self.interpreter.interpret(&line, state, &self.settings), self.unfit.clone()) {
            (Err(error @ (Error::Locked | Error::NotIdle)), Some((_, unfit))) => {
                self.refuse(&line, error, Some(&unfit))
            }
            (Ok(Command::Home { .. } | Command::Unlock), Some((error, unfit))) => {
                self.refuse(&line, error, Some(&unfit))
            }
            (Err(error), _) => self.refuse(&line, error, None),
            (Ok(Command::SetSetting { number, value }), _) => self.set(&line, number, value),
            (Ok(command), _) => self.carry_out(&line, command, from_pm),
        }
    }

    fn carry_out(&mut self, line: &str, command: Command<'_>, from_pm: [i64; AXES]) {
        match command {
            Command::Block(block) | Command::SetStartup { block, .. } => {
                let via = block.via_pm.map(|target_pm| BlockMove {
                    target_pm,
                    rate: Rate::Rapid,
                    arc: None,
                    path: PathControl::Exact,
                });
                let mut from_pm = from_pm;
                let cycle = block.drills.then(|| *self.interpreter.cycle());
                let of_holes = cycle.iter().flat_map(Cycle::parts).filter_map(|part| match part {
                    CyclePart::Move(one) => Some(one),
                    _ => None,
                });
                for motion in via.into_iter().chain(block.motion).chain(of_holes) {
                    self.go(from_pm, &motion);
                    from_pm = motion.target_pm;
                }
                if block.dwell_s.is_some_and(|s| s > 0.0) {
                    self.dwell();
                }
                let modal = self.interpreter.modal();
                let (speed_rpm, full_rpm) = (modal.speed_rpm, self.settings.spindle_max_rpm);
                self.survey.tool_numbers.extend((modal.tool > 0).then_some(modal.tool));
                if block.changes_speed && speed_rpm > full_rpm {
                    note(self.number, &mut self.survey.above_full, &mut self.survey.above_full_total);
                    let highest = self.survey.highest_rpm.get_or_insert((speed_rpm, full_rpm));
                    *highest = if speed_rpm > highest.0 { (speed_rpm, full_rpm) } else { *highest };
                }
                if block.motion.is_some() && ["G28.1", "G30.1"].iter().any(|code| line.contains(code)) {
                    note(self.number, &mut self.survey.moves_beside_places, &mut self.survey.moves_beside_places_total);
                }
                if let Some(tool) = block.tool_change {
                    self.survey.tools.entry(tool).or_insert(self.number);
                    self.tool_indices.entry(tool).or_insert(self.index);
                }
                if (block.pauses || block.tool_change.is_some()) && self.checks_from_pm.is_none() {
                    self.wait();
                }
                if block.ends_program {
                    self.survey.ends_at = Some(self.number);
                }
            }
            Command::Jog(jog) => {
                let rate = Rate::Feed { mm_min: jog.mm_min };
                self.go(from_pm, &BlockMove { target_pm: jog.target_pm, rate, arc: None, path: PathControl::Exact });
                self.interpreter.set_position_pm(jog.target_pm);
            }
            Command::Home { axis } => self.home(axis),
            Command::ToggleCheck => self.toggle_check(from_pm),
            _ => {}
        }
    }

    /// Notes what the comments of this line tell the operator, and what they would tell the machine.
    fn note_comments(&mut self, bytes: &[u8]) {
        if !bytes.contains(&b'(') && !bytes.contains(&b';') {
            return;
        }
        self.survey.messages += usize::from(!message(bytes).is_empty());
        for (place, does) in acting(bytes) {
            let lines = self.survey.acting.entry(format!("{} {does}", named(bytes, place))).or_default();
            if lines.len() < LISTED_MAX && lines.last() != Some(&self.number) {
                lines.push(self.number);
            }
        }
    }

    /// Notes that this line waits for the operator, to change a tool or to look.
    fn wait(&mut self) {
        note(self.number, &mut self.survey.pauses, &mut self.survey.pauses_total);
    }

    /// Notes a dwell that is to pierce: Grbl's laser shines in it.
    fn dwell(&mut self) {
        let modal = self.interpreter.modal();
        if !self.settings.laser_mode || modal.spindle != SpindleMode::Clockwise || modal.speed_rpm <= 0.0 {
            return;
        }
        note(self.number, &mut self.survey.dark_dwells, &mut self.survey.dark_dwells_total);
    }

    /// Ends or begins check mode. It ends with a reset, at the position at which it began.
    fn toggle_check(&mut self, position_pm: [i64; AXES]) {
        match self.checks_from_pm.take() {
            None => self.checks_from_pm = Some(position_pm),
            Some(from_pm) => {
                self.interpreter.reset();
                self.interpreter.set_position_pm(from_pm);
            }
        }
    }

    /// Updates the room after a change of the settings or of the homed axes.
    fn measure_room(&mut self) {
        let (before, behind) = (Room::before_homing(&self.settings, self.start_mm), Room::homed(&self.settings));
        let mm = |axis: usize| if self.homed[axis] { behind.mm[axis] } else { before.mm[axis] };
        self.room = Room { mm: std::array::from_fn(mm), ..behind };
    }

    fn set(&mut self, line: &str, number: u16, value: f32) {
        match self.settings.with(number, value) {
            Ok(settings) => {
                self.settings = settings;
                self.unfit = settings.check(&|_| f32::INFINITY).err().map(|why| (why.error(), Unfit(why).to_string()));
                self.measure_room();
            }
            Err(refused) => self.refuse(line, refused.error(), Some(&refused)),
        }
    }

    /// Notes that the axes are at zero, so that their travel is now known.
    fn home(&mut self, axis: Option<usize>) {
        self.survey.homes = true;
        let mut position_pm = self.interpreter.position_pm();
        for index in (0..AXES).filter(|index| axis.is_none_or(|axis| axis == *index)) {
            (self.homed[index], position_pm[index]) = (true, 0);
        }
        self.interpreter.set_position_pm(position_pm);
        self.measure_room();
    }

    fn go(&mut self, from_pm: [i64; AXES], motion: &BlockMove) {
        if self.checks_from_pm.is_some() {
            return;
        }
        let mut way = Bounds::at(from_pm.map(length::to_mm));
        way.add(motion.target_pm.map(length::to_mm));
        if let Some(arc) = &motion.arc {
            let bounds_mm = arc.bounds_mm();
            [0, 1].into_iter().for_each(|end| way.add(bounds_mm.map(|axis| axis[end])));
        }
        self.survey.moves += 1;
        self.survey.arcs += usize::from(motion.arc.is_some());
        match &mut self.survey.extents_mm {
            None => self.survey.extents_mm = Some(way),
            Some(extents) => extents.join(&way),
        }
        for axis in 0..AXES {
            let reach_mm = &mut self.reach_mm[usize::from(self.homed[axis])][axis];
            let (least, most) = reach_mm.unwrap_or((way.low_mm[axis], way.high_mm[axis]));
            *reach_mm = Some((least.min(way.low_mm[axis]), most.max(way.high_mm[axis])));
        }
        if let Rate::Feed { mm_min } = motion.rate {
            let (least, most) = self.survey.feeds_mm_min.unwrap_or((mm_min, mm_min));
            self.survey.feeds_mm_min = Some((least.min(mm_min), most.max(mm_min)));
        }
        if self.survey.outside.is_none() {
            self.survey.outside = self.outside(&way);
        }
    }

    fn outside(&self, way: &Bounds) -> Option<Outside> {
        let left = |axis: &Axis| self.room.beyond(*axis as usize, way, SAME_MM).map(|beyond| (*axis, beyond));
        let (axis, (place_mm, nearest_mm)) = Axis::ALL.iter().find_map(left)?;
        Some(Outside {
            line: self.number,
            text: self.text.clone(),
            axis: axis.to_string(),
            place_mm,
            nearest_mm,
            homed: self.homed[axis as usize],
            fit: Fit::Nowhere,
        })
    }

    /// Notes that a line is refused, and why, if that is about settings.
    fn refuse(&mut self, line: &str, error: Error, setting: Option<&dyn fmt::Display>) {
        let word = word(line);
        let why = self.interpreter.explain(line, error, &self.settings).map(|why| why.to_string());
        let remedy = match (setting, why, &word) {
            (Some(why), ..) => why.to_string(),
            (None, Some(why), _) => why,
            (None, None, Some(word)) => format!("{word}: {error}"),
            (None, None, None) => error.to_string(),
        };
        self.note_refused(kind(word.as_deref(), error), error.code(), word, remedy);
        self.survey.refused_lines.push(self.index);
    }

    /// Notes a line that no sender sends, because it has a byte that would act at once, or that is no text.
    fn refuse_to_send(&mut self, error: &ProgramError) {
        let words = error.to_string();
        let remedy = words.split_once(": ").map_or(words.as_str(), |(_, remedy)| remedy).to_owned();
        let word = match error {
            ProgramError::RealTime { byte, .. } => char::from(*byte).to_string(),
            _ => "no text".to_owned(),
        };
        self.note_refused(word, 0, None, remedy);
        self.survey.refused_lines.push(self.index);
    }

    /// Notes a line of the file that cannot be carried out.
    fn pass_over(&mut self, error: &LineError) {
        self.number = error.line;
        self.text.clone_from(&error.text);
        self.note_refused("# [] O".to_owned(), 0, None, error.problem.to_string());
    }

    fn note_refused(&mut self, key: String, code: u8, word: Option<String>, remedy: String) {
        *self.survey.refused_by_word.entry(key).or_default() += 1;
        self.survey.refused_total += 1;
        if self.survey.refused.len() < LISTED_MAX {
            let text = self.text.clone();
            self.survey.refused.push(Refused { line: self.number, text, code, word, remedy });
        }
    }
}

/// Counts a line, and lists it if it is one of the first.
fn note(number: usize, listed: &mut Vec<usize>, total: &mut usize) {
    *total += 1;
    if listed.len() < LISTED_MAX {
        listed.push(number);
    }
}

/// `Ä (0x84)`: the character that the byte at `place` is of, and the byte.
fn named(bytes: &[u8], place: usize) -> String {
    let byte = bytes[place];
    let text = str::from_utf8(bytes).unwrap_or_default();
    let character = text.char_indices().take_while(|(index, _)| *index <= place).last();
    match character.map(|(_, character)| character) {
        Some('\u{a0}') => format!("a no-break space (0x{byte:02X})"),
        Some(character) => format!("{character} (0x{byte:02X})"),
        None => format!("byte 0x{byte:02X}"),
    }
}

#[cfg(test)]
mod tests;
