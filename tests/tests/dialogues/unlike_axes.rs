//! Axes that differ from each other: each has its own bit of a mask, its own shaper and its own direction.

use embassy_time::Duration;
use isostep_motion::{Axis, Motor, State};
use isostep_sim::world::Wire;
use isostep_sim::{Board, Config, Sim};

use crate::talk::{powered_up, say};

const MASKS: std::ops::Range<u16> = 0..8;
/// Instants are whole ticks of 1 us.
const TICKS_S: f64 = 2e-6;

fn has(mask: u16, axis: Axis) -> bool {
    mask & 1 << axis as u16 != 0
}

fn is_dir_high(sim: &Sim, motor: Motor) -> bool {
    sim.outcome().waves.iter().rfind(|wave| wave.wire == Wire::Dir(motor)).is_some_and(|wave| wave.high)
}

/// `$3`: all axes go towards positive.
#[test]
fn each_bit_inverts_the_direction_of_its_axis() {
    for mask in MASKS {
        let mut config = Config::default();
        config.settings.direction_invert_mask = mask;
        let mut sim = powered_up(&config);
        assert_eq!(say(&mut sim, "G91 G0 X1 Y1 Z1"), ["ok"]);
        for axis in Axis::ALL {
            assert_eq!(is_dir_high(&sim, Motor::first(axis)), !has(mask, axis), "$3={mask}: {axis}");
        }
    }
}

/// `$8`: of the axis that has a second motor, whichever that is.
#[test]
fn only_the_bit_of_its_axis_inverts_a_second_motor() {
    for (axis, mask) in Axis::ALL.into_iter().flat_map(|axis| MASKS.map(move |mask| (axis, mask))) {
        let mut config = Config::default();
        (config.settings.second_motor_axis, config.settings.second_invert_mask) = (axis as u16 + 1, mask);
        let mut sim = powered_up(&config);
        assert_eq!(say(&mut sim, &format!("G91 G0 {axis}1")), ["ok"]);
        let [first, second] = [Motor::first(axis), Motor::second(axis)].map(|motor| is_dir_high(&sim, motor));
        assert_eq!(first != second, has(mask, axis), "$8={mask}: {axis}");
    }
}

/// `$338`: whose drivers are asked. `$339` and `$909`: which of them tell stalls in moves.
#[test]
fn each_bit_of_the_masks_of_drivers_is_its_axis() {
    for mask in MASKS {
        let mut config = Config { board: Board::SkrPico, driver: Board::SkrPico.driver(), ..Config::default() };
        config.settings.trinamic_mask = mask;
        let mut sim = Sim::new(&config);
        sim.run_for(Duration::from_millis(300)).unwrap();
        sim.replies();
        let reported = say(&mut sim, "M122");
        for axis in Axis::ALL {
            let is_reported = reported.iter().any(|line| line.starts_with(&format!("[MSG:{axis} driver: well")));
            assert_eq!(is_reported, has(mask, axis), "$338={mask}: {axis}: {reported:?}");
        }
    }
    for (homing, alarm) in MASKS.flat_map(|homing| MASKS.map(move |alarm| (homing, alarm))) {
        let mut config =
            Config { board: Board::SkrPico, driver: Board::SkrPico.driver(), diag: [true; 3], ..Config::default() };
        (config.settings.stall_homing_mask, config.settings.stall_alarm_mask) = (homing, alarm);
        (config.settings.stall_threshold, config.settings.homing_seek_mm_min) = ([70; 3], 1_800.0);
        let mut sim = Sim::new(&config);
        sim.run_for(Duration::from_millis(300)).unwrap();
        for axis in Axis::ALL {
            let tells = sim.driver_setup(axis as usize).unwrap().reports_stalls;
            assert_eq!(tells, has(homing & alarm, axis), "$339={homing}, $909={alarm}: {axis}");
        }
    }
}

/// ZV of 25 Hz on one axis, of 40 Hz on another, none on the third. Whichever moves, and whichever has the longest, a run is
/// over when that has passed: half a period of its damped frequency.
#[test]
fn a_run_lasts_longer_by_the_longest_shaper_whichever_axis_has_it_and_whichever_moves() {
    let config = |shaped: Option<(Axis, Axis)>| {
        let mut config = Config::default();
        config.settings.accel_mm_s2 = [1_000.0; 3];
        for (axis, hz) in shaped.into_iter().flat_map(|(long, short)| [(long, 25.0), (short, 40.0)]) {
            (config.settings.shaper_kind[axis as usize], config.settings.shaper_hz[axis as usize]) = (1, hz);
        }
        config
    };
    // When a hold has ended, and when the next run begins.
    let instants_s = |config: &Config, moving: Axis| {
        let mut sim = powered_up(config);
        sim.send(format!("G91 G1 {moving}8 F2400\n").as_bytes());
        sim.run_until_state(|state| state == State::Run).unwrap();
        let start_ns = sim.now_ns();
        sim.run_for(Duration::from_millis(100)).unwrap();
        sim.send(b"!");
        sim.run_until_state(|state| state == State::Hold { still: true }).unwrap();
        let held_s = (sim.now_ns() - start_ns) as f64 * 1e-9;
        let outcome = isostep_sim::run(format!("G91 G1 {moving}8 F2400\nG4 P0\n{moving}-8\n").as_bytes(), config);
        let moves = outcome.unwrap().moves;
        let next_s = (moves[moves.len() - 1].start_ns - moves[0].start_ns) as f64 * 1e-9;
        [held_s, next_s]
    };
    let longest_s = 0.5 / (25.0 * (1.0_f64 - 0.05 * 0.05).sqrt());
    for long in Axis::ALL {
        let short = Axis::ALL[(long as usize + 1) % 3];
        for moving in Axis::ALL {
            let (shaped, plain) = (instants_s(&config(Some((long, short))), moving), instants_s(&config(None), moving));
            for (shaped_s, plain_s) in shaped.into_iter().zip(plain) {
                let off_s = shaped_s - plain_s - longest_s;
                assert!(off_s.abs() < TICKS_S, "{moving} moves, {long} has the longest: {off_s} s");
            }
        }
    }
}
