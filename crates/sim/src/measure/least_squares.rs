//! Linear least squares with few unknowns.

/// Number of unknowns that are fitted.
pub(super) const UNKNOWNS: usize = 4;

/// The weights with which the points add up to each unknown: (JᵀJ)⁻¹ Jᵀ for the rows J. `None` if the points do not
/// determine the unknowns.
pub(super) fn weights(rows: &[[f64; UNKNOWNS]]) -> Option<[Vec<f64>; UNKNOWNS]> {
    let inverse = inverse(normal(rows))?;
    Some(inverse.map(|of_unknown| {
        rows.iter().map(|row| row.iter().zip(of_unknown).map(|(slope, factor)| slope * factor).sum()).collect()
    }))
}

type Square = [[f64; UNKNOWNS]; UNKNOWNS];

/// The matrix JᵀJ.
fn normal(rows: &[[f64; UNKNOWNS]]) -> Square {
    let mut sums = Square::default();
    for row in rows {
        for (sums, slope) in sums.iter_mut().zip(row) {
            sums.iter_mut().zip(row).for_each(|(sum, other)| *sum += slope * other);
        }
    }
    sums
}

/// Inverts by Gauss-Jordan elimination. The matrix is symmetric and positive definite, so no pivoting is needed.
fn inverse(mut left: Square) -> Option<Square> {
    let mut right = Square::default();
    (0..UNKNOWNS).for_each(|index| right[index][index] = 1.0);
    for pivot in 0..UNKNOWNS {
        let scale = 1.0 / left[pivot][pivot];
        if !(scale.is_finite() && scale > 0.0) {
            return None;
        }
        for square in [&mut left, &mut right] {
            square[pivot] = square[pivot].map(|value| value * scale);
        }
        for row in (0..UNKNOWNS).filter(|&row| row != pivot) {
            let factor = left[row][pivot];
            for square in [&mut left, &mut right] {
                let scaled = square[pivot];
                square[row].iter_mut().zip(scaled).for_each(|(value, scaled)| *value -= factor * scaled);
            }
        }
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic through points that lie on one: y = 3 - x + 0.5 x³.
    #[test]
    fn a_cubic_is_found_again() {
        let xs = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
        let rows = xs.map(|x: f64| [1.0, x, x.powi(2), x.powi(3)]);
        let ys = xs.map(|x: f64| 3.0 - x + 0.5 * x.powi(3));
        let found = weights(&rows).unwrap().map(|weights| weights.iter().zip(ys).map(|(w, y)| w * y).sum::<f64>());
        for (found, expected) in found.into_iter().zip([3.0, -1.0, 0.0, 0.5]) {
            assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
        }
    }

    #[test]
    fn points_that_tell_nothing_apart_have_no_weights() {
        assert!(weights(&[[0.0; UNKNOWNS]; 9]).is_none());
    }
}
