//! Finds the highest rate that works, by bisection.

/// Higher than any rate that a step port here may be tried at.
const RATE_MAX_STEPS_S: u32 = 5_000_000;

/// Rates of two significant digits from 1,000 to 5,000,000 steps/s.
pub fn fine() -> Vec<u32> {
    ladder(&(10..100).collect::<Vec<_>>())
}

/// Rates of one digit: 1, 2, 3, 5 and 7.
pub fn coarse() -> Vec<u32> {
    ladder(&[10, 20, 30, 50, 70])
}

fn ladder(tenths: &[u32]) -> Vec<u32> {
    let decades = [100, 1_000, 10_000, 100_000];
    let rates = decades.into_iter().flat_map(|decade| tenths.iter().map(move |tenths| tenths * decade));
    rates.filter(|&rate| rate <= RATE_MAX_STEPS_S).collect()
}

/// The result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Found<Y, N> {
    /// The highest rate that works, and the result of its trial.
    pub highest: Option<(u32, Y)>,
    /// The next higher rate, and why it fails; `None` if all rates work.
    pub next: Option<(u32, N)>,
}

/// Searches `rates`, which must ascend, by bisection with `works`. All rates above one that fails are assumed to fail
/// too.
pub fn highest<Y, N, E>(
    rates: &[u32],
    mut works: impl FnMut(u32) -> Result<Result<Y, N>, E>,
) -> Result<Found<Y, N>, E> {
    let mut found = Found { highest: None, next: None };
    let (mut low, mut high) = (0, rates.len());
    while low < high {
        let middle = low + (high - low) / 2;
        let rate = rates[middle];
        match works(rate)? {
            Ok(gave) => {
                found.highest = Some((rate, gave));
                low = middle + 1;
            }
            Err(why) => {
                found.next = Some((rate, why));
                high = middle;
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    fn search(rates: &[u32], limit: u32) -> (Option<u32>, Option<u32>, usize) {
        let mut trials = 0;
        let Ok(found) = highest(rates, |rate| {
            trials += 1;
            Ok::<_, Infallible>(if rate <= limit { Ok(()) } else { Err(()) })
        });
        (found.highest.map(|one| one.0), found.next.map(|one| one.0), trials)
    }

    #[test]
    fn the_border_is_found_wherever_it_is() {
        let rates = coarse();
        for pair in rates.windows(2) {
            let (highest, next, trials) = search(&rates, pair[0]);
            assert_eq!((highest, next), (Some(pair[0]), Some(pair[1])));
            assert!(trials <= 5, "{trials}");
        }
        assert_eq!(search(&rates, 1).0, None);
        assert_eq!(search(&rates, 9_000_000).0, Some(5_000_000));
    }

    #[test]
    fn rates_rise_and_have_two_digits() {
        let rates = fine();
        assert!(rates.is_sorted_by(|one, next| one < next));
        assert_eq!((rates[0], rates[1], *rates.last().unwrap()), (1_000, 1_100, 5_000_000));
        assert!(rates.contains(&1_300_000) && search(&rates, 1_250_000).2 <= 9);
    }
}
