//! An axis with two motors: homed apart, squared by their switches and an offset, and stopped by either.
//!
//! The simulated gantry has a frame between the motors, which may be out of square at rest and binds when it is skewed too
//! far. Its two motors get their steps from the ports that the firmware has.

use embassy_time::Duration;
use isostep_motion::{Alarm, Axis, GangedMotor, Motor};
use isostep_sim::world::{LossCause, Wire};
use isostep_sim::{Config, Gantry, Port, Sim, State, SwitchFault};
use isostep_trials::{cases, window};
use oorandom::Rand32;

/// Y of the default machine has a second motor, 30 mm from its switch.
fn machine(port: Port) -> Config {
    let mut config = Config { port, start_mm: [5.0, 30.0, 5.0], ..Config::default() };
    config.settings.second_motor_axis = 2;
    config
}

/// Carries out a line and returns what the machine says.
fn line(sim: &mut Sim, line: &str) -> Vec<String> {
    sim.replies();
    sim.send(format!("{line}\n").as_bytes());
    sim.run_until_idle().unwrap();
    sim.replies()
}

fn homed(config: &Config) -> Sim {
    let mut sim = Sim::new(config);
    sim.run_until_idle().unwrap();
    assert_eq!(line(&mut sim, "$HY"), ["ok"], "{:?}", config.gantry);
    assert_eq!(sim.machine().homed(), [false, true, false]);
    sim
}

/// The distance by which the second motor stands farther from its switch than the first, steps.
fn second_farther_steps(sim: &Sim) -> i32 {
    sim.second_place_steps().unwrap() - sim.places_steps()[1]
}

/// Both motors of Y after its pull-off, in steps from their switches.
fn places(sim: &Sim) -> [i32; 2] {
    [sim.places_steps()[1], sim.second_place_steps().unwrap()]
}

/// A gantry up to 5 mm out at power-up, switches that bounce and are up to 5 mm out themselves, offsets up to 5 mm:
/// each time each motor stands its pull-off from its switch, and the offset apart.
#[test]
fn homing_squares_the_gantry_as_its_offset_says() {
    let homings = window(cases(40, 200));
    let mut random = Rand32::new(homings.start);
    let mut up_to = |most: f64| (f64::from(random.rand_float()) * 2.0 - 1.0) * most;
    for homing in homings {
        let mut config = machine(Port::ALL[homing as usize % 2]);
        config.seed = homing;
        config.settings.steps_per_mm[1] = [50.0, 80.0, 160.0][homing as usize % 3];
        config.settings.homing_direction_mask = [0b111, 0b101][(homing / 2) as usize % 2];
        let offset_mm = (up_to(5.0) * 1_000.0).round() / 1_000.0;
        config.settings.square_offset_mm[1] = offset_mm as f32;
        config.gantry = Gantry { skew_mm: up_to(5.0), square_mm: offset_mm, ..Gantry::SQUARE };
        let mut sim = homed(&config);
        let steps = |mm: f64| (mm * f64::from(config.settings.steps_per_mm[1])).round() as i32;
        let farther_steps = second_farther_steps(&sim);
        assert!((farther_steps - steps(offset_mm)).abs() <= 1, "{homing}: {farther_steps} steps for {offset_mm} mm");
        let nearer_steps = places(&sim).into_iter().min().unwrap();
        assert!((nearer_steps - steps(2.0)).abs() <= 1, "{homing}: {nearer_steps} steps from its switch");
        assert!(sim.skew_mm().unwrap().abs() < 2.5 / 50.0, "{homing}: {:?}", sim.skew_mm());
        let outcome = sim.outcome();
        assert!(outcome.violations.is_empty() && outcome.losses.is_empty(), "{homing}: {:?}", outcome.losses);
        // Both go on together from there.
        let before = places(&sim);
        let away = if config.settings.homing_direction_mask & 0b10 != 0 { 8 } else { -8 };
        assert_eq!(line(&mut sim, &format!("G90 G53 G0 Y{away}")), ["ok"]);
        assert_eq!(places(&sim), before.map(|place| place + steps(8.0)), "{homing}");
    }
}

