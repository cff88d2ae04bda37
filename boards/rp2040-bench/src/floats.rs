//! Operations on `f64`, which the chip's ROM carries out, on numbers that bring out where it could go wrong.

use crate::Checksum;

/// Number of pairs of numbers that each operation is tried on.
pub const FLOAT_PAIRS: u32 = 2_000;

/// An operation, or some that belong together.
#[derive(Clone, Copy, Debug)]
pub struct FloatCase {
    /// The name in the firmware's output lines.
    pub name: &'static str,
    /// The number of operations, for two numbers.
    pub operations: u32,
    /// Carries them out. The result depends on every bit of their results.
    pub work: fn((f64, f64)) -> u64,
}

/// All that planning uses.
pub const FLOAT_CASES: [FloatCase; 8] = [
    FloatCase { name: "add", operations: 1, work: |(a, b)| (a + b).to_bits() },
    FloatCase { name: "subtract", operations: 1, work: |(a, b)| (a - b).to_bits() },
    FloatCase { name: "multiply", operations: 1, work: |(a, b)| (a * b).to_bits() },
    FloatCase { name: "divide", operations: 1, work: |(a, b)| (a / if b == 0.0 { 1.0 } else { b }).to_bits() },
    FloatCase { name: "order", operations: 4, work: order },
    FloatCase { name: "equal", operations: 1, work: |(a, b)| u64::from(a == b) },
    FloatCase { name: "to-single", operations: 2, work: |(a, _)| f64::from(a as f32).to_bits() },
    FloatCase { name: "to-whole", operations: 2, work: |(a, _)| ((a.abs() as u64) as f64).to_bits() },
];

/// Index of the division in [`FLOAT_CASES`].
pub const FLOAT_DIVIDE: usize = 3;
/// The name in the firmware's output lines of the division that finds the chip's divider in use.
pub const FLOAT_AMONG_DIVISION: &str = "float.divide.among-division";

fn order((a, b): (f64, f64)) -> u64 {
    [a < b, a <= b, a > b, a >= b].into_iter().fold(0, |bits, is| bits << 1 | u64::from(is))
}

/// Pairs of numbers: of any sign, zeros of both signs among them, from 2^-60 to 2^60, and often alike.
pub fn float_pairs() -> impl Iterator<Item = (f64, f64)> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    (0..FLOAT_PAIRS).map(move |index| {
        let (a, b, choice) = (number(random()), number(random()), random());
        let b = match index % 8 {
            0 => a,
            1 => -a,
            2 => f64::from_bits(a.to_bits() ^ 1),
            3 if choice & 1 == 0 => 0.0,
            3 => -0.0,
            _ => b,
        };
        let a = if index % 16 == 3 { 0.0 } else { a };
        if choice & 2 == 0 { (a, b) } else { (b, a) }
    })
}

/// A number from random bits.
fn number(random: u64) -> f64 {
    let exponent = 1_023 - 60 + (random >> 52) % 121;
    let mantissa = if random & 0b111 == 0 { 0 } else { random & 0xF_FFFF_FFFF_FFFF };
    f64::from_bits((random & 1 << 51) << 12 | exponent << 52 | mantissa)
}

/// A checksum of the results of `case`. `time` carries out the work on a pair.
pub fn floats(case: &FloatCase, mut time: impl FnMut((f64, f64), fn((f64, f64)) -> u64) -> u64) -> Checksum {
    let mut checksum = Checksum::default();
    for pair in float_pairs() {
        let result = time(pair, case.work);
        checksum.add(result as u32);
        checksum.add((result >> 32) as u32);
    }
    checksum
}
