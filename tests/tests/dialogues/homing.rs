//! Homing towards either end of an axis, what positions mean afterwards, and what makes them invalid.

use embassy_time::Duration;
use isostep_motion::{AXES, Alarm, Axis, ConfigError, Event, HomingPhase, Motor, State};
use isostep_sim::world::Edge;
use isostep_sim::{Config, Sim, SwitchFault};

use crate::talk::{powered_up, say, status};

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

/// The place where the carriage has been nearest to its end: that where the switch closes, which is 3 mm before that end.
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