/// Whichever ganged motor meets its switch first, far from it or on it at power-up.
#[test]
fn either_motor_may_meet_its_switch_first() {
    for (skew_mm, port) in [-5.0, -0.02, 0.0, 0.02, 5.0].into_iter().zip(Port::ALL.into_iter().cycle()) {
        for start_mm in [30.0, -0.5, 0.0] {
            let mut config = machine(port);
            config.start_mm[1] = start_mm;
            // On the switch at power-up the ganged motors are no farther apart than a pull-off frees.
            config.gantry.skew_mm = if start_mm > 0.0 { skew_mm } else { skew_mm.clamp(-1.0, 5.0) };
            let sim = homed(&config);
            assert_eq!(places(&sim), [100, 100], "{skew_mm} mm skewed, from {start_mm} mm");
        }
    }
}

/// The contacts bounce for longer than the axis takes for several steps, and are debounced for longer still.
#[test]
fn either_motor_s_switch_may_bounce_long_after_a_fast_latch() {
    for (port, negative) in Port::ALL.into_iter().flat_map(|port| [(port, 0b111), (port, 0b101)]) {
        for skew_mm in [-3.0, -0.04, 0.0, 0.04, 3.0] {
            let mut config = machine(port);
            (config.bounce_us, config.gantry.skew_mm) = (20_000, skew_mm);
            let settings = &mut config.settings;
            (settings.homing_debounce_ms, settings.homing_latch_mm_min) = (250, 600.0);
            settings.homing_direction_mask = negative;
            for seed in 0..4 {
                config.seed = seed;
                let sim = homed(&config);
                assert_eq!(places(&sim), [100, 100], "{port}, $23={negative}, {skew_mm} mm skewed, seed {seed}");
            }
        }
    }
}

/// Neither the offset nor anything else of homing leaves a motor without its steps.
#[test]
fn after_an_offset_both_motors_make_every_later_step() {
    for offset_mm in [-1.5, 1.5] {
        let mut config = machine(Port::Pio);
        config.settings.square_offset_mm[1] = offset_mm;
        let mut sim = homed(&config);
        for target_mm in [10, 0, 25] {
            let before = places(&sim);
            let y_steps = sim.machine().position_steps()[1];
            assert_eq!(line(&mut sim, &format!("G53 G1 Y{target_mm} F1200")), ["ok"]);
            let moved = 50 * target_mm - y_steps;
            assert_eq!(places(&sim), before.map(|place| place + moved), "to {target_mm} mm, {offset_mm} mm farther");
        }
        assert_eq!(second_farther_steps(&sim), (offset_mm * 50.0) as i32);
    }
}

/// The pull-off takes both motors off their switches, and the offset comes on top.
#[test]
fn the_pull_off_moves_both_motors() {
    for (offset_mm, wanted) in [(0.0, [100, 100]), (0.5, [100, 125]), (-0.5, [125, 100])] {
        let mut config = machine(Port::Timer);
        config.settings.square_offset_mm[1] = offset_mm;
        assert_eq!(places(&homed(&config)), wanted, "{offset_mm} mm");
    }
}

/// Every axis is really homed by `$H`, the squared one by its own two switches, whatever the other switches do.
#[test]
fn all_axes_are_homed_by_their_own_switches() {
    for second_motor_axis in 1..=3 {
        let mut config = machine(Port::Pio);
        config.settings.second_motor_axis = second_motor_axis;
        config.gantry.skew_mm = 1.0;
        let mut sim = Sim::new(&config);
        sim.run_until_idle().unwrap();
        assert_eq!(line(&mut sim, "$H"), ["ok"]);
        assert_eq!((sim.machine().homed(), sim.places_steps()), ([true; 3], [100; 3]), "{second_motor_axis}");
        assert_eq!(sim.second_place_steps(), Some(100), "{second_motor_axis}");
    }
}

/// The edges of STEP of a motor, ns.
fn rises(sim: &Sim, motor: Motor) -> Vec<u64> {
    let waves = sim.outcome().waves;
    waves.iter().filter(|wave| wave.wire == Wire::Step(motor) && wave.high).map(|wave| wave.t_ns).collect()
}

