//! A board in memory: it answers the proving image's lines, makes moves as they are compiled, and stamps their edges.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Result, bail};
use isostep_console::Settings;

use super::super::Link;
use super::super::stamped::PADS;
use crate::chip::Chip;
use crate::measure::planned_move::NAMES;
use crate::measure::{Machine, PlannedMove};

/// Stamps that are kept of a pad.
pub const WINDOW: usize = 1_000;
/// The port makes no more than this, steps/s.
const RATE_MAX_STEPS_S: f64 = 2_000_000.0;
/// From a line to the first edge of its move, s; and how long a line takes.
const START_S: f64 = 0.012_345;
const LINE_S: f64 = 0.000_3;
/// From an input to the last edge, s.
const STOPPING_S: f64 = 3.4e-6;
/// The chip's clock is so much faster than the frames of USB.
const FAST: f64 = 20e-6;

/// The chip and the faults of the board.
#[derive(Clone, Debug, Default)]
pub struct Faults {
    /// Its chip.
    pub chip: Chip,
    /// Inputs that the wire from GP28 goes to.
    pub wires: Vec<u8>,
    /// An edge of this axis, with this number in its move, comes so many cycles later.
    pub shifted: Option<(usize, u32, i64)>,
    /// An edge that does not come.
    pub lost: Option<(usize, u32)>,
    /// The stampers lose stamps.
    pub stampers_lose: bool,
    /// A top speed above this is refused, steps/s.
    pub rate_max: Option<f64>,
    /// It is an image that knows nothing of proving.
    pub is_old: bool,
    /// It answers nothing.
    pub is_silent: bool,
    /// It is unplugged after so many lines.
    pub unplugged_after: Option<u32>,
    /// After so many lines somebody interrupts.
    pub interrupts: Option<(u32, Arc<AtomicBool>)>,
}

/// The board.
pub struct Fake {
    faults: Faults,
    settings: Settings,
    said: VecDeque<String>,
    partial: String,
    lines: u32,
    now_s: f64,
    /// Steps of X, Y and Z when the machine rests.
    place_steps: [i64; 3],
    run: Option<Run>,
    alarm: Option<&'static str>,
    armed: Option<Armed>,
    /// When GP28 falls.
    falls_s: Option<f64>,
    is_low: bool,
    braking_since_s: Option<f64>,
    resets: u32,
    stops: Vec<Stopped>,
}

/// A stop while stampers were armed.
#[derive(Clone, Copy, Debug)]
pub struct Stopped {
    /// Edges that the stampers of an axis were to skip.
    pub skip: u32,
    /// Edges of each axis before it.
    pub made: u32,
    /// From the input to the last of them, us; negative if it came before.
    pub latency_us: f64,
}

/// A move under way.
struct Run {
    chip: Chip,
    begin_s: f64,
    planned: PlannedMove,
    /// No edge comes after this.
    stop_s: f64,
}

struct Armed {
    since_s: f64,
    pads: [u8; 3],
    skip: u32,
    /// Cycles of each pad's edges from the marker.
    cycles: BTreeMap<u8, Vec<u64>>,
}

impl Fake {
    pub fn new(faults: Faults) -> Self {
        Self {
            faults,
            settings: Settings::default(),
            said: VecDeque::new(),
            partial: String::new(),
            lines: 0,
            now_s: 1.0,
            place_steps: [0; 3],
            run: None,
            alarm: None,
            armed: None,
            falls_s: None,
            is_low: false,
            braking_since_s: None,
            resets: 0,
            stops: Vec::new(),
        }
    }

    /// The number of reset bytes that have come.
    pub fn resets(&self) -> u32 {
        self.resets
    }

    /// Its stops, in order.
    pub fn stops(&self) -> &[Stopped] {
        &self.stops
    }

    pub fn is_at_rest(&self) -> bool {
        self.run.is_none()
    }

