//! Homing seeks that brake in the room behind the limit switch (`$906`), from a speed at which a motor does not stop dead.

use embassy_time::Duration;
use isostep_motion::{AXES, Alarm, Axis, Finish, State};
use isostep_sim::analysis::mean_derivative;
use isostep_sim::drive::{Load, MotorData};
use isostep_sim::homing::{latches, towards};
use isostep_sim::losses::explained;
use isostep_sim::{Config, MoveRecord, Outcome, Port, Sim, SwitchFault};
use isostep_trials::{cases, cases_that_count, stride};

use crate::talk::{powered_up, say, switched_on};

const STEPS_PER_MM: f64 = 400.0;
const SEEK_MM_S: f64 = 50.0;
const ACCEL_MM_S2: f64 = 1_000.0;
const ROOM_MM: f64 = 2.5;
/// From 50 mm/s at 1,000 mm/s².
const BRAKES_MM: f64 = 1.25;
/// What is committed when the switch is touched, at 50 mm/s for 16 ms.
const GOES_ON_MM: f64 = 0.8;
const PULL_OFF_STEPS: i32 = 800;
/// The time over which an acceleration is measured, twice. The edges are exact to 8 ns, which is 0.2 % of the limit there.
const SPAN_S: f64 = 1e-3;

fn machine(room_mm: f64, start_mm: f64) -> Config {
    let load = Load { mm_per_rev: 8.0, mass_kg: 20.0, turning_kg_m2: 1.3e-6 };
    let mut config = Config { start_mm: [start_mm; AXES], loads: [Some(load); AXES], ..Config::default() };
    let settings = &mut config.settings;
    settings.steps_per_mm = [STEPS_PER_MM as f32; AXES];
    settings.max_rate_mm_min = [6_000.0; AXES];
    settings.accel_mm_s2 = [ACCEL_MM_S2 as f32; AXES];
    settings.homing_seek_mm_min = 60.0 * SEEK_MM_S as f32;
    settings.homing_latch_mm_min = 300.0;
    settings.switch_room_mm = room_mm as f32;
    config
}

/// The highest acceleration of X in a seek, from its edges and from its rest before and after it, over its limit.
fn accel_ratio(outcome: &Outcome, seek: &MoveRecord) -> f64 {
    let edges: Vec<f64> = outcome.edges_of(seek).iter().map(|edge| edge.t_ns as f64 * 1e-9).collect();
    let (begin_s, end_s) = (seek.start_ns as f64 * 1e-9, seek.end_ns as f64 * 1e-9);
    let end_steps = if seek.finish == Finish::Held { seek.held_at_steps } else { edges.len() as f64 };
    let rest = |spans: i32| f64::from(spans) * SPAN_S;
    let before = (0..3).rev().map(|spans| (begin_s - rest(spans), 0.0));
    let after = (0..3).map(|spans| (end_s + rest(spans), end_steps));
    let made = edges.iter().zip(0..).map(|(t_s, made)| (*t_s, f64::from(made) + 0.5));
    let samples: Vec<(f64, f64)> = before.chain(made).chain(after).collect();
    let mut highest = 0.0_f64;
    for first in 0..samples.len() {
        let later = |from: usize| (from..samples.len()).find(|&index| samples[index].0 >= samples[from].0 + SPAN_S);
        let Some(middle) = later(first) else { break };
        let Some(last) = later(middle) else { break };
        let [one, two, three] = [first, middle, last].map(|index| samples[index]);
        highest = highest.max(mean_derivative([one.0, two.0, three.0], [one.1, two.1, three.1]).abs());
    }
    highest / STEPS_PER_MM / ACCEL_MM_S2
}

/// How far X has gone on behind its switch, mm.
fn beyond_mm(config: &Config, seek: &MoveRecord) -> f64 {
    let made = f64::from(seek.end_steps[0].abs_diff(seek.origin_steps[0]));
    (made - f64::from(config.start_steps(0))) / STEPS_PER_MM
}

fn seek(outcome: &Outcome) -> &MoveRecord {
    outcome.moves.iter().find(|record| record.homing).unwrap()
}

