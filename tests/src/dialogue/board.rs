//! The emulated board of a dialogue.

use isostep_motion::{Axis, Motor};
use isostep_sim::drivers::DriverFault;
use isostep_sim::tool::ToolOutput;
use isostep_sim::vfd::VfdKind;
use isostep_sim::world::Wire;
use isostep_sim::{Port, SwitchFault};
use serde_json::Value;

use super::machine::{Counts, Machine};
use super::run::is;
use super::step::{Step, With};
use crate::emulated::{Board, Live};

const MS: u64 = 1_000_000;
/// The time between two questions whether a machine rests, at first, and at last if that takes long: each report takes its time.
const ASK_NS: u64 = 10 * MS;
const ASK_SELDOM_NS: u64 = 100 * MS;
/// The time without a report after which it is asked for again.
const ASK_AGAIN_NS: u64 = 500 * MS;
/// The resolution of each axis at power-up, and of the emulated switches.
const STEPS_PER_MM: f64 = 50.0;
/// The longest time to come to rest, or to boot.
const PATIENCE_NS: u64 = 60_000 * MS;

/// The emulated board whose steps `PioPort` makes.
pub type ByPio = Emulated<false>;
/// The emulated board whose steps `TimerPort` makes.
pub type ByTimer = Emulated<true>;

/// An emulated board.
pub struct Emulated<const BY_TIMER: bool> {
    live: Live,
    partial: Vec<u8>,
    heard: Vec<String>,
    /// The lines that have been sent and not answered yet.
    unanswered: usize,
    /// The resolution of each axis, as it was set last.
    steps_per_mm: [f64; 4],
    /// Both motors of X and Y move both axes.
    has_belts: bool,
    /// The motors whose driver has been without supply.
    unsupplied: Vec<Motor>,
    /// The watchdog's resets that the dialogue has waited for.
    resets: usize,
}

/// A motor by the emulator's name.
fn name(motor: Motor) -> String {
    let axis = motor.axis.to_string();
    if motor == Motor::from(motor.axis) { axis } else { "2".to_owned() }
}

fn mode(fault: SwitchFault) -> &'static str {
    match fault {
        SwitchFault::None => "normal",
        SwitchFault::StuckOpen => "stuck-open",
        SwitchFault::StuckClosed => "stuck-closed",
    }
}

fn joined(mut items: impl Iterator<Item = String>) -> String {
    let first = items.next().unwrap_or_default();
    items.fold(first, |all, item| all + "," + &item)
}

/// The setting that says what the motors do for the axes to move.
const KINEMATICS: u16 = 907;
/// The emulator's option that crosses belts.
const BELTS: &str = "--belts";

/// The emulator's options for what a machine is like. Settings are sent; what they say of the belts is wired, too.
fn options(change: &With) -> Result<Vec<String>, String> {
    let option = |name: &str, value: String| Ok(vec![format!("--{name}={value}")]);
    match change {
        With::Setting(KINEMATICS, 1.0) => Ok(vec![BELTS.to_owned()]),
        With::Setting(..) | With::SkrPico | With::FourAxes => Ok(Vec::new()),
        With::NormallyClosed => option("estop", "nc".to_owned()),
        With::Start(mm) => option("start", joined(mm.iter().map(f64::to_string))),
        With::Baud(115_200) => option("console", "uart".to_owned()),
        With::BounceUs(us) => option("bounce-us", us.to_string()),
        With::Switch(axis, fault) => option("switch", format!("{axis}={}", mode(*fault))),
        With::Jumpers(diag) => option(
            "diag",
            joined(Axis::ALL.into_iter().filter(|axis| diag[*axis as usize]).map(|axis| axis.to_string())),
        ),
        With::Vfd(VfdKind::Gs20) => Ok(vec!["--vfd".to_owned()]),
        With::Plate(place) => option("probe-plate", place.to_string()),
        With::Emulator(words) => Ok(words.split(' ').map(str::to_owned).collect()),
        _ => Err(format!("the emulated board cannot have {change:?}")),
    }
}

impl<const BY_TIMER: bool> Emulated<BY_TIMER> {
    fn board(test: &str, changes: &[With]) -> Board {
        let port = if BY_TIMER { Port::Timer } else { Port::Pio };
        let test = format!("{test}-{port}");
        if changes.contains(&With::FourAxes) {
            Board::of_four_axes(port, &test)
        } else if changes.contains(&With::SkrPico) {
            Board::of_skr_pico(&test)
        } else if changes.contains(&With::NormallyClosed) {
            Board::of_firmware("ISOSTEP_ESTOP_NC_ELF", &test)
        } else {
            Board::stepped_by(port, &test)
        }
    }

