//! Executes a scenario, checks the world meanwhile, and brings the machine back to motion afterwards.

use embassy_time::Duration;
use isostep_motion::{AXES, Axis, Direction, GangedMotor, Kinematics, Motor, State};

use super::drivers::Failing;
use super::scenario::{Act, Scenario};
use super::spindle::SpindleWatch;
use super::talk::{Talk, WELCOME};
use super::{Amount, Failure, judge};
use crate::config::Config;
use crate::executor::RunError;
use crate::faults::{Fault, Trouble};
use crate::flash::Flash;
use crate::plant::SwitchFault;
use crate::record::Wire;
use crate::sim::Sim;
use crate::tool::ToolOutput;

/// In motion a port reports its count so often, s.
const COUNTED_EVERY_S: f64 = 10e-3;

/// Time between two checks of the world, us.
pub(super) const LOOK_US: u64 = 20_000;
/// The longest wait of an act of rest, us.
const REST_US: u64 = 10_000_000;
/// The longest time that a sender waits for room, us, and the most bytes that it keeps unanswered.
const ROOM_US: u64 = 2_000_000;
const WINDOW_BYTES: usize = 128;
/// The longest duration of a fault, us.
const FAULT_MAX_US: u64 = 600_000;
/// A driver that fails has stopped the machine after this time, us: it is asked ten times a second, as the others are,
/// and some of them may be silent.
const DRIVER_REPORTED_US: u64 = 500_000;
/// The drivers have been set after this time from power-up, us, if they answer.
const START_US: u64 = 200_000;
/// A drive in alarm has stopped the steps after this time, us, and locked the machine after that: homing looks first whether a switch is
/// steady.
const ALARMED_US: u64 = 100;
const LOCKED_US: u64 = 100_000;
const ALARM: &str = "ALARM:";
pub(super) const DRIVER_ALARM: &str = "ALARM:17";
/// The longest time that the machine may need to finish.
const LIMIT: Duration = Duration::from_secs(3_600);
/// Attempts to bring a machine back to idle: there may be many M0 among the waiting lines.
const LEADS: u32 = 60;
/// Length of the final test move, mm.
const SMALL_MM: f64 = 0.5;

/// The observations at one instant.
#[derive(Clone, Copy, Debug)]
struct Look {
    state: State,
    steps: [u64; AXES],
    events: usize,
    runs: usize,
}

pub(super) struct Runner<'a> {
    scenario: &'a Scenario,
    pub(super) sim: Sim,
    flash: Flash,
    pub(super) talks: Vec<Talk>,
    amount: Amount,
    /// True if bytes may have been lost on a link. Then the machine may have received any command.
    pub(super) is_spoilt: bool,
    /// The steps made when a console was last welcomed.
    pub(super) welcomed_at: [u64; AXES],
    /// When the last fault of the feed hold, or of the safety door, is over, ns.
    pub(super) held_until_ns: u64,
    /// True if switches or motors may have misled the machine.
    pub has_deceived: bool,
    /// True if a driver may have failed.
    had_driver_fault: bool,
    /// What was seen of the VFD, and until when something was wrong with it, ns.
    spindle: SpindleWatch,
    /// The number of times that a console was told of an alarm.
    alarms: usize,
    act: Option<usize>,
}

impl<'a> Runner<'a> {
    pub fn new(scenario: &'a Scenario) -> Self {
        let flash = Flash::blank();
        let config = Config { time_limit: LIMIT, ..scenario.config.clone() };
        let sim = Sim::with_flash(&config, flash.clone());
        let talks = (0..=usize::from(config.second_console)).map(|_| Talk::default()).collect();
        let amount = Amount::default();
        Self {
            scenario,
            sim,
            flash,
            talks,
            amount,
            is_spoilt: false,
            welcomed_at: [0; AXES],
            held_until_ns: 0,
            has_deceived: false,
            // Steps that are lost are one.
            had_driver_fault: config.closed_loop,
            spindle: SpindleWatch::default(),
            alarms: 0,
            act: None,
        }
    }