    pub fn has_defaults(&self) -> bool {
        self.settings == Settings::default()
    }

    fn say(&mut self, line: impl Into<String>) {
        self.said.push_back(line.into());
    }

    /// Lets happen what is due up to now.
    fn look(&mut self) {
        let now_s = self.now_s;
        if let Some(falls_s) = self.falls_s.filter(|falls_s| *falls_s <= now_s) {
            self.falls_s = None;
            self.fall(falls_s);
        }
        if self.run.as_ref().is_some_and(|run| run.end_s() <= now_s) {
            self.end();
        }
    }

    fn fall(&mut self, at_s: f64) {
        self.is_low = true;
        if let Some(armed) = &mut self.armed {
            armed
                .cycles
                .entry(28)
                .or_default()
                .push(((at_s - armed.since_s) * f64::from(self.faults.chip.clock_hz())) as u64);
        }
        let is_wired = |pad: u8| self.faults.wires.contains(&pad) && (pad != 9 || self.settings.hard_limits);
        let alarm = if is_wired(12) { "ALARM:10" } else { "ALARM:1" };
        if (is_wired(9) || is_wired(12)) && self.run.is_some() && self.braking_since_s.is_none() {
            self.stop(at_s, alarm);
        }
    }

    fn stop(&mut self, at_s: f64, alarm: &'static str) {
        if let Some(run) = &mut self.run {
            run.stop_s = at_s + STOPPING_S;
            let made = run.made(0).count() as u32;
            let latency_us = 1e6 * (run.at_s(0, made.max(1)) - at_s);
            let skip = self.armed.as_ref().map_or(0, |armed| armed.skip);
            self.stops.push(Stopped { skip, made, latency_us });
        }
        self.end();
        self.alarm = Some(alarm);
        self.say(alarm);
    }

    /// Makes the edges of the move that is over.
    fn end(&mut self) {
        let Some(run) = self.run.take() else { return };
        self.braking_since_s = None;
        let clock_hz = f64::from(self.faults.chip.clock_hz());
        for (axis, pad) in PADS.into_iter().enumerate() {
            let made: Vec<u32> = run.made(axis).collect();
            self.place_steps[axis] += i64::from(run.planned.steps[axis].signum()) * made.len() as i64;
            let Some(armed) = &mut self.armed else { continue };
            let cycles = armed.cycles.entry(pad).or_default();
            for number in made {
                if self.faults.lost == Some((axis, number)) {
                    continue;
                }
                let cycle = ((run.at_s(axis, number) - armed.since_s) * clock_hz).round() as i64;
                let late = self
                    .faults
                    .shifted
                    .filter(|(of, nth, _)| (*of, *nth) == (axis, number))
                    .map_or(0, |(_, _, late)| late);
                cycles.push((cycle + late) as u64);
            }
        }
    }

    fn byte_at_once(&mut self, byte: u8) {
        match byte {
            b'?' => {
                let state = match (&self.run, self.alarm) {
                    (Some(_), _) => "Run",
                    (None, Some(_)) => "Alarm",
                    (None, None) => "Idle",
                };
                let [x, y, z] = self.place_steps.map(|steps| steps as f64 / f64::from(self.settings.steps_per_mm[0]));
                self.say(format!("<{state}|MPos:{x:.3},{y:.3},{z:.3}|FS:0,0>"));
            }
            _ => {
                self.resets += 1;
                self.reset();
            }
        }
    }

    /// The first has the machine brake, which lasts; the second stops it, and pulls GP28 down.
    fn reset(&mut self) {
        self.partial.clear();
        if self.braking_since_s.is_some() && self.run.is_some() {
            self.fall(self.now_s);
            self.stop(self.now_s, "ALARM:3");
        } else if self.run.is_some() {
            self.braking_since_s = Some(self.now_s);
            self.fall(self.now_s);
            return;
        }
        self.say("Grbl 1.1h ['$' for help]");
    }

