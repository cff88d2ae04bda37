//! The length of a straight path, using only arithmetic that `core` has.

/// Halves the exponent of a float in its bits, and yields a mantissa whose error is at most 3.5 %.
const HALF_BIAS: u32 = 0x1FBD_1DF5;

/// Picometres in mm.
const MM: f32 = 1e-9;

/// The length of a vector in picometres, in mm. A degree counts as a millimetre. The relative error is a few parts in
/// ten million.
pub(crate) fn length_mm<const N: usize>(vector_pm: [i64; N]) -> f32 {
    square_root(vector_pm.map(|pm| pm as f32 * MM).iter().map(|mm| mm * mm).sum())
}

/// The square root of a normal number or 0.
fn square_root(square: f32) -> f32 {
    if square < f32::MIN_POSITIVE {
        return 0.0;
    }
    // Each step of Newton's method squares the relative error: 3.5e-2, 6e-4, 2e-7.
    let rough = f32::from_bits((square.to_bits() >> 1) + HALF_BIAS);
    (0..3).fold(rough, |root, _| 0.5 * (root + square / root))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn known_lengths() {
        assert_eq!(length_mm([3_000_000_000, 0, -4_000_000_000]), 5.0);
        assert_eq!(length_mm([0; 3]), 0.0);
        assert_eq!(length_mm([0, -250_000_000, 0]), 0.25);
    }

    proptest! {
        #[test]
        fn is_the_root_of_the_squares(vector in prop::array::uniform3(-20_000f64..20_000.0)) {
            let expected = vector.iter().map(|part| part.powi(2)).sum::<f64>().sqrt();
            let length = f64::from(length_mm(vector.map(crate::length::from_mm)));
            prop_assert!((length - expected).abs() <= 4e-7 * expected);
        }
    }
}