    pub fn run(mut self) -> Result<Amount, Failure> {
        for (index, act) in self.scenario.acts.iter().enumerate() {
            self.act = Some(index);
            self.amount.faults += u64::from(act.is_fault());
            self.carry_out(act)?;
        }
        self.act = None;
        self.end_world()?;
        Ok(self.amount)
    }

    pub(super) fn failure(&self, promise: &'static str, found: impl Into<String>) -> Failure {
        Failure { promise, found: found.into(), act: self.act }
    }

    fn carry_out(&mut self, act: &Act) -> Result<(), Failure> {
        match act {
            Act::Line(console, line) => self.send_line(*console, line),
            Act::Bytes(console, bytes) => {
                self.is_spoilt |= bytes.ends_with(b"\n");
                self.send(*console, bytes);
                Ok(())
            }
            Act::Reset { by, early, late, apart_us } => self.reset(*by, early, late, *apart_us),
            Act::Wait(us) => self.wait(*us),
            Act::Rest => self.rest(),
            Act::Fault(trouble, us) => {
                self.suffer(*trouble, *us);
                Ok(())
            }
            Act::Drivers(failings) => self.fail_drivers(failings),
            Act::Drive(motor, us) => self.alarm(*motor, *us),
            Act::Vfd(fault, us) => {
                self.suffer(Trouble::Vfd(*fault), *us);
                Ok(())
            }
            Act::Between(sections, stimulus) => {
                // Bytes of the stimulus may be a reset.
                self.talks.iter_mut().for_each(|talk| talk.may_forget());
                self.has_deceived = true;
                self.sim.after_sections(*sections, stimulus.clone());
                Ok(())
            }
            Act::Open => {
                self.hear()?;
                self.sim.open_console();
                self.talks[0] = Talk::of_opened_console();
                self.hear()
            }
            Act::PowerCut(operations) => self.cut_power(*operations),
        }
    }

    fn suffer(&mut self, trouble: Trouble, us: u64) {
        // If switches and motors mislead it, a machine cannot know its position.
        self.has_deceived |= !matches!(
            trouble,
            Trouble::EmergencyStop
                | Trouble::BrokenEmergencyStop
                | Trouble::Hold
                | Trouble::Start
                | Trouble::Vfd(_)
                | Trouble::Starve
                | Trouble::Deaf
        );
        let until_ns = self.sim.now_ns() + us * 1_000;
        match trouble {
            Trouble::Hold => self.held_until_ns = until_ns,
            Trouble::Vfd(_) => self.spindle.is_wrong_to(until_ns),
            Trouble::Starve => self.spindle.starves_to(until_ns),
            _ => {}
        }
        self.sim.suffer(Fault { trouble, at_ns: self.sim.now_ns(), lasts_ns: Some(us * 1_000) });
    }

    /// A drive that is in alarm stops the machine at once, whatever it does, and no position is trusted. If its alarm is wired.
    fn alarm(&mut self, motor: Motor, us: u64) -> Result<(), Failure> {
        self.await_start()?;
        self.had_driver_fault = true;
        self.suffer(Trouble::Alarm(motor), us);
        self.wait(ALARMED_US)?;
        let steps = self.sim.steps();
        self.wait(LOCKED_US)?;
        let wire = if self.scenario.config.one_alarm_wire { Axis::X } else { motor.axis };
        let is_wired = self.sim.machine().config().drive_alarms[wire as usize].is_some();
        let (state, homed) = (self.sim.machine().state(), self.sim.machine().homed());
        let is_stopped = self.is_locked() && homed == [false; AXES] && self.sim.steps() == steps;
        if is_wired && !self.is_spoilt && !is_stopped {
            let found = format!("{state}, {homed:?} after {}", Trouble::Alarm(motor));
            return Err(self.failure("a drive in alarm stops the machine, and no position is trusted", found));
        }
        Ok(())
    }

