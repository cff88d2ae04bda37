//! A simulated machine beside the model, and what is compared.

use crate::axes::xyz_a;
use embassy_time::Duration;
use isostep_console::Settings;
use isostep_motion::{AXES, State as MachineState};
use isostep_sim::drive::Load;
use isostep_sim::{Config, Flash, Sim};
use oorandom::Rand64;

use super::line::{Asked, Line};
use super::machine::{Model, Place, State};
use super::program::{Author, Item, Room};
use super::report::{self, Report};
use super::settings::SettingValues;
use super::words::ONE;

/// Whole numbers of angstroms fit into their steps.
const STEPS_PER_MM: [f32; 7] = [40.0, 50.0, 80.0, 100.0, 160.0, 200.0, 400.0];
/// The distance from a place at which the carriages may stand, besides half a step: `f32` has this error there.
const ROUNDING_ANGSTROM: i64 = ONE / 5_000;
/// The distance that the carriages keep from the ends of the travel where no soft limits bar the way.
const MARGIN_MM: f64 = 1.0;
const RESET: u8 = 0x18;
/// The load of each motor: it follows whatever is asked. Homing stops from the seek speed at once, and where a heavy carriage
/// overshoots, its switch may stay closed; but that is a matter of mechanics, not of the dialect.
const LIGHT: Load = Load { mm_per_rev: 40.0, mass_kg: 0.1, turning_kg_m2: 0.0 };

/// A difference between the machine and the model.
pub type Difference = String;

/// A machine, and the model of it.
pub struct Bench {
    sim: Sim,
    config: Config,
    flash: Flash,
    model: Model,
    /// The settings of the first power-up.
    first: SettingValues,
    /// The bytes that have been sent and received.
    said: Vec<String>,
    last: Report,
}

/// Runs the program of a seed.
///
/// # Errors
/// The first difference, with what was sent and heard before it.
pub fn run(seed: u64) -> Result<(), String> {
    let mut random = Rand64::new(seed.into());
    let is_default = random.rand_range(0..3) == 0;
    let mut settings = Settings { accel_mm_s2: [500.0; AXES], max_rate_mm_min: [6_000.0; AXES], ..Settings::DEFAULT };
    settings.homing_seek_mm_min = 3_000.0;
    settings.jerk_or_0_mm_s3 = [0.0; AXES];
    settings.travel_mm = xyz_a([120.0, 100.0, 80.0], 0.0);
    if is_default {
        settings = Settings::DEFAULT;
    } else {
        let mut choose = || STEPS_PER_MM[random.rand_range(0..STEPS_PER_MM.len() as u64) as usize];
        settings.steps_per_mm = xyz_a([choose(), choose(), choose()], STEPS_PER_MM[0]);
    }
    let start_mm = xyz_a([20.0, 30.0, 25.0], 25.0);
    let loads = [Some(LIGHT); AXES];
    let config = Config { settings, start_mm, seed, loads, keep_record: false, bounce_us: 0, ..Config::default() };
    let mut bench = Bench::new(config);
    let mut author = Author::new(random, is_default);
    (0..40).try_for_each(|_| bench.next(&mut author)).map_err(|difference| {
        let said = bench.said[bench.said.len().saturating_sub(60)..].join("\n");
        format!("{said}\n{difference}\nmodel: {:?}", bench.model)
    })
}

impl Bench {
    fn new(config: Config) -> Self {
        let flash = Flash::blank();
        let sim = Sim::with_flash(&config, flash.clone());
        let model = Model::new(SettingValues::from_listing(&[]));
        let first = model.settings.clone();
        let mut bench = Self { sim, config, flash, model, first, said: Vec::new(), last: Report::default() };
        let _ = bench.settle();
        bench.first = SettingValues::from_listing(&bench.ask("$$"));
        bench.model.settings = bench.first.clone();
        bench
    }

    fn next(&mut self, author: &mut Author) -> Result<(), Difference> {
        let room = self.room();
        let item = author.next(&self.model, &room);
        (self.model.on_steps, self.model.prompt, self.model.waits) = (false, None, 0);
        self.model.path = vec![self.model.carriage];
        match &item {
            Item::PowerCycle => self.power_cycle()?,
            Item::Byte(RESET) => self.reset()?,
            Item::Byte(byte) => self.byte(*byte)?,
            Item::Lines(lines, bytes) => self.lines(lines, bytes)?,
        }
        self.compare()
    }

    fn note(&mut self, text: impl Into<String>) {
        self.said.push(text.into());
    }

    /// Takes what the machine has said.
    fn hear(&mut self) -> Vec<String> {
        let heard = self.sim.replies();
        self.note(format!("  {heard:?}"));
        self.last.read(&heard);
        heard
    }

    /// Runs the machine to its rest and returns what it says.
    fn settle(&mut self) -> Vec<String> {
        let ran = self.sim.run_until_idle();
        let heard = self.hear();
        if let Err(error) = ran {
            self.note(format!("  {error}"));
        }
        heard
    }

