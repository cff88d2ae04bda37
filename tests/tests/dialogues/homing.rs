//! Homing towards either end of an axis, what positions mean afterwards, and what makes them invalid.

use embassy_time::Duration;
use isostep_motion::{AXES, Alarm, Axis, ConfigError, Event, HomingPhase, Motor, State};
use isostep_sim::world::Edge;
use isostep_sim::{Config, Flash, Sim, SwitchFault};

use crate::talk::{powered_up, refused, say, status, switched_on};

/// A homed machine. The axes in this mask have their switches at the negative end.
fn homed_towards(negative: u16) -> Sim {
    let mut config = Config::default();
    config.settings.homing_direction_mask = negative;
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$H"), ["ok"], "$23={negative}");
    sim
}

/// The travel of an axis away from its switch, mm: positive if the switch is at the negative end.
fn travel_mm(negative: u16, axis: usize) -> f64 {
    let travel_mm = f64::from(Config::default().settings.travel_mm[axis]);
    if negative & (1 << axis) == 0 { -travel_mm } else { travel_mm }
}

/// Each axis homes to either end.
#[test]
fn zero_is_the_pull_off_from_the_switch_at_either_end() {
    for negative in 0..8 {
        let sim = homed_towards(negative);
        let now = sim.machine().status();
        assert_eq!((now.position_steps, now.homed), ([0; AXES], [true; AXES]), "$23={negative}");
        // 2 mm, minus the distance made during the debounce of the switch.
        let places = sim.places_steps();
        assert!(places.iter().all(|place| (99..=100).contains(place)), "$23={negative}: {places:?} from the switches");
    }
}

/// The switch opens 50 ms before the end of the pull-off, and its debounce takes 250 ms. Homing must wait for that.
#[test]
fn a_switch_that_opens_late_on_the_way_back_is_not_stuck() {
    let mut config = Config::default();
    config.settings.homing_debounce_ms = 250;
    (config.settings.homing_seek_mm_min, config.settings.homing_latch_mm_min) = (60.0, 60.0);
    config.settings.homing_pull_off_mm = 0.3;
    config.start_mm = [1.0; AXES];
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
}

/// `$24`, `$25`, `$26` and `$27` as Grbl has them.
#[test]
fn grbl_s_own_defaults_home() {
    for negative in [0, 7] {
        let mut config = Config::default();
        config.settings.homing_direction_mask = negative;
        let mut sim = powered_up(&config);
        for line in ["$24=25", "$25=500", "$26=250", "$27=1"] {
            assert_eq!(say(&mut sim, line), ["ok"]);
        }
        assert_eq!(say(&mut sim, "$H"), ["ok"], "$23={negative}");
        assert_eq!(sim.places_steps(), [50; AXES], "$23={negative}: 1 mm from the switches");
    }
}

/// Where the carriage has been nearest to its end: at the place where the switch closes, which is 3 mm before that end.
#[test]
fn the_seek_stops_where_the_switch_closes_however_long_it_is_debounced() {
    for (debounce_ms, bounce_us) in [(5, 0), (250, 0), (250, 4_000), (1_000, 1_000)] {
        let mut config = Config { bounce_us, ..Config::default() };
        (config.settings.homing_debounce_ms, config.settings.homing_seek_mm_min) = (debounce_ms, 1_000.0);
        let mut sim = powered_up(&config);
        assert_eq!(say(&mut sim, "$H"), ["ok"]);
        let outcome = sim.outcome();
        assert!(outcome.losses.is_empty(), "$26={debounce_ms}: {:?}", outcome.losses);
        assert_eq!((outcome.places_steps, outcome.drift_steps), ([100; AXES], [0; AXES]), "$26={debounce_ms}");
        for axis in 0..AXES {
            // Positions count from the zero that is found at the end.
            let edges: Vec<_> = outcome.edges.iter().filter(|edge| edge.axis == axis).collect();
            let mut place_steps = 100;
            let mut nearest_steps = 100;
            for edge in edges.iter().rev() {
                nearest_steps = nearest_steps.min(place_steps);
                place_steps -= edge.direction;
            }
            assert!((-1..=0).contains(&nearest_steps), "$26={debounce_ms}: {nearest_steps} steps from the switch");
        }
    }
}

