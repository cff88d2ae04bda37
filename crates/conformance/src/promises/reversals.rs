//! Reversals: moves there and back in one run.

use embassy_time::Instant;
use isostep_motion::{Motors, Wiring};
use oorandom::Rand32;

use crate::plan::{Chain, SEED};
use crate::rig::{Ports, Rig, WIRED, edges};

/// A hundred moves at random speeds, in random directions, follow each other in one run.
pub fn moves_there_and_back_in_one_run_are_exact(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let mut random = Rand32::new(SEED);
        for steps in [1, 2, 16, 100] {
            let chain = Chain::random(&mut random, &rig.capabilities(), steps);
            let start = Instant::from_millis(1);
            let (world, position_steps) = rig.makes(vec![(start, chain.items())], WIRED);
            assert_eq!(position_steps, chain.steps(), "{rig}, SEED={SEED}");
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
            let start = Instant::from_millis(1);
            let (world, position_steps) = rig.makes(vec![(start, chain.items())], Motors { wiring, ..WIRED });
            assert_eq!(position_steps, 1, "{rig}");
            rig.assert_edges(&edges(&world), chain.instants_ns(start));
        }
    }
}
