//! Carries out a dialogue on a simulated machine.

use std::collections::VecDeque;
use std::mem;

use embassy_time::{Duration, Instant};
use isostep_motion::{AXES, Event};
use isostep_sim::plate::Plate;
use isostep_sim::world::Wire;
use isostep_sim::{Axis, Board, Config, Flash, Sim, State};

use super::parse::{Dialogue, Wrong};
use super::pattern::{Numbers, all_match, matches};
use super::step::{Begin, Step, Wait, When, With};

const WELCOME: &str = "Grbl 1.1h ['$' for help]";
/// A status report comes this long after it was asked for, at most.
const SOON: Duration = Duration::from_millis(1);
/// How long something is waited for at most.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often the outputs are looked at.
const LOOK: Duration = Duration::from_micros(10);
/// What takes turns in the reports is in one of this many.
const REPORTS: usize = 40;

/// A machine, and what its consoles have heard that the dialogue has not said yet.
struct Runner {
    config: Config,
    flash: Flash,
    sim: Sim,
    heard: [Vec<String>; 2],
    noted: Noted,
    /// When the outputs began to be watched, us, and their changes since, each at most [`LOOK`] late.
    watched_us: u64,
    changes: VecDeque<(u64, [u16; 5])>,
}

/// What a later step may compare with.
struct Noted {
    counted: [i32; AXES],
    made: [u64; AXES],
    places: [i32; AXES],
    at: Instant,
}

impl Noted {
    fn of(sim: &Sim) -> Self {
        Self { counted: sim.counted_steps(), made: sim.steps(), places: sim.places_steps(), at: sim.now() }
    }
}

/// Carries out a dialogue. Whatever is heard must be written, before anything else is sent.
///
/// # Errors
/// The first line that is not so.
pub fn carry_out(dialogue: &Dialogue) -> Result<(), Wrong> {
    let (mut changes, mut runner) = (Vec::<With>::new(), None::<Runner>);
    let mut steps = dialogue.steps.iter().peekable();
    let mut last = 0;
    while let Some(&(line, ref step)) = steps.next() {
        let wrong = |why| Wrong { line, why };
        last = line;
        match (step, &mut runner) {
            (Step::With(with), _) => changes.push(with.clone()),
            (Step::Begin(Begin::PowerCycle), Some(before)) => {
                before.nothing_unsaid().map_err(wrong)?;
                let new = Runner::new(before.config.clone(), before.flash.clone(), &mem::take(&mut changes));
                runner = Some(new);
                runner.iter_mut().try_for_each(|runner| runner.wait(Wait::Idle)).map_err(wrong)?;
            }
            (Step::Begin(begin), before) => {
                before.as_mut().map_or(Ok(()), Runner::nothing_unsaid).map_err(wrong)?;
                let new = runner.insert(Runner::new(Config::default(), Flash::blank(), &mem::take(&mut changes)));
                new.begin(*begin).map_err(wrong)?;
            }
            (Step::Heard { console, line: heard }, Some(runner)) => {
                let mut written = vec![heard.clone()];
                while let Some((_, Step::Heard { line, .. })) =
                    steps.next_if(|(_, next)| matches!(next, Step::Heard { console: other, .. } if other == console))
                {
                    written.push(line.clone());
                }
                runner.heard(*console, &written).map_err(wrong)?;
            }
            (step, Some(runner)) => runner.carry_out(step).map_err(wrong)?,
            (_, None) => {
                return Err(wrong("there is no machine yet: write `homed`, `powered up` or `switched on`".to_owned()));
            }
        }
    }
    runner.map_or(Ok(()), |mut runner| runner.nothing_unsaid()).map_err(|why| Wrong { line: last, why })
}

impl Runner {
    fn new(mut config: Config, flash: Flash, changes: &[With]) -> Self {
        changes.iter().for_each(|with| with.change(&mut config));
        let mut sim = Sim::with_flash(&config, flash.clone());
        for with in changes {
            if let With::Pressed(wire) = with {
                sim.set_hand_input(*wire, true);
            }
        }
        let noted = Noted::of(&sim);
        Self { config, flash, sim, heard: Default::default(), noted, watched_us: 0, changes: VecDeque::new() }
    }

