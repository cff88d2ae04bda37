//! Overrides at any time, with holds in between.

use isostep_trials::cases;

use proptest::prelude::*;

use super::case::{case, curved, trapezoid};
use super::drive::{drive, overrides};

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(500, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_trapezoid_takes_on_other_speeds(case in case(trapezoid(), 30), events in overrides(), is_small in any::<bool>()) {
        if is_small { drive::<8>(&case, &events)? } else { drive::<64>(&case, &events)? }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(200, 2_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_curved_speed_profile_takes_on_other_speeds(case in case(curved(), 30), events in overrides(), is_small in any::<bool>()) {
        if is_small { drive::<8>(&case, &events)? } else { drive::<64>(&case, &events)? }
    }
}
