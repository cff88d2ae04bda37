//! `whole_steps` must round like the standard library, but takes what two roundings have left below a half for a half.

use isostep_motion::{beside_steps, whole_steps};
use proptest::prelude::*;

#[test]
fn halves_go_away_from_zero_and_the_rest_to_the_nearest() {
    let rows = [
        (0.5, 1),
        (-0.5, -1),
        (0.499_999_999_999_999_94, 1),
        (0.499_999_999_999_999, 0),
        (-0.0, 0),
        (1.5, 2),
        (-2.499, -2),
        (1e300, i32::MAX),
    ];
    for (value, expected) in rows {
        assert_eq!(whole_steps(value, 1.0), expected, "{value}");
    }
    assert_eq!(whole_steps(f64::NAN, 1.0), 0);
}

/// `value`, as far from zero as a product of decimals may have been before it was rounded.
fn unrounded(value: f64) -> f64 {
    f64::from_bits(value.to_bits().wrapping_add(4))
}

proptest! {
    #[test]
    fn decimals_that_make_a_half_are_one(
        steps in 0i64..2_000_000,
        steps_per_mm in prop::sample::select(&[2.5, 12.5, 25.0, 40.0, 50.0, 80.0, 160.0, 200.0, 320.0, 400.0, 800.0][..]),
    ) {
        let place_pm = ((2 * steps + 1) as f64 * 5e8 / steps_per_mm).round();
        prop_assert_eq!(place_pm * steps_per_mm, (2 * steps + 1) as f64 * 5e8, "a whole number of picometres");
        prop_assert_eq!(whole_steps(place_pm, steps_per_mm / 1e9), steps as i32 + 1);
        prop_assert_eq!(whole_steps(place_pm / 1e9, steps_per_mm), steps as i32 + 1);
    }

    #[test]
    fn a_place_is_what_rounding_makes_of_it(mm in -20_000f32..20_000.0, steps_per_mm in 0.1f32..1e4) {
        let (mm, steps_per_mm) = (mm.into(), steps_per_mm.into());
        prop_assert_eq!(whole_steps(mm, steps_per_mm), unrounded(mm * steps_per_mm).round() as i32);
    }

    #[test]
    fn what_is_beside_whole_steps_is_the_rest_to_half_a_part(mm in -20_000f32..20_000.0, steps_per_mm in 1e-3f32..1e4) {
        let (mm, steps_per_mm) = (mm.into(), steps_per_mm.into());
        let rest_parts = (mm * steps_per_mm - f64::from(whole_steps(mm, steps_per_mm))) * 128.0;
        let beside = f64::from(beside_steps(mm, steps_per_mm));
        prop_assert!((beside - rest_parts).abs() < 0.5 + 1e-4, "{beside} for {rest_parts} of {} steps", mm * steps_per_mm);
    }

    #[test]
    fn so_is_any_number(bits: u64, quarters in -5_000_000_000i64..5_000_000_000) {
        for value in [f64::from_bits(bits), quarters as f64 / 4.0] {
            let expected = if value.is_finite() { unrounded(value) } else { value };
            prop_assert_eq!(whole_steps(value, 1.0), expected.round() as i32, "{}", value);
        }
    }
}