#[test]
fn a_fast_seek_brakes_behind_the_switch_and_loses_no_step() {
    let places = cases_that_count(40, 1_000);
    let mut at_speed = 0;
    for place in 0..places {
        let start_mm = 90.0 * (f64::from(place) + 0.3) / f64::from(places);
        let config = machine(ROOM_MM, start_mm);
        let mut sim = powered_up(&config);
        assert_eq!(say(&mut sim, "$HX"), ["ok"], "from {start_mm} mm");
        let outcome = sim.outcome();
        assert_eq!(outcome.losses, [], "from {start_mm} mm");
        assert_eq!(outcome.violations, [], "from {start_mm} mm");
        assert_eq!((outcome.places_steps[0], outcome.drift_steps[0]), (PULL_OFF_STEPS, 0), "from {start_mm} mm");
        let (seek, beyond_mm) = (seek(&outcome), beyond_mm(&config, seek(&outcome)));
        assert_eq!(seek.finish, Finish::Held, "from {start_mm} mm");
        let ratio = accel_ratio(&outcome, seek);
        assert!(ratio <= 1.02, "from {start_mm} mm: {ratio} of the acceleration");
        assert!(beyond_mm <= GOES_ON_MM + BRAKES_MM, "from {start_mm} mm: {beyond_mm} mm");
        let back_off = outcome.moves.iter().filter(|record| record.homing).nth(1).unwrap();
        let opened_mm = f64::from(back_off.end_steps[0].abs_diff(back_off.origin_steps[0])) / STEPS_PER_MM - beyond_mm;
        assert!((opened_mm - 2.0).abs() <= 2.0 / STEPS_PER_MM, "from {start_mm} mm: backed off to {opened_mm} mm");
        if start_mm > 2.0 * BRAKES_MM {
            at_speed += 1;
            assert!(beyond_mm >= BRAKES_MM, "from {start_mm} mm: {beyond_mm} mm");
        }
    }
    assert!(at_speed * 10 > places * 9, "{at_speed} of {places} at the speed of the seek");
}

#[test]
fn without_room_a_fast_seek_loses_steps_and_its_remedy_is_the_speed_of_the_seek() {
    for place in 0..15 {
        let start_mm = 4.0 + 5.7 * f64::from(place);
        let mut sim = powered_up(&machine(0.0, start_mm));
        let heard = say(&mut sim, "$HX");
        assert!(heard.contains(&"ALARM:8".to_owned()), "from {start_mm} mm: {heard:?}");
        let outcome = sim.outcome();
        assert!(accel_ratio(&outcome, seek(&outcome)) > 10.0, "from {start_mm} mm");
        let explained = explained(&outcome, usize::MAX);
        assert!(!explained.is_empty());
        for loss in explained {
            let words = loss.to_string();
            assert!(words.contains("homing stops it at its switch at once, from 50 mm/s"), "{words}");
            assert!(words.ends_with("or give it room behind the switch ($906)"), "{words}");
        }
    }
}

#[test]
fn the_zero_is_the_same_step_each_time() {
    for (axis, negative) in Axis::ALL.into_iter().flat_map(|axis| [(axis, true), (axis, false)]) {
        let config = Config { bounce_us: 1_000, seed: 7, ..machine(ROOM_MM, 5.0) };
        let latches = latches(&towards(&config, negative), axis, cases(20, 50)).unwrap();
        assert!(latches.iter().all(|latch| (latch.closed_steps, latch.set_steps) == (0, 0)), "{axis}: {latches:?}");
    }
}

/// The switch closes for 4 ms: the axis brakes to rest, and goes on from there.
#[test]
fn a_spike_brakes_the_seek_and_it_goes_on() {
    let mut sim = powered_up(&machine(ROOM_MM, 60.0));
    sim.send(b"$HX\n");
    for _ in 0..3 {
        sim.run_for(Duration::from_millis(250)).unwrap();
        assert_eq!(sim.machine().state(), State::Home);
        sim.set_switch(Axis::X, SwitchFault::StuckClosed);
        sim.run_for(Duration::from_millis(4)).unwrap();
        sim.set_switch(Axis::X, SwitchFault::None);
    }
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok"]);
    let outcome = sim.outcome();
    let held = outcome.moves.iter().filter(|record| record.finish == Finish::Held).count();
    assert_eq!((held, outcome.places_steps[0]), (4, PULL_OFF_STEPS), "three spikes, and the switch");
    assert_eq!(outcome.losses, []);
}

#[test]
fn a_switch_that_never_closes_is_alarm_9_with_room_too() {
    let mut sim = powered_up(&Config { switches: [SwitchFault::StuckOpen; AXES], ..machine(ROOM_MM, 20.0) });
    say(&mut sim, "$HX");
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::SwitchNotFound { axis: Axis::X }));
}