    /// Runs to an instant, and keeps what is heard.
    fn run_to(&mut self, at_ns: u64, bytes: &[u8]) -> Result<(), String> {
        self.partial.extend(self.live.run_to(at_ns, bytes)?);
        while let Some(end) = self.partial.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.partial.drain(..=end).collect();
            let line = String::from_utf8_lossy(&line).trim_end().to_owned();
            match line.as_str() {
                "" => continue,
                "ok" => self.unanswered = self.unanswered.saturating_sub(1),
                _ if line.starts_with("error:") => self.unanswered = self.unanswered.saturating_sub(1),
                _ if line.starts_with("Grbl ") => self.unanswered = 0,
                _ => {}
            }
            self.heard.push(line);
        }
        Ok(())
    }

    /// The status report, after some time, or later where a sector of the flash is erased. It is not heard.
    fn status(&mut self, within_ns: u64) -> Result<String, String> {
        let (before, end_ns) = (self.heard.len(), self.live.now_ns() + PATIENCE_NS);
        let mut asked_ns = 0;
        loop {
            // None is sent while the host has more to read than it can.
            if asked_ns == 0 || self.live.now_ns() > asked_ns + ASK_AGAIN_NS {
                asked_ns = self.live.now_ns();
                self.run_to(asked_ns, b"?")?;
            }
            self.run_for(within_ns)?;
            if let Some(index) = self.heard[before..].iter().position(|line| line.starts_with('<')) {
                return Ok(self.heard.remove(before + index));
            }
            is(self.live.now_ns() < end_ns, || format!("no report: {:?}", self.heard))?;
        }
    }

    fn wait_for_welcome(&mut self) -> Result<(), String> {
        let end_ns = self.live.now_ns() + PATIENCE_NS;
        while !self.heard.iter().any(|line| line.starts_with("Grbl ")) {
            is(self.live.now_ns() < end_ns, || format!("no welcome: {:?}", self.heard))?;
            self.run_for(ASK_NS)?;
        }
        Ok(())
    }

    /// Settings, each of which must be taken; what was heard before stays.
    fn set(&mut self, changes: &[With]) -> Result<(), String> {
        for change in changes {
            if let With::Setting(number, value) = change {
                let before = self.heard.len();
                self.send(0, format!("${number}={value}\n").as_bytes())?;
                self.settle()?;
                let heard = self.heard.split_off(before);
                is(heard.last().is_some_and(|last| last == "ok"), || format!("${number}={value}: {heard:?}"))?;
            }
        }
        Ok(())
    }

    fn counts_agree(&mut self) -> Result<(), String> {
        let (before, report, after) = (self.counted_places()?, self.status(5 * MS)?, self.counted_places()?);
        let place = report.split('|').find_map(|field| field.strip_prefix("MPos:")).ok_or_else(|| report.clone())?;
        let mm = place.trim_end_matches('>').split(',').map(str::parse::<f64>);
        let steps =
            mm.zip(self.steps_per_mm).map(|(mm, per_mm)| mm.map_or(i64::MIN, |mm| (mm * per_mm).round() as i64));
        let told: Vec<_> = steps.collect();
        // Of two belts that turn against each other one steps first.
        let slack = i64::from(self.has_belts && before != after);
        let between = |axis: usize| {
            let [one, other] = [before[axis], after[axis]];
            (one.min(other) - slack..=one.max(other) + slack).contains(&told[axis])
        };
        let agree = told.len() == before.len() && (0..told.len()).all(between);
        is(agree, || format!("it says {told:?}, and {after:?} left the pins"))
    }

    /// The places of the axes by the edges. With crossed belts they are half a sum and half a difference, to the whole step that is nearer
    /// to zero.
    fn counted_places(&mut self) -> Result<Vec<i64>, String> {
        let mut places = self.counts()?.counted;
        if let ([x, y, ..], true) = (&mut places[..], self.has_belts) {
            (*x, *y) = ((*x + *y) / 2, (*x - *y) / 2);
        }
        Ok(places)
    }

    fn figure(&mut self, path: &str, written: &str) -> Result<(), String> {
        let figures = self.live.look()?;
        let found =
            figures.pointer(&format!("/{}", path.replace('.', "/"))).ok_or_else(|| format!("no figure {path}"))?;
        let is_so = match (found.as_f64(), written.split_once("..").unwrap_or((written, written))) {
            (Some(found), (least, most)) => {
                let bound =
                    |text: &str, open: f64| if text.is_empty() { open } else { text.parse().unwrap_or(f64::NAN) };
                (bound(least, f64::MIN)..=bound(most, f64::MAX)).contains(&found)
            }
            (None, _) => found.as_str().map_or_else(|| found.to_string(), str::to_owned) == written,
        };
        is(is_so, || format!("{path} is {found}"))
    }

    fn until_state(&mut self, name: &str) -> Result<(), String> {
        let end_ns = self.live.now_ns() + PATIENCE_NS;
        while !self.status(MS)?[1..].starts_with(name) {
            is(self.live.now_ns() < end_ns, || format!("never {name}"))?;
        }
        Ok(())
    }
}