    /// The answer of the machine to a line that asks.
    fn ask(&mut self, line: &str) -> Vec<String> {
        self.sim.send(format!("{line}\n").as_bytes());
        let _ = self.sim.run_until_idle();
        self.sim.replies()
    }

    /// The range into which each axis may be sent. The carriages are where the simulated world has them.
    fn room(&self) -> Room {
        let (places, steps) = (self.sim.places_steps(), self.sim.machine().position_steps());
        std::array::from_fn(|axis| {
            let angstrom = |mm: f64| (mm * ONE as f64) as i64;
            let travel_mm = self.model.settings.get(130 + axis as u16);
            if self.model.homed[axis] {
                return (0, angstrom(travel_mm));
            }
            let zero_mm = f64::from(places[axis] - steps[axis]) / f64::from(self.steps_per_mm(axis));
            (angstrom(MARGIN_MM - zero_mm), angstrom(travel_mm - MARGIN_MM - zero_mm))
        })
    }

    fn steps_per_mm(&self, axis: usize) -> f32 {
        self.model.settings.get(100 + axis as u16) as f32
    }

    fn power_cycle(&mut self) -> Result<(), Difference> {
        self.note("power cycle");
        let places = self.sim.places_steps();
        self.config.start_mm = std::array::from_fn(|axis| f64::from(places[axis]) / f64::from(self.steps_per_mm(axis)));
        self.sim = Sim::with_flash(&self.config, self.flash.clone());
        self.last = Report::default();
        let expected = self.model.power_cycle();
        let heard = self.settle();
        self.answers(&heard, &expected)?;
        let listed = SettingValues::from_listing(&self.ask("$$"));
        if !listed.is_about(&self.model.settings) {
            return Err(format!("settings after a power cycle: {listed:?}"));
        }
        let mut expected: Vec<_> =
            (0..2).map(|index| format!("$N{index}={}", self.model.startup[index].text)).collect();
        expected.push("ok".to_owned());
        let heard = self.ask("$N");
        self.answers(&heard, &expected)?;
        let build = self.ask("$I");
        if !self.model.build.is_empty() && !build[0].ends_with(&format!(":{}]", self.model.build)) {
            return Err(format!("{build:?} after a power cycle"));
        }
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Difference> {
        self.note("reset at rest");
        let expected = self.model.reset();
        self.sim.send(&[RESET]);
        let heard = self.settle();
        self.answers(&heard, &expected)
    }

    fn byte(&mut self, byte: u8) -> Result<(), Difference> {
        self.note(format!("byte {byte:#x} at rest"));
        self.model.byte(byte, true);
        self.sim.send(&[byte]);
        let heard = self.settle();
        self.answers(&heard, &[])
    }

    fn lines(&mut self, lines: &[Line], bytes: &[(u64, u8)]) -> Result<(), Difference> {
        let packet: String = lines.iter().map(|line| format!("{}\n", line.text)).collect();
        self.note(format!("{packet:?} {bytes:x?}"));
        let mut expected = Vec::new();
        let mut alarms = Vec::new();
        let before = self.model.clone();
        for line in lines {
            let was = self.model.state;
            let waits = self.model.waits;
            expected.extend(self.model.line(line));
            self.model.waits += if matches!(line.asked, Asked::Block(_)) { 0 } else { waits };
            match self.model.state {
                State::Alarm(code) if was != self.model.state => alarms.push(format!("ALARM:{code}")),
                _ => {}
            }
        }
        self.sim.send(packet.as_bytes());
        let mut heard = Vec::new();
        for &(ms, byte) in bytes {
            self.sim.run_for(Duration::from_millis(ms)).map_err(|error| error.to_string())?;
            if byte == b'~' {
                // Before a hold has come to rest it does nothing.
                let is_over = |state| state != (MachineState::Hold { still: false });
                self.sim.run_until_state(is_over).map_err(|error| error.to_string())?;
            }
            heard.extend(self.hear());
            if byte == RESET || cancels(byte, lines) {
                return self.cut_short(byte, &before, lines);
            }
            self.model.byte(byte, false);
            self.sim.send(&[byte]);
        }
        heard.extend(self.settle());
        let waits = self.model.waits;
        for wait in 0..waits {
            if self.sim.machine().state() != (MachineState::Hold { still: true }) {
                return Err(format!("it does not wait for the {}. ~ of {waits}", wait + 1));
            }
            self.sim.send(b"~");
            heard.extend(self.settle());
        }
        if let Some(tool) = self.model.prompt
            && !heard
                .iter()
                .any(|line| line.starts_with("[MSG:M6") && (tool == 0 || line.contains(&format!("tool {tool},"))))
        {
            return Err(format!("no prompt for tool {tool}: {heard:?}"));
        }
        if matches!(lines[0].asked, Asked::Restore('$')) && expected[0] == "ok" {
            self.model.settings = self.first.clone();
        }
        let said_alarms: Vec<_> = heard.iter().filter(|line| line.starts_with("ALARM")).cloned().collect();
        if said_alarms != alarms {
            return Err(format!("alarms {said_alarms:?}, {alarms:?} expected"));
        }
        self.answers(&heard, &expected)
    }

    /// A reset or a jog's cancel comes while lines move the machine. It then stands on their path.
    fn cut_short(&mut self, byte: u8, before: &Model, lines: &[Line]) -> Result<(), Difference> {
        let path = std::mem::take(&mut self.model.path);
        self.sim.send(&[byte]);
        let mut heard = self.settle();
        if byte == b'!' {
            // Where no jog was under way any more it is a hold.
            self.sim.send(b"~");
            heard.extend(self.settle());
        }
        let mut after = before.clone();
        let mut expected = Vec::new();
        if byte == RESET {
            expected = after.reset();
        }
        if byte != RESET && path.len() == 1 {
            // The jog was refused: all is as before.
            return self.answers(&heard, &[]);
        }
        self.model = after;
        let is_alarm = heard.iter().any(|line| line.starts_with("ALARM:2"));
        if is_alarm {
            self.model.lock(2);
            expected.truncate(1);
        }
        let from = heard.iter().position(|line| Some(line) == expected.first()).unwrap_or(0);
        if heard[..from].iter().filter(|line| is_answer(line)).count() > lines.len() {
            return Err(format!("more answers than lines: {heard:?}"));
        }
        if byte == RESET {
            self.answers(&heard[from..], &expected)?;
        }
        let here = self.carriage();
        if !path.windows(2).any(|ends| self.is_between(here, ends[0], ends[1])) && path.len() > 1 {
            return Err(format!("it stands at {here:?}, not on the way {path:?}"));
        }
        (self.model.carriage, self.model.position) = (here, here);
        if let Some(&target) = path.last().filter(|&&target| byte != RESET && self.is_at(target)) {
            // The jog had come to its end.
            (self.model.carriage, self.model.position) = (target, target);
        }
        Ok(())
    }

    /// True if the machine stands at a place, within half a step.
    fn is_at(&self, place: Place) -> bool {
        let tolerance = |axis: usize| ONE / self.steps_per_mm(axis) as i64 / 2 + ROUNDING_ANGSTROM;
        self.carriage().iter().zip(place).enumerate().all(|(axis, (at, to))| (at - to).abs() <= tolerance(axis))
    }

    /// True if a place is on the straight line between two others, within a step.
    fn is_between(&self, here: Place, from: Place, to: Place) -> bool {
        // The parts of the line on which each axis would be where it is.
        let (mut least, mut most) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let step = ONE as f64 / f64::from(self.steps_per_mm(axis));
            let (length, gone) = ((to[axis] - from[axis]) as f64, (here[axis] - from[axis]) as f64);
            let ends = [(gone - step) / length, (gone + step) / length];
            if length == 0.0 && gone.abs() > step {
                return false;
            }
            if length != 0.0 {
                least = least.max(ends[0].min(ends[1]));
                most = most.min(ends[0].max(ends[1]));
            }
        }
        least <= most
    }

