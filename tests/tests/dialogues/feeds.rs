//! Feeds of every size on axes of every resolution. A feed always means "at most".

use embassy_time::Duration;
use isostep_motion::AXES;
use isostep_sim::{Config, Sim};
use isostep_trials::stride;

use crate::talk::{begin, bytes, field, powered_up, say, status};

/// From the coarsest resolution to the finest that can be set, steps/mm.
const RESOLUTIONS: [f32; 7] = [0.1, 0.5, 5.0, 50.0, 320.0, 2_000.0, 10_000.0];
/// From the slowest feed that is accepted to the fastest that can be written, mm/min.
const FEEDS: [f64; 7] = [1.0, 60.0, 2_880.0, 100_000.0, 12_000_001.0, 60_000_000.0, 99_999_000.0];
/// Acceleration of every axis, mm/s².
const ACCEL: f64 = 50.0;

/// A machine with this resolution. Its top speed is the highest that its outputs allow, at most 2,880 mm/min.
fn machine(steps_per_mm: f32) -> Sim {
    let mut config = Config::default();
    config.settings.steps_per_mm = [steps_per_mm; AXES];
    config.settings.max_rate_mm_min = [top_mm_min(steps_per_mm) as f32; AXES];
    config.settings.soft_limits = false;
    config.keep_waves = false;
    // The carriage may move by a few of the largest steps.
    config.settings.travel_mm = [500.0; AXES];
    powered_up(&config)
}

fn top_mm_min(steps_per_mm: f32) -> f64 {
    (200_000.0 * 60.0 / f64::from(steps_per_mm)).min(2_880.0)
}

/// The time that a move of this length from rest to rest takes at this speed, s.
fn lasts_s(length_mm: f64, speed_mm_s: f64, accel_mm_s2: f64) -> f64 {
    if length_mm > speed_mm_s * speed_mm_s / accel_mm_s2 {
        length_mm / speed_mm_s + speed_mm_s / accel_mm_s2
    } else {
        2.0 * (length_mm / accel_mm_s2).sqrt()
    }
}

/// Sends a line that moves each of `axes` axes by the same length, and checks that it takes the expected time.
fn check(sim: &mut Sim, line: &str, (length_mm, axes): (f64, f64), feed_mm_min: f64, steps_per_mm: f32) {
    assert_eq!(say(sim, line), ["ok"], "{line} at {steps_per_mm} steps/mm");
    assert!(status(sim).starts_with("<Idle|"), "{line} at {steps_per_mm} steps/mm");
    let diagonal = axes.sqrt();
    let speed_mm_s = feed_mm_min.min(top_mm_min(steps_per_mm) * diagonal) / 60.0;
    let wanted_s = lasts_s(length_mm * diagonal, speed_mm_s, ACCEL * diagonal);
    let took_s = sim.outcome().moves.last().map_or(0.0, |record| record.plan_s);
    assert!((took_s / wanted_s - 1.0).abs() < 1e-3, "{line} at {steps_per_mm} steps/mm: {took_s} s, not {wanted_s} s");
}

/// A length of whole steps, at least one.
fn length_mm(steps_per_mm: f32) -> f64 {
    f64::from(1.0 / steps_per_mm).max(1.0)
}

#[test]
fn every_feed_is_planned_at_every_resolution() {
    let cases = RESOLUTIONS.into_iter().flat_map(|resolution| FEEDS.map(|feed| (resolution, feed)));
    for (steps_per_mm, feed) in cases.step_by(stride(3)) {
        let (mm, feed_mm_min) = (length_mm(steps_per_mm), f64::from(feed as f32));
        for (letters, axes) in [("X", 1.0), ("XYZ", 3.0)] {
            let mut sim = machine(steps_per_mm);
            let to = |mm: f64| letters.chars().map(|letter| format!("{letter}{mm}")).collect::<String>();
            check(&mut sim, &format!("G91 G1 {} F{feed}", to(mm)), (mm, axes), feed_mm_min, steps_per_mm);
            check(&mut sim, &format!("$J=G91 {} F{feed}", to(-mm)), (mm, axes), feed_mm_min, steps_per_mm);
            let outcome = sim.outcome();
            assert_eq!(outcome.counted_steps, [0; AXES], "F{feed} at {steps_per_mm} steps/mm");
            let missed = outcome.violations.first().map(ToString::to_string);
            assert_eq!(missed, None, "F{feed} at {steps_per_mm} steps/mm");
        }
    }
}

/// Feeds in inches, and in inverse time (moves per minute).
#[test]
fn feeds_of_other_units_are_at_most_as_well() {
    for steps_per_mm in [50.0, 10_000.0] {
        let mut sim = machine(steps_per_mm);
        check(&mut sim, "G91 G20 G1 X0.1 F99999999", (2.54, 1.0), 1e9, steps_per_mm);
        check(&mut sim, "G21 G93 G1 X-2 F99999999", (2.0, 1.0), 1e8, steps_per_mm);
        check(&mut sim, "G93 G1 X2 F0.001", (2.0, 1.0), 1.0, steps_per_mm);
    }
}

/// The override applies to the requested feed, not to the feed after the limits.
#[test]
fn an_override_of_a_feed_beyond_the_limits_counts_from_that_feed() {
    let mut sim = machine(50.0);
    for (feed, least) in [("12000001", "2880"), ("28000", "2800")] {
        begin(&mut sim, &format!("G91 G1 X200 F{feed}"), Duration::from_secs(2));
        assert_eq!(field(&mut sim, "FS"), "2880,0", "F{feed}");
        bytes(&mut sim, &[0x92; 9]);
        sim.run_for(Duration::from_millis(500)).unwrap();
        assert_eq!(field(&mut sim, "FS"), format!("{least},0"), "a tenth of F{feed}");
        bytes(&mut sim, &[0x90]);
        sim.run_until_idle().unwrap();
        sim.replies();
        assert_eq!(say(&mut sim, "G91 G0 X-200"), ["ok"]);
    }
}

/// `$25` and `$24` are feeds of a single axis.
#[test]
fn homing_is_as_fast_as_its_axis_at_most() {
    for (steps_per_mm, seek, latch) in [(10_000.0, 100_000.0, 60.0), (10_000.0, 600.0, 100_000.0), (0.1, 600.0, 1.0)] {
        let mut config = Config::default();
        config.settings.steps_per_mm = [steps_per_mm; AXES];
        config.settings.max_rate_mm_min = [top_mm_min(steps_per_mm) as f32; AXES];
        (config.settings.homing_seek_mm_min, config.settings.homing_latch_mm_min) = (seek, latch);
        if steps_per_mm < 1.0 {
            // A pull-off must be at least one step.
            config.settings.homing_pull_off_mm = 20.0;
        }
        config.start_mm = [30.0, 30.0, 30.0];
        let mut sim = powered_up(&config);
        assert_eq!(say(&mut sim, "$HX"), ["ok"], "$25={seek}, $24={latch} at {steps_per_mm} steps/mm");
        assert!(status(&mut sim).starts_with("<Idle|MPos:0.000"));
    }
}
