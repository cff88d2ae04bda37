//! Moves that come while others are made: none is faster than it can brake from, nor slower than it has to be.

use isostep_trials::cases;

use proptest::prelude::*;

use super::case::{case, curved, trapezoid};
use super::drive::{drive, pushes};

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(500, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_trapezoid_keeps_to_what_it_knows(case in case(trapezoid(), 30), events in pushes(), is_small in any::<bool>()) {
        if is_small { drive::<8>(&case, &events)? } else { drive::<64>(&case, &events)? }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(200, 2_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_curved_speed_profile_keeps_to_what_it_knows(case in case(curved(), 30), events in pushes(), is_small in any::<bool>()) {
        if is_small { drive::<8>(&case, &events)? } else { drive::<64>(&case, &events)? }
    }
}