    /// Waits until the drivers have been set after power-up. What fails for an instant before that matters to nobody.
    fn await_start(&mut self) -> Result<(), Failure> {
        self.wait_to(START_US * 1_000)
    }

    /// Drivers that fail stop the machine, whatever it does, within the time of a few rounds. It may be stopped by something else
    /// at the same time, and a line that waited may have unlocked it. One that is locked trusts no position any more.
    fn fail_drivers(&mut self, failings: &[Failing]) -> Result<(), Failure> {
        self.await_start()?;
        self.had_driver_fault = true;
        let from_ns = self.sim.now_ns();
        let mut stopping = Vec::new();
        for failing in failings {
            self.wait_to(from_ns + failing.after_us * 1_000)?;
            // A motor that is off since an earlier fault, or while its driver is set anew, is in no danger.
            if failing.must_stop(|motor| self.has_motor(motor) && !self.sim.is_driver_off(motor)) {
                stopping.push((failing, self.is_locked(), self.alarms));
            }
            self.suffer(failing.trouble(), failing.us);
        }
        let reported_us = failings.iter().map(|failing| failing.after_us + failing.us.max(DRIVER_REPORTED_US)).max();
        self.wait_to(from_ns + reported_us.unwrap_or(0) * 1_000)?;
        if self.is_spoilt {
            return Ok(());
        }
        let (state, homed) = (self.sim.machine().state(), self.sim.machine().homed());
        let goes_on = |&&(_, was_locked, alarms): &&(_, bool, usize)| !was_locked && alarms == self.alarms;
        if let Some((failing, ..)) = stopping.iter().find(goes_on).filter(|_| !self.is_locked()) {
            let found = format!("{state} after {}", failing.trouble());
            return Err(self.failure("a driver that fails stops the machine", found));
        }
        if self.is_locked() && !stopping.is_empty() && homed != [false; AXES] {
            let found = format!("{homed:?} in {state}");
            return Err(self.failure("after a driver has failed no position is trusted", found));
        }
        Ok(())
    }

    fn watch_spindle(&mut self) -> Result<(), Failure> {
        let found = if self.is_spoilt { Ok(()) } else { self.spindle.look(&self.sim, &self.scenario.config) };
        found.map_err(|(promise, found)| self.failure(promise, found))
    }

    fn has_motor(&self, motor: Motor) -> bool {
        let second = self.sim.machine().config().squared.map(|squared| Motor::second(squared.axis));
        motor.ganged == GangedMotor::First || Some(motor) == second
    }

    fn is_locked(&self) -> bool {
        matches!(self.sim.machine().state(), State::Alarm(_))
    }

    pub(super) fn send(&mut self, console: usize, bytes: &[u8]) {
        self.talks[console].say(bytes);
        self.sim.send_to(console, bytes);
    }

    /// Sends a line when there is room for it, as senders do. Does not send it if there is no room in time.
    fn send_line(&mut self, console: usize, line: &str) -> Result<(), Failure> {
        let mut waited_us = 0;
        while self.talks[console].unanswered_bytes() + line.len() + 1 > WINDOW_BYTES
            && self.talks[console].unanswered_bytes() > 0
        {
            if waited_us >= ROOM_US {
                return Ok(());
            }
            self.wait(LOOK_US)?;
            waited_us += LOOK_US;
        }
        self.amount.lines += 1;
        self.send(console, format!("{line}\n").as_bytes());
        Ok(())
    }

    pub(super) fn hear(&mut self) -> Result<(), Failure> {
        for console in 0..self.talks.len() {
            for line in self.sim.replies_of(console) {
                self.alarms += usize::from(line.starts_with(ALARM));
                if line == DRIVER_ALARM && !self.had_driver_fault {
                    let found = format!("console {console}: {line}");
                    return Err(self.failure("no driver is said to fail that does not", found));
                }
                if line.starts_with(WELCOME) {
                    self.welcomed_at = self.sim.steps();
                }
                if !self.talks[console].hear(&line) {
                    return Err(
                        self.failure("one answer for each line", format!("console {console}: one more `{line}`"))
                    );
                }
            }
        }
        Ok(())
    }

