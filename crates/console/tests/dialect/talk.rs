//! A simple machine that executes every command at once and prints it, for tests in the form of dialogues.

use std::fmt::Write as _;

use expect_test::Expect;
use isostep_console::{
    AXES, Block, BlockMove, Command, Coordinates, CyclePart, Interpreter, Jog, LineAssembler, Overrides, Probe, Rate,
    Realtime, ReportedState, Settings, SpindleMode, StatusReport, StatusReporter, Unfit, length,
    parameters::{STARTUP_LINES, StoredLine},
    realtime, report,
};

/// Checks what a sender receives when it sends `program` to an idle machine.
pub fn check(program: &str, heard: Expect) {
    heard.assert_eq(&Talk::new(ReportedState::Idle).send(program));
}

/// The step outputs of this machine support 30,000 steps/s, or fewer if pulse and pause take longer.
pub fn carries(pulse_us: u16) -> f32 {
    (1e6 / (2.0 * f32::from(pulse_us))).min(30_000.0)
}

pub struct Talk {
    lines: LineAssembler,
    pub interpreter: Interpreter,
    pub settings: Settings,
    pub state: ReportedState,
    pub overrides: Overrides,
    pub emergency_stop: bool,
    pub probe_touched: bool,
    startup: [StoredLine; STARTUP_LINES],
    build_text: StoredLine,
    reporter: StatusReporter,
    heard: String,
}

impl Talk {
    pub fn new(state: ReportedState) -> Self {
        Self {
            lines: LineAssembler::new(),
            interpreter: Interpreter::new(),
            settings: Settings::DEFAULT,
            state,
            overrides: Overrides::DEFAULT,
            emergency_stop: false,
            probe_touched: false,
            startup: Default::default(),
            build_text: StoredLine::new(),
            reporter: StatusReporter::new(),
            heard: String::new(),
        }
    }

    /// Sends the text and returns everything received for it, one `sent -> heard` per line.
    pub fn send(&mut self, text: &str) -> String {
        text.lines().map(|line| format!("{line} -> {}\n", self.bytes(format!("{line}\n").as_bytes()))).collect()
    }

    /// Sends bytes; returns the replies on one line.
    pub fn bytes(&mut self, bytes: &[u8]) -> String {
        self.heard.clear();
        for &byte in bytes {
            match realtime::classify(byte) {
                Some(Realtime::Status) => self.status(StatusReporter::write),
                Some(Realtime::FullStatus) => self.status(StatusReporter::write_full),
                Some(Realtime::Modal) => report::modal(&mut self.heard, &self.interpreter, &self.settings).unwrap(),
                Some(Realtime::Override(byte)) => self.overrides.apply(byte),
                Some(_) => {}
                None => self.byte(byte),
            }
        }
        self.heard.trim_end().replace("\r\n", " ")
    }

    fn byte(&mut self, byte: u8) {
        let Self { lines, interpreter, settings, state, heard, .. } = self;
        if lines.push(byte).is_none() {
            return;
        }
        if !lines.message().is_empty() {
            report::program_message(heard, lines.message()).unwrap();
        }
        match lines.line() {
            Ok(line) => {
                let line = line.to_owned();
                match interpreter.interpret(&line, *state, settings) {
                    Ok(command) => self.carry_out(command),
                    Err(error) => {
                        if let Some(why) = interpreter.explain(&line, error, settings) {
                            report::message(heard, why).unwrap();
                        }
                        report::error(heard, error).unwrap();
                    }
                }
            }
            Err(error) => report::error(heard, error).unwrap(),
        }
    }

