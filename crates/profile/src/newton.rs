//! Roots of rising functions.

/// More than any of ours takes; then rounding is all that is left to improve.
const ITERATIONS_MAX: u32 = 100;

/// Where a rising function is 0, between `low`, where it is not above 0, and `high`, where it is not below. `function`
/// gives value and slope. By Newton's method from `from`, by bisection where that leaves the bracket. Ends with a step
/// of `tolerance` of the result at most; the result then is better than that.
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
        let next = if (low..=high).contains(&newton) { newton } else { (low + high) / 2.0 };
        let step = (next - x).abs();
        x = next;
        if step <= tolerance * x {
            break;
        }
    }
    x
}
