//! The length of a straight path, using only arithmetic that `core` has.

/// Halves the exponent of a float in its bits, and yields a mantissa whose error is at most 3.5 %.
const HALF_BIAS: u32 = 0x1FBD_1DF5;

/// The length of a vector. The relative error is a few parts in ten million.
pub(crate) fn length(vector: [f32; 3]) -> f32 {
    square_root(vector.iter().map(|part| part * part).sum())
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
        assert_eq!(length([3.0, 0.0, -4.0]), 5.0);
        assert_eq!(length([0.0; 3]), 0.0);
        assert_eq!(length([0.0, -0.25, 0.0]), 0.25);
    }

    proptest! {
        #[test]
        fn is_the_root_of_the_squares(vector in prop::array::uniform3(-20_000f32..20_000.0)) {
            let expected = vector.iter().map(|&part| f64::from(part).powi(2)).sum::<f64>().sqrt();
            prop_assert!((f64::from(length(vector)) - expected).abs() <= 3e-7 * expected);
        }
    }
}
