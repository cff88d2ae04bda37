//! The accuracy with which homing without switches finds the same place again, by the stalls that drivers tell.

use std::collections::BTreeSet;

use isostep_sim::{Axis, Board, Config, Sim};
use isostep_trials::stride;

const HOMINGS: usize = 100;
const MICROSTEPS: i32 = 16;
const JUMPERS: usize = Board::JUMPERS;

/// A machine that homes by stalls, at 125 full steps a second. Where full steps end differs by the phase.
fn config(phase: i32, load_noise: f64) -> Config {
    let board = Board::SkrPico;
    let mut config = Config {
        board,
        driver: board.driver(),
        diag: std::array::from_fn(|axis| axis < JUMPERS),
        load_noise,
        keep_waves: false,
        ..Config::default()
    };
    let thresholds = (0..JUMPERS).map(|axis| (200 + axis as u16, 75.0));
    let reach = (0..JUMPERS).map(|axis| (980 + axis as u16, 3_000.0));
    // The run-up is 3.2 mm.
    let accels = (0..JUMPERS).map(|axis| (120 + axis as u16, 500.0));
    let mask = ((1 << JUMPERS) - 1) as f32;
    for (number, value) in thresholds.chain(reach).chain(accels).chain([(25, 2_400.0), (339, mask)]) {
        assert!(config.settings.set(number, value), "${number}");
    }
    config.start_mm =
        std::array::from_fn(|axis| 5.0 + f64::from(phase) / f64::from(config.settings.steps_per_mm[axis]));
    config
}

/// Homes again and again, each time from another place. Returns where each axis stood then, steps from its switch.
fn places(config: &Config) -> [BTreeSet<i32>; JUMPERS] {
    let mut sim = Sim::new(config);
    let mut places: [BTreeSet<_>; JUMPERS] = Default::default();
    sim.run_until_idle().unwrap();
    sim.replies();
    for homing in 0..HOMINGS {
        sim.send(b"$H\n");
        sim.run_until_idle().unwrap();
        let heard = sim.replies();
        assert_eq!((heard.len(), heard.last().unwrap().as_str()), (JUMPERS + 1, "ok"), "homing {homing}: {heard:?}");
        for (places, place) in places.iter_mut().zip(sim.places_steps()) {
            places.insert(place);
        }
        let away_mm = 5.0 + homing as f64 * 0.07;
        let to = Axis::ALL.map(|axis| format!("{axis}{away_mm:.2}")).concat();
        sim.send(format!("G53 G0 {to}\n").as_bytes());
        sim.run_until_idle().unwrap();
        assert_eq!(sim.replies(), ["ok"], "to {to}");
    }
    assert_eq!(sim.outcome().losses, [], "no field ran on by two full steps");
    places
}

/// A driver measures where a full step ends, and noise decides which of two full steps it is.
#[test]
fn stalls_find_the_same_place_or_one_a_full_step_farther() {
    for load_noise in [0.0, 0.2] {
        let (mut axes, mut scattered) = (0, 0);
        for phase in (0..MICROSTEPS).step_by(2 * stride(4)) {
            for places in places(&config(phase, load_noise)) {
                let (first, last) = (places.first().unwrap(), places.last().unwrap());
                assert!([0, MICROSTEPS].contains(&(last - first)) && places.len() <= 2, "{places:?}");
                axes += 1;
                scattered += usize::from(places.len() > 1);
            }
        }
        println!("load noise {load_noise}: of {axes} axes that homed {HOMINGS} times {scattered} have two places");
    }
}
