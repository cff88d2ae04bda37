//! Carries out a dialogue on a machine of either kind.

use std::collections::VecDeque;
use std::mem;

use super::machine::{Counts, Machine};
use super::parse::{Dialogue, Wrong};
use super::pattern::{Numbers, all_match, matches};
use super::step::{Begin, Step, Wait, When, With};

const WELCOME: &str = "Grbl 1.1h ['$' for help]";
const MS: u64 = 1_000_000;
/// A status report comes so many milliseconds after it was asked for, at most: an erase of the flash may be under way.
const SOON_MS: usize = 400;
/// The longest time that something is waited for.
const PATIENCE_NS: u64 = 60_000 * MS;
/// The time between two looks at the outputs.
const LOOK_NS: u64 = 10_000;
/// The number of reports, one of which has each thing that takes turns in them.
const REPORTS: usize = 40;

/// A machine, and what its consoles have heard that the dialogue has not said yet.
struct Runner<M> {
    machine: M,
    heard: [Vec<String>; 2],
    noted: Noted,
    /// When the outputs began to be watched, ns, and their changes since, each at most [`LOOK_NS`] late.
    watched_ns: u64,
    changes: VecDeque<(u64, [u16; 5])>,
}

/// Values that a later step may compare with.
struct Noted {
    counts: Counts,
    at_ns: u64,
}