/// The switch is closed for less than the debounce time, in the seek and in the latch: the axis stops, and goes on.
#[test]
fn a_spike_stops_homing_and_it_goes_on() {
    use HomingPhase::{Latch, Seek};
    let homed_after = |spikes_ms: &[u64], expected: &[HomingPhase]| {
        let mut config = Config { start_mm: [20.0; AXES], ..Config::default() };
        (config.settings.homing_debounce_ms, config.settings.homing_latch_mm_min) = (20, 300.0);
        let mut sim = powered_up(&config);
        sim.send(b"$HX\n");
        let (mut stood, mut phases) = (0, Vec::new());
        for (from_ms, to_ms) in std::iter::once(&0).chain(spikes_ms).zip(spikes_ms) {
            sim.run_for(Duration::from_millis(to_ms - from_ms - 5)).unwrap();
            assert_eq!(sim.machine().state(), State::Home);
            let before = sim.steps()[0];
            sim.run_for(Duration::from_millis(5)).unwrap();
            assert_ne!(sim.steps()[0], before, "{to_ms} ms: it moves");
            sim.set_switch(Motor::first(Axis::X), SwitchFault::StuckClosed);
            sim.run_for(Duration::from_millis(1)).unwrap();
            let still = sim.steps()[0];
            sim.run_for(Duration::from_millis(14)).unwrap();
            sim.set_switch(Motor::first(Axis::X), SwitchFault::None);
            sim.run_for(Duration::from_millis(15)).unwrap();
            stood += u32::from(sim.steps()[0] == still);
            sim.run_for(Duration::from_millis(3)).unwrap();
            phases.extend(sim.outcome().events.iter().rev().find_map(|(_, event)| match event {
                Event::Homing { phase, .. } => Some(*phase),
                _ => None,
            }));
        }
        assert_eq!(phases, expected, "{spikes_ms:?}");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.replies(), ["ok"], "{spikes_ms:?}");
        assert_eq!(stood as usize, spikes_ms.len(), "{spikes_ms:?}");
        let outcome = sim.outcome();
        assert!(outcome.losses.is_empty() && outcome.violations.is_empty(), "{spikes_ms:?}");
        outcome.places_steps[0]
    };
    for (spikes_ms, phases) in [
        (&[][..], &[][..]),
        (&[500], &[Seek]),
        (&[500, 1_000, 1_500], &[Seek; 3]),
        (&[2_700], &[Latch]),
        (&[700, 2_900], &[Seek, Latch]),
    ] {
        assert_eq!(homed_after(spikes_ms, phases), 100, "{spikes_ms:?}");
    }
}

/// So many that the wire must be bad.
#[test]
fn a_hundred_spikes_are_an_alarm() {
    let mut sim = powered_up(&Config { start_mm: [90.0; AXES], ..Config::default() });
    sim.send(b"$HX\n");
    let mut spikes = 0;
    while sim.replies().is_empty() {
        assert!(spikes < 200);
        sim.run_for(Duration::from_millis(20)).unwrap();
        sim.set_switch(Motor::first(Axis::X), SwitchFault::StuckClosed);
        sim.run_for(Duration::from_millis(1)).unwrap();
        sim.set_switch(Motor::first(Axis::X), SwitchFault::None);
        sim.run_for(Duration::from_millis(6)).unwrap();
        spikes += 1;
    }
    assert_eq!(spikes, 100);
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::SwitchNotFound { axis: Axis::X }));
}

/// A contact that never comes to rest ends homing with an alarm.
#[test]
fn a_switch_that_chatters_for_ever_is_an_alarm() {
    let mut sim = powered_up(&Config { start_mm: [20.0; AXES], ..Config::default() });
    sim.suffer("chatter:X@0.5".parse().unwrap());
    sim.send(b"$HX\n");
    sim.run_for(Duration::from_secs(10)).unwrap();
    let heard = sim.replies();
    assert!(heard.contains(&"ALARM:9".to_owned()), "{heard:?}");
}

/// The switch is closed from the start, so no edge reports it.
#[test]
fn a_closed_switch_bars_the_way_onto_it_at_either_end() {
    for negative in [0, 7] {
        let mut config = Config { start_mm: [-0.5, 40.0, 15.0], ..Config::default() };
        (config.settings.homing_direction_mask, config.settings.hard_limits) = (negative, true);
        let mut sim = switched_on(&config);
        let away = travel_mm(negative, 0).signum();
        say(&mut sim, &format!("G91 G0 X{}", -away)).expect("ALARM:1");
        assert_eq!(sim.counted_steps(), [0; AXES], "$23={negative}: onto it");
        say(&mut sim, "$X");
        assert_eq!(say(&mut sim, &format!("G91 G0 X{away}")), ["ok"], "$23={negative}: off it");
    }
}

