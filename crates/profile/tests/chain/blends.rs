//! Random chains whose corners are blends.

use isostep_trials::cases;
use proptest::prelude::*;

use crate::bent::drive;
use crate::case::{Case, case, trapezoid};
use crate::drive::{holds, overrides, pushes};

/// Moves at whose corners the path may leave by some hundredths of a millimetre, or not at all.
pub fn bent(most: usize) -> impl Strategy<Value = Case> {
    let deviation = prop_oneof![1 => Just(0.0f32), 4 => (1e-3f32.ln()..0.3f32.ln()).prop_map(f32::exp)];
    let jumps = prop::bool::weighted(0.1);
    let blend_s = prop_oneof![1 => Just(0.0), 1 => (1e-4f64.ln()..3e-2f64.ln()).prop_map(f64::exp)];
    let offset = || prop_oneof![1 => Just(0), 2 => -64..=64i8];
    let beside = prop::collection::vec((deviation, [offset(), offset(), offset()]), most);
    (case(trapezoid(), most), beside, jumps, blend_s).prop_map(|(mut case, beside, jumps, blend_s)| {
        case.effort.blend_s = blend_s;
        if !jumps {
            case.limits.iter_mut().for_each(|limits| limits.start_speed_steps_s = 0.0);
        }
        for (one, (deviation_mm, offsets)) in case.moves.iter_mut().zip(beside) {
            (one.deviation_mm, one.offsets) = (deviation_mm, offsets);
        }
        case
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(1_000, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn pushes_are_bent(case in bent(40), events in pushes()) {
        drive::<8>(&case, &events)?;
    }

    #[test]
    fn holds_are_bent(case in bent(40), events in holds()) {
        drive::<8>(&case, &events)?;
    }

    #[test]
    fn overrides_are_bent(case in bent(40), events in overrides()) {
        drive::<8>(&case, &events)?;
    }
}
