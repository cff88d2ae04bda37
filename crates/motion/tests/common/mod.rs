//! A configuration that works.

use embassy_time::Duration;
use isostep_motion::{AXES, Axis, Config, Direction, Duties, HomingConfig, Level, ToolConfig, Wiring};
use isostep_profile::shaper::Shaper;
use isostep_profile::{IntervalLaw, Limits, SpeedLaw};

pub fn works() -> Config {
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
        shapers: [Shaper::default(); AXES],
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
