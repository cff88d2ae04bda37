//! When a driver says that its motor stalls.

use isostep_sim::drivers::Wire;
use tmc2209::reg::{GCONF, SGTHRS, TCOOLTHRS};
use tmc2209::{WritableRegister, WriteRequest};

/// Steps of a full step, by the pins of the first driver.
const MICROSTEPS: i32 = 8;
/// 500 full steps a second, and 40. Their `TSTEP`s are 93 and 1,171.
const FAST_STEPS_S: f64 = 4_000.0;
const SLOW_STEPS_S: f64 = 320.0;
const FAST_TCOOLTHRS: u32 = 200;
const SLOW_TCOOLTHRS: u32 = 2_000;
/// A free motor measures 390 to 410, twice this is the threshold.
const THRESHOLD: u32 = 50;

/// A driver with these thresholds. Its motor turns freely, and fast.
fn turning(sgthrs: u32, tcoolthrs: u32) -> Wire {
    let mut wire = Wire::new([0, 2, 1, 3]);
    set(&mut wire, SGTHRS::from(sgthrs));
    set(&mut wire, TCOOLTHRS::from(tcoolthrs));
    assert_eq!(stalls(&mut wire, FAST_STEPS_S, 0.0).last(), Some(&(sgthrs > 195)));
    wire
}

fn set<R: WritableRegister>(wire: &mut Wire, register: R) {
    wire.exchange(WriteRequest::new(0, register).bytes());
}

/// DIAG after each step of ten full steps, at this speed and load.
fn stalls(wire: &mut Wire, speed_steps_s: f64, load: f64) -> Vec<bool> {
    let step = |_| {
        wire[0].set_load(speed_steps_s, load);
        wire[0].step(1);
        wire[0].diag()
    };
    (0..10 * MICROSTEPS).map(step).collect()
}

#[test]
fn a_motor_that_turns_freely_is_not_stalled_unless_the_threshold_is_above_its_load() {
    assert!(!stalls(&mut turning(THRESHOLD, FAST_TCOOLTHRS), FAST_STEPS_S, 0.0).contains(&true));
    assert!(!stalls(&mut turning(THRESHOLD, FAST_TCOOLTHRS), FAST_STEPS_S, 0.6).contains(&true));
    assert!(!stalls(&mut turning(255, FAST_TCOOLTHRS), FAST_STEPS_S, 0.0).contains(&false));
}

#[test]
fn a_stall_is_reported_where_the_next_full_step_ends_and_until_one_ends_that_is_free() {
    for begun in 0..MICROSTEPS {
        let mut wire = turning(THRESHOLD, FAST_TCOOLTHRS);
        wire[0].step(begun);
        let reported = stalls(&mut wire, FAST_STEPS_S, 1.0);
        let first = reported.iter().position(|stalls| *stalls).unwrap();
        assert_eq!(first as i32, MICROSTEPS - 1 - begun);
        assert!(reported[first..].iter().all(|stalls| *stalls));
        let freed = stalls(&mut wire, FAST_STEPS_S, 0.0).into_iter().take_while(|stalls| *stalls).count();
        assert_eq!(freed as i32, MICROSTEPS - 1 - begun);
    }
}

#[test]
fn a_slow_motor_is_a_stall_if_tcoolthrs_includes_its_speed() {
    assert!(!stalls(&mut turning(THRESHOLD, FAST_TCOOLTHRS), SLOW_STEPS_S, 0.0).contains(&true));
    assert!(stalls(&mut turning(THRESHOLD, SLOW_TCOOLTHRS), SLOW_STEPS_S, 0.0).contains(&true));
}

#[test]
fn spread_cycle_and_a_tcoolthrs_of_0_tell_no_stall() {
    let mut wire = turning(255, FAST_TCOOLTHRS);
    set(&mut wire, GCONF::from(1 << 2));
    assert!(!wire[0].diag(), "as soon as it is written");
    assert!(!stalls(&mut wire, FAST_STEPS_S, 1.0).contains(&true));
    set(&mut wire, GCONF::from(0));
    assert!(wire[0].diag());
    set(&mut wire, TCOOLTHRS::from(0));
    for speed_steps_s in [0.0, SLOW_STEPS_S, FAST_STEPS_S, 1e9] {
        assert!(!stalls(&mut wire, speed_steps_s, 1.0).contains(&true), "{speed_steps_s} steps/s");
    }
}

#[test]
fn a_motor_that_comes_to_rest_is_stalled_no_more() {
    for (speed_steps_s, tcoolthrs, is_reported) in [
        (0.0, 0xF_FFFF, false),
        (FAST_STEPS_S / 2.0, FAST_TCOOLTHRS, true),
        (FAST_STEPS_S / 2.2, FAST_TCOOLTHRS, false),
        (FAST_STEPS_S / 2.2, 0xF_FFFF, true),
    ] {
        let mut wire = turning(THRESHOLD, tcoolthrs);
        assert!(stalls(&mut wire, FAST_STEPS_S, 1.0).contains(&true));
        wire[0].set_load(speed_steps_s, 1.0);
        assert_eq!(wire[0].diag(), is_reported, "{speed_steps_s} steps/s");
        wire[0].set_load(FAST_STEPS_S, 1.0);
        assert_eq!(wire[0].diag(), is_reported, "no full step was made");
    }
}
