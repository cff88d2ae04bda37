//! `whole_steps` must round like the standard library.

use isostep_motion::whole_steps;
use proptest::prelude::*;

#[test]
fn halves_go_away_from_zero_and_the_rest_to_the_nearest() {
    let rows =
        [(0.5, 1), (-0.5, -1), (0.499_999_999_999_999_94, 0), (-0.0, 0), (1.5, 2), (-2.499, -2), (1e300, i32::MAX)];
    for (value, expected) in rows {
        assert_eq!(whole_steps(value, 1.0), expected, "{value}");
    }
    assert_eq!(whole_steps(f64::NAN, 1.0), 0);
}

proptest! {
    #[test]
    fn a_place_is_what_rounding_makes_of_it(mm in -20_000f32..20_000.0, steps_per_mm in 0.1f32..1e4) {
        let (mm, steps_per_mm) = (mm.into(), steps_per_mm.into());
        prop_assert_eq!(whole_steps(mm, steps_per_mm), (mm * steps_per_mm).round() as i32);
    }

    #[test]
    fn so_is_any_number(bits: u64, quarters in -5_000_000_000i64..5_000_000_000) {
        for value in [f64::from_bits(bits), quarters as f64 / 4.0] {
            prop_assert_eq!(whole_steps(value, 1.0), value.round() as i32, "{}", value);
        }
    }
}
