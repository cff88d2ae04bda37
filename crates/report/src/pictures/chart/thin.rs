//! Reduces the number of points without losing a peak.

/// The points needed to draw a line over `columns` columns: of each column the first, the lowest, the highest and the
/// last, in order of time.
pub fn thin(points: &[(f64, f64)], from: f64, to: f64, columns: usize) -> Vec<(f64, f64)> {
    let width = ((to - from) / columns as f64).max(f64::MIN_POSITIVE);
    let column = |point: &(f64, f64)| ((point.0 - from) / width).floor();
    points.chunk_by(|one, next| column(one) == column(next)).flat_map(extremes).collect()
}

fn extremes(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let by_value = |one: &usize, other: &usize| points[*one].1.total_cmp(&points[*other].1);
    let indices = || 0..points.len();
    let mut kept: Vec<usize> =
        [Some(0), indices().min_by(by_value), indices().max_by(by_value), points.len().checked_sub(1)]
            .into_iter()
            .flatten()
            .collect();
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|index| points[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_lowest_highest_and_last_of_each_column_are_kept_in_order() {
        let points = [(0.0, 5.0), (0.1, 9.0), (0.2, 1.0), (0.3, 4.0), (0.4, 6.0), (1.0, 0.0), (1.5, 2.0)];
        let kept = thin(&points, 0.0, 2.0, 2);
        assert_eq!(kept, [(0.0, 5.0), (0.1, 9.0), (0.2, 1.0), (0.4, 6.0), (1.0, 0.0), (1.5, 2.0)]);
    }

    #[test]
    fn few_points_stay_as_they_are() {
        assert_eq!(thin(&[], 0.0, 1.0, 10), []);
        assert_eq!(thin(&[(0.0, 1.0)], 0.0, 0.0, 10), [(0.0, 1.0)]);
    }
}
