//! A board with the proving image: its own PIO stamps the edges of its pads, and its own core presses its switches.

mod stops;

use std::collections::VecDeque;

use anyhow::{Context, Result};

use super::how::{How, Jumper};
use super::judge::{self, Fault, Fineness, Window};
use super::progress::Progress;
use super::session::{Answer, Identity, Session};
use super::stamps::{self, Stamps};
use crate::chip::Chip;
use crate::flight::WINDOW_BYTES;
use crate::measure::board::Followed;
use crate::measure::load::{Awake, Load};
use crate::measure::moves::{Carried, Stream};
use crate::measure::planned_move::PROVED;
use crate::measure::starts::Starts;
use crate::measure::stops::{Cause, Stops};
use crate::measure::{Board, Machine, Measured, Method, PlannedMove, Ramp};

/// The pads of STEP, of all axes.
pub const PADS: [u8; PROVED] = [2, 4, 6];
/// The pad of the image that pulls an input down.
pub const OUT: u8 = 28;
/// Time for which the load is measured, and for which the move cruises around that, s.
const LOADED_S: f64 = 0.5;
const LOADED_CRUISE_S: f64 = 1.0;

fn method(chip: Chip) -> Method {
    Method {
        unit_ns: Fineness::Single.unit_ns(chip),
        start_from: "the line before it",
        edges: "the start of the move is fitted as the median error, so a delay common to all edges does not show",
        rates: "one window in the middle of each move and its end are looked at, not every edge",
        load: "nobody asks for reports meanwhile, and a cruise is less work than a ramp",
        starts: "both lines come in one packet, so the time on the cable is not in it",
        moves: "a curve of one shape; the cable and this computer count too, so a hub or a busy computer makes it less",
    }
}

/// A ramp of this duration, or a longer one: from rest to 2,000,000 steps/s in 0.1 s. It is four times what the fastest machines
/// have, so that a ramp at the highest rates is not too many windows.
pub const fn ramp(s: f64) -> Ramp {
    Ramp { s, accel_max_steps_s2: 2e7 }
}

/// A board that stamps its own edges.
pub struct Stamped<'b, 'l> {
    /// Its console.
    pub session: &'b mut Session<'l>,
    /// Its description of itself.
    pub identity: Identity,
    /// Its chip, whose clock its stamps count.
    pub chip: Chip,
    /// The measurements.
    pub how: &'b How,
    /// Shows how far a measurement is.
    pub progress: &'b Progress,
    /// Faults that were found during a measurement.
    pub faults: Vec<String>,
}

impl Stamped<'_, '_> {
    /// Makes the board this machine.
    pub fn set_up(&mut self, machine: &Machine) -> Result<()> {
        for line in machine.lines() {
            self.session.ask(&line)?;
        }
        Ok(())
    }

    /// Resets the machine, lets go of the wire, and clears an alarm.
    pub fn settle(&mut self) -> Result<()> {
        self.session.restart()?;
        self.session.ask("$PROVE=OUT")?;
        // A switch is debounced.
        self.session.wait(0.03)?;
        self.unlock()
    }

    /// Clears an alarm, if there is one.
    pub fn unlock(&mut self) -> Result<()> {
        if self.session.rest()?.state == "Alarm" {
            self.session.ask("$X")?;
        }
        self.session.take_alarm();
        Ok(())
    }

    /// Makes a move, and waits until it is over.
    pub fn make(&mut self, planned: &PlannedMove) -> Result<()> {
        self.session.ask(&planned.line())?;
        self.session.wait(planned.duration_s())?;
        self.session.rest().map(drop)
    }

    /// Sends two lines in one packet, so that the time from one to the other is always the same; both have to be accepted.
    pub fn ask_both(&mut self, lines: [&str; 2]) -> Result<()> {
        self.session.say(&format!("{}\n{}\n", lines[0], lines[1]))?;
        lines.into_iter().try_for_each(|line| self.session.accepted(line))
    }

    /// Makes a move while the stampers watch these pads. Returns the stamps, and the alarm if one came.
    pub fn stamped(
        &mut self,
        planned: &PlannedMove,
        pads: [u8; 3],
        skip: u32,
    ) -> Result<([Stamps; 3], Option<String>)> {
        self.session.arm(pads, skip)?;
        self.make(planned)?;
        let alarm = self.session.take_alarm();
        Ok((self.session.read(skip)?, alarm))
    }