    /// The place that the machine reports, from its count of steps.
    fn carriage(&self) -> Place {
        let steps = self.sim.machine().position_steps();
        std::array::from_fn(|axis| i64::from(steps[axis]) * ONE / self.steps_per_mm(axis) as i64)
    }

    /// Compares answers; messages, alarms and results of probes are left out.
    fn answers(&mut self, heard: &[String], expected: &[String]) -> Result<(), Difference> {
        let is_said = |line: &&String| !["[", "ALARM", "<"].iter().any(|begins| line.starts_with(begins));
        let heard: Vec<_> = heard.iter().filter(is_said).collect();
        if heard == expected.iter().collect::<Vec<_>>() {
            Ok(())
        } else {
            Err(format!("answered {heard:?}, {expected:?} expected"))
        }
    }

    /// Compares all that the machine reports at rest.
    fn compare(&mut self) -> Result<(), Difference> {
        self.compare_carriage()?;
        for _ in 0..2 {
            self.sim.send(b"?");
            self.sim.run_for(Duration::from_millis(1)).map_err(|error| error.to_string())?;
            let heard = self.sim.replies();
            self.last.read(&heard);
        }
        report::compare(&self.last, &self.model)?;
        let modal = self.ask("$G");
        report::compare_modes(&modal, &self.model)?;
        if self.model.state != State::Check {
            let listed = self.ask("$#");
            report::compare_parameters(&listed, &self.model)?;
        }
        Ok(())
    }

    fn compare_carriage(&mut self) -> Result<(), Difference> {
        let here = self.carriage();
        if self.sim.counted_steps() != self.sim.machine().position_steps() {
            return Err(format!("{:?} steps left the pins", self.sim.counted_steps()));
        }
        if !self.is_at(self.model.carriage) {
            return Err(format!("it stands at {here:?}, not at {:?}", self.model.carriage));
        }
        if self.model.on_steps {
            (self.model.carriage, self.model.position) = (here, here);
        }
        Ok(())
    }
}

/// True if the byte ends a jog on its way.
fn cancels(byte: u8, lines: &[Line]) -> bool {
    matches!(byte, 0x85 | b'!') && lines.iter().any(|line| matches!(line.asked, Asked::Jog(_)))
}

fn is_answer(line: &str) -> bool {
    line == "ok" || line.starts_with("error:")
}
