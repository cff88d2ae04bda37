//! Sends bytes to a console without a machine behind it. Each line is carried out at once.

use std::fmt::{self, Write};

use crate::axes::xyz_a;
use isostep_console::parameters::{STORED_LINE_CHARS, StoredLine};
use isostep_console::{
    Block, BlockMove, Command, Coordinates, CyclePart, Error, Interpreter, Jog, LineAssembler, MAX_COORDINATE_PM,
    MIN_FEED_MM_MIN, Overrides, Rate, Realtime, Refusal, ReportedState, SETTING_TABLE, Settings, SpindleMode,
    StatusReport, StatusReporter, Unfit, length, realtime, report, stopped_at,
};
use isostep_sim::AXES;

/// Bytes that a controller has room for, which are the maximum lengths of the reports.
const MESSAGE_BYTES: usize = 256;
const STATUS_BYTES: usize = 145;
const FULL_STATUS_BYTES: usize = 184;
const SETTING_BYTES: usize = 64;
/// The longest line of a catalogue.
const CATALOGUE_BYTES: usize = 190;
/// The number of chords of an arc that are checked. There may be very many.
const CHORDS: usize = 32;

/// Sends `bytes` to a console. Bytes that the console ignores set what is reported: 0xB0 to 0xBC set the state, 0xC0 to
/// 0xFF set which inputs are pressed.
///
/// # Panics
/// When a line does not get exactly one answer, a refused line changes anything, a report is too long, or a value is
/// not finite or too large.
pub fn run(bytes: &[u8]) {
    let mut console = Console::new();
    for &byte in bytes {
        console.byte(byte);
    }
    console.report(true);
    console.report(false);
    let ends = bytes.iter().filter(|byte| matches!(byte, b'\r' | b'\n')).count();
    assert_eq!(console.answers, ends, "a line has one answer");
}

/// The step outputs support a pulse and a pause of the same length, up to 1 MHz.
fn carries(pulse_us: u16) -> f32 {
    (1e6 / (2.0 * f32::from(pulse_us))).min(1e6)
}

struct Console {
    lines: LineAssembler,
    interpreter: Interpreter,
    settings: Settings,
    overrides: Overrides,
    reporter: StatusReporter,
    state: ReportedState,
    inputs: u8,
    /// The last line number and the last feed.
    line_number: u32,
    feed_mm_min: f32,
    startup: [StoredLine; 2],
    build_text: StoredLine,
    answers: usize,
}

impl Console {
    fn new() -> Self {
        Self {
            lines: LineAssembler::new(),
            interpreter: Interpreter::new(),
            settings: Settings::DEFAULT,
            overrides: Overrides::DEFAULT,
            reporter: StatusReporter::new(),
            state: ReportedState::Idle,
            inputs: 0,
            line_number: 0,
            feed_mm_min: 0.0,
            startup: Default::default(),
            build_text: StoredLine::new(),
            answers: 0,
        }
    }

    fn byte(&mut self, byte: u8) {
        match realtime::classify(byte) {
            Some(Realtime::Status) => self.report(false),
            Some(Realtime::FullStatus) => self.report(true),
            Some(Realtime::Modal) => self.list(),
            Some(Realtime::Reset) => {
                self.lines.reset();
                self.interpreter.reset();
                self.reporter = StatusReporter::new();
            }
            Some(Realtime::Override(byte)) => self.overrides.apply(byte),
            Some(Realtime::Ignored) => match byte {
                0xB0..0xBD => self.state = ReportedState::ALL[usize::from(byte - 0xB0)],
                0xC0.. => self.inputs = byte - 0xC0,
                _ => {}
            },
            Some(_) => {}
            None => self.part_of_a_line(byte),
        }
    }

    fn part_of_a_line(&mut self, byte: u8) {
        let Some(line) = self.lines.push(byte) else { return };
        let line = line.map(str::to_owned);
        let answer = match &line {
            Ok(line) => self.line(line),
            Err(error) => Err(*error),
        };
        let mut said = Limited::new(MESSAGE_BYTES);
        report::answer(&mut said, answer).expect("an answer fits");
        // A list has nothing to say of a tool that is not there.
        assert!(said.text.is_empty() || said.text.ends_with("\r\n"), "{}", said.text);
        assert!(said.text.matches("\r\n").count() == 1);
        self.answers += 1;
        self.is_sound();
    }

