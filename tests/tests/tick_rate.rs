//! The whole machine by a clock of any tick rate: of 1 MHz, or of 32,768 Hz with the feature `tick-hz-32_768`.

use embassy_time::Duration;
use isostep_motion::{Axis, State};
use isostep_report::Figures;
use isostep_sim::plate::Plate;
use isostep_sim::{Config, Port, Sim};

/// Slow enough for `TimerPort` by the slower clock, which makes a step in two of its ticks at best. The Z of the second
/// line takes longer than an item for a port lasts.
const MOVES: &str =
    "$11=0.02\nG1 X10 Y-5 Z2 F900\nX10.5 Y-4\nZ2.1 F2\nG2 X14 I2 F600\nG0 X0 Y0 Z0\nG4 P0.25\nG1 X1 F300\n";
const CURVED: &str = "$940=1\n";
const LASER: &str = "$32=1\nM4 S500\nG1 X10 F1500\nX20 S200\nM5\nG0 X0\n";

fn machine(port: Port) -> Sim {
    let mut sim = Sim::new(&Config { port, ..Config::default() });
    sim.run_until_idle().unwrap();
    sim
}

/// Every promise of a run, from its edges: equal intervals, edges where the closed form has them, limits, positions.
#[track_caller]
fn keeps_its_promises(sim: &Sim) {
    let figures = Figures::new("tick rate", &sim.outcome());
    let broken: Vec<_> = figures.broken().collect();
    assert!(broken.is_empty() && figures.losses_total == 0, "{broken:?}");
}

#[test]
fn the_clock_has_the_rate_that_was_chosen() {
    let hz = if cfg!(feature = "tick-hz-32_768") { 32_768 } else { 1_000_000 };
    assert_eq!(embassy_time::TICK_HZ, hz);
}

#[test]
fn moves_keep_their_promises() {
    for port in Port::ALL {
        for speed_profile in ["", CURVED] {
            let mut sim = machine(port);
            sim.send(format!("{speed_profile}{MOVES}").as_bytes());
            sim.run_until_idle().unwrap();
            assert_eq!((sim.machine().state(), sim.counted_steps()[0]), (State::Idle, 50), "{port:?} {speed_profile}");
            keeps_its_promises(&sim);
        }
    }
}

/// A contact is exact to the step whatever the clock resolves, as long as that is less than a step takes.
#[test]
fn it_homes_and_probes() {
    for port in Port::ALL {
        let mut sim = machine(port);
        sim.send(b"$H\n");
        sim.run_until_idle().unwrap();
        sim.set_plate(Some(Plate { axis: Axis::Z, place_mm: 7.0, is_below: false }));
        sim.send(b"G38.2 Z20 F300\n");
        sim.run_until_idle().unwrap();
        let replies = sim.replies();
        assert!(replies.iter().any(|line| line == "[PRB:0.000,0.000,5.000:1]"), "{port:?}: {replies:?}");
        keeps_its_promises(&sim);
    }
}

#[test]
fn it_is_held_and_resumed() {
    for port in Port::ALL {
        let mut sim = machine(port);
        sim.send(b"G1 X20 Y10 F900\nX0 Y0\n");
        sim.run_for(Duration::from_millis(700)).unwrap();
        sim.send(b"!");
        sim.run_for(Duration::from_millis(700)).unwrap();
        assert_eq!(sim.machine().state(), State::Hold { still: true }, "{port:?}");
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.counted_steps()[..3], [0; 3], "{port:?}");
        keeps_its_promises(&sim);
    }
}

#[test]
fn a_laser_is_on_in_its_strokes() {
    let mut sim = machine(Port::Pio);
    sim.send(LASER.as_bytes());
    sim.run_until_idle().unwrap();
    keeps_its_promises(&sim);
}
