//! Interprets the words of an arc.

use super::{Interpreter, in_mm, within};
use crate::{
    Arc, Error, MotionMode,
    arc::{Ends, PLANES},
    block::Words,
};

impl Interpreter {
    /// The arc to the target, if the block's motion mode is an arc; checked in Grbl's order.
    pub(super) fn arc(&self, words: &mut Words) -> Result<Option<Arc>, Error> {
        let (mode, plane) = (words.modal.motion, words.modal.plane);
        if !mode.is_arc() {
            return Ok(None);
        }
        let [first, second, _] = PLANES[usize::from(plane)];
        if [first, second].iter().all(|&axis| words.axes()[axis].is_none()) {
            return Err(Error::PlaneAxesMissing);
        }
        let (start_mm, target_mm) = (self.position_mm, self.target_mm(words)?);
        let ends = Ends { start_mm, target_mm, plane, clockwise: mode == MotionMode::ClockwiseArc };
        let arc = if let Some(radius) = words.take(b'R') {
            Arc::of_radius(ends, in_mm(radius, &words.modal).into())?
        } else {
            let offsets = words.take_offsets();
            let offsets = [offsets[first], offsets[second]];
            if offsets == [None; 2] {
                return Err(Error::OffsetsMissing);
            }
            Arc::around(ends, offsets.map(|offset| in_mm(offset.unwrap_or(0.0), &words.modal).into()))?
        };
        // The middle of an arc may be out of range even if both ends are within it.
        arc.bounds_mm().iter().flatten().try_for_each(|&mm| within(mm as f32).map(|_| ()))?;
        Ok(Some(arc))
    }
}
