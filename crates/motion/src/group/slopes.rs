//! The lines that pass near all ends of some moves, one axis beside another.

/// A fraction whose denominator is not negative.
#[derive(Clone, Copy)]
pub(super) struct Slope {
    pub(super) rise: i32,
    pub(super) run: i32,
}

impl Slope {
    /// A line that goes so far beside another axis, on which it goes so far.
    pub(super) fn of(rise: i32, run: i32) -> Self {
        if run < 0 { Self { rise: -rise, run: -run } } else { Self { rise, run } }
    }

    #[inline(never)]
    fn is_below(self, other: Self) -> bool {
        i64::from(self.rise) * i64::from(other.run) < i64::from(other.rise) * i64::from(self.run)
    }
}

/// The slopes of the lines from a beginning that pass all ends so far within a distance.
#[derive(Clone, Copy)]
pub(super) struct Slopes {
    /// That distance, in the units of rises.
    pub(super) within: i32,
    least: Slope,
    most: Slope,
}

impl Slopes {
    /// Any, as there are no ends yet.
    pub(super) const fn any(within: i32) -> Self {
        Self { within, least: Slope { rise: -1, run: 0 }, most: Slope { rise: 1, run: 0 } }
    }

    /// Leaves those that pass this end, too.
    #[inline(never)]
    pub(super) fn narrow(&mut self, end: Slope) {
        let least = Slope { rise: end.rise.saturating_sub(self.within), ..end };
        let most = Slope { rise: end.rise.saturating_add(self.within), ..end };
        if self.least.is_below(least) {
            self.least = least;
        }
        if most.is_below(self.most) {
            self.most = most;
        }
    }

    /// True if a line of this slope passes all ends.
    pub(super) fn has(&self, slope: Slope) -> bool {
        !slope.is_below(self.least) && !self.most.is_below(slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_passes_all_ends_or_it_is_none_of_them() {
        let ends = [(10, 3), (20, -4), (35, 6), (50, 2)];
        for within in 0..12 {
            let mut slopes = Slopes::any(within);
            for (run, rise) in ends {
                slopes.narrow(Slope { rise, run });
            }
            for rise in -400..400 {
                let passes = |&(run, end): &(i32, i32)| (rise * run - end * 1_000).abs() <= within * 1_000;
                assert_eq!(slopes.has(Slope { rise, run: 1_000 }), ends.iter().all(passes), "{rise} within {within}");
            }
        }
    }

    #[test]
    fn without_ends_any_slope_will_do_and_large_ones_do_not_overflow() {
        let slope = |rise: i32| Slope { rise, run: 1 };
        assert!([0, i32::MAX, i32::MIN].into_iter().all(|rise| Slopes::any(5).has(slope(rise))));
        let mut slopes = Slopes::any(i32::MAX);
        slopes.narrow(Slope { rise: i32::MAX, run: i32::MAX });
        assert!(slopes.has(slope(0)) && slopes.has(slope(1)) && !slopes.has(slope(3)));
    }
}