/// True if nothing happens any more in a state, where no line waits for its answer.
fn rests(report: &str, unanswered: usize) -> bool {
    let state = report[1..].split('|').next().unwrap_or_default();
    matches!(state, "Hold:0" | "Door:0" | "Door:1" | "Sleep" | "Tool")
        || matches!(state, "Idle" | "Check" | "Alarm") && unanswered == 0
}

impl<const BY_TIMER: bool> Machine for Emulated<BY_TIMER> {
    /// A thousandth.
    const DUTY_TOLERANCE: u16 = 65;

    fn power_up(name: &str, changes: &[With]) -> Result<Self, String> {
        let options: Vec<_> = changes.iter().map(options).collect::<Result<Vec<_>, _>>()?.concat();
        let options: Vec<_> = options.iter().map(String::as_str).collect();
        let has_belts = options.contains(&BELTS);
        let live = Self::board(name, changes).with(&options).live();
        let mut board = Self {
            live,
            partial: Vec::new(),
            heard: Vec::new(),
            unanswered: 0,
            steps_per_mm: [STEPS_PER_MM; 4],
            has_belts,
            unsupplied: Vec::new(),
            resets: 0,
        };
        board.wait_for_welcome()?;
        board.set(changes)?;
        Ok(board)
    }

    fn power_cycle(&mut self, changes: &[With]) -> Result<(), String> {
        self.live.act("power-cycle")?;
        (self.unanswered, self.partial) = (0, Vec::new());
        self.wait_for_welcome()?;
        self.set(changes)
    }

    fn starts_within_ns(&self) -> u64 {
        ASK_NS
    }

    fn send(&mut self, console: usize, bytes: &[u8]) -> Result<(), String> {
        is(console == 0, || "the emulated board has one cable".to_owned())?;
        for (axis, per_mm) in self.steps_per_mm.iter_mut().enumerate() {
            let value =
                std::str::from_utf8(bytes).ok().and_then(|line| line.trim().strip_prefix(&format!("$10{axis}=")));
            *per_mm = value.and_then(|value| value.parse().ok()).unwrap_or(*per_mm);
        }
        self.unanswered += bytes.iter().filter(|byte| **byte == b'\n').count();
        self.run_to(self.live.now_ns(), bytes)
    }

    fn run_for(&mut self, time_ns: u64) -> Result<(), String> {
        self.run_to(self.live.now_ns() + time_ns, b"")
    }

    /// Two reports in a row are of the same rest, and nothing else is heard between.
    fn settle(&mut self) -> Result<(), String> {
        let (mut last, begin_ns) = (String::new(), self.live.now_ns());
        let end_ns = begin_ns + PATIENCE_NS;
        loop {
            let heard = self.heard.len();
            let lasts_ns = self.live.now_ns() - begin_ns;
            let within_ns = if last.is_empty() { (lasts_ns / 20).clamp(ASK_NS, ASK_SELDOM_NS) } else { ASK_NS };
            let report = self.status(within_ns)?;
            if rests(&report, self.unanswered) && heard == self.heard.len() {
                let state = report.split('|').next().unwrap_or_default();
                if last == state {
                    return Ok(());
                }
                state.clone_into(&mut last);
            } else {
                last.clear();
            }
            is(self.live.now_ns() < end_ns, || format!("it does not come to rest: {report}"))?;
        }
    }

    fn replies(&mut self, console: usize) -> Vec<String> {
        if console == 0 { std::mem::take(&mut self.heard) } else { Vec::new() }
    }