/// Carries out a dialogue. Whatever is heard must be written, before anything else is sent.
///
/// # Errors
/// The first line that is not so.
pub fn carry_out<M: Machine>(dialogue: &Dialogue) -> Result<(), Wrong> {
    let (mut changes, mut runner) = (Vec::<With>::new(), None::<Runner<M>>);
    let mut steps = dialogue.steps.iter().peekable();
    let mut last = 0;
    while let Some(&(line, ref step)) = steps.next() {
        let wrong = |why| Wrong { line, why };
        last = line;
        match (step, &mut runner) {
            (Step::With(with), _) => changes.push(with.clone()),
            (Step::Begin(Begin::PowerCycle), Some(before)) => {
                before.nothing_unsaid().map_err(wrong)?;
                before.machine.power_cycle(&mem::take(&mut changes)).map_err(wrong)?;
                before.noted = Noted::of(&mut before.machine).map_err(wrong)?;
                before.wait(Wait::Idle).map_err(wrong)?;
            }
            (Step::Begin(begin), before) => {
                before.take().map_or(Ok(()), Runner::end).map_err(wrong)?;
                let machine = M::power_up(&dialogue.name, &mem::take(&mut changes)).map_err(wrong)?;
                let new = runner.insert(Runner::new(machine).map_err(wrong)?);
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
    runner.map_or(Ok(()), Runner::end).map_err(|why| Wrong { line: last, why })
}

impl Noted {
    fn of(machine: &mut impl Machine) -> Result<Self, String> {
        Ok(Self { counts: machine.counts()?, at_ns: machine.now_ns() })
    }
}

impl<M: Machine> Runner<M> {
    fn new(mut machine: M) -> Result<Self, String> {
        let noted = Noted::of(&mut machine)?;
        Ok(Self { machine, heard: Default::default(), noted, watched_ns: 0, changes: VecDeque::new() })
    }

    fn end(mut self) -> Result<(), String> {
        self.nothing_unsaid()?;
        self.machine.end()
    }

    fn begin(&mut self, begin: Begin) -> Result<(), String> {
        self.wait(Wait::For(self.machine.starts_within_ns()))?;
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
        self.machine.send(0, format!("{line}\n").as_bytes())?;
        self.wait(Wait::Idle)
    }

    fn wait(&mut self, wait: Wait) -> Result<(), String> {
        match wait {
            Wait::None => {}
            Wait::For(time_ns) => self.machine.run_for(time_ns)?,
            Wait::Idle => self.machine.settle()?,
        }
        for (console, heard) in self.heard.iter_mut().enumerate() {
            heard.extend(self.machine.replies(console));
        }
        Ok(())
    }

    /// Runs the machine, by milliseconds, until something is so.
    fn wait_until(
        &mut self,
        what: &str,
        mut is_so: impl FnMut(&mut Self) -> Result<bool, String>,
    ) -> Result<(), String> {
        let end_ns = self.machine.now_ns() + PATIENCE_NS;
        while !is_so(self)? {
            is(self.machine.now_ns() < end_ns, || format!("{what} in {} s", PATIENCE_NS / 1000 / MS))?;
            self.wait(Wait::For(MS))?;
        }
        Ok(())
    }

    /// Checks that a console has heard what is written.
    fn heard(&mut self, console: usize, written: &[String]) -> Result<(), String> {
        let heard = mem::take(&mut self.heard[console]);
        let listed = |lines: &[String]| lines.iter().map(|line| format!("\n  {line}")).collect::<String>();
        match all_match(written, &heard) {
            true => Ok(()),
            false => Err(format!("heard{}\nwhere this is written:{}", listed(&heard), listed(written))),
        }
    }

    fn watch(&mut self, time_ns: u64) -> Result<(), String> {
        self.watched_ns = self.machine.now_ns();
        let mut before = self.machine.tool()?;
        for _ in 0..time_ns / LOOK_NS {
            self.wait(Wait::For(LOOK_NS))?;
            let now = self.machine.tool()?;
            if now != before {
                before = now;
                self.changes.push_back((self.machine.now_ns(), before));
            }
        }
        Ok(())
    }

    fn changed(&mut self, duties: [u16; 5], when: Option<When>) -> Result<(), String> {
        let (at_ns, found) = self.changes.pop_front().ok_or("the outputs have not changed")?;
        is(found == duties, || format!("the outputs have become {found:?} of 65535"))?;
        let (due_ns, most_ns) = match when {
            None => return Ok(()),
            Some(When::AtOnce) => (Some(self.watched_ns), LOOK_NS),
            Some(When::AtStandstill) => (self.machine.last_step_ns(), 25 * MS),
            Some(When::WithMove(count)) => (self.machine.end_of_move_ns(count), LOOK_NS),
        };
        let late_us = (at_ns as f64 - due_ns.ok_or("there was no such move")? as f64) * 1e-3;
        // The clock has microseconds.
        let is_so = (-1.0..=most_ns as f64 * 1e-3 + 1.0).contains(&late_us);
        is(is_so, || format!("the outputs have changed {late_us} us later"))
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
                self.machine.send(*console, bytes)?;
                self.wait(*wait)
            }
            Step::Wait(wait) => self.wait(*wait),
            Step::Silence => self.nothing_unsaid(),
            Step::Report(parts) => self.report(parts),
            Step::Unchanged { error, line } => self.unchanged(error, line),
            Step::Note => {
                self.noted = Noted::of(&mut self.machine)?;
                Ok(())
            }
            Step::UntilHeard => {
                self.wait_until("nothing was heard", |this| Ok(this.heard.iter().any(|heard| !heard.is_empty())))
            }
            Step::UntilOutput(index, on) => {
                self.wait_until("the output has not changed", |this| Ok((this.machine.tool()?[*index] > 0) == *on))
            }
            Step::Rested(numbers, unit_ns) => {
                let rested_ns = self.machine.now_ns() - self.machine.last_step_ns().ok_or("no step was made")?;
                is(numbers.contains((rested_ns / unit_ns) as i64), || format!("the last step was {rested_ns} ns ago"))
            }
            Step::Accessories(letters) => self.accessories(letters),
            Step::Watch(time_ns) => self.watch(*time_ns),
            Step::Changed(duties, when) => self.changed(*duties, *when),
            Step::Press { wire, pressed, bounces: true } => {
                for flips in 0..4 {
                    let pressed = *pressed == (flips % 2 == 0);
                    self.machine.act(&Step::Press { wire: *wire, pressed, bounces: false })?;
                    self.wait(Wait::For(MS / 2))?;
                }
                self.machine.act(&Step::Press { wire: *wire, pressed: *pressed, bounces: false })?;
                // Longer than the debounce time.
                self.wait(Wait::For(20 * MS))
            }
            Step::Tool(duties) => self.outputs(0..5, *duties, 0),
            Step::Output { index, duty, tolerance } => self.outputs(*index..index + 1, [*duty; 5], *tolerance),
            Step::Steps(..)
            | Step::Places(..)
            | Step::PlacesAsNoted
            | Step::Moved(..)
            | Step::Took(..)
            | Step::NoStepMade => self.check_motion(step),
            _ => {
                self.machine.act(step)?;
                self.wait(Wait::None)
            }
        }
    }

    /// Checks what has moved.
    fn check_motion(&mut self, step: &Step) -> Result<(), String> {
        let (found, noted) = (self.machine.counts()?, &self.noted.counts);
        match step {
            Step::Steps(numbers) => all("the steps are", numbers, &found.counted),
            Step::Places(numbers) => {
                let written = &found.places[..numbers.len().min(found.places.len())];
                all("the carriages are, from their switches,", numbers, written)
            }
            Step::PlacesAsNoted => {
                is(found.places == noted.places, || format!("{:?}, and at the note {:?}", found.places, noted.places))
            }
            Step::Moved(numbers) => {
                let moved: Vec<_> = found.counted.iter().zip(&noted.counted).map(|(now, then)| now - then).collect();
                all("since the note it has moved", numbers, &moved)
            }
            Step::Took(numbers, unit_ns) => {
                let took_ns = self.machine.now_ns() - self.noted.at_ns;
                let is_so = numbers.contains((took_ns / unit_ns) as i64);
                is(is_so, || format!("since the note it has taken {} us", took_ns / 1000))
            }
            _ => is(found.made == noted.made, || {
                format!("since the note steps were made: {:?}, and then {:?}", noted.made, found.made)
            }),
        }
    }

    fn outputs(&mut self, which: std::ops::Range<usize>, duties: [u16; 5], tolerance: u16) -> Result<(), String> {
        let (found, tolerance) = (self.machine.tool()?, tolerance.max(M::DUTY_TOLERANCE));
        let is_so = which.into_iter().all(|index| found[index].abs_diff(duties[index]) <= tolerance);
        is(is_so, || format!("the outputs are {found:?} of 65535"))
    }

    /// A status report, and what else was heard with it stays to be written.
    fn ask(&mut self) -> Result<String, String> {
        self.nothing_unsaid()?;
        self.machine.send(0, b"?")?;
        for _ in 0..SOON_MS {
            self.wait(Wait::For(MS))?;
            if let Some(index) = self.heard[0].iter().position(|line| line.starts_with('<')) {
                return Ok(self.heard[0].remove(index));
            }
        }
        Err(format!("no report: {:?}", self.heard[0]))
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

    /// Modes, offsets, settings, start-up lines and the position are as before.
    fn unchanged(&mut self, error: &str, line: &[u8]) -> Result<(), String> {
        let before = self.everything()?;
        self.machine.send(0, &[line, b"\n"].concat())?;
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

/// An error that says what was found, unless it is so.
pub fn is(is_so: bool, found: impl FnOnce() -> String) -> Result<(), String> {
    if is_so { Ok(()) } else { Err(found()) }
}

/// Axes that are not written must be at 0.
fn all(what: &str, numbers: &[Numbers], found: &[i64]) -> Result<(), String> {
    let is_so = (0..numbers.len().max(found.len())).all(|axis| {
        numbers.get(axis).copied().unwrap_or(Numbers::ZERO).contains(found.get(axis).copied().unwrap_or(0))
    });
    is(is_so, || format!("{what} {found:?}"))
}
