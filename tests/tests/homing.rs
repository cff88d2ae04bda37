//! The scatter of the place that homing finds, in both directions of every axis, with switches that bounce and
//! scatter.
//!
//! A latch ends with the first edge of the switch. The step by which it has closed is the last one that is made.

use isostep_sim::homing::{Latch, latches, towards};
use isostep_sim::{Axis, Config};
use isostep_trials::cases;

fn latches_of_each() -> u32 {
    cases(20, 50)
}

fn machine(latch_mm_s: f32, bounce_us: u32, switch_scatter_mm: f64) -> Config {
    let mut config = Config { bounce_us, switch_scatter_mm, seed: 5, ..Config::default() };
    config.settings.homing_latch_mm_min = 60.0 * latch_mm_s;
    config
}

/// The latches of every axis in both directions. Each axis has a different resolution.
fn all(config: &Config) -> Vec<(String, f64, Vec<Latch>)> {
    let mut config = config.clone();
    config.settings.steps_per_mm = [50.0, 80.0, 400.0];
    let mut all = Vec::new();
    for (axis, negative) in Axis::ALL.into_iter().flat_map(|axis| [(axis, true), (axis, false)]) {
        let latches = latches(&towards(&config, negative), axis, latches_of_each()).unwrap();
        let name = format!("{axis} {} {config:?}", if negative { "negative" } else { "positive" });
        all.push((name, f64::from(config.settings.steps_per_mm[axis as usize]), latches));
    }
    all
}

fn range(steps: impl Iterator<Item = i32> + Clone) -> (i32, i32) {
    (steps.clone().min().unwrap(), steps.max().unwrap())
}

#[test]
fn the_controller_adds_nothing_however_fast_the_latch_is_and_however_long_the_contacts_bounce() {
    for (latch_mm_s, bounce_us, debounce_ms) in [(1.0, 0, 5), (1.0, 1_000, 5), (5.0, 1_000, 250), (5.0, 4_000, 5)] {
        let mut config = machine(latch_mm_s, bounce_us, 0.0);
        config.settings.homing_debounce_ms = debounce_ms;
        for (name, _, latches) in all(&config) {
            assert!(latches.iter().all(|latch| (latch.closed_steps, latch.set_steps) == (0, 0)), "{latches:?}: {name}");
        }
    }
}

#[test]
fn a_switch_s_own_scatter_goes_through_as_it_is() {
    let config = machine(1.0, 1_000, 0.1);
    for (name, steps_per_mm, latches) in all(&config) {
        assert!(latches.iter().all(|latch| latch.late_steps() == 0), "{latches:?}: {name}");
        let reach = (0.1 * steps_per_mm).round() as i32;
        let (first, last) = range(latches.iter().map(|latch| latch.closed_steps));
        let width = last - first;
        assert!(-reach <= first && last <= reach && 10 * width >= 16 * reach, "closed at {first} to {last}: {name}");
    }
}
