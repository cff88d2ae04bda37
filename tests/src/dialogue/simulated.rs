//! The simulated machine of a dialogue.

use embassy_time::Duration;
use isostep_motion::{AXES, Event, Kinematics};
use isostep_sim::world::Wire;
use isostep_sim::{Board, Config, Flash, Sim, State};

use super::machine::{Counts, Machine};
use super::run::is;
use super::step::{PlatePlace, Step, With};

/// A simulated machine, with what it keeps without power.
pub struct Simulated {
    config: Config,
    flash: Flash,
    sim: Sim,
}

impl Simulated {
    fn new(mut config: Config, flash: Flash, changes: &[With]) -> Result<Self, String> {
        changes.iter().try_for_each(|with| with.change(&mut config))?;
        let mut sim = Sim::with_flash(&config, flash.clone());
        for with in changes {
            if let With::Pressed(wire) = with {
                sim.set_hand_input(*wire, true);
            }
        }
        Ok(Self { config, flash, sim })
    }

    /// Checks what is recorded.
    fn check(&self, step: &Step) -> Result<(), String> {
        let outcome = self.sim.outcome();
        match step {
            Step::CountsAgree => {
                let kinematics =
                    if self.config.settings.has_crossed_belts() { Kinematics::CoreXy } else { Kinematics::Cartesian };
                let counted = kinematics.axes(self.sim.counted_steps());
                let reported = self.sim.machine().position_steps();
                is(reported == counted, || format!("it says {reported:?}, and {counted:?} left the pins"))
            }
            Step::Moves(numbers) => {
                let made = outcome.moves.iter().filter(|record| !record.homing).count();
                is(numbers.contains(made as i64), || format!("{made} moves have begun"))
            }
            Step::Trusted(axes) => {
                let homed = self.sim.machine().homed();
                is(homed == *axes, || format!("trusted are {homed:?}"))
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
                let homed = outcome.events.iter().filter_map(|(_, event)| match event {
                    Event::Homed { axis } => Some(axis.to_string()),
                    _ => None,
                });
                let homed = homed.collect::<Vec<_>>().join(" ");
                is(homed == *axes, || format!("homed were {homed}"))
            }
            Step::ToolNeverOn => is(outcome.tool.is_empty(), || format!("an output was on: {:?}", outcome.tool)),
            Step::DriverIs(driver, words) => self.driver_is(*driver, words),
            Step::VfdTurns(hz) => {
                let (turns_hz, drives) = self.sim.vfd(|vfd| (vfd.output_hz(), vfd.drives()));
                let is_so = (turns_hz - hz).abs() <= hz.abs() / 100.0 && drives == (*hz != 0.0);
                is(is_so, || format!("the VFD is at {turns_hz} Hz, and drives its motor: {drives}"))
            }
            _ => Err("the simulated machine cannot do this: use `on: board`".to_owned()),
        }
    }

    fn driver_is(&self, driver: usize, words: &[String]) -> Result<(), String> {
        let setup = self.sim.driver_setup(driver).ok_or("this board's drivers have no UART")?;
        let chop = if setup.is_spread_cycle { "spread-cycle" } else { "stealth-chop" };
        let stalls = if setup.reports_stalls { "reports-stalls" } else { "reports-no-stalls" };
        let (run, hold) = (format!("{}-mA", setup.run_ma), format!("{}-mA-hold", setup.hold_ma));
        let found = [format!("{}-microsteps", setup.microsteps), run, hold, chop.to_owned(), stalls.to_owned()];
        is(words.iter().all(|word| found.contains(word)), || format!("the driver is {}", found.join(" ")))
    }
}

impl Machine for Simulated {
    const DUTY_TOLERANCE: u16 = 0;

    fn power_up(_name: &str, changes: &[With]) -> Result<Self, String> {
        Self::new(Config::default(), Flash::blank(), changes)
    }

    fn power_cycle(&mut self, changes: &[With]) -> Result<(), String> {
        *self = Self::new(self.config.clone(), self.flash.clone(), changes)?;
        Ok(())
    }

    fn starts_within_ns(&self) -> u64 {
        // UART drivers are set first.
        if self.config.board == Board::SkrPico { 300_000_000 } else { 50_000_000 }
    }

    fn send(&mut self, console: usize, bytes: &[u8]) -> Result<(), String> {
        self.sim.send_to(console, bytes);
        Ok(())
    }

    fn run_for(&mut self, time_ns: u64) -> Result<(), String> {
        self.sim.run_for(Duration::from_micros(time_ns / 1000)).map_err(|error| error.to_string())
    }

    fn settle(&mut self) -> Result<(), String> {
        self.sim.run_until_idle().map_err(|error| error.to_string())
    }

    fn replies(&mut self, console: usize) -> Vec<String> {
        if console > 0 && !self.config.second_console { Vec::new() } else { self.sim.replies_of(console) }
    }

    fn now_ns(&self) -> u64 {
        self.sim.now_ns()
    }

    fn counts(&mut self) -> Result<Counts, String> {
        let made = self.sim.steps().map(|steps| steps as i64).to_vec();
        let [counted, places] =
            [self.sim.counted_steps(), self.sim.places_steps()].map(|all| all.map(i64::from).to_vec());
        Ok(Counts { counted, made, places })
    }

    fn tool(&mut self) -> Result<[u16; 5], String> {
        Ok(self.sim.tool())
    }

    fn last_step_ns(&mut self) -> Option<u64> {
        self.sim.outcome().edges.last().map(|edge| edge.t_ns)
    }

    fn end_of_move_ns(&self, count: usize) -> Option<u64> {
        self.sim.outcome().moves.iter().filter(|record| !record.homing).nth(count - 1).map(|record| record.end_ns)
    }

    fn act(&mut self, step: &Step) -> Result<(), String> {
        match *step {
            Step::Until(ref name) => {
                let is_it = |state: State| format!("{state:?}").split(['(', ' ']).next() == Some(name);
                self.sim.run_until_state(is_it).map_err(|error| error.to_string())?;
            }
            Step::Switch(motor, fault) => self.sim.set_switch(motor, fault),
            Step::Press { wire, pressed, .. } => self.sim.set_hand_input(wire, pressed),
            Step::Cut(is_cut) => self.sim.cut_emergency_stop(is_cut),
            Step::Plate(place_mm) => self.sim.set_plate(place_mm.and_then(PlatePlace::plate)),
            Step::Drive(motor, is_wrong) => self.sim.set_drive(motor, is_wrong),
            Step::CutAlarm(axis, is_cut) => self.sim.cut_drive_alarm(axis, is_cut),
            Step::Driver(motor, fault) => self.sim.set_driver(motor, fault),
            Step::Vfd(fault) => self.sim.set_vfd(fault),
            Step::Fault(fault) => self.sim.suffer(fault),
            Step::FlashRefuses(true) => self.flash.refuse(),
            Step::FlashRefuses(false) => self.flash.mend(),
            Step::StopSeen(pressed) => self.sim.machine().emergency_stop_edge(pressed),
            Step::Open => self.sim.open_console(),
            Step::CutOff => self.sim.machine().tool_cut_off(),
            Step::ResetHeard => self.sim.machine().reset_heard(),
            _ => self.check(step)?,
        }
        Ok(())
    }

    fn end(self) -> Result<(), String> {
        Ok(())
    }
}