    /// The windows of these axes, each seen by one stamper.
    pub fn windows(&self, axes: &[usize], stamps: &[Stamps; 3], skip: u32) -> Vec<Window> {
        let of = |(&axis, stamps): (&usize, &Stamps)| {
            self.window(axis, skip, stamps, stamps.instants_ns(self.chip), Fineness::Single)
        };
        axes.iter().zip(stamps).map(of).collect()
    }

    /// The window of an axis that two stampers have seen.
    ///
    /// # Errors
    /// When they do not agree.
    pub fn pair_window(&self, axis: usize, skip: u32, of: [&Stamps; 2]) -> Result<Window> {
        if of.iter().any(|stamps| stamps.lost) {
            let lost = Stamps { lost: true, ..Stamps::default() };
            return Ok(self.window(axis, skip, &lost, Vec::new(), Fineness::Pair));
        }
        let exact = stamps::both(self.chip, of[0], of[1]);
        let instants_ns =
            exact.context("two stampers of one pad have seen different edges: is the image of this release?")?;
        Ok(self.window(axis, skip, of[0], instants_ns, Fineness::Pair))
    }

    fn window(&self, axis: usize, skip: u32, stamps: &Stamps, instants_ns: Vec<f64>, fineness: Fineness) -> Window {
        let is_full = stamps.counted.last().is_some_and(|last| *last >= skip + self.identity.window as u32);
        let (counted, lost, chip) = (stamps.counted.clone(), stamps.lost, self.chip);
        Window { axis, instants_ns, counted, is_full, lost, fineness, chip }
    }

    /// The edges that are left out in each of the windows that cover a move of `count` steps: all of them, or `most`,
    /// evenly from its beginning to its end.
    pub fn skips(&self, count: u32, most: usize) -> Vec<u32> {
        // Each window has the first edge again.
        let own = (self.identity.window - 1) as u32;
        let needed = (count.saturating_sub(1)).div_ceil(own).max(1);
        let shown = u32::try_from(most).unwrap_or(u32::MAX).clamp(1, needed);
        let last = needed - 1;
        (0..shown).map(|index| own * if shown == 1 { 0 } else { (index * last).div_ceil(shown - 1) }).collect()
    }

    /// Makes a move and looks at its middle and its end.
    fn looked_at(&mut self, planned: &PlannedMove, followed: &mut Followed) -> Result<Measured<()>> {
        let skip = planned.steps_by(0, planned.duration_s() / 2.0);
        let (stamps, alarm) = self.stamped(planned, PADS, skip)?;
        if let Some(alarm) = alarm {
            return Ok(Err(alarm));
        }
        let axes = (0..PROVED).filter(|&axis| planned.count(axis) > 0);
        let verdict = judge::judge(planned, &self.windows(&axes.collect::<Vec<_>>(), &stamps, skip));
        let is_broken = |fault: &&Fault| !matches!(fault, Fault::OutOfLine { .. } | Fault::Far { .. });
        if let Some(fault) = verdict.faults.iter().find(is_broken) {
            return Ok(Err(fault.to_string()));
        }
        verdict.judged.iter().flatten().for_each(|one| followed.errors.add(one.error_ns));
        Ok(Ok(()))
    }

    /// The delay of a start that follows this line, ms.
    fn start_ms(&mut self, before: &str, planned: &PlannedMove) -> Result<f64> {
        self.session.ask("$PROVE=OUT")?;
        self.session.arm([PADS[0], PADS[1], OUT], 0)?;
        self.ask_both([before, &planned.line()])?;
        self.session.wait(planned.duration_s())?;
        self.session.rest()?;
        let stamps = self.session.read(0)?;
        let pulled_ns = stamps[2]
            .instants_ns(self.chip)
            .first()
            .copied()
            .with_context(|| format!("GP{OUT} was not seen to go low"))?;
        let verdict = judge::judge(planned, &self.windows(&[0, 1], &stamps, 0));
        Ok((verdict.start_ns - pulled_ns) * 1e-6)
    }
}

impl Board for Stamped<'_, '_> {
    fn method(&self) -> Method {
        method(self.chip)
    }

    fn note(&mut self, what: &str) {
        self.progress.step(what);
    }

    fn follow(&mut self, machine: &Machine, moves: &[PlannedMove]) -> Result<Measured<Followed>> {
        let mut followed = Followed::default();
        // The board may refuse the rate, which is an answer; if it is gone, the next line says so.
        let mut made = self.set_up(machine).map_err(|refused| format!("{refused:#}"));
        for planned in moves {
            if made.is_ok() {
                made = self.looked_at(planned, &mut followed).unwrap_or_else(|error| Err(format!("{error:#}")));
            }
        }
        if made.is_err() {
            self.settle()?;
        }
        Ok(made.map(|()| followed))
    }

