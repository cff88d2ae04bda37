//! How exactly homing finds the same place each time, in both directions of every axis, with switches that bounce and
//! scatter.
//!
//! A latch ends when the switch has been steady for the debounce time D. D begins with the last bounce, which comes at
//! most B after the first contact. At v steps/s the carriage is then between v D and v (D + B) behind the place of the
//! contact. The last step may or may not have been made.

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

/// The least and the most steps by which a latch is late. The most includes one step that is already under way.
fn bounds_steps(config: &Config, steps_per_mm: f64) -> (i32, i32) {
    let speed_steps_s = f64::from(config.settings.homing_latch_mm_min) / 60.0 * steps_per_mm;
    let debounce_s = f64::from(config.settings.homing_debounce_ms) * 1e-3;
    let least = speed_steps_s * debounce_s;
    let most = speed_steps_s * (debounce_s + f64::from(config.bounce_us) * 1e-6);
    (least.floor() as i32, most.floor() as i32 + 1)
}

fn range(steps: impl Iterator<Item = i32> + Clone) -> (i32, i32) {
    (steps.clone().min().unwrap(), steps.max().unwrap())
}

#[test]
fn the_controller_adds_its_latch_speed_times_debounce_and_bounce_and_no_more() {
    for (latch_mm_s, bounce_us) in [(1.0, 0), (1.0, 1_000), (5.0, 1_000), (5.0, 4_000)] {
        let config = machine(latch_mm_s, bounce_us, 0.0);
        for (name, steps_per_mm, latches) in all(&config) {
            let (least, most) = bounds_steps(&config, steps_per_mm);
            let (early, late) = range(latches.iter().map(Latch::late_steps));
            assert!(least <= early && late <= most, "{early} to {late} steps late, not {least} to {most}: {name}");
            assert!(latches.iter().all(|latch| latch.closed_steps == 0), "{name}");
            if bounce_us == 0 {
                assert_eq!(early, late, "without bounces each latch is as the others: {name}");
            }
        }
    }
}

/// With a fast latch, bounces must be visible: this shows that the bound above is not far too wide.
#[test]
fn a_fast_latch_spreads_by_what_its_switch_bounces() {
    let (name, _, latches) = all(&machine(5.0, 4_000, 0.0)).swap_remove(4);
    let (early, late) = range(latches.iter().map(Latch::late_steps));
    assert!((6..=9).contains(&(late - early)), "2,000 steps/s for up to 4 ms: {} steps apart: {name}", late - early);
}

#[test]
fn a_switch_s_own_scatter_goes_through_as_it_is() {
    let config = machine(1.0, 1_000, 0.1);
    for (name, steps_per_mm, latches) in all(&config) {
        let (least, most) = bounds_steps(&config, steps_per_mm);
        let (early, late) = range(latches.iter().map(Latch::late_steps));
        assert!(least <= early && late <= most, "{early} to {late} steps late, not {least} to {most}: {name}");
        let reach = (0.1 * steps_per_mm).round() as i32;
        let (first, last) = range(latches.iter().map(|latch| latch.closed_steps));
        let width = last - first;
        assert!(-reach <= first && last <= reach && 10 * width >= 16 * reach, "closed at {first} to {last}: {name}");
        let (low, high) = range(latches.iter().map(|latch| latch.set_steps));
        assert!(-reach - most <= low && high <= reach - least, "{low} to {high}: {name}");
        assert!(high - low >= width - (most - least), "it scatters as the switch does: {low} to {high}: {name}");
    }
}
