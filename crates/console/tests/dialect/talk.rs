//! A machine that carries out every command at once and says so, to read dialogues by.

use std::fmt::Write as _;

use isostep_console::{
    Block, Command, Interpreter, LineAssembler, Motion, Rate, Realtime, Settings, State, Status, StatusReporter,
    realtime, report,
};

/// The port of this machine carries 30,000 steps/s, or a pulse and a pause as long.
pub fn carries(pulse_us: u16) -> f32 {
    (1e6 / (2.0 * f32::from(pulse_us))).min(30_000.0)
}

pub struct Talk {
    lines: LineAssembler,
    pub interpreter: Interpreter,
    pub settings: Settings,
    pub state: State,
    reporter: StatusReporter,
    heard: String,
}

impl Talk {
    pub fn new(state: State) -> Self {
        Self {
            lines: LineAssembler::new(),
            interpreter: Interpreter::new(),
            settings: Settings::DEFAULT,
            state,
            reporter: StatusReporter::new(),
            heard: String::new(),
        }
    }

    /// Sends the text and gives everything heard for it, one `sent -> heard` a line.
    pub fn send(&mut self, text: &str) -> String {
        text.lines().map(|line| format!("{line} -> {}\n", self.bytes(format!("{line}\n").as_bytes()))).collect()
    }

    /// Sends bytes; gives the replies on one line.
    pub fn bytes(&mut self, bytes: &[u8]) -> String {
        self.heard.clear();
        for &byte in bytes {
            match realtime::classify(byte) {
                Some(Realtime::Status) => self.status(),
                Some(_) => {}
                None => self.byte(byte),
            }
        }
        self.heard.trim_end().replace("\r\n", " ")
    }

    fn byte(&mut self, byte: u8) {
        let Self { lines, interpreter, settings, state, .. } = self;
        let Some(line) = lines.push(byte) else { return };
        match line.and_then(|line| interpreter.interpret(line, *state, settings)) {
            Ok(command) => self.carry_out(command),
            Err(error) => report::error(&mut self.heard, error).unwrap(),
        }
    }

    fn carry_out(&mut self, command: Command) {
        let heard = &mut self.heard;
        match command {
            Command::Block(block) => describe(heard, &block),
            Command::Home => heard.push_str("(home) "),
            Command::Unlock => heard.push_str("(unlock) "),
            Command::Help => heard.push_str(report::HELP),
            Command::ShowBuild => heard.push_str(report::BUILD),
            Command::ShowSettings => report::settings(heard, &self.settings).unwrap(),
            Command::ShowModal => {
                report::modal(heard, self.interpreter.modal(), self.settings.report_inches).unwrap();
            }
            Command::SetSetting { number, value } => match self.settings.with(number, value, &carries) {
                Ok(settings) => self.settings = settings,
                Err(why) => {
                    report::message(heard, why).unwrap();
                    return report::error(heard, why.error()).unwrap();
                }
            },
        }
        heard.push_str(report::OK);
    }

    fn status(&mut self) {
        let status = Status {
            state: self.state,
            position_mm: self.interpreter.position_mm(),
            feed_mm_min: 0.0,
            limits_pressed: [false; 3],
            free_blocks: 15,
            free_bytes: 128,
        };
        self.reporter.write(&mut self.heard, &status, &self.settings).unwrap();
    }
}

fn describe(heard: &mut String, block: &Block) {
    if let Some(seconds) = block.dwell_s {
        write!(heard, "(wait {seconds} s) ").unwrap();
    }
    match block.motion {
        Some(Motion::Move { target_mm, rate: Rate::Rapid }) => write!(heard, "(rapid {target_mm:?}) ").unwrap(),
        Some(Motion::Move { target_mm, rate: Rate::Feed { mm_min } }) => {
            write!(heard, "(feed {mm_min} {target_mm:?}) ").unwrap();
        }
        Some(Motion::GoHome { via_mm, target_mm }) => write!(heard, "(home {target_mm:?} via {via_mm:?}) ").unwrap(),
        None => {}
    }
    if block.ends_program {
        heard.push_str("(end) ");
    }
}