    fn begin(&mut self, begin: Begin) -> Result<(), String> {
        // UART drivers are set first.
        let settles_ms = if self.config.board == Board::SkrPico { 300 } else { 50 };
        self.wait(Wait::For(Duration::from_millis(settles_ms)))?;
        if begin != Begin::SwitchedOn {
            self.heard(0, &[WELCOME.to_owned()])?;
        }
        if begin == Begin::Homed {
            self.say("$H")?;
            self.heard(0, &["ok".to_owned()])?;
        }
        Ok(())
    }

    fn say(&mut self, line: &str) -> Result<(), String> {
        self.sim.send(format!("{line}\n").as_bytes());
        self.wait(Wait::Idle)
    }

    fn wait(&mut self, wait: Wait) -> Result<(), String> {
        match wait {
            Wait::None => Ok(()),
            Wait::For(time) => self.sim.run_for(time),
            Wait::Idle => self.sim.run_until_idle(),
        }
        .map_err(|error| error.to_string())?;
        let consoles = 1 + usize::from(self.config.second_console);
        for console in 0..consoles {
            self.heard[console].extend(self.sim.replies_of(console));
        }
        Ok(())
    }

    /// What a console has heard must be what is written.
    fn heard(&mut self, console: usize, written: &[String]) -> Result<(), String> {
        let heard = mem::take(&mut self.heard[console]);
        let listed = |lines: &[String]| lines.iter().map(|line| format!("\n  {line}")).collect::<String>();
        match all_match(written, &heard) {
            true => Ok(()),
            false => Err(format!("heard{}\nwhere this is written:{}", listed(&heard), listed(written))),
        }
    }

    fn watch(&mut self, time: Duration) -> Result<(), String> {
        self.watched_us = self.sim.now().as_micros();
        let mut before = self.sim.tool();
        for _ in 0..time.as_micros() / LOOK.as_micros() {
            self.wait(Wait::For(LOOK))?;
            if self.sim.tool() != before {
                before = self.sim.tool();
                self.changes.push_back((self.sim.now().as_micros(), before));
            }
        }
        Ok(())
    }

    fn changed(&mut self, duties: [u16; 5], when: Option<When>) -> Result<(), String> {
        let (at_us, found) = self.changes.pop_front().ok_or("the outputs have not changed")?;
        is(found == duties, || format!("the outputs have become {found:?} of 65535"))?;
        let outcome = self.sim.outcome();
        let (due_ns, most_us) = match when {
            None => return Ok(()),
            Some(When::AtOnce) => (Some(self.watched_us * 1_000), LOOK.as_micros()),
            Some(When::AtStandstill) => (outcome.edges.last().map(|edge| edge.t_ns), 25_000),
            Some(When::WithMove(count)) => {
                let mut made = outcome.moves.iter().filter(|record| !record.homing);
                (made.nth(count - 1).map(|record| record.end_ns), LOOK.as_micros())
            }
        };
        let late_us = at_us as f64 - due_ns.ok_or("there was no such move")? as f64 * 1e-3;
        // The clock has microseconds.
        is((-1.0..=most_us as f64 + 1.0).contains(&late_us), || format!("the outputs have changed {late_us} us later"))
    }

    /// Everything that was heard, and each change that was seen, must have been written by now.
    fn nothing_unsaid(&mut self) -> Result<(), String> {
        if let Some(change) = self.changes.front() {
            return Err(format!("an output has changed before this line, and it is not written: {change:?}"));
        }

        match self.heard.iter().flatten().next() {
            None => Ok(()),
            Some(_) => {
                Err(format!("heard before this line, and not written: {:?}: write it with <, or < ...", self.heard))
            }
        }
    }

