//! How fast a corner may be taken.

use super::config::{ChainConfig, SQUARE_MAX, Square};
use crate::root::sqrt;

/// Directions are the same if the square of half their difference is less: rounding, and no more.
const SAME: f64 = 1e-24;
/// They are opposite if it is nearer to 1: a cosine of -0.999999, as Grbl has it.
const OPPOSITE: f64 = 5e-7;

/// Grbl's rule: the speed at which a circle that deviates from the corner by the deviation asks for the acceleration
/// that the axes have across the corner, squared. `None` if it has to stop there.
///
/// v² = a deviation s/(1 - s), s being the sine of half the angle between the way in, reversed, and the way out. With q
/// = 1 - s², the square of half the difference of both directions, s/(1 - s) is s (1 + s)/q, which does not cancel; and
/// a is the least of what an axis may do, by its share of the difference.
pub(super) fn square<const N: usize>(before: &[f64; N], after: &[f64; N], config: &ChainConfig<N>) -> Option<Square> {
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
    // The inverse of what the axes have across the corner.
    let mut across_s2_mm = 0.0;
    for (s2_mm, own) in config.corner_s2_mm.iter().zip(difference).filter(|(_, own)| *own != 0.0) {
        let own_s2_mm = s2_mm * own.abs() as f32;
        if own_s2_mm > across_s2_mm {
            across_s2_mm = own_s2_mm;
        }
    }
    // half/square, by the product of two roots. What is only a bound may be rounded to 24 bits.
    let mm2_s2 = config.twice_deviation_mm * sine * (1.0 + sine) / (across_s2_mm * half);
    Some(config.scale.square(f64::from(mm2_s2)))
}