    /// Lets time pass and checks the world.
    pub(super) fn wait(&mut self, us: u64) -> Result<(), Failure> {
        let mut left_us = us;
        while left_us > 0 {
            let before = self.look()?;
            let slice_us = left_us.min(LOOK_US);
            let ran = self.sim.run_for(Duration::from_micros(slice_us));
            self.ran(ran)?;
            left_us -= slice_us;
            let after = self.look()?;
            self.compare(before, after)?;
            self.watch_spindle()?;
            self.hear()?;
        }
        Ok(())
    }

    /// Lets time pass up to `at_ns` since power-up.
    fn wait_to(&mut self, at_ns: u64) -> Result<(), Failure> {
        self.wait(at_ns.saturating_sub(self.sim.now_ns()) / 1_000)
    }

    fn ran(&self, ran: Result<(), RunError>) -> Result<(), Failure> {
        match ran {
            // A damaged command may have asked for a wait this long.
            Err(RunError::TimeLimit { .. }) if self.is_spoilt => Ok(()),
            ran => ran.map_err(|error| self.failure("everything comes to an end", error.to_string())),
        }
    }

    fn rest(&mut self) -> Result<(), Failure> {
        for _ in 0..REST_US / LOOK_US {
            if self.is_at_rest() {
                return Ok(());
            }
            self.wait(LOOK_US)?;
        }
        Ok(())
    }

    pub(super) fn is_at_rest(&self) -> bool {
        matches!(self.sim.machine().state(), State::Idle | State::Alarm(_) | State::Hold { still: true })
    }

    /// Checks what must be true at any instant.
    fn look(&self) -> Result<Look, Failure> {
        let (state, tool) = (self.sim.machine().state(), self.sim.tool());
        if matches!(state, State::Alarm(_)) && tool != [0; 5] {
            return Err(self.failure("in an alarm all outputs are off", format!("{tool:?} in {state}")));
        }
        let config = self.sim.machine().config();
        let is_at_rest = matches!(state, State::Idle | State::Hold { still: true });
        if config.tool.laser && is_at_rest && tool[ToolOutput::Pwm as usize] != 0 {
            return Err(self.failure("a laser is dark at rest", format!("{tool:?} in {state}")));
        }
        self.look_at_travel(state)?;
        Ok(Look { state, steps: self.sim.steps(), events: self.sim.events(), runs: self.sim.runs() })
    }

    /// A homed axis must be within its travel.
    fn look_at_travel(&self, state: State) -> Result<(), Failure> {
        let machine = self.sim.machine();
        if !self.scenario.config.settings.soft_limits || !matches!(state, State::Run | State::Jog) || self.is_spoilt {
            return Ok(());
        }
        let (homed, position_steps, config) = (machine.homed(), machine.position_steps(), machine.config());
        let motors = config.of_motors();
        for axis in Axis::ALL.into_iter().filter(|axis| homed[*axis as usize]) {
            let (at, travel) = (position_steps[axis as usize], config.travel_steps(axis));
            // In motion the counts of two motors are from different instants.
            let is_of_two = config.kinematics.is_shared(axis);
            let slack =
                f64::from(u8::from(is_of_two)) * motors.limits[axis as usize].top_speed_steps_s * COUNTED_EVERY_S;
            let slack_steps = slack.ceil() as i32;
            if at < travel.start() - slack_steps || at > travel.end() + slack_steps {
                return Err(
                    self.failure("a homed axis stays within its travel", format!("{axis} at {at} of {travel:?}"))
                );
            }
        }
        Ok(())
    }

