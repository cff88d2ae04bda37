//! Interprets the words of an arc.

use super::{Interpreter, within};
use crate::{
    Arc, Error, MotionMode,
    arc::{Ends, PLANES},
    block::Words,
    length,
};

impl Interpreter {
    /// The arc to the target, if the block's motion mode is an arc; checked in Grbl's order.
    pub(super) fn arc(&self, words: &mut Words) -> Result<Option<Arc>, Error> {
        let (mode, plane) = (words.modal.motion, words.modal.plane);
        if !mode.is_arc() {
            return Ok(None);
        }
        let [first, second, _] = PLANES[usize::from(plane)];
        if [first, second].iter().all(|&axis| words.axes_pm()[axis].is_none()) {
            return Err(Error::PlaneAxesMissing);
        }
        let [start_mm, target_mm] =
            [self.position_pm, self.target_pm(words)?].map(|place_pm| place_pm.map(length::to_mm));
        let ends = Ends { start_mm, target_mm, plane, clockwise: mode == MotionMode::ClockwiseArc };
        let arc = if let Some(radius_pm) = words.take_radius_pm() {
            Arc::of_radius(ends, length::to_mm(radius_pm))?
        } else {
            let offsets_pm = words.take_offsets_pm();
            let offsets_pm = [offsets_pm[first], offsets_pm[second]];
            if offsets_pm == [None; 2] {
                return Err(Error::OffsetsMissing);
            }
            Arc::around(ends, offsets_pm.map(|offset_pm| length::to_mm(offset_pm.unwrap_or(0))))?
        };
        // The middle of an arc may be out of range even if both ends are within it.
        arc.bounds_mm().iter().flatten().try_for_each(|&mm| within(length::from_mm(mm)).map(|_| ()))?;
        Ok(Some(arc))
    }
}