    fn line(&mut self, line: &str) {
        self.lines += 1;
        if let Some((lines, interrupted)) = &self.faults.interrupts
            && *lines == self.lines
        {
            interrupted.store(true, Ordering::Relaxed);
        }
        self.now_s += LINE_S;
        self.look();
        let answer = self.carried_out(line);
        self.say(if answer { "ok" } else { "error:3" });
    }

    fn carried_out(&mut self, line: &str) -> bool {
        if let Some(rest) = line.strip_prefix("$PROVE") {
            return !self.faults.is_old && self.prove(rest);
        }
        match line {
            "$X" => self.alarm = None,
            "$$" => {
                for (number, value) in numbers(&self.settings) {
                    self.say(format!("${number}={value}"));
                }
            }
            _ if line.starts_with('$') => return self.set(line),
            _ if line.contains("G91") => return self.begin(line),
            _ => {}
        }
        true
    }

    fn set(&mut self, line: &str) -> bool {
        let Some((number, value)) = line[1..].split_once('=') else { return false };
        let (Ok(number), Ok(value)) = (number.parse(), value.parse()) else { return false };
        let rate_max = self.faults.rate_max.unwrap_or(RATE_MAX_STEPS_S);
        let mut settings = self.settings;
        if !settings.set(number, value) {
            return false;
        }
        let is_too_fast = (110..113).contains(&number)
            && f64::from(value) / 60.0 * f64::from(settings.steps_per_mm[usize::from(number - 110)])
                > rate_max * 1.000_001;
        if !is_too_fast {
            self.settings = settings;
        }
        !is_too_fast
    }

    fn begin(&mut self, line: &str) -> bool {
        if self.alarm.is_some() {
            return false;
        }
        let word =
            |letter: char| line.split_whitespace().find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
        let steps = std::array::from_fn(|axis| {
            let mm = NAMES[axis].chars().next().and_then(word).unwrap_or(0.0);
            (mm * f64::from(self.settings.steps_per_mm[axis])).round() as i32
        });
        // Starts are on a cycle.
        let clock_hz = f64::from(self.faults.chip.clock_hz());
        let begin_s = ((self.now_s + START_S) * clock_hz).round() / clock_hz;
        let planned = Machine::from(self.settings).planned(steps).unwrap();
        self.run = Some(Run { chip: self.faults.chip, begin_s, planned, stop_s: f64::INFINITY });
        true
    }

    fn prove(&mut self, rest: &str) -> bool {
        let (word, numbers) =
            rest.trim_start_matches('=').split_once(',').unwrap_or((rest.trim_start_matches('='), ""));
        let numbers: Vec<u32> = numbers.split(',').filter_map(|number| number.parse().ok()).collect();
        match (word, numbers.as_slice()) {
            ("", _) => {
                for line in [
                    "[PROVE:1]",
                    "[ID:E660583883724B2F]",
                    match self.faults.chip {
                        Chip::Rp2040 => "[CHIP:20002927,3]",
                        Chip::Rp2350 => "[CHIP:20004927,2]",
                    },
                    "[PORT:PIO]",
                    "[WINDOW:1000]",
                    "[READY:345678]",
                ] {
                    self.say(line);
                }
            }
            ("ARM", &[one, two, three, skip]) => {
                let pads = [one, two, three].map(|pad| pad as u8);
                self.armed = Some(Armed { since_s: self.now_s, pads, skip, cycles: BTreeMap::new() });
            }
            ("READ", &[stamper]) => self.read(stamper as usize),
            ("COLD", _) | ("OUT", &[0]) => self.fall(self.now_s),
            ("OUT", &[us]) => self.falls_s = Some(self.now_s + f64::from(us) * 1e-6),
            ("OUT", _) => (self.is_low, self.falls_s) = (false, None),
            ("LOAD", _) => self.say("[LOAD:750000,1000000]"),
            ("MASK", _) => self.say("[MASK:250]"),
            ("CACHE", _) => self.say("[CACHE:400,5200,5300]"),
            ("COUNT", _) => self.say("[COUNT:9500,10000]"),
            ("FRAME", _) => {
                self.now_s = (self.now_s * 1e3).ceil() * 1e-3;
                let us = self.now_s * 1e6 * (1.0 + FAST);
                self.say(format!("[FRAME:{},{us:.0}]", (self.now_s * 1e3).round() as u64 % 2_048));
            }
            ("PAD", _) => self.say("[PAD:0,1000]"),
            _ => return false,
        }
        true
    }

