//! Interprets the words of an arc.

use super::{Interpreter, within};
use crate::{
    Arc, Error, Misfit, MotionMode, Settings,
    arc::{Ends, PLANES},
    block::Words,
    length,
};

impl Interpreter {
    /// The arc to the target, if the block's motion mode is an arc; checked in Grbl's order.
    pub(super) fn arc(&self, words: &mut Words) -> Result<Option<Arc>, Error> {
        if !words.modal.motion.is_arc() {
            return Ok(None);
        }
        let ends = self.ends(words)?;
        let arc = if let Some(radius_pm) = words.take_radius_pm() {
            Arc::of_radius(ends, length::to_mm(radius_pm))?
        } else {
            Arc::around(ends, offset_mm(words)?)?
        };
        // The middle of an arc may be out of range even if both ends are within it.
        arc.bounds_mm().iter().flatten().try_for_each(|&mm| within(length::from_mm(mm)).map(|_| ()))?;
        Ok(Some(arc))
    }

    /// Why the centre that `line` gives for its arc does not fit: for a line of G-code that was refused with
    /// [`Error::InvalidTarget`]. `None` if the line was refused for another reason.
    #[must_use]
    pub fn misfit(&self, line: &str, settings: &Settings) -> Option<Misfit> {
        let mut words = Words::new(self.modal, settings.rotary());
        words.read(&mut line.as_bytes()).ok()?;
        if !words.modal.motion.is_arc() || words.take_radius_pm().is_some() {
            return None;
        }
        let at_line = Self { modal: words.modal, ..*self };
        Misfit::of(at_line.ends(&words).ok()?, offset_mm(&mut words).ok()?)
    }

    fn ends(&self, words: &Words) -> Result<Ends, Error> {
        let (mode, plane) = (words.modal.motion, words.modal.plane);
        let [first, second, ..] = PLANES[usize::from(plane)];
        if [first, second].iter().all(|&axis| words.axes_pm()[axis].is_none()) {
            return Err(Error::PlaneAxesMissing);
        }
        let [start_mm, target_mm] =
            [self.position_pm, self.target_pm(words)?].map(|place_pm| place_pm.map(length::to_mm));
        Ok(Ends { start_mm, target_mm, plane, clockwise: mode == MotionMode::ClockwiseArc })
    }
}

/// From the start of an arc to its centre, in its plane.
fn offset_mm(words: &mut Words) -> Result<[f64; 2], Error> {
    let [first, second, ..] = PLANES[usize::from(words.modal.plane)];
    let offsets_pm = words.take_offsets_pm();
    let offsets_pm = [offsets_pm[first], offsets_pm[second]];
    if offsets_pm == [None; 2] {
        return Err(Error::OffsetsMissing);
    }
    Ok(offsets_pm.map(|offset_pm| length::to_mm(offset_pm.unwrap_or(0))))
}
