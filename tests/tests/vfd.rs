//! A spindle by a VFD whose wire and whose VFD fail at random: each fault is told, none is missed, and of a spindle that is driven it is
//! known within 0.3 s how it turns.

use std::env;

use embassy_time::Duration;
use isostep_motion::{Alarm, State};
use isostep_sim::tool::ToolOutput;
use isostep_sim::vfd::{VfdFault, VfdKind};
use isostep_sim::{Config, Sim};
use isostep_trials::{cases, window};
use oorandom::Rand64;

/// Exchanges of a case: requests, whether they are answered or not.
const EXCHANGES: usize = 100;
/// A spindle of which nothing is known for so long is stopped. The machine is looked at every 10 ms.
const KNOWN_MS: u64 = 300;
const LOOK_MS: u64 = 10;
/// What the simulated VFD's speed changes by in that time, rpm: 200 Hz/s of 60 rpm/Hz, and two percent of 24,000 for what is not a fault.
const RAMP_RPM: f64 = 200.0 * 60.0 * (KNOWN_MS + LOOK_MS) as f64 / 1e3 + 480.0;

/// A case: the machine, and what is wrong with it.
struct Case {
    sim: Sim,
    kind: VfdKind,
    random: Rand64,
    now_ms: u64,
    fault: Option<VfdFault>,
    /// Since when, and until when.
    fault_ms: [u64; 2],
    /// Since when the spindle may turn; `None` if it may not.
    enabled_ms: Option<u64>,
    /// When something was last wrong.
    wrong_ms: u64,
    /// It was told since the fault began, or before it and it has not been well since.
    is_told: bool,
    is_well: bool,
    alarms: usize,
    reported_rpm: f64,
}

impl Case {
    /// True if nothing is known of the spindle with this fault, or the VFD says that it has failed. One that does not say so is
    /// found out by its speed: at once if the spindle had it, or else after the time for that.
    fn has_to_stop(&self, fault: VfdFault) -> bool {
        use VfdFault::{Cut, Garbled, Off, OtherAddress, Refuses, Tripped};
        let says_faults = matches!(self.kind, VfdKind::Gs20 | VfdKind::Nowforever);
        matches!(fault, Cut | Garbled | Off | OtherAddress | Refuses) || fault == Tripped && says_faults
    }

    fn new(seed: u64) -> Self {
        let mut random = Rand64::new(seed.into());
        let kind = VfdKind::ALL[random.rand_range(0..VfdKind::ALL.len() as u64) as usize];
        let mut config = Config { vfd: Some(kind), seed, ..Config::default() };
        config.settings.spindle_type = 1 + VfdKind::ALL.iter().position(|&other| other == kind).unwrap() as u16;
        config.settings.spindle_max_rpm = 24_000.0;
        config.settings.soft_limits = false;
        Self {
            sim: Sim::new(&config),
            kind,
            random,
            now_ms: 0,
            fault: None,
            fault_ms: [0; 2],
            enabled_ms: None,
            wrong_ms: 0,
            is_told: false,
            is_well: true,
            alarms: 0,
            reported_rpm: 0.0,
        }
    }

    fn run(&mut self) -> Result<usize, String> {
        let mut next_ms = 500;
        while self.sim.vfd_frames().iter().filter(|frame| !frame.is_reply).count() < EXCHANGES {
            if self.now_ms >= next_ms {
                self.happen();
                next_ms = self.now_ms + self.random.rand_range(10..900);
            }
            if self.fault.is_some() && self.now_ms >= self.fault_ms[1] {
                self.mend()?;
            }
            self.look()?;
        }
        Ok(self.alarms)
    }

    /// Something is asked for, or goes wrong.
    fn happen(&mut self) {
        let rpm = 1_000 * self.random.rand_range(1..25);
        let line = match self.random.rand_range(0..10) {
            0..3 => format!("M3 S{rpm}\n"),
            3 => format!("M4 S{rpm}\n"),
            4 => "M5\n".to_owned(),
            5 => "\u{9A}".to_owned(),
            6 => "\u{9B}".to_owned(),
            _ if self.fault.is_some() => return,
            _ => {
                let fault = VfdFault::ALL[self.random.rand_range(0..VfdFault::ALL.len() as u64) as usize];
                self.sim.set_vfd(Some(fault));
                (self.fault, self.is_told) = (Some(fault), !self.is_well);
                self.fault_ms = [self.now_ms, self.now_ms + self.random.rand_range(20..1_500)];
                return;
            }
        };
        let bytes: Vec<u8> = line.chars().map(|byte| byte as u8).collect();
        self.sim.send(&bytes);
    }

