//! Edges: each at its instant, in its direction, as long as was asked for.

use embassy_time::Instant;
use isostep_motion::{AXES, Axis, ConfigError, GangedMotor, Motor, Motors, SecondMotor, StepCounter, Wiring};
use isostep_profile::{ACCEL_MAX_STEPS_S2, Limits};
use isostep_sim::world::Wire;
use isostep_sim::{Config, Sim};

use crate::plan::{LIMITS, Plan};
use crate::rig::{Ports, Rig, WIRED, carry_out, edges, rises};

/// Every edge is where the closed form has it, in several runs, one after the other.
pub fn every_step_leaves_at_its_instant_there_and_back(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let moves = [(1, 500), (101, -501), (201, 1), (211, -1), (221, 2)];
        let moves = moves.map(|(at_ms, steps)| (Instant::from_millis(at_ms), Plan::new(steps)));
        let (world, position_steps) = rig.makes(moves.to_vec(), WIRED);
        assert_eq!(position_steps, 1);
        rig.assert_plans(&edges(&world), &moves);
    }
}

/// DIR is low for the positive direction if the wiring says so.
pub fn directions_can_be_inverted(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let wiring = Wiring { direction_inverted: true, ..Wiring::default() };
        let works = vec![(Instant::from_millis(1), Plan::new(5))];
        let (world, position_steps) = rig.makes(works, Motors { wiring, ..WIRED });
        assert_eq!((position_steps, world.borrow().counted_steps()[0]), (5, -5), "{rig}");
    }
}

/// Three runs: of both motors, of the second alone, of the first alone, back. The count is that of the axis's steps.
pub fn a_motor_that_is_held_makes_no_step_and_the_other_makes_all(ports: impl Ports) {
    if !ports.take_second_motors() {
        return;
    }
    for (rig, direction_inverted) in Rig::all(ports).flat_map(|rig| [(rig, false), (rig, true)]) {
        let runs =
            [(1, 40, None), (51, 30, Some(GangedMotor::First)), (101, -20, Some(GangedMotor::Second)), (151, 10, None)];
        let world = rig.run(|mut port, _| async move {
            let step_counter = StepCounter::new();
            for (at_ms, steps, held) in runs {
                let motors = Motors { second: Some(SecondMotor { direction_inverted, held }), ..WIRED };
                let at = (Instant::from_millis(at_ms), motors);
                carry_out(&mut port, Plan::new(steps), at, &step_counter).await.unwrap();
            }
            assert_eq!(step_counter.position_steps(), 60);
        });
        let plans = runs.map(|(at_ms, steps, _)| (Instant::from_millis(at_ms), Plan::new(steps)));
        if !direction_inverted {
            rig.assert_plans(&edges(&world), &plans);
        }
        let [first, second] = [Motor::first(Axis::X), Motor::second(Axis::X)].map(|motor| rises(&world, motor));
        assert_eq!((first.len(), second.len()), (40 + 20 + 10, 40 + 30 + 10), "{rig}");
        assert_eq!((&first[..40], &first[60..]), (&second[..40], &second[70..]), "{rig}: at the same instants");
        let second_steps = if direction_inverted { -80 } else { 80 };
        let skewed_steps = world.borrow().second_place_steps().unwrap() - world.borrow().places_steps()[0];
        assert_eq!(skewed_steps, second_steps - 30, "{rig}");
    }
}

/// STEP stays high as long as the driver needs, or longer if the wiring asks for it.
pub fn pulses_are_as_wide_as_the_driver_or_the_wiring_asks(ports: impl Ports) {
    for rig in Rig::all(ports) {
        for asked_ns in [0, 2_000, 10_000] {
            let wiring = Wiring { pulse_ns: asked_ns, ..Wiring::default() };
            let works = vec![(Instant::from_millis(1), Plan::new(3))];
            let (world, _) = rig.makes(works, Motors { wiring, ..WIRED });
            let world = world.borrow();
            let step = world.record().waves.iter().filter(|wave| wave.wire == Wire::Step(Axis::X.into()));
            let pulses: Vec<_> = step.skip_while(|wave| !wave.high).collect();
            let widths_ns: Vec<_> = pulses.chunks(2).map(|pulse| pulse[1].t_ns - pulse[0].t_ns).collect();
            assert_eq!(widths_ns, [u64::from(asked_ns.max(rig.driver.step_high_ns)); 3], "{rig}");
        }
    }
}

/// The highest rate of its capabilities is made, and a configuration above it is refused.
pub fn the_highest_rate_it_claims_works_from_rest_and_the_next_is_refused(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let capabilities = rig.capabilities();
        let rate = f64::from(capabilities.rate_max_steps_s(Wiring::default()));
        // The ramp has at least 500 steps.
        let accel = (rate * rate / 1_000.0).min(ACCEL_MAX_STEPS_S2);
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: rate,
            accel_steps_s2: accel,
            decel_steps_s2: accel,
            jerk_steps_s3: f64::INFINITY,
        };
        let moves = [2_000, -2_001].map(|steps| Plan::within(steps, limits));
        let moves = [1, 101].map(Instant::from_millis).into_iter().zip(moves).collect::<Vec<_>>();
        let (world, _) = rig.makes(moves.clone(), WIRED);
        rig.assert_plans(&edges(&world), &moves);

        let mut config = Sim::new(&Config::default()).machine().config();
        config.wiring = [Wiring::default(); AXES];
        config.limits = [limits; AXES];
        assert_eq!(config.check([Some(capabilities); AXES]), Ok(()), "{rig}");
        config.limits[1].top_speed_steps_s = rate + 1.0;
        let refused = config.check([Some(capabilities); AXES]);
        assert!(
            matches!(refused, Err(ConfigError::Rate { axis: Axis::Y, max, .. }) if max == rate),
            "{rig}: {refused:?}"
        );
    }
}

/// Three steps in three hours. An hour is 4.5e11 ticks of 8 ns, far beyond 32 bits.
pub fn steps_may_be_an_hour_apart(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let limits = Limits { top_speed_steps_s: 1.0, accel_steps_s2: 1.0, decel_steps_s2: 1.0, ..LIMITS };
        let moves = [(Instant::from_millis(1), Plan::beside(10_800, 3, limits))];
        let (world, _) = rig.makes(moves.to_vec(), WIRED);
        rig.assert_plans(&edges(&world), &moves);
    }
}
