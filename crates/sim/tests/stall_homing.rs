//! How well homing without switches finds the same place again, by the stalls that drivers tell.

use std::collections::BTreeSet;

use isostep_sim::{AXES, Axis, Board, Config, Sim};

const HOMINGS: usize = 100;
const MICROSTEPS: i32 = 16;
/// The first axes, for which the board has jumpers.
const JUMPERS: usize = if AXES < 3 { AXES } else { 3 };

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
    for (number, value) in thresholds.chain([(25, 2_400.0), (339, ((1 << JUMPERS) - 1) as f32)]) {
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
        assert_eq!(sim.replies(), ["ok"], "homing {homing}");
        for (places, place) in places.iter_mut().zip(sim.places_steps()) {
            places.insert(place);
        }
        let away_mm = 1.0 + homing as f64 * 0.07;
        let to = Axis::ALL.map(|axis| format!("{axis}{away_mm:.2}")).concat();
        sim.send(format!("G53 G0 {to}\n").as_bytes());
        sim.run_until_idle().unwrap();
        assert_eq!(sim.replies(), ["ok"], "to {to}");
    }
    assert_eq!(sim.outcome().losses, []);
    places
}

#[test]
#[ignore = "the controller homes by switches alone"]
fn stalls_find_the_same_place_or_one_a_full_step_farther() {
    for load_noise in [0.0, 0.1, 0.2] {
        let mut scattered = 0;
        for phase in 0..MICROSTEPS {
            for places in places(&config(phase, load_noise)) {
                let (first, last) = (places.first().unwrap(), places.last().unwrap());
                assert!([0, MICROSTEPS].contains(&(last - first)) && places.len() <= 2, "{places:?}");
                scattered += usize::from(places.len() > 1);
            }
        }
        println!("load noise {load_noise}: {scattered} of {} axes have two places", JUMPERS * MICROSTEPS as usize);
    }
}