    fn load(&mut self, rate_steps_s: u32) -> Result<Measured<Load>> {
        let machine = Machine::new(rate_steps_s, ramp(0.1));
        let planned = machine.straight(PROVED, LOADED_CRUISE_S)?;
        self.set_up(&machine)?;
        let session = &mut *self.session;
        // This begins to measure, and the one after the move ends it: programming settings into the flash masks interrupts
        // for long, at rest, and does not count.
        session.numbers::<1>("$PROVE=MASK", "MASK")?;
        session.ask(&planned.line())?;
        session.wait(planned.profile().t_accel_s() + (LOADED_CRUISE_S - LOADED_S) / 2.0)?;
        session.numbers::<2>("$PROVE=LOAD", "LOAD")?;
        session.wait(LOADED_S)?;
        let [asleep_us, all_us] = session.numbers("$PROVE=LOAD", "LOAD")?;
        session.rest()?;
        let [cycles] = session.numbers("$PROVE=MASK", "MASK")?;
        Ok(Ok(Load {
            cruising: Awake { ratio: 1.0 - asleep_us / all_us.max(1.0), cycles_per_step: None },
            ramping: None,
            waited_us: Some(cycles * self.chip.cycle_ns() * 1e-3),
            resolution: format!("1 us of {:.0} ms", all_us * 1e-3),
        }))
    }

    fn stops(&mut self, cause: Cause, rate_steps_s: u32, count: u32) -> Result<Measured<Stops>> {
        stops::measure(self, cause, rate_steps_s, count)
    }

    /// A line that pulls a pad down comes right before the line of the move, in one packet. The pad is stamped, so the time from
    /// there to the start of the move is on one clock: to read a line, plan, compile, and let all axes go.
    fn starts(&mut self, count: u32) -> Result<Measured<Starts>> {
        if self.how.jumpers.contains(&Jumper::Estop) {
            return Ok(
                Err("the pad that is pulled down would press the emergency stop: take the wire away".to_owned()),
            );
        }
        let machine = Machine::new(100_000, ramp(0.02));
        let mut planned = machine.straight(PROVED, 0.0)?;
        self.set_up(&machine)?;
        // The wire may lead to a limit switch.
        self.session.ask("$21=0")?;
        let mut starts = Starts::default();
        for (before, delays_ms) in [("$PROVE=OUT,0", &mut starts.warm_ms), ("$PROVE=COLD", &mut starts.cold_ms)] {
            for index in 0..=count {
                let delay_ms = self.start_ms(before, &planned)?;
                // The first one warms up.
                delays_ms.extend((index > 0).then_some(delay_ms));
                planned = planned.back();
            }
        }
        self.session.ask("$PROVE=OUT")?;
        Ok(Ok(starts))
    }

    fn stream(&mut self, stream: &Stream) -> Result<Measured<Carried>> {
        // Back to zero while a millimetre is what it was: the same steps are many millimetres afterwards.
        self.set_up(&Machine::new(100_000, ramp(0.02)))?;
        self.session.ask("G90 G53 G0 X0 Y0 Z0")?;
        self.session.rest()?;
        for line in &stream.before {
            self.session.ask(line)?;
        }
        let (mut unanswered, mut in_flight) = (VecDeque::new(), 0);
        let mut at_s = Vec::with_capacity(stream.lines.len());
        let mut waiting = stream.lines.iter().peekable();
        while at_s.len() < stream.lines.len() {
            let mut packet = String::new();
            while let Some(line) = waiting.next_if(|line| in_flight + line.len() < WINDOW_BYTES) {
                in_flight += line.len() + 1;
                unanswered.push_back(line);
                packet += &format!("{line}\n");
            }
            if !packet.is_empty() {
                self.session.say(&packet)?;
            }
            let Some(line) = unanswered.pop_front() else { break };
            if let Answer::Refused(why) = self.session.answer(line)? {
                return Ok(Err(format!("`{line}` was answered {why}")));
            }
            in_flight -= line.len() + 1;
            at_s.push(self.session.now_s());
        }
        self.session.rest()?;
        let alarm = self.session.take_alarm();
        Ok(alarm.map_or(Ok(Carried { at_s, by: "the answers", awake_ratio: None }), |alarm| {
            Err(format!("the moves ended in {alarm}"))
        }))
    }
}