    /// Carries out a line. If the line is refused, nothing may have changed.
    fn line(&mut self, line: &str) -> Result<(), Error> {
        let before = (self.interpreter, self.settings);
        let command = self.interpreter.interpret(line, self.state, &self.settings);
        if matches!(command, Ok(Command::Jog(_))) {
            assert_eq!(self.interpreter, before.0, "{line}");
        }
        let answer = command.and_then(|command| self.carry_out(command));
        if let Err(error) = answer {
            assert_eq!((self.interpreter, self.settings), before, "{line}: {error}");
            stopped_at(line).inspect(|range| assert!(!line[range.clone()].is_empty(), "{line}"));
            if let Some(refusal) = Refusal::of(line, error) {
                tells(report::message, refusal);
            }
        }
        answer
    }

    fn carry_out(&mut self, command: Command<'_>) -> Result<(), Error> {
        match command {
            Command::Block(block) => self.block(&block),
            Command::Jog(Jog { target_pm, mm_min }) => {
                is_a_place(target_pm);
                is_a_feed(mm_min);
                self.interpreter.set_position_pm(target_pm);
            }
            Command::SetSetting { number, value } => {
                assert!(value.is_finite());
                self.settings = self.settings.with(number, value).map_err(|why| {
                    tells(report::message, why);
                    why.error()
                })?;
            }
            Command::SetStartup { index, block, line } => {
                self.block(&block);
                self.startup[index] = line.try_into().expect("a line that is stored fits");
            }
            Command::SetBuild { text } => self.build_text = text.try_into().expect("a text that is stored fits"),
            Command::Restore { settings, parameters } => {
                if settings {
                    self.settings = Settings::DEFAULT;
                }
                if parameters {
                    self.interpreter.set_coordinates(Coordinates::default());
                    self.startup = Default::default();
                }
            }
            Command::Home { axis } => assert!(axis.is_none_or(|axis| axis < AXES)),
            Command::Buzz { axis } | Command::MeasureStall { axis } => assert!(axis < AXES),
            Command::ExplainError(error) => tells(report::message, error),
            Command::ExplainAlarm(alarm) => tells(report::message, alarm),
            Command::ShowSettings | Command::ShowParameters | Command::ShowBuild { .. } => self.list(),
            Command::DescribeSetting { number } => fits(CATALOGUE_BYTES, |out| report::description(out, number)),
            Command::ShowCatalogue(catalogue) => (0..catalogue.lines())
                .for_each(|line| fits(CATALOGUE_BYTES, |out| catalogue.print(out, line, &self.settings))),
            Command::ShowModal | Command::ShowStartup | Command::Help => self.list(),
            Command::Unlock
            | Command::MeasureTool
            | Command::ShowVfd
            | Command::SetToolReference
            | Command::ToggleCheck
            | Command::Sleep
            | Command::Boot => {}
            Command::Prove { .. } | Command::ShowDrivers => {}
        }
        Ok(())
    }

    /// The first parts of a cycle, and its end: all of them may be a hundred million.
    fn holes(&self, drills: bool) {
        if !drills {
            return;
        }
        let cycle = self.interpreter.cycle();
        cycle.bounds_pm().into_iter().for_each(is_a_place);
        for part in cycle.parts().take(1_000) {
            match part {
                CyclePart::Move(one) => is_a_place(one.target_pm),
                CyclePart::Dwell(dwell_s) => assert!(dwell_s > 0.0 && dwell_s.is_finite()),
                CyclePart::SpindleOff | CyclePart::SpindleOn => {}
            }
        }
        assert_eq!(self.interpreter.position_pm(), cycle.end_pm());
    }

    fn block(&mut self, block: &Block) {
        self.line_number = block.line_number;
        assert!(block.dwell_s.is_none_or(|dwell_s| dwell_s >= 0.0 && dwell_s.is_finite()), "{block:?}");
        block.via_pm.into_iter().for_each(is_a_place);
        self.holes(block.drills);
        if let Some(probe) = block.probe {
            is_a_place(probe.target_pm);
            is_a_feed(probe.mm_min);
            self.interpreter.set_touched(probe.target_pm, probe.must);
        }
        let Some(BlockMove { target_pm, rate, arc, .. }) = block.motion else { return };
        is_a_place(target_pm);
        assert_eq!(self.interpreter.position_pm(), target_pm);
        if let Rate::Feed { mm_min } = rate {
            is_a_feed(mm_min);
            self.feed_mm_min = mm_min;
        }
        if let Some(arc) = arc {
            let most_mm = length::to_mm(MAX_COORDINATE_PM + 1);
            assert!(
                arc.bounds_mm().iter().all(|[least, most]| -most_mm <= *least && least <= most && *most <= most_mm)
            );
            assert!(arc.length_mm().is_finite() && arc.length_mm() >= 0.0);
            let chords = arc.chords(f64::from(self.settings.arc_tolerance_mm));
            chords.take(CHORDS).for_each(|chord_mm| is_a_place(chord_mm.map(|mm| length::from_mm(mm * (1.0 - 1e-6)))));
        }
    }