#[test]
fn both_motors_step_at_the_same_instants() {
    for port in Port::ALL {
        let mut sim = Sim::new(&machine(port));
        assert_eq!(line(&mut sim, "G91 G1 X3 Y4 F1200").last().unwrap(), "ok");
        assert_eq!(line(&mut sim, "G1 X-1 Y-2"), ["ok"]);
        let first = rises(&sim, Motor::first(Axis::Y));
        assert_eq!(first.len(), 300, "{port}");
        assert_eq!(rises(&sim, Motor::second(Axis::Y)), first, "{port}");
        assert_eq!(sim.outcome().violations, [], "{port}");
    }
}

/// Its DIR is the other one with `$8`, the first's follows `$3`, and the gantry still goes where it is sent.
#[test]
fn the_second_motor_may_be_mounted_the_other_way_round() {
    for (second_invert_mask, direction_invert_mask) in [(0b010, 0), (0, 0b010), (0b111, 0b010)] {
        for port in Port::ALL {
            let mut config = machine(port);
            config.settings.second_invert_mask = second_invert_mask;
            config.settings.direction_invert_mask = direction_invert_mask;
            config.gantry.skew_mm = -3.0;
            let mut sim = homed(&config);
            assert_eq!(line(&mut sim, "G53 G0 Y7"), ["ok"]);
            assert_eq!((places(&sim), sim.outcome().violations), ([450, 450], vec![]));
            let level = |motor| {
                let outcome = sim.outcome();
                outcome.waves.iter().rfind(|wave| wave.wire == Wire::Dir(motor)).is_some_and(|wave| wave.high)
            };
            let is_other = level(Motor::first(Axis::Y)) != level(Motor::second(Axis::Y));
            assert_eq!(is_other, second_invert_mask & 0b010 != 0, "{port}");
        }
    }
}

#[test]
fn the_limit_of_either_motor_stops_everything() {
    for port in Port::ALL {
        for ganged in [GangedMotor::First, GangedMotor::Second] {
            let motor = Motor { axis: Axis::Y, ganged };
            let mut sim = homed(&machine(port));
            sim.send(b"G53 G1 X20 Y30 F1200\n");
            sim.run_for(Duration::from_millis(900)).unwrap();
            sim.set_switch(motor, SwitchFault::StuckClosed);
            let (places_then, x_then) = (places(&sim), sim.places_steps()[0]);
            sim.run_for(Duration::from_millis(100)).unwrap();
            assert_eq!(sim.machine().state(), State::Alarm(Alarm::HardLimit { motor }), "{port}");
            assert_eq!((places(&sim), sim.places_steps()[0]), (places_then, x_then), "{port}: no step more");
            assert!(places_then[0] > 150 && places_then[0] == places_then[1], "{port}: {places_then:?}");
            assert_eq!(sim.machine().position_steps()[1], places_then[0] - 100, "{port}");
            assert_eq!(sim.machine().homed(), [false; 3], "{port}");
            let name = motor.to_string();
            let said = sim.replies();
            assert!(said.iter().any(|said| said.contains(&format!("{name} limit switch closed"))), "{said:?}");
            // Nothing goes further onto it, and away from it is allowed.
            assert_eq!(line(&mut sim, "$X").last().unwrap(), "ok");
            assert!(line(&mut sim, "G91 G0 Y-1").iter().any(|said| said == "ALARM:1"), "{port}");
            assert_eq!(line(&mut sim, "$X").last().unwrap(), "ok");
            assert_eq!(line(&mut sim, "G91 G0 Y1"), ["ok"]);
        }
    }
}

/// Without a second motor its switch means nothing, whatever level its input has.
#[test]
fn without_a_second_motor_its_switch_does_not_count() {
    let mut config = machine(Port::Pio);
    // Pulled up, an input that is not connected reads as pressed.
    config.settings.limit_invert = true;
    config.settings.second_motor_axis = 0;
    let mut sim = homed(&config);
    assert_eq!(line(&mut sim, "G53 G0 Y5"), ["ok"]);
    sim.send(b"?");
    sim.run_until_idle().unwrap();
    assert!(!sim.replies().concat().contains("Pn:"));
}