#[test]
fn the_travel_is_away_from_the_switch_at_either_end() {
    for negative in 0..8 {
        let mut sim = homed_towards(negative);
        let from = sim.places_steps();
        let far: [f64; AXES] = std::array::from_fn(|axis| travel_mm(negative, axis));
        let [x, y, z] = far;
        assert_eq!(say(&mut sim, &format!("G0 X{x} Y{y} Z{z}")), ["ok"], "$23={negative}");
        assert_eq!(status(&mut sim), format!("<Idle|MPos:{x:.3},{y:.3},{z:.3}"));
        let went: [i32; AXES] = std::array::from_fn(|axis| sim.places_steps()[axis] - from[axis]);
        assert_eq!(went, far.map(|mm| (mm.abs() * 50.0) as i32), "$23={negative}: away from the switches");
        for axis in Axis::ALL {
            let mm = far[axis as usize];
            let (low, high) = (mm.min(0.0), mm.max(0.0));
            // One step beyond each end.
            for beyond in [low - 0.02, high + 0.02] {
                let heard = say(&mut sim, &format!("G0 {axis}{beyond:.2}"));
                let words = format!(
                    "[MSG:{axis}{beyond:.3} is outside the travel, {low:.3} to {high:.3} mm: correct the program, then $X]"
                );
                assert!(heard.contains(&words), "$23={negative}: no `{words}` in {heard:?}");
                say(&mut sim, "$X");
            }
        }
        assert_eq!(say(&mut sim, "G0 X0 Y0 Z0"), ["ok"], "$23={negative}");
        let outcome = sim.outcome();
        assert_eq!((outcome.places_steps, outcome.drift_steps), (from, [0; AXES]), "$23={negative}");
    }
}

/// With such a pull-off, the carriage would reach the far end before it had a zero.
#[test]
fn nothing_moves_with_a_pull_off_as_long_as_the_travel() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$130=30"), ["ok"]);
    for pull_off in ["30", "100"] {
        let words = format!(
            "[MSG:$27={pull_off} is not below the travel of X, $130=30 mm: lower $27 or raise $130; until then nothing moves]"
        );
        assert_eq!(say(&mut sim, &format!("$27={pull_off}")), [words.as_str(), "ok"]);
        assert_eq!(say(&mut sim, "$H"), [words.as_str(), "error:2"]);
    }
    assert_eq!(say(&mut sim, "$27=29.9"), ["ok"]);
    for (axis, travel) in [(1, "29.9"), (2, "5")] {
        let setting = 130 + axis;
        let words = format!(
            "[MSG:$27=29.900 is not below the travel of {}, ${setting}={} mm: lower $27 or raise ${setting}; \
             until then nothing moves]",
            Axis::ALL[axis],
            if travel == "5" { "5" } else { "29.900" }
        );
        assert_eq!(say(&mut sim, &format!("${setting}={travel}")), [words.as_str(), "ok"]);
        assert_eq!(say(&mut sim, "$H"), [words.as_str(), "error:2"]);
        assert_eq!(say(&mut sim, &format!("${setting}=100")), ["ok"]);
    }
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    let outcome = sim.outcome();
    assert!(outcome.losses.is_empty(), "{:?}", outcome.losses);
}

/// The settings were stored by another build with other defaults.
#[test]
fn nothing_moves_with_a_stored_pull_off_beyond_the_travel() {
    let flash = Flash::blank();
    let mut sim = Sim::with_flash(&Config::default(), flash.clone());
    assert_eq!(say(&mut sim, "$27=50").last().map(String::as_str), Some("ok"));
    let mut small = Config::default();
    small.settings.travel_mm[1] = 45.0;
    let mut sim = Sim::with_flash(&small, flash);
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    let words =
        "[MSG:$27=50 is not below the travel of Y, $131=45 mm: lower $27 or raise $131; until then nothing moves]";
    assert!(heard.iter().any(|line| line == words), "no `{words}` in {heard:?}");
    assert_eq!(say(&mut sim, "G0 X1"), [words, "error:9"]);
    assert_eq!(say(&mut sim, "$27=2\nG0 X1"), ["ok", "ok"]);
}

/// A configuration is also refused where no console is involved.
#[test]
fn a_configuration_with_a_pull_off_beyond_the_travel_is_refused() {
    let mut config = isostep_controller::config(&Config::default().settings);
    assert_eq!(config.check([None; AXES]), Ok(()));
    config.homing.pull_off_mm = 100.0;
    let refused = config.check([None; AXES]);
    assert_eq!(refused, Err(ConfigError::PullOff { axis: Axis::Z, asked_mm: 100.0, travel_mm: 100.0 }));
    let words = "Z: a homing pull-off of 100 mm is not below the travel of 100 mm: lower it, or raise the travel";
    assert_eq!(refused.unwrap_err().to_string(), words);
}