    /// Checks what must hold after every answered line.
    fn is_sound(&self) {
        is_a_place(self.interpreter.position_pm());
        let offset_pm = self.interpreter.work_offset_pm();
        // The offset is the sum of a coordinate system, a shift and a tool's length.
        assert!(offset_pm.iter().all(|pm| pm.abs() <= 3 * MAX_COORDINATE_PM), "{offset_pm:?}");
        assert!(self.interpreter.modal().feed.is_finite() && self.interpreter.modal().speed_rpm.is_finite());
        if let Err(unfit) = self.settings.check(&carries) {
            // Of steps that follow the microsteps.
            tells(report::message, Unfit(unfit));
        }
    }

    /// Prints every report that can be listed.
    fn list(&self) {
        for row in SETTING_TABLE {
            fits(SETTING_BYTES, |out| report::setting(out, row, &self.settings));
        }
        for line in 0..report::PARAMETERS {
            fits(MESSAGE_BYTES, |out| report::parameter(out, line, &self.interpreter, &self.settings));
        }
        fits(MESSAGE_BYTES, |out| report::modal(out, &self.interpreter, &self.settings));
        fits(MESSAGE_BYTES, |out| report::build(out, &self.build_text, true));
        fits(MESSAGE_BYTES, |out| report::extended_build(out, &self.settings));
        for (index, line) in self.startup.iter().enumerate() {
            assert!(line.len() <= STORED_LINE_CHARS);
            fits(MESSAGE_BYTES, |out| report::startup(out, index, line));
        }
    }

    fn report(&mut self, is_full: bool) {
        let [probe_touched, x, y, z, door_open, emergency_stop] =
            core::array::from_fn(|bit| self.inputs >> bit & 1 == 1);
        let modal = self.interpreter.modal();
        let ratio = f32::from(self.overrides.spindle_percent) / 100.0;
        let status = StatusReport {
            state: self.state,
            position_pm: self.interpreter.position_pm(),
            work_offset_pm: self.interpreter.work_offset_pm(),
            line_number: self.line_number,
            feed_mm_min: self.feed_mm_min,
            spindle_rpm: if modal.spindle == SpindleMode::Off { 0.0 } else { modal.speed_rpm * ratio },
            actual_rpm: (self.line_number % 2 == 1).then_some(self.feed_mm_min),
            spindle: modal.spindle,
            coolant: modal.coolant,
            probe_touched,
            limits_pressed: xyz_a([x, y, z], y),
            second_limit_pressed: x && y,
            drive_alarm: y,
            door_open,
            hold_pressed: door_open,
            start_pressed: probe_touched,
            emergency_stop,
            free_blocks: 15,
            free_bytes: 1024,
            overrides: self.overrides,
            homed: xyz_a([x, y, z], y),
            tool: 99_999,
            system: 8,
            has_tool_reference: true,
        };
        if is_full {
            fits(FULL_STATUS_BYTES, |out| self.reporter.write_full(out, &status, &self.settings));
        } else {
            fits(STATUS_BYTES, |out| self.reporter.write(out, &status, &self.settings));
        }
    }
}

fn is_a_place(place_pm: [i64; AXES]) {
    assert!(place_pm.iter().all(|pm| pm.abs() <= MAX_COORDINATE_PM), "{place_pm:?}");
}

fn is_a_feed(mm_min: f32) {
    assert!(mm_min.is_finite() && mm_min >= MIN_FEED_MM_MIN, "{mm_min}");
}

/// A text buffer of limited size, as in a controller.
struct Limited {
    text: String,
    most: usize,
}

impl Limited {
    fn new(most: usize) -> Self {
        Self { text: String::new(), most }
    }
}

impl Write for Limited {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.text += text;
        if self.text.len() > self.most { Err(fmt::Error) } else { Ok(()) }
    }
}

/// Checks that `write` writes at most this number of bytes, in whole lines of text.
fn fits(most: usize, write: impl FnOnce(&mut Limited) -> fmt::Result) {
    let mut said = Limited::new(most);
    let written = write(&mut said);
    assert!(written.is_ok(), "more than {most} bytes: {}", said.text);
    // A list has nothing to say of a tool that is not there.
    assert!(said.text.is_empty() || said.text.ends_with("\r\n"), "{}", said.text);
    assert!(said.text.bytes().all(|byte| matches!(byte, b'\r' | b'\n' | b' '..=b'~')));
    assert!(!said.text.contains("NaN") && !said.text.contains("inf"), "{}", said.text);
}

fn tells<T: fmt::Display>(message: fn(&mut Limited, T) -> fmt::Result, text: T) {
    let mut said = Limited::new(MESSAGE_BYTES);
    assert!(message(&mut said, text).is_ok(), "more than {MESSAGE_BYTES} bytes: {}", said.text);
}
