//! Faults as they come: a task for each begins and ends it.

use std::rc::Rc;

use isostep_motion::Motor;
use oorandom::Rand64;

use crate::executor::{Executor, Priority};
use crate::faults::{Fault, Trouble};
use crate::link::Pipe;
use crate::plant::SwitchFault;
use crate::record::Wire;
use crate::time::Clock;
use crate::world::Shared;

/// The longest time between two changes of a contact that chatters, ns.
const CHATTER_MAX_NS: u64 = 3_000_000;

/// Spawns a task that begins and ends `fault`; hosts read from the pipes `hosts`. Randomness depends on the seed and on
/// the time of the fault.
pub(crate) fn spawn(executor: &mut Executor, fault: Fault, seed: u64, world: &Shared, hosts: Vec<Pipe>) {
    let surroundings = Surroundings {
        clock: executor.clock().clone(),
        world: world.clone(),
        hosts,
        starve: executor.starver(),
        random: Rand64::new(u128::from(seed) << 64 | u128::from(fault.at_ns)),
    };
    executor.spawn_at(Priority::World, "fault", surroundings.suffer(fault));
}

/// The target of a fault.
struct Surroundings {
    clock: Clock,
    world: Shared,
    hosts: Vec<Pipe>,
    starve: Rc<dyn Fn(u64)>,
    random: Rand64,
}

impl Surroundings {
    async fn suffer(mut self, Fault { trouble, at_ns, lasts_ns }: Fault) {
        self.clock.until(at_ns).await;
        let end_ns = lasts_ns.map_or(u64::MAX, |ns| at_ns.saturating_add(ns));
        match trouble {
            Trouble::Chatter(motor) => self.chatter(motor, end_ns).await,
            Trouble::Starve => (self.starve)(end_ns),
            _ => self.set(trouble, true),
        }
        if lasts_ns.is_some() {
            self.clock.until(end_ns).await;
            self.set(trouble, false);
        }
    }

    async fn chatter(&mut self, motor: Motor, end_ns: u64) {
        let mut is_closed = true;
        while self.clock.now_ns() < end_ns {
            let fault = if is_closed { SwitchFault::StuckClosed } else { SwitchFault::None };
            self.world.borrow_mut().set_switch(motor, fault);
            let next_ns = self.clock.now_ns() + 1 + self.random.rand_range(0..CHATTER_MAX_NS);
            self.clock.until(next_ns.min(end_ns)).await;
            is_closed = !is_closed;
        }
    }

    fn set(&self, trouble: Trouble, is_on: bool) {
        let mut world = self.world.borrow_mut();
        let fault = |fault| if is_on { fault } else { SwitchFault::None };
        match trouble {
            Trouble::EmergencyStop => world.set_hand_input(Wire::EmergencyStop, is_on),
            Trouble::BrokenEmergencyStop => world.cut_emergency_stop(is_on),
            Trouble::Hold => world.set_hand_input(Wire::Hold, is_on),
            Trouble::Start => world.set_hand_input(Wire::Start, is_on),
            Trouble::Probe => world.set_hand_input(Wire::Probe, is_on),
            Trouble::Limit(motor) => world.set_switch(motor, fault(SwitchFault::StuckClosed)),
            Trouble::Broken(motor) => world.set_switch(motor, fault(SwitchFault::StuckOpen)),
            Trouble::Chatter(motor) => world.set_switch(motor, SwitchFault::None),
            Trouble::Stall(motor) => world.set_stalled(motor, is_on),
            Trouble::Alarm(motor) => world.set_drive(motor, is_on),
            Trouble::Driver(motor, fault) => world.set_driver(motor, is_on.then_some(fault)),
            Trouble::Vfd(fault) => world.set_vfd(is_on.then_some(fault)),
            Trouble::Deaf => self.hosts.iter().for_each(|host| host.stall(is_on)),
            Trouble::Starve => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use embassy_time::Duration;
    use isostep_motion::{Alarm, Axis, State};

    use super::*;
    use crate::config::Config;
    use crate::sim::Sim;

    /// Runs `line` for `seconds` on a machine with a fault.
    fn machine_with(fault: &str, line: &str, seconds: u64) -> Sim {
        let config = Config { faults: vec![fault.parse().unwrap()], ..Config::default() };
        let mut sim = Sim::new(&config);
        sim.send(format!("{line}\n").as_bytes());
        sim.run_for(Duration::from_secs(seconds)).unwrap();
        sim
    }

    #[test]
    fn each_fault_has_its_effect() {
        let line = "G1 X20 F600";
        assert_eq!(machine_with("e-stop@0.5+0.1", line, 1).machine().state(), State::Alarm(Alarm::EmergencyStop));
        for limit in ["limit:Y@0.5+0.1", "chatter:Y@0.5+0.1"] {
            let hard = machine_with(limit, &format!("$21=1\n{line}"), 1).machine().state();
            assert_eq!(hard, State::Alarm(Alarm::HardLimit { motor: Motor::first(Axis::Y) }), "{limit}");
        }
        assert_eq!(machine_with("hold@0.5+0.1", line, 3).machine().state(), State::Hold { still: true });
        let lost = machine_with("stall:X@0.5+0.1", line, 4).outcome();
        assert!(lost.drift_steps[0] < 0 && lost.losses.len() == 1, "{:?}", lost.losses);
        let homed = machine_with("broken:Z@0", "$H", 60).machine().state();
        assert_eq!(homed, State::Alarm(Alarm::SwitchNotFound { axis: Axis::Z }));
    }

    #[test]
    fn who_is_starved_feeds_no_axis() {
        let sim = machine_with("starve@0.5+1", "G1 X20 F600", 1);
        assert_eq!(sim.machine().state(), State::Run, "nobody could say otherwise");
        let sim = machine_with("starve@0.5+1", "G1 X20 F600", 2);
        assert_eq!(sim.machine().state(), State::Alarm(Alarm::Underrun { axis: Axis::X }));
    }

    #[test]
    fn a_deaf_host_hears_what_waited_when_it_reads_again() {
        let mut sim = machine_with("deaf@0+2", "G1 X1 F600", 1);
        assert_eq!(sim.replies(), [""; 0]);
        sim.run_for(Duration::from_secs(2)).unwrap();
        assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", "ok"]);
    }
}
