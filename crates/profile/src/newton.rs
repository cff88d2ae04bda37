//! Roots: of rising functions, and rough ones to begin a search with.

/// More than any of ours takes; then rounding is all that is left to improve.
const ITERATIONS_MAX: u32 = 100;

/// Where a rising function is 0, between `low`, where it is not above 0, and `high`, where it is not below. `function`
/// gives value and slope. By Newton's method from `from`, by bisection where that leaves the bracket by more than
/// `tolerance` of the result: by less it is only that an end of it is as good as the root. Ends with a step of `tolerance`
/// at most; by Newton's method the result then is within the square of that, as far as floats go.
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

/// The `n`-th root of `x`, to 6.2 %: so much of the logarithm, as a float's bits have it: log2(1 + f) as f, of
/// which 2^f is short by 6.15 % at most.
#[inline(always)]
pub(crate) fn rough_root(x: f64, n: u64) -> f64 {
    f64::from_bits(x.to_bits() / n + ONE_BITS / n * (n - 1))
}

/// 1 as a float.
const ONE_BITS: u64 = 0x3ff0_0000_0000_0000;

#[cfg(test)]
mod tests {
    use super::rough_root;

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
