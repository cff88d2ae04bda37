//! Motion in pieces of as many phases, as columns that a page keeps as they come: so nothing is held twice.

use isostep_motion::AXES;

use crate::motion::{COLUMNS, LOADS, Motion};

/// Phases of each piece but the last. A power of two, which the page knows too.
pub const PHASES: usize = 4_096;
/// Between two phases that are no farther apart there is no pause, s.
const PAUSE_MIN_S: f64 = 1e-9;

/// A column; of one number if all its numbers are the same, as those of an axis that rests.
#[inline(never)]
pub fn packed<N: Copy + PartialEq>(mut column: Vec<N>) -> Vec<N> {
    if column.windows(2).all(|pair| pair[0] == pair[1]) {
        column.truncate(1);
    }
    column
}

/// Every number of a column, of rows that have so many.
#[inline(never)]
fn every<N: Copy>(numbers: &[N], first: usize, width: usize) -> Vec<N> {
    numbers.iter().skip(first).step_by(width).copied().collect()
}

impl Motion {
    /// The next whole piece, with the changes of power so far; nothing if there is none yet.
    pub(crate) fn take_piece(&mut self) -> Option<Self> {
        if self.kinds.len() < PHASES {
            return None;
        }
        let mut rest = self.following();
        rest.times_s = self.times_s.split_off(2 * PHASES);
        rest.kinds = self.kinds.split_off(PHASES);
        rest.values = self.values.split_off(COLUMNS * AXES * PHASES);
        rest.changes_mm_s2 = self.changes_mm_s2.split_off(AXES * PHASES);
        rest.loads = self.loads.split_off(LOADS * PHASES);
        rest.asked_mm_s = self.asked_mm_s.split_off(PHASES);
        rest.before_s = self.times_s.last().copied();
        Some(std::mem::replace(self, rest))
    }

    /// The beginning of each phase, s since power-up.
    pub fn begins_s(&self) -> Vec<f64> {
        every(&self.times_s, 0, 2)
    }

    /// The time from the phase before to each, s.
    pub fn pauses_s(&self) -> Vec<f64> {
        // Before the very first there is none.
        let mut ended_s = self.before_s.or(self.times_s.first().copied()).unwrap_or_default();
        let pause_s = |times_s: &[f64]| {
            let pause_s = times_s[0] - std::mem::replace(&mut ended_s, times_s[1]);
            if pause_s > PAUSE_MIN_S { pause_s } else { 0.0 }
        };
        self.times_s.chunks_exact(2).map(pause_s).collect()
    }

    /// The end of the last phase, s since power-up; of no phase that of the one before.
    pub fn end_s(&self) -> f64 {
        self.times_s.last().copied().or(self.before_s).unwrap_or_default()
    }

    /// One of the [`COLUMNS`] of an axis.
    pub fn of_axis(&self, axis: usize, column: usize) -> Vec<f32> {
        every(&self.values, COLUMNS * axis + column, COLUMNS * AXES)
    }

    /// The changes of the acceleration of an axis, mm/s².
    pub fn changes_of(&self, axis: usize) -> Vec<f32> {
        every(&self.changes_mm_s2, axis, AXES)
    }

    /// One of the [`LOADS`].
    pub fn loads_of(&self, load: usize) -> Vec<u16> {
        every(&self.loads, load, LOADS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Phases of a second each, with a pause of half a second behind the first.
    fn motion(phases: usize) -> Motion {
        let begin_s = |phase: usize| phase as f64 + if phase > 0 { 0.5 } else { 0.0 };
        let mut motion = Motion::default();
        motion.times_s = (0..phases).flat_map(|phase| [begin_s(phase), begin_s(phase) + 1.0]).collect();
        motion.kinds = vec![1; phases];
        motion.values = (0..phases * AXES * COLUMNS).map(|number| number as f32).collect();
        motion.changes_mm_s2 = (0..phases * AXES).map(|number| number as f32).collect();
        motion.loads = (0..phases * LOADS).map(|number| number as u16).collect();
        motion.asked_mm_s = vec![20.0; phases];
        motion
    }

    #[test]
    fn pieces_are_whole_and_go_on_from_each_other() {
        let mut motion = motion(2 * PHASES + 3);
        let times = |motion: &Motion| motion.begins_s().into_iter().zip(motion.pauses_s()).collect::<Vec<_>>();
        let (whole, places) = (times(&motion), motion.of_axis(1, 0));
        let mut pieces: Vec<_> = std::iter::from_fn(|| motion.take_piece()).collect();
        pieces.push(motion.take());
        assert_eq!(pieces.iter().map(|piece| piece.kinds.len()).collect::<Vec<_>>(), [PHASES, PHASES, 3]);
        assert_eq!(pieces.iter().flat_map(times).collect::<Vec<_>>(), whole);
        assert_eq!(whole[..3], [(0.0, 0.0), (1.5, 0.5), (2.5, 0.0)]);
        assert_eq!(pieces.iter().flat_map(|piece| piece.of_axis(1, 0)).collect::<Vec<_>>(), places);
        assert_eq!((pieces[2].end_s(), motion.end_s()), ((2 * PHASES + 3) as f64 + 0.5, pieces[2].end_s()));
        let last = &pieces[2];
        assert_eq!(last.changes_of(2)[1], (AXES * (2 * PHASES + 1) + 2) as f32);
        assert_eq!(last.loads_of(1)[0], (LOADS * 2 * PHASES + 1) as u16);
    }

    #[test]
    fn a_column_of_one_number_is_that_number() {
        assert_eq!(packed(vec![2.5, 2.5, 2.5]), [2.5]);
        assert_eq!(packed(vec![2.5, 2.5, 1.0]), [2.5, 2.5, 1.0]);
        assert!(packed(Vec::<u8>::new()).is_empty());
    }
}