/// Resets, the door and the emergency stop at every millisecond from before the switch until the latch.
#[test]
fn a_stop_while_a_seek_brakes_stops_at_once() {
    // A motor that loses no step by the stop itself, nor by its swinging after it.
    let mut config = Config { motor: MotorData::RIGID, ..machine(ROOM_MM, 8.0) };
    config.settings.hold_input_is_door = true;
    let outcome = {
        let mut sim = powered_up(&config);
        assert_eq!(say(&mut sim, "$HX"), ["ok"]);
        sim.outcome()
    };
    let homing: Vec<_> = outcome.moves.iter().filter(|record| record.homing).collect();
    let from_ns = homing[0].end_ns - 60_000_000;
    let to_ns = homing[2].begin_ns() + 20_000_000;
    type Stop = (fn(&mut Sim), Alarm);
    let stops: [Stop; 3] = [
        (|sim| sim.send(b"\x18"), Alarm::HomingReset),
        (|sim| sim.send(&[0x84]), Alarm::HomingDoor),
        (|sim| sim.set_emergency_stop(true), Alarm::EmergencyStop),
    ];
    let mut braking = 0;
    for (stop, alarm) in stops {
        for at_us in (from_ns / 1_000..to_ns / 1_000).step_by(997 * stride(3)) {
            let mut sim = powered_up(&config);
            sim.send(b"$HX\n");
            sim.run_to(at_us * 1_000).unwrap();
            braking += u32::from(at_us * 1_000 < homing[0].end_ns && sim.places_steps()[0] < 0);
            stop(&mut sim);
            sim.run_for(Duration::from_millis(1)).unwrap();
            let stopped = sim.counted_steps();
            sim.run_until_idle().unwrap();
            assert_eq!(sim.machine().state(), State::Alarm(alarm), "at {at_us} us");
            assert_eq!(sim.counted_steps(), stopped, "at {at_us} us: it went on");
            assert_eq!(sim.machine().position_steps(), stopped, "at {at_us} us");
            sim.set_emergency_stop(false);
            sim.run_for(Duration::from_millis(50)).unwrap();
            sim.replies();
            let heard = say(&mut sim, "$HX");
            assert_eq!(heard.last_line(), "ok", "at {at_us} us: {heard:?}");
            assert_eq!(sim.places_steps()[0], PULL_OFF_STEPS, "at {at_us} us");
        }
    }
    assert!(braking > 10, "{braking}");
}

/// A seek was stopped there, and nobody knows how far behind the switch that is.
#[test]
fn an_axis_that_stands_anywhere_in_the_room_homes() {
    for beyond_mm in [0.01, 1.0, 2.0, 2.5] {
        let mut sim = switched_on(&machine(ROOM_MM, -beyond_mm));
        sim.replies();
        assert_eq!(say(&mut sim, "$HX"), ["ok"], "{beyond_mm} mm behind");
        assert_eq!(sim.places_steps()[0], PULL_OFF_STEPS, "{beyond_mm} mm behind");
        assert_eq!(sim.outcome().losses, [], "{beyond_mm} mm behind");
    }
    // Farther than five times the pull-off, by which a latch is bounded without room.
    let mut config = machine(40.0, -0.01);
    config.settings.homing_latch_mm_min = 1_000.0;
    let mut sim = switched_on(&config);
    sim.replies();
    assert_eq!(say(&mut sim, "$HX"), ["ok"]);
    assert_eq!(sim.places_steps()[0], PULL_OFF_STEPS);
}

/// One motor of two would be measured where it stands, and not at its switch.
#[test]
fn an_axis_with_two_motors_stops_at_its_switch_at_once() {
    let mut config = machine(ROOM_MM, 20.0);
    (config.settings.second_motor_axis, config.settings.homing_seek_mm_min) = (1, 300.0);
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$HX"), ["ok"]);
    let outcome = sim.outcome();
    assert_eq!(seek(&outcome).finish, Finish::Stopped);
    assert!(beyond_mm(&config, seek(&outcome)) <= 1.0 / STEPS_PER_MM);
}

/// What the console takes the machine takes, and what the one refuses the other does.
#[test]
fn console_and_machine_agree_on_the_room_that_a_seek_needs() {
    let carries = |_| f32::INFINITY;
    for (room_mm, accel_mm_s2, decel_mm_s2) in [(0.5, 50.0, 0.0), (3.0, 1_000.0, 0.0), (1.0, 500.0, 80.0)] {
        let mut settings = machine(room_mm, 5.0).settings;
        (settings.accel_mm_s2, settings.decel_or_0_mm_s2) = ([accel_mm_s2; AXES], [decel_mm_s2; AXES]);
        settings.homing_seek_mm_min = 6_000.0;
        let refused = settings.check(&carries).unwrap_err().to_string();
        let (before, _) = refused.split_once(" mm/min from which X brakes").expect(&refused);
        let most_mm_min: f32 = before.rsplit(' ').next().unwrap().parse().unwrap();
        for (seek_mm_min, is_taken) in [(most_mm_min, true), (most_mm_min + 1.0, false)] {
            settings.homing_seek_mm_min = seek_mm_min;
            assert_eq!(settings.check(&carries).is_ok(), is_taken, "{seek_mm_min}");
            let config = isostep_controller::config(&settings);
            assert_eq!(config.check([None; AXES]).is_ok(), is_taken, "{seek_mm_min}: {:?}", config.check([None; AXES]));
        }
        // An axis that is no faster than that brakes however fast the seek is to be.
        (settings.homing_seek_mm_min, settings.max_rate_mm_min) = (6_000.0, [most_mm_min; AXES]);
        assert_eq!(settings.check(&carries), Ok(()));
    }
}

/// Steps by `TimerPort` leave at other instants.
#[test]
fn the_seek_brakes_with_any_port() {
    for port in Port::ALL {
        let mut sim = powered_up(&Config { port, ..machine(ROOM_MM, 30.0) });
        assert_eq!(say(&mut sim, "$HX"), ["ok"], "{port:?}");
        let outcome = sim.outcome();
        assert_eq!((outcome.losses.len(), outcome.places_steps[0]), (0, PULL_OFF_STEPS), "{port:?}");
    }
}