/// A ganged motor is jammed. If the other meets its switch, the alarm names the jammed one, and no motor has gone alone by more
/// than the limit. Far from the switches only the frame itself holds the other motor back.
#[test]
fn a_jammed_motor_is_an_alarm_and_nothing_is_torn() {
    for port in Port::ALL {
        for jammed in [Motor::first(Axis::Y), Motor::second(Axis::Y)] {
            for start_mm in [2.0, 5.0, 30.0] {
                let mut config = machine(port);
                config.start_mm[1] = start_mm;
                config.settings.skew_max_mm = 3.0;
                config.gantry.binds_mm = 8.0;
                let mut sim = Sim::new(&config);
                sim.suffer(format!("stall:{jammed}@0").parse().unwrap());
                let said = line(&mut sim, "$HY");
                let (alarm, skew_max_mm) = match start_mm {
                    30.0 => (Alarm::SwitchNotFound { axis: Axis::Y }, 8.0),
                    // What it goes while its switch is debounced, and a step.
                    _ => (Alarm::Skewed { motor: jammed }, start_mm + 0.05 + 0.02),
                };
                assert_eq!(sim.machine().state(), State::Alarm(alarm), "{said:?}");
                assert!(sim.skew_mm().unwrap().abs() <= skew_max_mm + 0.02, "{port}: {:?}", sim.skew_mm());
                assert_eq!(sim.machine().homed(), [false; 3]);
                if start_mm < 30.0 {
                    assert!(said.iter().any(|said| said == "ALARM:15"), "{said:?}");
                    assert!(said.iter().any(|said| said.contains(&format!("{jammed} did not reach"))), "{said:?}");
                    assert!(sim.outcome().losses.iter().all(|loss| loss.cause != LossCause::Bound), "{port}");
                }
            }
        }
    }
}

/// A ganged motor moves alone by the skew limit at most, whether it is jammed, or its switch does not close.
#[test]
fn no_motor_goes_farther_alone_than_the_skew_limit() {
    for port in Port::ALL {
        for ganged in [GangedMotor::First, GangedMotor::Second] {
            let blind = Motor { axis: Axis::Y, ganged };
            let mut config = machine(port);
            config.settings.skew_max_mm = 1.5;
            let mut sim = Sim::new(&config);
            sim.set_switch(blind, SwitchFault::StuckOpen);
            line(&mut sim, "$HY");
            assert_eq!(sim.machine().state(), State::Alarm(Alarm::Skewed { motor: blind }), "{port}");
            assert_eq!(sim.skew_mm().unwrap().abs(), 1.5, "{port}");
        }
    }
}

#[test]
fn neither_switch_found_is_alarm_9_and_a_switch_that_stays_closed_is_named() {
    let mut sim = Sim::new(&machine(Port::Pio));
    for motor in [Motor::first(Axis::Y), Motor::second(Axis::Y)] {
        sim.set_switch(motor, SwitchFault::StuckOpen);
    }
    line(&mut sim, "$HY");
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::SwitchNotFound { axis: Axis::Y }));
    for motor in [Motor::first(Axis::Y), Motor::second(Axis::Y)] {
        let mut sim = Sim::new(&machine(Port::Pio));
        sim.set_switch(motor, SwitchFault::StuckClosed);
        line(&mut sim, "$HY");
        let state = sim.machine().state();
        let other = Motor { ganged: motor.ganged.other(), ..motor };
        // The other motor has farther to go than it may alone.
        assert_eq!(state, State::Alarm(Alarm::Skewed { motor: other }));
        assert_eq!(sim.skew_mm().unwrap().abs(), 10.0);
    }
    for motor in [Motor::first(Axis::Y), Motor::second(Axis::Y)] {
        let mut config = machine(Port::Pio);
        config.start_mm[1] = 5.0;
        let mut sim = Sim::new(&config);
        sim.set_switch(motor, SwitchFault::StuckClosed);
        let said = line(&mut sim, "$HY");
        assert_eq!(sim.machine().state(), State::Alarm(Alarm::SwitchStuck { motor }));
        assert!(said.iter().any(|said| said.contains(&format!("{motor} limit switch still closed"))), "{said:?}");
    }
}