    fn mend(&mut self) -> Result<(), String> {
        let lasted_ms = self.now_ms - self.fault_ms[0];
        let fault = self.fault.take().expect("there is one");
        self.wrong_ms = self.now_ms;
        self.sim.set_vfd(None);
        if self.has_to_stop(fault) && lasted_ms > KNOWN_MS + LOOK_MS && !self.is_told {
            return Err(format!("{fault} for {lasted_ms} ms, and nobody was told"));
        }
        Ok(())
    }

    /// Goes on by a look, and judges what is seen.
    fn look(&mut self) -> Result<(), String> {
        self.sim.send(b"?");
        self.sim.run_for(Duration::from_millis(LOOK_MS)).map_err(|error| error.to_string())?;
        self.now_ms += LOOK_MS;
        self.hear();
        let state = self.sim.machine().state();
        let (drives, turns_hz) = self.sim.vfd(|vfd| (vfd.drives(), vfd.output_hz()));
        let is_enabled = self.sim.tool()[ToolOutput::Enable as usize] > 0;
        self.enabled_ms = is_enabled.then(|| self.enabled_ms.unwrap_or(self.now_ms));
        let for_ms = |since_ms: u64| self.now_ms.saturating_sub(since_ms);
        if let State::Alarm(alarm) = state {
            return self.leave_alarm(alarm);
        }
        let fault = self.fault.filter(|&fault| self.has_to_stop(fault));
        let enabled_for_ms = self.enabled_ms.map_or(0, for_ms);
        if fault.is_some() && for_ms(self.fault_ms[0]).min(enabled_for_ms) > KNOWN_MS {
            return Err(format!("{fault:?} since {} ms, and the spindle may turn", for_ms(self.fault_ms[0])));
        }
        let off_rpm = (self.reported_rpm - turns_hz.abs() * 60.0).abs();
        if drives && enabled_for_ms > KNOWN_MS && off_rpm > RAMP_RPM {
            return Err(format!("it is at {turns_hz} Hz, and {} rpm are reported", self.reported_rpm));
        }
        Ok(())
    }

    fn hear(&mut self) {
        for line in self.sim.replies() {
            let is_of_vfd = line.contains("VFD") || line.contains("something else answers");
            if is_of_vfd {
                self.is_well = line.contains("is well");
            }
            self.is_told |= is_of_vfd && !self.is_well || line.contains("the spindle turns");
            let fields = line.split_once("|FS:").and_then(|(_, rest)| rest.split(['|', '>']).next());
            if let Some(rpm) = fields.and_then(|fields| fields.split(',').nth(2)) {
                self.reported_rpm = rpm.parse().expect("a speed");
            }
        }
    }

    /// An alarm has to have a cause. Then the machine is unlocked.
    fn leave_alarm(&mut self, alarm: Alarm) -> Result<(), String> {
        let is_of_spindle = matches!(alarm, Alarm::SpindleFailed { .. });
        let is_caused = self.fault.is_some() || self.now_ms - self.wrong_ms <= 2 * KNOWN_MS;
        if !is_of_spindle || !is_caused {
            return Err(format!("{alarm:?} without a cause"));
        }
        if self.enabled_ms.is_some() {
            return Err(format!("{alarm:?}, and the spindle may turn"));
        }
        self.alarms += 1;
        self.sim.send(b"$X\n");
        Ok(())
    }
}

#[test]
fn of_ten_thousand_exchanges_each_fault_is_told_and_none_is_missed() {
    let only: Option<u64> = env::var("VFD_CASE").ok().map(|case| case.parse().expect("VFD_CASE is a number"));
    let mut alarms = 0;
    for case in only.map_or(window(cases(24, 100)), |case| case..case + 1) {
        match Case::new(case).run() {
            Ok(found) => alarms += found,
            Err(why) => panic!("{why}: VFD_CASE={case} cargo test -p isostep-tests vfd::of_ten_thousand"),
        }
    }
    assert!(alarms > 0 || only.is_some(), "no fault has stopped the machine");
}
