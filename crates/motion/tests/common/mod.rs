//! A configuration that works.

use embassy_time::Duration;
use isostep_motion::{AXES, Axis, Config, Direction, HomingConfig};
use isostep_profile::Limits;

pub fn works() -> Config {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 2_000.0,
        accel_steps_s2: 10_000.0,
        decel_steps_s2: 10_000.0,
        jerk_steps_s3: f64::INFINITY,
    };
    let homing = HomingConfig {
        order: Axis::ALL.map(Some),
        towards: [Direction::Negative; AXES],
        seek_mm_s: 10.0,
        room_mm: 0.0,
        latch_mm_s: 1.0,
        pull_off_mm: 2.0,
        debounce: Duration::from_millis(5),
        by_stall: [false; AXES],
    };
    Config::new([limits; AXES], [50.0; AXES], [400.0, 350.0, 100.0], homing)
}