    fn carry_out(&mut self, step: &Step) -> Result<(), String> {
        match step {
            Step::With(_) | Step::Begin(_) | Step::Heard { .. } => unreachable!("these are of the dialogue"),
            Step::Send { console, bytes, wait } => {
                // Lines that are sent together may be answered together.
                if *wait != Wait::None {
                    self.nothing_unsaid()?;
                }
                self.sim.send_to(*console, bytes);
                self.wait(*wait)
            }
            Step::Wait(wait) => self.wait(*wait),
            Step::Silence => self.nothing_unsaid(),
            Step::Report(parts) => self.report(parts),
            Step::Unchanged { error, line } => self.unchanged(error, line),
            Step::Note => {
                self.noted = Noted::of(&self.sim);
                Ok(())
            }
            Step::UntilHeard => {
                let begun = self.sim.now();
                while self.heard.iter().all(Vec::is_empty) {
                    is(self.sim.now() - begun < PATIENCE, || {
                        format!("nothing was heard for {} s", PATIENCE.as_secs())
                    })?;
                    self.wait(Wait::For(SOON))?;
                }
                Ok(())
            }
            Step::Until(name) => {
                let is_it = |state: State| format!("{state:?}").split(['(', ' ']).next() == Some(name);
                self.sim.run_until_state(is_it).map_err(|error| error.to_string())?;
                self.wait(Wait::None)
            }
            Step::Accessories(letters) => self.accessories(letters),
            Step::Watch(time) => self.watch(*time),
            Step::Changed(duties, when) => self.changed(*duties, *when),
            Step::DriverIs(driver, words) => self.driver_is(*driver, words),
            Step::Switch(..)
            | Step::Press { .. }
            | Step::Cut(_)
            | Step::Plate(_)
            | Step::Driver(..)
            | Step::Fault(_)
            | Step::FlashRefuses(_)
            | Step::StopSeen(_)
            | Step::Open
            | Step::CutOff
            | Step::ResetHeard => self.act(step),
            _ => self.check_motion(step),
        }
    }

    /// Checks what has moved.
    fn check_motion(&self, step: &Step) -> Result<(), String> {
        match step {
            Step::Steps(numbers) => all("the steps are", numbers, self.sim.counted_steps()),
            Step::Places(numbers) => all("the carriages are, from their switches,", numbers, self.sim.places_steps()),
            Step::PlacesAsNoted => {
                let places = self.sim.places_steps();
                is(places == self.noted.places, || format!("{places:?}, and at the note {:?}", self.noted.places))
            }
            Step::Moved(numbers) => {
                let counted = self.sim.counted_steps();
                all(
                    "since the note it has moved",
                    numbers,
                    std::array::from_fn(|axis| counted[axis] - self.noted.counted[axis]),
                )
            }
            Step::Took(numbers, unit) => {
                let took = self.sim.now() - self.noted.at;
                let is_so = numbers.contains((took.as_micros() / unit.as_micros()) as i64);
                is(is_so, || format!("since the note it has taken {} us", took.as_micros()))
            }
            Step::NoStepMade => is(self.sim.steps() == self.noted.made, || "steps were made since the note".to_owned()),
            Step::CountsAgree => {
                let (reported, counted) = (self.sim.machine().position_steps(), self.sim.counted_steps());
                is(reported == counted, || format!("it says {reported:?}, and {counted:?} left the pins"))
            }
            _ => self.check_machine(step),
        }
    }

