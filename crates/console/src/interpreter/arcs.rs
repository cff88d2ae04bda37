//! Interprets the words of an arc.

use super::{Interpreter, within};
use crate::{
    Arc, Error, Misfit, MotionMode, Settings,
    arc::{ArcEnds, PLANES},
    length,
    words::block::BlockWords,
};

impl Interpreter {
    /// The arc to the target, if the block's motion mode is an arc; checked in Grbl's order.
    pub(super) fn arc(&self, words: &mut BlockWords) -> Result<Option<Arc>, Error> {
        if !words.modal.motion.is_arc() {
            return Ok(None);
        }
        let ends = self.ends(words)?;
        let arc = if let Some(radius_pm) = words.take_length_pm(b'R') {
            Arc::of_radius(ends, length::to_mm(radius_pm))?
        } else {
            Arc::around(ends, mm_or_0(offsets_pm(words)?))?
        };
        // The middle of an arc may be out of range even if both ends are within it.
        arc.bounds_mm().iter().flatten().try_for_each(|&mm| within(length::from_mm(mm)).map(|_| ()))?;
        Ok(Some(arc))
    }

    /// Why the centre or the radius that `line` gives for its arc does not fit: for a line of G-code that was refused with
    /// [`Error::InvalidTarget`] or [`Error::RadiusTooSmall`]. `None` if the line was refused for another reason.
    pub(super) fn misfit(&self, line: &str, settings: &Settings) -> Option<Misfit> {
        let mut words = BlockWords::new(self.modal, settings.rotary());
        words.read(&mut line.as_bytes()).ok()?;
        if !words.modal.motion.is_arc() {
            return None;
        }
        let at_line = Self { modal: words.modal, ..*self };
        let ends = at_line.ends(&words).ok()?;
        if let Some(radius_pm) = words.take_length_pm(b'R') {
            return Misfit::of_radius(ends, length::to_mm(radius_pm));
        }
        let offsets_pm = offsets_pm(&mut words).ok()?;
        Misfit::of_centre(ends, mm_or_0(offsets_pm), at_line.offset_to_mm(offsets_pm))
    }

    /// From the start of an arc to a place in its plane, in work coordinates; `None` if the place lacks a coordinate.
    fn offset_to_mm(&self, place_pm: [Option<i64>; 2]) -> Option<[f64; 2]> {
        let [Some(first_pm), Some(second_pm)] = place_pm else { return None };
        let [first, second, ..] = PLANES[usize::from(self.modal.plane)];
        let zero_pm = self.work_offset_pm();
        let offset_mm = |axis: usize, pm| length::to_mm(zero_pm[axis] + pm - self.position_pm[axis]);
        Some([offset_mm(first, first_pm), offset_mm(second, second_pm)])
    }

    fn ends(&self, words: &BlockWords) -> Result<ArcEnds, Error> {
        let (mode, plane) = (words.modal.motion, words.modal.plane);
        let [first, second, ..] = PLANES[usize::from(plane)];
        // Without them a centre makes a full circle, as does a target where the arc begins.
        let has_target = [first, second].iter().any(|&axis| words.axes_pm()[axis].is_some());
        if !has_target && (words.has_radius() || !words.has_offsets()) {
            return Err(if words.has_axes() { Error::PlaneAxesMissing } else { Error::AxisWordsMissing });
        }
        let [start_mm, target_mm] =
            [self.position_pm, self.target_pm(words)?].map(|place_pm| place_pm.map(length::to_mm));
        Ok(ArcEnds { start_mm, target_mm, plane, clockwise: mode == MotionMode::ClockwiseArc })
    }
}

/// I, J and K of an arc, those of its plane.
fn offsets_pm(words: &mut BlockWords) -> Result<[Option<i64>; 2], Error> {
    let [first, second, ..] = PLANES[usize::from(words.modal.plane)];
    let offsets_pm = words.take_offsets_pm();
    let offsets_pm = [offsets_pm[first], offsets_pm[second]];
    if offsets_pm == [None; 2] {
        return Err(Error::OffsetsMissing);
    }
    Ok(offsets_pm)
}

fn mm_or_0(offsets_pm: [Option<i64>; 2]) -> [f64; 2] {
    offsets_pm.map(|offset_pm| length::to_mm(offset_pm.unwrap_or(0)))
}
