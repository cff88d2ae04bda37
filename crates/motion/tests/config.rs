//! A configuration that cannot work is refused by name.

use isostep_motion::{AXES, Axis, Capabilities, Config, DriverTiming, Squared};
use isostep_profile::SpeedProfile;
use isostep_profile::shaper::{Shaper, ShaperKind};

use super::common::works;

/// The same with a shaper on every axis.
fn shaped() -> Config {
    let shaper = Shaper { kind: ShaperKind::Zv, natural_hz: 40.0, damping_ratio: 0.05 };
    Config { shapers: [shaper; AXES], ..works() }
}

const SQUARED: Squared = Squared { axis: Axis::Y, direction_inverted: false, offset_mm: -350.0, skew_max_mm: 10.0 };

/// A port that carries the driver's 250,000 steps/s.
fn port() -> Capabilities {
    Capabilities::new(8_000_000, DriverTiming::DRV8825)
}

#[test]
fn what_cannot_work_is_refused_with_its_value() {
    type Change = fn(&mut Config);
    let rows: &[(Change, &str)] = &[
        (|config| config.limits[1].accel_steps_s2 = 0.0, "Y: "),
        (|config| config.limits[2].top_speed_steps_s = 1e7, "Z: 10000000 steps/s is above the 250000 steps/s"),
        (|config| config.steps_per_mm[0] = 0.0, "steps/mm: 0 must be above 0"),
        (|config| config.steps_per_mm[2] = f64::INFINITY, "steps/mm: inf must be above 0"),
        (|config| config.travel_mm[1] = -1.0, "travel, mm: -1 must be above 0"),
        (|config| config.junction_deviation_mm = -0.01, "junction deviation, mm: -0.01 must be 0 or more"),
        (|config| config.junction_deviation_mm = f64::NAN, "junction deviation, mm: NaN must be 0 or more"),
        (|config| config.junction_deviation_mm = f64::INFINITY, "junction deviation, mm: inf must be 0 or more"),
        (|config| config.tool.pwm_hz = 0, "PWM frequency, Hz: 0 must be above 0"),
        (|config| config.homing.seek_mm_s = 0.0, "homing seek, mm/s: 0 must be above 0"),
        (|config| config.homing.latch_mm_s = f64::NAN, "homing latch, mm/s: NaN must be above 0"),
        (|config| config.homing.pull_off_mm = 0.0, "homing pull-off, mm: 0 must be above 0"),
        (
            |config| config.homing.pull_off_mm = 100.0,
            "Z: a homing pull-off of 100 mm is not below the travel of 100 mm",
        ),
        (|config| config.squared = Some(SQUARED), "Y: a homing pull-off of 352 mm is not below the travel of 350 mm"),
        (
            |config| config.squared = Some(Squared { offset_mm: 0.0, skew_max_mm: 0.0, ..SQUARED }),
            "skew limit, mm: 0 must be above 0",
        ),
        (|config| config.homing.order[2] = Some(Axis::X), "the homing order must not name an axis twice"),
        (|config| config.shapers[1].natural_hz = 9.9, "Y: shaper of 9.9 Hz is outside 10 to 500 Hz"),
        (|config| config.shapers[0].natural_hz = f64::NAN, "X: shaper of NaN Hz is outside 10 to 500 Hz"),
        (|config| config.shapers[2].damping_ratio = 0.51, "Z: shaper's damping ratio 0.51 is outside 0 to 0.5"),
        (|config| config.shapers[0].damping_ratio = -0.1, "X: shaper's damping ratio -0.1 is outside 0 to 0.5"),
        (
            |config| config.speed_profile = SpeedProfile::Sine,
            "X has a shaper, which shapes the trapezoid only: choose no shaper, or the trapezoid",
        ),
    ];
    for (change, words) in rows {
        let mut config = shaped();
        change(&mut config);
        let refused = config.check([Some(port()); AXES]).expect_err(words).to_string();
        assert!(refused.starts_with(words), "{refused} is not {words}");
    }
    assert_eq!(works().check([Some(port()); AXES]), Ok(()));
    assert_eq!(shaped().check([Some(port()); AXES]), Ok(()));
    let curved = Config { speed_profile: SpeedProfile::Sine, ..works() };
    assert_eq!(curved.check([Some(port()); AXES]), Ok(()), "without a shaper its numbers do not count");
    let corners = Config { junction_deviation_mm: 0.0, ..works() };
    assert_eq!(corners.check([None; AXES]), Ok(()), "every corner is a stop");
}
