//! Reversals: moves there and back in one run.

use embassy_time::Instant;
use isostep_motion::{StepCounter, Wiring};
use oorandom::Rand32;

use crate::plan::{Chain, SEED};
use crate::rig::{Ports, Rig, carry_out_all, edges};

/// A hundred moves at random speeds, in random directions, follow each other in one run.
pub fn moves_there_and_back_in_one_run_are_exact(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let mut random = Rand32::new(SEED);
        for steps in [1, 2, 16, 100] {
            let chain = Chain::random(&mut random, &rig.capabilities(), steps);
            let (start, items, net) = (Instant::from_millis(1), chain.items(), chain.steps());
            let world = rig.run(|mut port, _| async move {
                let step_counter = StepCounter::new();
                carry_out_all(&mut port, items, (start, Wiring::default()), &step_counter).await.unwrap();
                assert_eq!(step_counter.position_steps(), net, "{rig}, SEED={SEED}");
            });
            rig.assert_edges(&edges(&world), chain.instants_ns(start));
        }
    }
}

/// Steps as close as the port accepts in one direction.
pub fn steps_to_and_fro_may_be_as_close_as_others(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let capabilities = rig.capabilities();
        for pulse_ns in [0, 3_000] {
            let wiring = Wiring { pulse_ns, ..Wiring::default() };
            let chain = Chain::to_and_fro(capabilities.tick_hz, 1_001, capabilities.period_min_ticks(wiring));
            let (start, items) = (Instant::from_millis(1), chain.items());
            let world = rig.run(|mut port, _| async move {
                let step_counter = StepCounter::new();
                carry_out_all(&mut port, items, (start, wiring), &step_counter).await.unwrap();
                assert_eq!(step_counter.position_steps(), 1, "{rig}");
            });
            rig.assert_edges(&edges(&world), chain.instants_ns(start));
        }
    }
}