/// Freed, the frame springs back: the axis has to be homed again, with an idle delay too.
#[test]
fn freed_motors_leave_the_squared_axis_not_homed() {
    let mut config = machine(Port::Pio);
    config.gantry.skew_mm = 4.0;
    let sim = homed(&config);
    assert_eq!((sim.skew_mm(), sim.machine().homed()[1]), (Some(0.0), true), "held square");
    config.settings.idle_delay_ms = 100;
    let mut sim = Sim::new(&config);
    line(&mut sim, "$H");
    sim.run_for(Duration::from_secs(1)).unwrap();
    assert_eq!((sim.skew_mm(), sim.machine().homed()), (Some(4.0), [true, false, true]));
}

#[test]
fn a_pressed_switch_of_the_second_motor_is_told_apart() {
    let mut sim = Sim::new(&machine(Port::Pio));
    sim.run_until_idle().unwrap();
    for (ganged, pins) in [(GangedMotor::First, "|Pn:Y|"), (GangedMotor::Second, "|Pn:Y2|")] {
        let motor = Motor { axis: Axis::Y, ganged };
        sim.set_switch(motor, SwitchFault::StuckClosed);
        sim.run_until_idle().unwrap();
        sim.replies();
        sim.send(b"?");
        sim.run_until_idle().unwrap();
        let report = format!("{}|", sim.replies().concat().trim_end_matches('>'));
        assert!(report.contains(pins), "{report} for {pins}");
        sim.set_switch(motor, SwitchFault::None);
    }
}

#[test]
fn settings_that_cannot_work_are_refused_with_the_remedy() {
    let mut sim = Sim::new(&Config::default());
    for (asked, reason) in [
        ("$905=4", "$905=4 is above the most, 3: lower it"),
        ("$171=5.5", "$171=5.500 is above the most, 5 mm: lower it"),
        ("$171=-6", "$171=-6 is below the least, -5 mm: raise it"),
        ("$349=0", "$349=0 is below the least, 0.100 mm: raise it"),
        ("$8=8", "$8=8 is above the most, 7: lower it"),
    ] {
        let said = line(&mut sim, asked);
        assert!(said.contains(&format!("[MSG:{reason}]")), "{said:?}");
    }
    for asked in ["$131=6", "$905=2", "$171=-3.9"] {
        assert_eq!(line(&mut sim, asked), ["ok"], "{asked}");
    }
    let said = line(&mut sim, "$171=-4");
    let reason = "$27=2 with the offset of the second motor, $171=-4, is not below the travel of Y, $131=6 mm: \
                  lower $27 or raise $131";
    assert!(said.contains(&format!("[MSG:{reason}; until then nothing moves]")), "{said:?}");
    assert_eq!(line(&mut sim, "$H").last().unwrap(), "error:2");
    assert_eq!(line(&mut sim, "$905=0"), ["ok"], "no second motor, no offset");
}

/// A reset, the emergency stop, and a reset again: none of them leaves a ganged motor held.
#[test]
fn a_stop_while_one_motor_moves_alone_leaves_none_held() {
    for at_ms in [2_900, 3_000, 3_050, 3_100, 3_200, 3_300, 3_400] {
        let mut config = machine(Port::Pio);
        config.gantry.skew_mm = 5.0;
        let mut sim = Sim::new(&config);
        sim.run_until_idle().unwrap();
        sim.send(b"$HY\n");
        sim.run_for(Duration::from_millis(at_ms)).unwrap();
        sim.send(&[0x18]);
        sim.run_until_idle().unwrap();
        assert_eq!(sim.machine().state(), State::Alarm(Alarm::HomingReset), "after {at_ms} ms");
        assert_eq!(line(&mut sim, "$X").last().unwrap(), "ok");
        let before = places(&sim);
        assert_eq!(line(&mut sim, "G91 G0 Y3"), ["ok"]);
        assert_eq!(places(&sim), before.map(|place| place + 150), "after {at_ms} ms");
    }
}

#[test]
fn a_changed_offset_takes_the_zero_away() {
    for asked in ["$8=2", "$171=0.1", "$349=4", "$905=0"] {
        let mut sim = homed(&machine(Port::Pio));
        assert_eq!(line(&mut sim, "$170=1"), ["ok"], "of another axis");
        assert!(sim.machine().homed()[1]);
        assert_eq!(line(&mut sim, asked).last().unwrap(), "ok");
        assert!(!sim.machine().homed()[1], "{asked}");
    }
}
