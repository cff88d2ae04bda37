//! Runs scripts of the emulated board on a simulated machine. It supports the commands that apply to a simulated
//! machine.

use std::collections::VecDeque;

use embassy_time::Duration;
use isostep_motion::{Axis, Motor};
use isostep_sim::tool::ToolOutput;
use isostep_sim::world::Wire;
use isostep_sim::{Sim, State, SwitchFault};

/// How often a wait looks for its condition.
const LOOK_EVERY: Duration = Duration::from_micros(100);
/// How long a wait lasts at most.
const PATIENCE: Duration = Duration::from_secs(60);

/// A simulated machine, and the lines that it has sent.
pub struct ScriptRunner {
    sim: Sim,
    replies: VecDeque<String>,
    statuses: VecDeque<String>,
    messages: VecDeque<String>,
}

impl ScriptRunner {
    /// For a machine that has sent nothing yet.
    #[must_use]
    pub fn new(sim: Sim) -> Self {
        Self { sim, replies: VecDeque::new(), statuses: VecDeque::new(), messages: VecDeque::new() }
    }

    /// Runs a script.
    ///
    /// # Panics
    /// At the first line that fails or is not a supported command.
    pub fn carry_out(&mut self, script: &str) {
        let mut case = "";
        for (number, line) in (1..).zip(script.lines()) {
            if let Some(name) = line.strip_prefix("# case: ") {
                case = name;
                continue;
            }
            let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
            if let Err(error) = self.carry_out_command(word, rest) {
                panic!("case {case}, line {number} ({line}): {error}");
            }
        }
    }

    fn carry_out_command(&mut self, word: &str, rest: &str) -> Result<(), String> {
        match word {
            "send" => self.sim.send(format!("{rest}\n").as_bytes()),
            "bytes" => self.sim.send(&bytes(rest)?),
            "expect" => return self.expect(rest),
            "wait-ms" => self.run_for(Duration::from_millis(rest.parse().map_err(|error| format!("{error}"))?)),
            "wait-idle" => return self.wait_idle(),
            "wait-output" => return self.wait_output(rest),
            "check-position" => return self.check_position(),
            "motors" => return self.check_motors(rest),
            "switch" => return self.set_switch(rest),
            "estop" => self.sim.set_emergency_stop(rest == "pressed"),
            "probe" => self.sim.set_hand_input(Wire::Probe, rest == "pressed"),
            _ => return Err("no command of a simulated machine".to_owned()),
        }
        Ok(())
    }

    fn run_for(&mut self, time: Duration) {
        self.sim.run_for(time).expect("no livelock");
        for line in self.sim.replies() {
            match &line {
                _ if line == "ok" || line.starts_with("error:") => self.replies.push_back(line),
                _ if line.starts_with('<') => self.statuses.push_back(line),
                _ => self.messages.push_back(line),
            }
        }
    }

    /// Runs the machine until `look` finds something.
    fn wait_for<T>(&mut self, what: &str, mut look: impl FnMut(&mut Self) -> Option<T>) -> Result<T, String> {
        let end = self.sim.now() + PATIENCE;
        loop {
            if let Some(found) = look(self) {
                return Ok(found);
            }
            if self.sim.now() >= end {
                return Err(format!("no {what}; the last messages are {:?}", self.messages));
            }
            self.run_for(LOOK_EVERY);
        }
    }

    /// The next reply or status must begin with `prefix`. Other messages are searched for one that does.
    fn expect(&mut self, prefix: &str) -> Result<(), String> {
        let next = |runner: &mut Self| match prefix {
            _ if prefix.starts_with("ok") || prefix.starts_with("error") => runner.replies.pop_front(),
            _ if prefix.starts_with('<') => runner.statuses.pop_front(),
            _ => {
                let index = runner.messages.iter().position(|line| line.starts_with(prefix))?;
                runner.messages.drain(..=index).next_back()
            }
        };
        let found = self.wait_for(prefix, next)?;
        if found.starts_with(prefix) { Ok(()) } else { Err(format!("got {found}")) }
    }

    fn wait_idle(&mut self) -> Result<(), String> {
        let is_idle = |runner: &mut Self| (runner.sim.machine().state() == State::Idle).then_some(());
        self.wait_for("state Idle", is_idle)
    }

    fn wait_output(&mut self, rest: &str) -> Result<(), String> {
        let (name, state) = rest.split_once(' ').ok_or("which output, and on or off?")?;
        let index = ToolOutput::ALL.iter().position(|output| output.to_string() == name).ok_or("no such output")?;
        self.wait_for(rest, |runner| ((runner.sim.tool()[index] > 0) == (state == "on")).then_some(()))
    }

    fn check_position(&mut self) -> Result<(), String> {
        let (reported, counted) = (self.sim.machine().position_steps(), self.sim.counted_steps());
        if reported == counted { Ok(()) } else { Err(format!("it says {reported:?}, and {counted:?} left the pins")) }
    }

    fn check_motors(&mut self, state: &str) -> Result<(), String> {
        let waves = self.sim.outcome().waves;
        // The drivers are enabled by a low ENABLE.
        let on = waves.iter().rfind(|wave| wave.wire == Wire::Enable).is_some_and(|wave| !wave.high);
        if on == (state == "on") { Ok(()) } else { Err(format!("the motors are energised: {on}")) }
    }

    fn set_switch(&mut self, rest: &str) -> Result<(), String> {
        let (motor, fault) = match rest {
            "X stuck-closed" => (Motor::first(Axis::X), SwitchFault::StuckClosed),
            "X stuck-open" => (Motor::first(Axis::X), SwitchFault::StuckOpen),
            "X normal" => (Motor::first(Axis::X), SwitchFault::None),
            "2 stuck-closed" => (Motor::second(Axis::X), SwitchFault::StuckClosed),
            "2 normal" => (Motor::second(Axis::X), SwitchFault::None),
            _ => return Err("no fault of this switch here".to_owned()),
        };
        self.sim.set_switch(motor, fault);
        Ok(())
    }
}

fn bytes(hex: &str) -> Result<Vec<u8>, String> {
    hex.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).map_err(|error| format!("{byte}: {error}")))
        .collect()
}