    /// A machine that is locked or held must not move. Between two looks it may have been unlocked, have begun a run, and
    /// have been stopped again.
    fn compare(&self, before: Look, after: Look) -> Result<(), Failure> {
        let stands = matches!(before.state, State::Alarm(_) | State::Hold { still: true });
        let is_unchanged = before.state == after.state && (before.events, before.runs) == (after.events, after.runs);
        if stands && is_unchanged && before.steps != after.steps {
            return Err(self.failure("what is locked or held stands still", format!("{before:?}, then {after:?}")));
        }
        Ok(())
    }

    /// Cuts the power: another machine starts with the contents of the flash.
    fn cut_power(&mut self, operations: u64) -> Result<(), Failure> {
        self.flash.cut_power_after(operations, self.scenario.config.seed);
        self.wait(200_000)?;
        self.take_stock()?;
        self.flash.mend();
        let config = Config { time_limit: LIMIT, ..self.scenario.config.clone() };
        self.sim = Sim::with_flash(&config, self.flash.clone());
        self.talks.iter_mut().for_each(|talk| *talk = Talk::default());
        (self.has_deceived, self.held_until_ns, self.spindle) = (false, 0, SpindleWatch::default());
        self.wait(1_000)
    }

    /// Ends all faults and brings the machine back to motion.
    fn end_world(&mut self) -> Result<(), Failure> {
        self.sim.forget_stimuli();
        self.wait(FAULT_MAX_US)?;
        self.wait_to(self.spindle.wrong_until_ns)?;
        for wire in [Wire::EmergencyStop, Wire::Hold, Wire::Start, Wire::Probe] {
            self.sim.set_hand_input(wire, false);
        }
        self.sim.set_plate(None);
        for axis in Axis::ALL {
            self.sim.set_switch(axis, SwitchFault::None);
        }
        self.lead_on()?;
        self.check_answers()?;
        // A driver that had found a short is switched off and on in its next round after an unlock, and is well then. What
        // could not be read from a driver before is told now.
        let ran = self.sim.run_for(Duration::from_micros(DRIVER_REPORTED_US));
        self.ran(ran)?;
        self.lead_on()?;
        self.move_a_little()?;
        self.take_stock()
    }

    /// Runs until nothing can happen any more.
    fn run_out(&mut self) -> Result<(), Failure> {
        let ran = self.sim.run_until_idle();
        self.ran(ran)?;
        self.look()?;
        self.hear()
    }

    /// Brings the machine from any state to idle, by what an operator can do.
    fn lead_on(&mut self) -> Result<(), Failure> {
        // End a line that may have no end.
        (0..self.talks.len()).for_each(|console| self.send(console, b"\n"));
        let mut word = String::new();
        for _ in 0..LEADS {
            self.run_out()?;
            let was_locked = word == "Alarm";
            word = self.word()?;
            let tool = self.sim.tool();
            if matches!(word.as_str(), "Sleep" | "Door:0") && tool != [0; 5] {
                return Err(
                    self.failure("in sleep and behind an open door all outputs are off", format!("{tool:?} in {word}"))
                );
            }
            match word.as_str() {
                "Idle" => return Ok(()),
                "Hold:0" | "Door:0" => self.send(0, b"~"),
                "Alarm" if was_locked => self.set_anew()?,
                "Alarm" => self.send(0, b"$X\n"),
                "Check" => self.send(0, b"$C\n"),
                "Sleep" => self.send(0, &[0x18]),
                // A damaged command may have asked for hours of motion.
                "Run" | "Jog" if self.is_spoilt => self.send(0, &[0x18]),
                _ => return Err(self.failure("every wait ends", format!("it rests in {word}"))),
            }
        }
        let word = self.word()?;
        Err(self.failure("whatever can be resumed can be resumed", format!("it stays in {word}")))
    }

