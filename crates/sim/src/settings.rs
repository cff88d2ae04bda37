//! Reads settings from a file of `$n=v` lines, as senders save them and as `$$` prints them.
//!
//! # Design
//! A line is interpreted as by the controller's console, including comments, spaces and upper case. Other lines that a
//! terminal captures with `$$` are skipped: its `ok`, the welcome, reports and messages. A value is checked against its
//! own range at its line. The rules between settings are checked at the end, as with settings from the flash, so the
//! lines may have any order.

use embassy_time::Duration;
use isostep_console::{Command, Conflict, Error, Interpreter, ReportedState, SettingError, Settings};
use isostep_motion::{AXES, Axis, Capabilities, DriverTiming};
use isostep_profile::Limits;

use crate::config::{Config, Port};
use crate::drive::Drive;

use crate::program;
use crate::sim::Sim;

/// The reason why a file of settings was refused. None of its settings is in force.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}{}: {reason}", .line.as_ref().map_or(String::new(), |(number, text)| format!(":{number}: `{text}`")))]
pub struct Refused {
    /// Name of the file.
    pub file: String,
    /// Line number, from 1, and its text; `None` if the reason is not a single line.
    pub line: Option<(usize, String)>,
    /// The value, the limit and the remedy.
    pub reason: Reason,
}

/// The fault of a file of settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    /// A value is not allowed.
    #[error(transparent)]
    Setting(SettingError),
    /// Values do not work together: the broken rule.
    #[error("{0}")]
    Conflict(String),
    /// The console does not understand the line.
    #[error("error:{code}: {0}", code = .0.code())]
    Line(Error),
    /// The line is not a setting.
    #[error("this is no setting: a file of settings has $n=v lines, such as $110=2880, and comments")]
    NoSetting,
    /// There is no setting in the file.
    #[error("there is no $n=v line in it: save what $$ prints, or write one such as $110=2880")]
    Empty,
}

/// The default machine with the settings of `text`, the contents of `file`. The machine is stepped by `port`, with
/// drivers that need `timing`.
///
/// # Errors
/// [`Refused`] with the first line that is not allowed.
pub fn read(file: &str, text: &[u8], port: Port, timing: DriverTiming) -> Result<Settings, Refused> {
    taken(file, text)?.end(capabilities(port, timing))
}

/// As [`read`], for a machine of which it is not known what its step ports carry.
///
/// # Errors
/// [`Refused`] with the first line that no machine allows.
pub fn read_for_any_port(file: &str, text: &[u8]) -> Result<Settings, Refused> {
    taken(file, text)?.end([None; AXES])
}

/// A text whose lines are each allowed.
fn taken<'f>(file: &'f str, text: &[u8]) -> Result<Reading<'f>, Refused> {
    let mut reading = Reading::new(file);
    for (number, line) in (1..).zip(lines(text)) {
        reading.take(number, &line)?;
    }
    Ok(reading)
}

/// The lines of a text, with any line ends.
pub fn lines(text: &[u8]) -> Vec<String> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    program::split(text).map(|line| String::from_utf8_lossy(line).trim().to_owned()).collect()
}

/// The capabilities that the ports of such a machine report once their tasks have run.
fn capabilities(port: Port, driver: DriverTiming) -> [Option<Capabilities>; AXES] {
    let mut sim = Sim::new(&Config { port, driver, keep_record: false, ..Config::default() });
    // At power-up, no task of a machine wakes another for ever.
    sim.run_for(Duration::from_micros(1)).expect("a machine at power-up comes to rest");
    sim.machine().capabilities()
}

/// A file, as far as it has been read.
struct Reading<'f> {
    file: &'f str,
    settings: Settings,
    /// The lines that set something: number, text, setting.
    taken: Vec<(usize, String, u16)>,
}

impl<'f> Reading<'f> {
    fn new(file: &'f str) -> Self {
        Self { file, settings: Settings::DEFAULT, taken: Vec::new() }
    }