    fn read(&mut self, stamper: usize) {
        let Some(armed) = &self.armed else { return };
        let is_second = armed.pads[..stamper].contains(&armed.pads[stamper]);
        let edges = armed.cycles.get(&armed.pads[stamper]).cloned().unwrap_or_default();
        // The third keeps the last round of a ring; the others have the first edge, and a window after what they skip.
        let skip = armed.skip as usize;
        let (first, mut stamped): (usize, Vec<u64>) = if stamper == 2 {
            let end = edges.len().min(skip + WINDOW);
            (end.saturating_sub(WINDOW), edges[end.saturating_sub(WINDOW)..end].to_vec())
        } else {
            let seen = edges.iter().enumerate().filter(|(index, _)| *index == 0 || *index > skip);
            (0, seen.take(WINDOW).map(|(_, cycle)| *cycle).collect())
        };
        // It looks in every second cycle, and the second of a pad in those between.
        stamped.iter_mut().for_each(|cycle| *cycle += (*cycle + u64::from(is_second)) % 2);
        let mut stamps = stamped;
        let loses = self.faults.stampers_lose && stamps.len() > 100;
        if loses {
            stamps.drain(50..60);
        }
        self.say(format!("[STAMPS:{stamper},{},{},{}]", first + 1, stamps.len(), u8::from(loses)));
        let before = [0].into_iter().chain(stamps.iter().copied());
        let differences: Vec<String> =
            stamps.iter().zip(before).map(|(stamp, before)| format!("{:x}", stamp - before)).collect();
        for line in differences.chunks(12) {
            self.say(format!("[S:{}]", line.join(" ")));
        }
    }
}

impl Run {
    fn at_s(&self, axis: usize, number: u32) -> f64 {
        self.begin_s + self.planned.compiled_ns(self.chip, axis, number) * 1e-9
    }

    /// The steps that come before the stop.
    fn made(&self, axis: usize) -> impl Iterator<Item = u32> {
        (1..=self.planned.count(axis)).take_while(move |&number| self.at_s(axis, number) <= self.stop_s)
    }

    fn end_s(&self) -> f64 {
        self.begin_s + self.planned.duration_s()
    }
}

/// Every setting with its value.
fn numbers(settings: &Settings) -> Vec<(u16, f32)> {
    (0..1_000).filter_map(|number| Some((number, settings.get(number)?))).collect()
}

impl Link for Fake {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        if self.faults.unplugged_after.is_some_and(|lines| lines <= self.lines) {
            bail!("Broken pipe");
        }
        for &byte in bytes {
            match byte {
                _ if self.faults.is_silent => {}
                b'?' | 0x18 => {
                    self.look();
                    self.byte_at_once(byte);
                }
                b'\n' => {
                    let line = std::mem::take(&mut self.partial);
                    self.line(&line);
                }
                _ => self.partial.push(char::from(byte)),
            }
        }
        Ok(())
    }

    fn line(&mut self, patience_s: f64) -> Result<Option<String>> {
        if self.faults.unplugged_after.is_some_and(|lines| lines <= self.lines) {
            bail!("No such device");
        }
        if self.said.is_empty() {
            self.now_s += patience_s.max(1e-6);
            self.look();
        }
        Ok(self.said.pop_front())
    }

    fn now_s(&self) -> f64 {
        self.now_s
    }
}
