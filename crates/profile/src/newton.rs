//! Zeros of rising functions, and rough n-th roots to begin a search with.

/// More iterations than any search takes. After so many, only rounding could still improve.
const ITERATIONS_MAX: u32 = 100;

/// The zero of a rising function between `low`, where it is not above 0, and `high`, where it is not below 0.
/// `function` returns value and slope. The search begins at `from`.
///
/// Each iteration is a Newton step. It bisects instead if that step leaves the bracket by more than `tolerance` of the
/// result; if the step leaves it by less, the end of the bracket is as good as the zero. The search ends after a step
/// of at most `tolerance`, as a fraction of the result. If that was a Newton step, the error is within the square of
/// that, as far as floats allow.
pub(crate) fn rising_root(
    (mut low, mut high): (f64, f64),
    from: f64,
    tolerance: f64,
    function: impl Fn(f64) -> (f64, f64),
) -> f64 {
    let mut x = from;
    for _ in 0..ITERATIONS_MAX {
        let (value, slope) = function(x);
        *if value < 0.0 { &mut low } else { &mut high } = x;
        let newton = x - value / slope;
        let slack = tolerance * x;
        let is_near = (low - slack..=high + slack).contains(&newton);
        let next = if is_near { newton.max(low).min(high) } else { (low + high) / 2.0 };
        let step = (next - x).abs();
        x = next;
        if step <= slack {
            break;
        }
    }
    x
}

/// The `n`-th root of `x`, to 6.2 %. It divides the bits of the float, which are nearly its logarithm: they have f in
/// place of log2(1 + f), and 2^f is short of 1 + f by 6.15 % at most.
#[inline(always)]
pub(crate) fn rough_root(x: f64, n: u64) -> f64 {
    f64::from_bits(x.to_bits() / n + ONE_BITS / n * (n - 1))
}

/// The bits of the float 1.
const ONE_BITS: u64 = 0x3ff0_0000_0000_0000;

#[cfg(test)]
mod tests {
    use core::cell::Cell;

    use super::{rising_root, rough_root};

    /// Newton's method doubles the digits, and it ends when they are found.
    #[test]
    fn a_zero_is_found_in_few_iterations() {
        for (wanted, from) in [(0.001, 1.0), (2.0, 1.0), (3.0, 3.0), (9.0, 10.0)] {
            let evaluations = Cell::new(0);
            let zero = rising_root((0.0, 10.0), from, 1e-8, |x| {
                evaluations.set(evaluations.get() + 1);
                (x * x - wanted * wanted, 2.0 * x)
            });
            assert!((zero / wanted - 1.0).abs() < 1e-14, "{zero}, not {wanted}");
            assert!(evaluations.get() <= 16, "{wanted}: {} evaluations", evaluations.get());
        }
    }

    #[test]
    fn rough_roots_are_rough() {
        for n in [3, 8] {
            for i in -300..300 {
                let x = f64::from(i).exp2().powf(1.03);
                let ratio = rough_root(x, n) / x.powf(1.0 / n as f64);
                assert!((0.938..=1.062).contains(&ratio), "the root {n} of {x}: {ratio}");
            }
        }
    }
}