    fn take(&mut self, number: usize, text: &str) -> Result<(), Refused> {
        let refused = |reason| Refused { file: self.file.to_owned(), line: Some((number, text.to_owned())), reason };
        match setting(text).map_err(refused)? {
            None => Ok(()),
            Some((setting, value)) => {
                let with = self.settings.with(setting, value);
                self.settings = with.map_err(|error| refused(Reason::Setting(error)))?;
                self.taken.push((number, text.to_owned(), setting));
                Ok(())
            }
        }
    }

    fn end(self, ports: [Option<Capabilities>; AXES]) -> Result<Settings, Refused> {
        let refused = |line, reason| Refused { file: self.file.to_owned(), line, reason };
        if self.taken.is_empty() {
            return Err(refused(None, Reason::Empty));
        }
        self.settings
            .check(&|pulse_us| isostep_controller::carries_steps_s(ports, pulse_us))
            .map_err(|conflict| refused(self.line_of(conflict), Reason::Conflict(conflict.to_string())))?;
        Ok(self.settings)
    }

    /// The last line that sets one of the settings that do not work together.
    fn line_of(&self, conflict: Conflict<'_>) -> Option<(usize, String)> {
        let last = self.taken.iter().rfind(|(_, _, setting)| conflict.numbers().any(|number| number == *setting));
        last.map(|(number, text, _)| (*number, text.clone()))
    }
}

/// The setting and value of a line; `None` if it sets nothing.
fn setting(text: &str) -> Result<Option<(u16, f32)>, Reason> {
    if text == "ok" || text == "$$" || text.starts_with(['<', '[']) || text.starts_with("Grbl ") {
        return Ok(None);
    }
    let line = program::stripped(text.as_bytes()).map_err(Reason::Line)?;
    if line.is_empty() {
        return Ok(None);
    }
    if !line.starts_with('$') {
        return Err(Reason::NoSetting);
    }
    match Interpreter::new().interpret(&line, ReportedState::Idle, &Settings::DEFAULT).map_err(Reason::Line)? {
        Command::SetSetting { number, value } => Ok(Some((number, value))),
        _ => Err(Reason::NoSetting),
    }
}

/// One text with figures for each axis whose limits its motor cannot reach.
pub fn beyond_motors(settings: &Settings, config: &Config) -> Vec<String> {
    let machine = isostep_controller::config(settings);
    let drives = config.mechanics(&machine).drives;
    let axes = Axis::ALL.into_iter().zip(drives).zip(machine.limits).zip(machine.steps_per_mm);
    axes.filter_map(|(((axis, drive), limits), steps_per_mm)| beyond(axis, &limits, &drive, steps_per_mm)).collect()
}

