//! A reset, behind which all hosts are silent: every console must be told, and nothing that was sent before it may be
//! carried out, prompt or be answered after it.

use isostep_console::report::messages;
use isostep_motion::State;

use super::Failure;
use super::runner::{DRIVER_ALARM, LOOK_US, Runner};
use super::talk::{Talk, is_answer};

/// Time in which the consoles read what has been sent, us.
const READING_US: u64 = 100_000;
/// Time in which a host notices the welcome and sends its next line, us.
const NOTICE_US: u64 = 1_000;
/// The longest time until all consoles have been told, the machine is at rest and has been quiet, us.
const LONGEST_US: u64 = 30_000_000;
/// The time for which it must be quiet, us. It is longer than any dwell or fault.
const QUIET_US: u64 = 1_000_000;
/// The longest time after which a button that was pressed has its effect, ns.
const BUTTON_NS: u64 = 100_000_000;

/// The alarm of a VFD that cannot be told to stop.
const VFD_ALARM: &str = "ALARM:19";

const FORGOTTEN: &str = "nothing from before a reset is carried out after it";

/// The knowledge that the host of a console has of a reset.
struct Host {
    /// Number of welcomes of which it knows.
    welcomes: u32,
    /// The number of lines it has sent that may have to be answered after the reset.
    sent: usize,
    is_informed: bool,
}

impl Runner<'_> {
    /// Resets the machine by console `by`, whose host sends an empty line behind the reset. Before that the host of the
    /// other one sends `early`, and after that, if it has not been told yet, `late`. As soon as it has been told it
    /// sends an empty line, too. That is all that anybody sends.
    pub(super) fn reset(&mut self, by: usize, early: &[u8], late: &[u8], apart_us: u64) -> Result<(), Failure> {
        self.sim.forget_stimuli();
        // What is in a host's own buffers is not covered.
        if !self.is_all_read()? {
            return Ok(());
        }
        let others = (0..self.talks.len()).filter(|&console| console != by);
        others.clone().for_each(|console| self.send(console, early));
        self.wait(apart_us)?;
        let may_hold = self.held_until_ns + BUTTON_NS > self.sim.now_ns();
        self.talks.iter_mut().for_each(Talk::may_forget);
        let mut hosts: Vec<_> =
            self.talks.iter().map(|talk| Host { welcomes: talk.welcomes, sent: 0, is_informed: false }).collect();
        self.send(by, b"\x18\n");
        hosts[by].sent = 1;
        self.wait(apart_us)?;
        for console in others {
            if self.talks[console].welcomes == hosts[console].welcomes {
                self.send(console, late);
            }
        }
        let (mut passed_us, mut quiet_us) = (0, 0);
        while quiet_us < QUIET_US {
            hosts.iter_mut().enumerate().for_each(|(console, host)| self.notice(console, host, console == by));
            let all_informed = hosts.iter().all(|host| host.is_informed);
            if passed_us > LONGEST_US {
                return self.is_never_quiet(&hosts);
            }
            let slice_us = if all_informed { LOOK_US } else { NOTICE_US };
            self.wait(slice_us)?;
            passed_us += slice_us;
            quiet_us = if all_informed && self.is_at_rest() { quiet_us + slice_us } else { 0 };
            if all_informed && self.sim.tool() != [0; 5] {
                return Err(self.failure(FORGOTTEN, format!("outputs {:?} are on", self.sim.tool())));
            }
        }
        self.check_quiet(&hosts, may_hold)
    }

    /// The host of a console notices a welcome. If the reset came from elsewhere it sends the first line that counts
    /// again, after the end of a line that it had begun.
    fn notice(&mut self, console: usize, host: &mut Host, has_reset: bool) {
        let talk = &self.talks[console];
        let elsewhere = |line: &String| line.contains(messages::RESET_ELSEWHERE);
        if talk.welcomes == host.welcomes || !has_reset && !talk.heard.iter().any(elsewhere) {
            return;
        }
        (host.welcomes, host.is_informed) = (talk.welcomes, true);
        if !has_reset {
            host.sent += 1;
            let line: &[u8] = if talk.is_in_line() { b"\n\n" } else { b"\n" };
            self.send(console, line);
        }
    }

    /// True if the controller has read all that was sent, after waiting for it.
    fn is_all_read(&mut self) -> Result<bool, Failure> {
        self.hear()?;
        for _ in 0..READING_US / NOTICE_US {
            let mut consoles = 0..self.talks.len();
            if consoles.all(|console| self.talks[console].welcomes > 0 && self.sim.unread_of(console) == 0) {
                return Ok(true);
            }
            self.wait(NOTICE_US)?;
        }
        Ok(false)
    }

    fn is_never_quiet(&self, hosts: &[Host]) -> Result<(), Failure> {
        let state = self.sim.machine().state();
        match hosts.iter().position(|host| !host.is_informed) {
            // A damaged command may have asked for an acceleration this low.
            _ if self.is_spoilt => Ok(()),
            None => Err(self.failure(FORGOTTEN, format!("it is still in {state}"))),
            Some(console) => {
                Err(self
                    .failure("a reset is reported on every console", format!("console {console} was not, in {state}")))
            }
        }
    }

    fn check_quiet(&mut self, hosts: &[Host], may_hold: bool) -> Result<(), Failure> {
        for (console, (talk, host)) in self.talks.iter().zip(hosts).enumerate() {
            let answers = talk.heard.iter().filter(|line| is_answer(line)).count();
            // If there were two welcomes, the reset may have come between them.
            if !(1..=host.sent).contains(&answers) {
                let found =
                    format!("console {console} hears {answers} answers to {} lines: {:?}", host.sent, talk.heard);
                return Err(self.failure("only what is sent after a reset is answered", found));
            }
        }
        // Start-up lines are carried out after every reset.
        let starts_up = self.talks.iter().flat_map(|talk| &talk.heard).any(|line| line.starts_with('>'));
        let mut heard = self.talks.iter().flat_map(|talk| &talk.heard);
        if let Some(line) = heard.find(|line| is_of_a_line(line) && !(starts_up && is_alarm(line))) {
            return Err(self.failure(FORGOTTEN, format!("a console prints `{line}`")));
        }
        let (steps, state) = (self.sim.steps(), self.sim.machine().state());
        if steps != self.welcomed_at && !starts_up {
            return Err(self.failure(FORGOTTEN, format!("{:?} steps at the welcome, then {steps:?}", self.welcomed_at)));
        }
        if state == (State::Hold { still: true }) && !may_hold {
            return Err(self.failure(FORGOTTEN, "it is held".to_owned()));
        }
        self.talks.iter_mut().for_each(Talk::begin_anew);
        Ok(())
    }
}

/// True if a line printed this behind the last welcome, other than the empty line of the host. The emergency stop, a
/// driver that fails, and a VFD that does not stop lock a machine at rest too, whenever they do; every other alarm needs a motion.
fn is_of_a_line(printed: &str) -> bool {
    let is_of_reset =
        ["ok", ">", "[MSG:", "ALARM:10", DRIVER_ALARM, VFD_ALARM].iter().any(|begin| printed.starts_with(begin));
    !is_of_reset || printed.contains("M6") || printed.contains(messages::PROGRAM_END)
}

/// A start-up line may move, and so may raise any alarm.
fn is_alarm(printed: &str) -> bool {
    printed.starts_with("ALARM:")
}
