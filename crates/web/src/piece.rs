//! Motion in pieces of as many phases, as columns that a page keeps as they come: so nothing is held twice.

use isostep_motion::AXES;

use crate::motion::{COLUMNS, LOADS, Motion};

/// Phases of each piece but the last. A power of two, which the page knows too.
pub const PHASES: usize = 4_096;
/// Between two phases that are no farther apart there is no pause, s.
const PAUSE_MIN_S: f64 = 1e-9;

/// A column; of one number if all its numbers are the same, as those of an axis that rests.
pub fn packed<N: Copy + PartialEq>(column: impl Iterator<Item = N>) -> Vec<N> {
    let mut column: Vec<N> = column.collect();
    if column.windows(2).all(|pair| pair[0] == pair[1]) {
        column.truncate(1);
        column.shrink_to_fit();
    }
    column
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
    pub fn begins_s(&self) -> impl Iterator<Item = f64> {
        self.times_s.iter().step_by(2).copied()
    }

    /// The time from the phase before to each, s.
    pub fn pauses_s(&self) -> impl Iterator<Item = f64> {
        let ends_s = self.before_s.into_iter().chain(self.ends_s());
        // Before the very first there is none.
        let firsts = usize::from(self.before_s.is_none());
        let pauses_s = self.begins_s().skip(firsts).zip(ends_s).map(|(begins_s, ended_s)| begins_s - ended_s);
        std::iter::repeat_n(0.0, firsts.min(self.kinds.len()))
            .chain(pauses_s.map(|pause_s| if pause_s > PAUSE_MIN_S { pause_s } else { 0.0 }))
    }

    /// The end of the last phase, s since power-up; of no phase that of the one before.
    pub fn end_s(&self) -> f64 {
        self.ends_s().next_back().or(self.before_s).unwrap_or_default()
    }

    /// One of the [`COLUMNS`] of an axis.
    pub fn of_axis(&self, axis: usize, column: usize) -> impl Iterator<Item = f32> {
        self.values.iter().skip(COLUMNS * axis + column).step_by(COLUMNS * AXES).copied()
    }

    /// The changes of the acceleration of an axis, mm/s².
    pub fn changes_of(&self, axis: usize) -> impl Iterator<Item = f32> {
        self.changes_mm_s2.iter().skip(axis).step_by(AXES).copied()
    }

    /// One of the [`LOADS`].
    pub fn loads_of(&self, load: usize) -> impl Iterator<Item = u16> {
        self.loads.iter().skip(load).step_by(LOADS).copied()
    }

    fn ends_s(&self) -> impl DoubleEndedIterator<Item = f64> {
        self.times_s.chunks_exact(2).map(|times_s| times_s[1])
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
        let whole: Vec<_> = motion.begins_s().zip(motion.pauses_s()).collect();
        let places: Vec<_> = motion.of_axis(1, 0).collect();
        let mut pieces: Vec<_> = std::iter::from_fn(|| motion.take_piece()).collect();
        pieces.push(motion.take());
        assert_eq!(pieces.iter().map(|piece| piece.kinds.len()).collect::<Vec<_>>(), [PHASES, PHASES, 3]);
        let times = pieces.iter().flat_map(|piece| piece.begins_s().zip(piece.pauses_s()));
        assert_eq!(times.collect::<Vec<_>>(), whole);
        assert_eq!(whole[..3], [(0.0, 0.0), (1.5, 0.5), (2.5, 0.0)]);
        assert_eq!(pieces.iter().flat_map(|piece| piece.of_axis(1, 0)).collect::<Vec<_>>(), places);
        assert_eq!((pieces[2].end_s(), motion.end_s()), ((2 * PHASES + 3) as f64 + 0.5, pieces[2].end_s()));
        let last = &pieces[2];
        assert_eq!(last.changes_of(2).nth(1), Some((AXES * (2 * PHASES + 1) + 2) as f32));
        assert_eq!(last.loads_of(1).next(), Some((LOADS * 2 * PHASES + 1) as u16));
    }

    #[test]
    fn a_column_of_one_number_is_that_number() {
        assert_eq!(packed([2.5, 2.5, 2.5].into_iter()), [2.5]);
        assert_eq!(packed([2.5, 2.5, 1.0].into_iter()), [2.5, 2.5, 1.0]);
        assert!(packed(std::iter::empty::<u8>()).is_empty());
    }
}