fn beyond(axis: Axis, limits: &Limits, drive: &Drive, steps_per_mm: f64) -> Option<String> {
    let [start, top] = [limits.start_speed_steps_s, limits.top_speed_steps_s].map(|speed| speed / steps_per_mm);
    let accel = limits.accel_steps_s2.max(limits.decel_steps_s2) / steps_per_mm;
    let spare = drive.accel_mm_s2(0.0).min(drive.spare_mm_s2(top)).max(0.0);
    let [accel_number, top_number, start_number] = [120, 110, 910].map(|number| number + axis as u16);
    if start > drive.jump_mm_s() {
        return Some(format!(
            "{axis}: {start:.0} mm/s (${start_number}) are above the {:.0} mm/s at which the motor starts at once: \
             lower the start speed, or give a stronger motor",
            drive.jump_mm_s()
        ));
    }
    (accel > spare).then(|| {
        format!(
            "{axis}: {accel:.0} mm/s2 (${accel_number}) up to {top:.0} mm/s (${top_number}) are above the {spare:.0} mm/s2 \
             that the motor has for that: lower one of them, or give a stronger motor"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Settings, String> {
        super::read("my.txt", text.as_bytes(), Port::Pio, DriverTiming::DRV8825).map_err(|refused| refused.to_string())
    }

    fn refusal(text: &str) -> String {
        read(text).unwrap_err()
    }

    #[test]
    fn what_senders_save_is_read() {
        let text = "\u{feff}; a small mill\r\n\r\n$100 = 80.5 (x, step/mm)\r\n(speeds)\n$110=6000 ; mm/min\n$120=500.000\rok\n";
        let settings = read(text).unwrap();
        let expected = Settings {
            steps_per_mm: [80.5, 50.0, 50.0],
            max_rate_mm_min: [6000.0, 2880.0, 2880.0],
            accel_mm_s2: [500.0, 50.0, 50.0],
            ..Settings::DEFAULT
        };
        assert_eq!(settings, expected);
    }

    #[test]
    fn what_the_console_lists_is_read_back() {
        let mut sim = Sim::new(&Config::default());
        sim.send(b"$20=0\n$101=160\n$121=123.5\n$940=1\n$$\n");
        sim.run_until_idle().unwrap();
        let caught = sim.replies().join("\r\n");
        let settings = read(&caught).unwrap();
        assert_eq!(settings.get(101), Some(160.0));
        assert_eq!((settings.get(121), settings.get(20), settings.get(940)), (Some(123.5), Some(0.0), Some(1.0)));
    }

    #[test]
    fn the_order_does_not_matter() {
        assert!(read("$940=3\n$910=120\n$911=120\n$912=120\n").is_ok());
        let settings = read("$100=10000\n$110=600\n").unwrap();
        assert_eq!(settings.steps_per_mm[0], 10_000.0);
        assert!(!read("$22=0").unwrap().soft_limits);
    }

    #[test]
    fn what_cannot_be_is_refused_with_its_line_the_limit_and_the_remedy() {
        let reported = "my.txt:2: `$130=20000`: $130=20000 is above the most, 10000 mm: lower it";
        assert_eq!(refusal("$100=80\n$130=20000\n"), reported);
        assert_eq!(refusal("$100=80\r\r\n$130=20000\r\r\n"), reported, "whatever ends the lines");
        assert_eq!(refusal("$999=1"), "my.txt:1: `$999=1`: there is no $999: $$ lists the settings");
        assert_eq!(
            refusal("$100=400\n$110=60000 (fast)\n$120=100\n"),
            "my.txt:2: `$110=60000 (fast)`: $110=60000 is above the 37202 mm/min that the step outputs carry with $0=2 at $100=400 \
             steps/mm: lower one of the three"
        );
        assert_eq!(
            refusal("$27=30\n$130=30\n$131=40\n"),
            "my.txt:2: `$130=30`: $27=30 is not below the travel of X, $130=30 mm: lower $27 or raise $130"
        );
        assert_eq!(
            read("$27=100\n$130=200\n$132=200\n").unwrap().homing_pull_off_mm,
            100.0,
            "another line puts it right"
        );
        assert!(refusal("$22=0\n$20=1").starts_with("my.txt:2: `$20=1`: $20=1 needs a machine that homes"));
        assert!(refusal("$100=80\nG0 X1\n").starts_with("my.txt:2: `G0 X1`: this is no setting"));
        assert!(refusal("$H").contains("this is no setting"));
        assert!(refusal("$100=1e3").starts_with("my.txt:1: `$100=1e3`: error:2: A value is missing"));
        assert!(refusal("; nothing\n").starts_with("my.txt: there is no $n=v line in it"));
    }

    #[test]
    fn a_motor_that_is_too_weak_is_reported_with_the_numbers() {
        let beyond = |settings| beyond_motors(&settings, &Config::default());
        assert_eq!(beyond(Settings::DEFAULT), [""; 0]);
        let words = "Y: 9000 mm/s2 ($121) up to 800 mm/s ($111) are above the 3471 mm/s2 that the motor has for that: lower \
                     one of them, or give a stronger motor";
        assert_eq!(beyond(read("$101=80\n$111=48000\n$121=9000").unwrap()), [words]);
        assert_eq!(beyond(read("$101=80\n$111=6000\n$121=9000").unwrap()), [""; 0]);
        let reported = beyond(read("$100=20\n$110=12000\n$910=9000").unwrap());
        assert!(reported[0].starts_with("X: 150 mm/s ($910) are above the "), "{reported:?}");
    }
}
