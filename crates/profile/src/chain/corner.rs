//! How fast a corner may be taken.

use super::config::{ChainConfig, SQUARE_MAX, Square};
use crate::root::sqrt;

/// Directions count as the same if the square of half their difference is below this, which allows for rounding only.
const SAME: f64 = 1e-24;
/// Directions count as opposite if that square is nearer to 1 than this: a cosine of -0.999999, as in Grbl.
const OPPOSITE: f64 = 5e-7;

/// The squared speed at a corner by Grbl's rule. On a circle that deviates from the corner by the configured distance,
/// this speed needs the acceleration that the axes have across the corner. `None` if the machine has to stop there.
///
/// v² = a deviation s/(1 - s), where s is the sine of half the angle between the reversed direction before the corner
/// and the direction after it. Let q = 1 - s², which is the square of half the difference of both directions. Then
/// s/(1 - s) is s (1 + s)/q, which does not cancel. The acceleration a is the smallest of what the axes may do, each
/// divided by its component of the difference's direction.
pub(super) fn square<const N: usize>([before, after]: [&[f64; N]; 2], config: &ChainConfig<N>) -> Option<Square> {
    let mut difference = [0.0; N];
    let mut four_squares = 0.0;
    for axis in (0..N).filter(|&axis| before[axis] != after[axis]) {
        let own = after[axis] - before[axis];
        difference[axis] = own;
        four_squares += own * own;
    }
    let square = four_squares * 0.25;
    if square < SAME {
        return Some(SQUARE_MAX as Square);
    }
    let sine_square = 1.0 - square;
    if sine_square < OPPOSITE || config.twice_deviation_mm == 0.0 {
        return None;
    }
    let (sine, half) = (sqrt(sine_square) as f32, sqrt(square) as f32);
    // The inverse of the acceleration that the axes have across the corner.
    let mut across_s2_mm = 0.0;
    for (s2_mm, own) in config.corner_s2_mm.iter().zip(difference).filter(|(_, own)| *own != 0.0) {
        let own_s2_mm = s2_mm * own.abs() as f32;
        if own_s2_mm > across_s2_mm {
            across_s2_mm = own_s2_mm;
        }
    }
    // Dividing by `half` stands for half/square. 24 bits are enough, because the result is only a bound.
    let mm2_s2 = config.twice_deviation_mm * sine * (1.0 + sine) / (across_s2_mm * half);
    Some(config.scale.square(f64::from(mm2_s2)))
}