    fn carry_out(&mut self, command: Command<'_>) {
        let Self { heard, interpreter, settings, startup, build_text, .. } = self;
        match command {
            Command::Block(block) => describe(heard, &block, interpreter),
            Command::Jog(Jog { target_pm, mm_min }) => {
                write!(heard, "(jog {mm_min} {:?}) ", in_mm(target_pm)).unwrap();
                interpreter.set_position_pm(target_pm);
            }
            Command::Home { axis: None } => heard.push_str("(home) "),
            Command::Home { axis: Some(axis) } => write!(heard, "(home {axis}) ").unwrap(),
            Command::Buzz { axis } => write!(heard, "(buzz {axis}) ").unwrap(),
            #[cfg(feature = "trinamic")]
            Command::MeasureStall { axis } => write!(heard, "(measure a stall of {axis}) ").unwrap(),
            Command::Unlock => heard.push_str("(unlock) "),
            Command::MeasureTool => heard.push_str("(measure the tool) "),
            Command::SetToolReference => heard.push_str("(tool reference) "),
            Command::ToggleCheck => heard.push_str("(check) "),
            Command::Sleep => heard.push_str("(sleep) "),
            Command::Boot => heard.push_str("(boot) "),
            Command::Prove { words } => write!(heard, "(prove {words}) ").unwrap(),
            #[cfg(feature = "trinamic")]
            Command::ShowDrivers => heard.push_str("(drivers) "),
            Command::ShowVfd => heard.push_str("(vfd) "),
            Command::Help => heard.push_str(report::HELP),
            Command::ShowBuild { is_extended } => {
                report::build(heard, build_text, is_extended).unwrap();
                if is_extended {
                    report::extended_build(heard, settings).unwrap();
                }
            }
            Command::DescribeSetting { number } => report::description(heard, number).unwrap(),
            Command::ShowCatalogue(catalogue) => {
                (0..catalogue.lines()).for_each(|line| catalogue.print(heard, line, settings).unwrap());
            }
            Command::SetBuild { text } => *build_text = text.try_into().unwrap(),
            Command::ShowSettings => report::settings(heard, settings).unwrap(),
            Command::ShowParameters => {
                (0..report::PARAMETERS).for_each(|line| report::parameter(heard, line, interpreter, settings).unwrap())
            }
            Command::ShowModal => report::modal(heard, interpreter, settings).unwrap(),
            Command::ShowStartup => {
                for (index, line) in startup.iter().enumerate() {
                    report::startup(heard, index, line).unwrap();
                }
            }
            Command::SetStartup { index, block, line } => {
                describe(heard, &block, interpreter);
                startup[index] = line.try_into().unwrap();
            }
            Command::Restore { settings, parameters } => {
                write!(heard, "(restore{}{}) ", if settings { " $" } else { "" }, if parameters { " #" } else { "" })
                    .unwrap();
                if settings {
                    self.settings = Settings::DEFAULT;
                }
                if parameters {
                    interpreter.set_coordinates(Coordinates::default());
                    *startup = Default::default();
                }
            }
            Command::ExplainError(error) => report::message(heard, error).unwrap(),
            Command::ExplainAlarm(alarm) => report::message(heard, alarm).unwrap(),
            Command::SetSetting { number, value } => match settings.with(number, value) {
                Ok(settings) => {
                    self.settings = settings;
                    if let Err(unfit) = settings.check(&carries) {
                        report::message(heard, Unfit(unfit)).unwrap();
                    }
                }
                Err(why) => {
                    report::message(heard, why).unwrap();
                    return report::error(heard, why.error()).unwrap();
                }
            },
        }
        self.heard.push_str(report::OK);
    }

    fn status(&mut self, write: fn(&mut StatusReporter, &mut String, &StatusReport, &Settings) -> std::fmt::Result) {
        let modal = self.interpreter.modal();
        let status = StatusReport {
            state: self.state,
            position_pm: self.interpreter.position_pm(),
            work_offset_pm: self.interpreter.work_offset_pm(),
            line_number: 0,
            feed_mm_min: 0.0,
            spindle_rpm: if modal.spindle == SpindleMode::Off { 0.0 } else { modal.speed_rpm },
            actual_rpm: None,
            spindle: modal.spindle,
            coolant: modal.coolant,
            probe_touched: self.probe_touched,
            limits_pressed: [false; AXES],
            second_limit_pressed: false,
            door_open: false,
            hold_pressed: false,
            start_pressed: false,
            drive_alarm: false,
            emergency_stop: self.emergency_stop,
            free_blocks: 15,
            free_bytes: 128,
            overrides: self.overrides,
            homed: [false; AXES],
            tool: self.interpreter.tool_in_spindle(),
            system: modal.system,
            has_tool_reference: false,
        };
        write(&mut self.reporter, &mut self.heard, &status, &self.settings).unwrap();
    }
}