    /// Checks what else is recorded of the machine.
    fn check_machine(&self, step: &Step) -> Result<(), String> {
        let outcome = self.sim.outcome();
        match step {
            Step::Moves(numbers) => {
                let made = outcome.moves.iter().filter(|record| !record.homing).count();
                is(numbers.contains(made as i64), || format!("{made} moves have begun"))
            }
            Step::Trusted(axes) => {
                let homed = self.sim.machine().homed();
                is(homed == *axes, || format!("trusted are {homed:?}"))
            }
            Step::Tool(duties) => {
                is(self.sim.tool() == *duties, || format!("the outputs are {:?} of 65535", self.sim.tool()))
            }
            Step::Motors(on) => {
                // The drivers are enabled by a low ENABLE.
                let waves = &outcome.waves;
                let are_on = waves.iter().rfind(|wave| wave.wire == Wire::Enable).is_some_and(|wave| !wave.high);
                is(are_on == *on, || format!("whether the motors are on: {are_on}"))
            }
            Step::State(name) => {
                let state = self.sim.machine().state();
                is(format!("{state:?}") == *name, || format!("the state is {state:?}"))
            }
            Step::NoStepLost => {
                let kept = outcome.drift_steps == [0; AXES] && outcome.losses.is_empty();
                is(kept, || format!("lost are {:?}: {:?}", outcome.drift_steps, outcome.losses))
            }
            Step::NoViolation => {
                let violations = &outcome.violations;
                is(violations.is_empty(), || format!("{violations:?}"))
            }
            Step::Homings(axes) => {
                let events = &outcome.events;
                let homed = events.iter().filter_map(|(_, event)| match event {
                    Event::Homed { axis } => Some(axis.to_string()),
                    _ => None,
                });
                let homed = homed.collect::<Vec<_>>().join(" ");
                is(homed == *axes, || format!("homed were {homed}"))
            }
            Step::ToolNeverOn => {
                let tool = &outcome.tool;
                is(tool.is_empty(), || format!("an output was on: {tool:?}"))
            }
            Step::Output { index, duty, tolerance } => {
                let tool = self.sim.tool();
                is(tool[*index].abs_diff(*duty) <= *tolerance, || format!("the outputs are {tool:?} of 65535"))
            }
            _ => unreachable!("{step:?} checks nothing"),
        }
    }

    /// Does what a hand does, and what goes wrong.
    fn act(&mut self, step: &Step) -> Result<(), String> {
        match *step {
            Step::Switch(motor, fault) => self.sim.set_switch(motor, fault),
            Step::Press { wire, pressed, bounces } => {
                for flips in 0..if bounces { 4 } else { 0 } {
                    self.sim.set_hand_input(wire, pressed == (flips % 2 == 0));
                    self.wait(Wait::For(Duration::from_micros(500)))?;
                }
                self.sim.set_hand_input(wire, pressed);
                // Longer than the debounce time.
                return self.wait(if bounces { Wait::For(Duration::from_millis(20)) } else { Wait::None });
            }
            Step::Cut(is_cut) => self.sim.cut_emergency_stop(is_cut),
            Step::Plate(place_mm) => {
                self.sim.set_plate(place_mm.map(|place_mm| Plate { axis: Axis::Z, place_mm, is_below: false }));
            }
            Step::Driver(motor, fault) => self.sim.set_driver(motor, fault),
            Step::Fault(fault) => self.sim.suffer(fault),
            Step::FlashRefuses(true) => self.flash.refuse(),
            Step::FlashRefuses(false) => self.flash.mend(),
            Step::StopSeen(pressed) => self.sim.machine().emergency_stop_edge(pressed),
            Step::Open => self.sim.open_console(),
            Step::CutOff => self.sim.machine().tool_cut_off(),
            Step::ResetHeard => self.sim.machine().reset_heard(),
            _ => unreachable!("{step:?} is no action"),
        }
        Ok(())
    }

    /// A status report, and what else was heard with it stays to be written.
    fn ask(&mut self) -> Result<String, String> {
        self.nothing_unsaid()?;
        self.sim.send(b"?");
        self.wait(Wait::For(SOON))?;
        let index = self.heard[0].iter().position(|line| line.starts_with('<'));
        index.map(|index| self.heard[0].remove(index)).ok_or_else(|| format!("no report: {:?}", self.heard[0]))
    }