    /// Unlocks a machine that settings lock, because they do not work together: those that it began with do.
    fn set_anew(&mut self) -> Result<(), Failure> {
        let settings = self.scenario.config.settings;
        for (number, value) in (0..1_000).filter_map(|number| Some((number, settings.get(number)?))) {
            self.send(0, format!("${number}={value}\n").as_bytes());
            self.run_out()?;
        }
        self.send(0, b"$X\n");
        Ok(())
    }

    /// The state as named in a status report.
    fn word(&mut self) -> Result<String, Failure> {
        self.hear()?;
        self.send(0, b"?");
        self.run_out_for_report()
    }

    fn run_out_for_report(&mut self) -> Result<String, Failure> {
        let ran = self.sim.run_until_idle();
        self.ran(ran)?;
        let mut word = None;
        for line in self.sim.replies_of(0) {
            if let Some(report) = line.strip_prefix('<') {
                word = report.split(['|', '>']).next().map(str::to_owned);
            }
        }
        word.ok_or_else(|| self.failure("a report is given whenever asked for", "none came".to_owned()))
    }

    fn check_answers(&self) -> Result<(), Failure> {
        for (console, talk) in self.talks.iter().enumerate() {
            let lines = talk.missing_answers();
            if lines > 0 {
                let found = format!("console {console}: {lines} lines have none");
                return Err(self.failure("every line is answered", found));
            }
        }
        Ok(())
    }

    /// The machine must execute a move from its present position.
    fn move_a_little(&mut self) -> Result<(), Failure> {
        let machine = self.sim.machine();
        let config = machine.config();
        let was_steps = machine.position_steps();
        // Away from the nearer end of the first axis, by its true position.
        let place_mm = config.mm(Axis::X, self.sim.places_steps()[0]);
        let away = if place_mm < config.travel_mm[0] / 2.0 { SMALL_MM } else { -SMALL_MM };
        let mm = if config.homing.towards[0] == Direction::Negative { away } else { -away };
        self.hear()?;
        // In machine coordinates: the program's place may be up to half a step from where the machine stands.
        let wanted = was_steps[0] + config.steps(Axis::X, mm);
        let target_mm = config.mm(Axis::X, wanted);
        self.send(0, format!("G21 G90 G94 G53 G1 X{target_mm:.6} F300\n").as_bytes());
        let ran = self.sim.run_until_idle();
        self.ran(ran)?;
        if self.is_spoilt {
            // A damaged command may have changed its position and its travel.
            return Ok(());
        }
        let mut wanted_steps = was_steps;
        wanted_steps[0] = wanted;
        let said = self.sim.replies_of(0);
        let is_at = self.sim.machine().position_steps();
        // With belts, the other axis may have stood half a step beside, and goes to a whole one.
        let slack_steps = [0, if config.kinematics == Kinematics::CoreXy { 1 } else { 0 }];
        let is_there = |axis: usize| is_at[axis].abs_diff(wanted_steps[axis]) <= slack_steps[usize::from(axis == 1)];
        if said.last().map(String::as_str) != Some("ok") || !(0..AXES).all(is_there) {
            let found = format!("X{target_mm:.6} from {was_steps:?} led to {is_at:?}, and it said {said:?}");
            return Err(self.failure("at last it moves where it is sent", found));
        }
        Ok(())
    }

    /// Judges the whole record of this machine.
    fn take_stock(&mut self) -> Result<(), Failure> {
        let outcome = self.sim.outcome();
        let machine = self.sim.machine();
        let is_moving = !self.is_at_rest();
        self.amount = self.amount.and(Amount {
            virtual_ns: outcome.duration_ns,
            steps: outcome.edges.len() as u64,
            sections: self.sim.sections(),
            ..Amount::default()
        });
        let found = if is_moving {
            judge::timing(&outcome)
        } else {
            judge::judge(&outcome, machine.homed(), self.has_deceived || self.is_spoilt)
        };
        found.map_err(|(promise, found)| self.failure(promise, found))
    }
}
