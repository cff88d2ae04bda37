//! A configuration that cannot work is refused by name, and every text for a person says something.

use embassy_time::Duration;
use isostep_motion::{
    AXES, Alarm, Axis, Capabilities, Config, Direction, DriverTiming, Duties, HomingConfig, Level, Motor, Side,
    Squared, ToolConfig, Unplannable, Wiring,
};
use isostep_profile::{IntervalLaw, Limits, SpeedLaw};

fn works() -> Config {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 2_000.0,
        accel_steps_s2: 10_000.0,
        decel_steps_s2: 10_000.0,
        jerk_steps_s3: f64::INFINITY,
    };
    Config {
        limits: [limits; AXES],
        steps_per_mm: [50.0; AXES],
        travel_mm: [400.0, 350.0, 100.0],
        is_endless: [false; AXES],
        junction_deviation_mm: 0.01,
        interval_law: IntervalLaw::Fastest,
        speed_law: SpeedLaw::Trapezoid,
        hard_limits: true,
        wiring: [Wiring::default(); AXES],
        enable_inverted: false,
        switches_inverted: false,
        idle_delay: None,
        tool: ToolConfig {
            laser: false,
            duties: Duties::new(Level::ZERO, 0, 1),
            pwm_hz: 1_000,
            spin_up: Duration::from_ticks(0),
        },
        probe_inverted: false,
        probe_pulled_up: true,
        hold_is_door: false,
        homing: HomingConfig {
            order: Axis::ALL.map(Some),
            towards: [Direction::Negative; AXES],
            seek_mm_s: 10.0,
            latch_mm_s: 1.0,
            pull_off_mm: 2.0,
            debounce: Duration::from_millis(5),
        },
        squared: None,
    }
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
    ];
    for (change, words) in rows {
        let mut config = works();
        change(&mut config);
        let refused = config.check([Some(port()); AXES]).expect_err(words).to_string();
        assert!(refused.starts_with(words), "{refused} is not {words}");
    }
    assert_eq!(works().check([Some(port()); AXES]), Ok(()));
    let corners = Config { junction_deviation_mm: 0.0, ..works() };
    assert_eq!(corners.check([None; AXES]), Ok(()), "every corner is a stop");
}

#[test]
fn every_reason_says_something_of_its_own() {
    let axis = Axis::Y;
    let motor = Motor { axis, side: Side::Second };
    let reasons = [
        Unplannable::NoSteps,
        Unplannable::Limits { axis },
        Unplannable::Feed,
        Unplannable::TooLong,
        Unplannable::Standstill,
        Unplannable::Ends,
    ];
    let alarms = [
        Alarm::HardLimit { motor },
        Alarm::SoftLimit { axis },
        Alarm::ResetInMotion,
        Alarm::HomingReset,
        Alarm::SwitchStuck { motor },
        Alarm::Skewed { motor },
        Alarm::SwitchNotFound { axis },
        Alarm::EmergencyStop,
        Alarm::LateStep { axis },
        Alarm::Underrun { axis },
        Alarm::ToolCutOff,
        Alarm::ProbeInitial,
        Alarm::ProbeContact,
        Alarm::HomingDoor,
    ];
    let alarms = alarms.into_iter().chain(reasons.map(|reason| Alarm::Unplannable { reason }));
    let mut texts: Vec<_> =
        reasons.map(|reason| reason.to_string()).into_iter().chain(alarms.map(|a| a.to_string())).collect();
    assert!(texts.iter().all(|text| text.len() > 10), "{texts:?}");
    assert!(texts.iter().filter(|text| text.contains('Y')).count() == 9, "those of an axis name it: {texts:?}");
    let all = texts.len();
    texts.sort();
    texts.dedup();
    assert_eq!(texts.len(), all, "two say the same");
}