    fn now_ns(&self) -> u64 {
        self.live.now_ns()
    }

    fn counts(&mut self) -> Result<Counts, String> {
        let figures = self.live.look()?;
        let mut counts = Counts::default();
        for axis in ["X", "Y", "Z", "A"].iter().filter_map(|axis| figures["axes"].get(*axis)) {
            let place_steps = axis["place_mm"].as_f64().unwrap_or(f64::NAN) * STEPS_PER_MM;
            counts.counted.push(axis["position_steps"].as_i64().unwrap_or(i64::MIN));
            counts.made.push(axis["edges"].as_i64().unwrap_or(i64::MIN));
            counts.places.push(place_steps.round() as i64);
        }
        Ok(counts)
    }

    fn tool(&mut self) -> Result<[u16; 5], String> {
        let figures = self.live.look()?;
        Ok(ToolOutput::ALL.map(|output| {
            let duty = figures["tool"][output.to_string()].as_f64().unwrap_or(f64::NAN);
            (duty * f64::from(u16::MAX)).round() as u16
        }))
    }

    fn last_step_ns(&mut self) -> Option<u64> {
        self.live.look().ok()?["moving"]["last_edge_ns"].as_u64()
    }

    fn end_of_move_ns(&self, _count: usize) -> Option<u64> {
        None
    }

    fn act(&mut self, step: &Step) -> Result<(), String> {
        let pressed = |pressed: bool| if pressed { "pressed" } else { "released" };
        let command = match step {
            Step::CountsAgree => return self.counts_agree(),
            Step::Until(name) => return self.until_state(name),
            Step::Figure(path, written) => return self.figure(path, written),
            // The board's drivers are watched in every run, and what is lost is a figure.
            Step::NoViolation => return self.figure("driver_timing.violations", "0"),
            Step::Emulator(command) => {
                self.resets += usize::from(command == "wait-reset");
                command.clone()
            }
            Step::Motors(on) => format!("motors {}", if *on { "on" } else { "off" }),
            Step::Switch(motor, fault) => format!("switch {} {}", name(*motor), mode(*fault)),
            Step::Press { wire: Wire::EmergencyStop, pressed: down, .. } => format!("estop {}", pressed(*down)),
            Step::Press { wire: Wire::Probe, pressed: down, .. } => format!("probe {}", pressed(*down)),
            Step::Press { wire: Wire::Hold, pressed: down, .. } => format!("hold {}", pressed(*down)),
            Step::Press { wire: Wire::Start, pressed: down, .. } => format!("start {}", pressed(*down)),
            // One contact, which is as long in alarm as something is wrong.
            Step::Drive(_, is_wrong) => format!("alarm {}", pressed(*is_wrong)),
            Step::Cut(is_cut) => format!("estop {}", if *is_cut { "cut" } else { "mended" }),
            Step::Plate(None) => "probe-plate none".to_owned(),
            Step::Plate(Some(place)) => format!("probe-plate {}", place.to_string().replace(',', " ")),
            Step::Driver(motor, None) => {
                // A supply that was never off must not come again.
                if self.unsupplied.iter().any(|other| other == motor) {
                    self.live.act(&format!("driver {} on", name(*motor)))?;
                }
                format!("driver {} well", name(*motor))
            }
            Step::Driver(motor, Some(DriverFault::Off)) => {
                self.unsupplied.push(*motor);
                format!("driver {} off", name(*motor))
            }
            Step::Driver(motor, Some(DriverFault::OpenCoil)) => format!("driver {} open", name(*motor)),
            Step::Driver(motor, Some(fault)) => format!("driver {} {fault}", name(*motor)),
            Step::Vfd(None) => "vfd well".to_owned(),
            Step::Vfd(Some(fault)) => format!("vfd {fault}"),
            Step::Open => {
                self.live.act("dtr off")?;
                self.run_for(5 * MS)?;
                "dtr on".to_owned()
            }
            _ => return Err("the emulated board cannot do this: use `on: simulator`".to_owned()),
        };
        self.live.act(&command)
    }

    fn end(self) -> Result<(), String> {
        let resets = self.resets;
        let figures = self.live.end()?;
        is(figures["error"] == Value::Null, || figures["error"].to_string())?;
        let found = figures["watchdog_resets"].as_array().map_or(0, Vec::len);
        is(found == resets, || format!("the watchdog has reset the board {found} times"))
    }
}