/// A place in mm.
pub fn in_mm(place_pm: [i64; AXES]) -> [f64; AXES] {
    place_pm.map(length::to_mm)
}

fn describe(heard: &mut String, block: &Block, interpreter: &Interpreter) {
    if block.line_number > 0 {
        write!(heard, "(N{}) ", block.line_number).unwrap();
    }
    if let Some(tool) = block.tool_change {
        write!(heard, "(tool {tool}) ").unwrap();
    }
    let switches = [
        (block.switches_spindle, "(spindle) "),
        (block.changes_speed, "(speed) "),
        (block.switches_coolant, "(coolant) "),
    ];
    switches.into_iter().filter(|(switches, _)| *switches).for_each(|(_, name)| heard.push_str(name));
    if let Some(seconds) = block.dwell_s {
        write!(heard, "(wait {seconds} s) ").unwrap();
    }
    if let Some(via_pm) = block.via_pm {
        write!(heard, "(via {:?}) ", in_mm(via_pm)).unwrap();
    }
    match block.motion {
        Some(BlockMove { target_pm, rate: Rate::Rapid, .. }) => {
            write!(heard, "(rapid {:?}) ", in_mm(target_pm)).unwrap()
        }
        Some(BlockMove { target_pm, rate: Rate::Feed { mm_min }, arc: None, .. }) => {
            write!(heard, "(feed {mm_min} {:?}) ", in_mm(target_pm)).unwrap();
        }
        Some(BlockMove { target_pm, rate: Rate::Feed { mm_min }, arc: Some(arc), .. }) => {
            let bounds_mm = arc.bounds_mm().map(|[least, most]| format!("{least:.3}..{most:.3}")).join(" ");
            let (length_mm, target_mm) = (arc.length_mm(), in_mm(target_pm));
            write!(heard, "(arc {mm_min:.1} {target_mm:?} of {length_mm:.3} in {bounds_mm}) ").unwrap();
        }
        None => {}
    }
    if block.drills {
        interpreter.cycle().parts().for_each(|part| describe_part(heard, part));
    }
    if let Some(Probe { target_pm, mm_min, away, must }) = block.probe {
        let (way, or) = (if away { "away" } else { "toward" }, if must { " or alarm" } else { "" });
        write!(heard, "(probe {way}{or} {mm_min} {:?}) ", in_mm(target_pm)).unwrap();
    }
    if block.motion.is_some_and(|motion| motion.path.stops()) {
        heard.push_str("(stop) ");
    }
    if block.pauses {
        heard.push_str("(pause) ");
    }
    if block.ends_program {
        heard.push_str("(end) ");
    }
}

/// A part of a cycle: `X1,2,3` for a rapid, `F100:1,2,3` for a feed, and `|` behind a move that ends in a stop.
fn describe_part(heard: &mut String, part: CyclePart) {
    match part {
        CyclePart::Move(BlockMove { target_pm, rate, path, .. }) => {
            let place = in_mm(target_pm).map(|mm| mm.to_string()).join(",");
            let rate = if let Rate::Feed { mm_min } = rate { format!("F{mm_min}:") } else { String::new() };
            write!(heard, "{rate}{place}{} ", if path.stops() { "|" } else { "" }).unwrap();
        }
        CyclePart::Dwell(seconds) => write!(heard, "(wait {seconds} s) ").unwrap(),
        CyclePart::SpindleOff => heard.push_str("(spindle off) "),
        CyclePart::SpindleOn => heard.push_str("(spindle on) "),
    }
}
