//! The position contract in the simulator, by either step port; and what the table of `docs/position.md` says of each case.

use isostep_sim::motor::PullOutCurve;
use isostep_sim::{Config, Port, Sim};
use isostep_tests::contract::{On, START_MM, script};
use isostep_tests::desk::Desk;

#[test]
fn every_way_to_end_keeps_the_contract() {
    for port in Port::ALL {
        let motor = Some(PullOutCurve { pull_in_steps_s: 1e9, ..PullOutCurve::default() });
        let config = Config { port, motor, start_mm: [START_MM, 40.0, 15.0], ..Config::default() };
        Desk::new(Sim::new(&config)).carry_out(&script(|on| on == On::Every, ""));
    }
}