    /// A word without a colon is the state; a field behind `no` must not be there. Offsets and overrides take turns, so they
    /// are looked for in the next reports, too.
    fn report(&mut self, parts: &[String]) -> Result<(), String> {
        let first = self.ask()?;
        let mut parts = parts.iter();
        while let Some(part) = parts.next() {
            let Some((name, _)) = part.split_once(':').filter(|(name, _)| !is_state(name)) else {
                let is_so = match part.as_str() {
                    "no" => parts.next().is_some_and(|name| field(&first, name).is_none()),
                    state => first[1..].split('|').next().is_some_and(|reported| matches(state, reported)),
                };
                is(is_so, || first.clone())?;
                continue;
            };
            let mut report = first.clone();
            for _ in 1..if matches!(name, "Ov" | "WCO") { REPORTS } else { 1 } {
                if field(&report, name).is_none() {
                    report = self.ask()?;
                }
            }
            is(field(&report, name).is_some_and(|found| matches(part, found)), || report.clone())?;
        }
        Ok(())
    }

    /// They are in the report that has the overrides, and nothing is there if none is on.
    fn accessories(&mut self, letters: &str) -> Result<(), String> {
        for _ in 0..REPORTS {
            let report = self.ask()?;
            if field(&report, "Ov").is_some() {
                let found = field(&report, "A").map_or("none", |found| &found[2..]);
                return is(found == letters, || report.clone());
            }
        }
        Err(format!("no report of {REPORTS} has the overrides"))
    }

    fn driver_is(&mut self, driver: usize, words: &[String]) -> Result<(), String> {
        let setup = self.sim.driver_setup(driver).ok_or("this board's drivers have no UART")?;
        let chop = if setup.is_spread_cycle { "spread-cycle" } else { "stealth-chop" };
        let stalls = if setup.tells_stalls { "tells-stalls" } else { "tells-no-stalls" };
        let (run, hold) = (format!("{}-mA", setup.run_ma), format!("{}-mA-hold", setup.hold_ma));
        let found = [format!("{}-microsteps", setup.microsteps), run, hold, chop.to_owned(), stalls.to_owned()];
        is(words.iter().all(|word| found.contains(word)), || format!("the driver is {}", found.join(" ")))
    }

    /// Modes, offsets, settings, start-up lines and the position are as before.
    fn unchanged(&mut self, error: &str, line: &[u8]) -> Result<(), String> {
        let before = self.everything()?;
        self.sim.send(&[line, b"\n"].concat());
        self.wait(Wait::Idle)?;
        let heard = mem::take(&mut self.heard[0]);
        let is_refused = heard.last().is_some_and(|last| last == error);
        let only_reported = heard.iter().rev().skip(1).all(|line| line.starts_with("[MSG:"));
        is(is_refused && only_reported, || format!("heard {heard:?}"))?;
        let after = self.everything()?;
        is(before == after, || format!("it was\n{before:#?}\nand is\n{after:#?}"))
    }

    fn everything(&mut self) -> Result<Vec<String>, String> {
        self.nothing_unsaid()?;
        for line in ["$G", "$#", "$$", "$N"] {
            self.say(line)?;
        }
        let mut all = mem::take(&mut self.heard[0]);
        let report = self.ask()?;
        all.push(report.split('|').take(2).collect::<Vec<_>>().join("|"));
        Ok(all)
    }
}

/// The states that have a number behind a colon.
fn is_state(name: &str) -> bool {
    matches!(name, "Hold" | "Door")
}

/// A field with its name.
fn field<'a>(report: &'a str, name: &str) -> Option<&'a str> {
    report
        .trim_end_matches('>')
        .split('|')
        .find(|field| field.strip_prefix(name).is_some_and(|rest| rest.starts_with(':')))
}

fn is(is_so: bool, found: impl FnOnce() -> String) -> Result<(), String> {
    if is_so { Ok(()) } else { Err(found()) }
}

fn all(what: &str, numbers: &[Numbers], found: [i32; AXES]) -> Result<(), String> {
    is(numbers.iter().zip(found).all(|(numbers, found)| numbers.contains(found.into())), || format!("{what} {found:?}"))
}