/// Which axes stay homed after each change, and the axes that the message names.
#[test]
fn a_setting_that_changes_what_a_place_means_takes_the_zero_away() {
    let cases = [
        // DIR is inverted, so directions are reversed.
        ("$3=2", [true, false, true], "Y"),
        ("$3=5", [false, true, false], "X Z"),
        // The switch is at the other end, so the travel is on the other side of zero.
        ("$23=3", [true, true, false], "Z"),
        // The length of a step changes. The count stays, so it means another place.
        ("$100=80", [false, true, true], "X"),
        ("$102=49.9", [true, true, false], "Z"),
        ("$RST=$", [true; AXES], ""),
        // The zero stays valid: these change only the travel, or how the zero was or will be found.
        ("$130=300", [true; AXES], ""),
        ("$27=3", [true; AXES], ""),
        ("$901=123", [true; AXES], ""),
        ("$5=1", [true; AXES], ""),
        ("$110=2000", [true; AXES], ""),
        // The value is unchanged.
        ("$3=0", [true; AXES], ""),
        ("$100=50", [true; AXES], ""),
    ];
    for (line, homed, axes) in cases {
        let mut sim = homed_towards(7);
        assert_eq!(say(&mut sim, "G0 X10 Y10 Z10"), ["ok"]);
        let heard = say(&mut sim, line);
        assert_eq!(sim.machine().homed(), homed, "{line}: {heard:?}");
        let words = format!("[MSG:what the position of {axes} means has changed: home again with $H]");
        assert_eq!(heard.contains(&words), !axes.is_empty(), "{line}: {heard:?}");
        assert!(heard.contains(&"ok".to_owned()), "{line}: {heard:?}");
    }
}

/// The machine was homed with other settings, and then goes back to the defaults.
#[test]
fn restored_settings_take_the_zero_of_what_they_change_away() {
    let mut config = Config::default();
    config.settings.steps_per_mm[0] = 80.0;
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    let heard = say(&mut sim, "$RST=$");
    assert_eq!(sim.machine().homed(), [false, true, true], "{heard:?}");
}

/// Soft limits must not apply relative to the old zero, where they would be on the wrong side.
#[test]
fn soft_limits_are_off_until_it_is_homed_anew() {
    let mut sim = homed_towards(7);
    assert_eq!(say(&mut sim, "$3=1").last().map(String::as_str), Some("ok"));
    assert_eq!(say(&mut sim, "G0 X-5"), ["ok"]);
    assert_eq!(say(&mut sim, "$3=0").last().map(String::as_str), Some("ok"));
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    assert!(say(&mut sim, "G0 X-5").contains(&"ALARM:2".to_owned()));
    say(&mut sim, "$X");
    refused(&mut sim, "$J=X-5 F100", 15);
}

/// The highest rate of each phase, from the edges: seek and back-off at `$25`, latch and pull-off at `$24`.
#[test]
fn each_phase_of_homing_has_its_own_speed() {
    let mut config = Config { bounce_us: 0, ..Config::default() };
    (config.settings.homing_seek_mm_min, config.settings.homing_latch_mm_min) = (480.0, 90.0);
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    let outcome = sim.outcome();
    let starts: Vec<_> = outcome
        .events
        .iter()
        .filter_map(|(t_ns, event)| match event {
            Event::Homing { axis, phase } => Some((*t_ns, *axis, *phase)),
            _ => None,
        })
        .collect();
    assert_eq!(starts.len(), 12);
    for (index, &(begin_ns, axis, phase)) in starts.iter().enumerate() {
        let end_ns = starts.get(index + 1).map_or(u64::MAX, |next| next.0);
        let of_phase = |edge: &&Edge| edge.axis == axis as usize && (begin_ns..end_ns).contains(&edge.t_ns);
        let edges: Vec<_> = outcome.edges.iter().filter(of_phase).collect();
        let shortest_ns = edges.windows(2).map(|pair| pair[1].t_ns - pair[0].t_ns).min().unwrap();
        let mm_s = 1e9 / shortest_ns as f64 / 50.0;
        let expected_mm_s = match phase {
            HomingPhase::Seek | HomingPhase::BackOff => 8.0,
            HomingPhase::Latch | HomingPhase::PullOff => 1.5,
        };
        assert!((mm_s / expected_mm_s - 1.0).abs() < 0.01, "{axis} {phase:?}: {mm_s} mm/s, {expected_mm_s} expected");
    }
}
