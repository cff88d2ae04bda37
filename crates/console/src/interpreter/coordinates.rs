//! Work offsets, stored positions, and how axis words refer to them.

use super::{Interpreter, Z, in_mm, within};
use crate::{
    AXES, Error, MotionMode, Move, Rate,
    block::{NonModal, Words},
    parameters::WORK_SYSTEMS,
};

/// G10 L2 gives the offset itself. G10 L20 gives the work position that the current position shall have.
const OFFSET: f32 = 2.0;
const WORK_POSITION: f32 = 20.0;

impl Interpreter {
    /// Executes a code of group 0. G28 and G30 move, perhaps via another point.
    pub(super) fn non_modal(&mut self, words: &mut Words) -> Result<(Option<[f32; AXES]>, Option<Move>), Error> {
        match words.non_modal {
            Some(NonModal::SetWorkOffset) => self.set_work_offset(words)?,
            Some(NonModal::Shift) => self.shift(words)?,
            Some(NonModal::Unshift) => self.shift_mm = [0.0; AXES],
            Some(NonModal::Keep(place)) => self.coordinates.places_mm[place] = self.position_mm,
            Some(NonModal::GoTo(place)) => return self.go_to(place, words),
            Some(NonModal::MachineCoordinates)
                if !matches!(self.modal.motion, MotionMode::Rapid | MotionMode::Linear) =>
            {
                return Err(Error::AbsoluteNeedsMotion);
            }
            Some(NonModal::MachineCoordinates | NonModal::Dwell) | None => {}
        }
        Ok((None, None))
    }

    /// G10. P0 is the work coordinate system in force.
    fn set_work_offset(&mut self, words: &mut Words) -> Result<(), Error> {
        if !words.has_axes() {
            return Err(Error::AxisWordsMissing);
        }
        let (Some(number), Some(meaning)) = (words.take(b'P'), words.take(b'L')) else {
            return Err(Error::ValueMissing);
        };
        let system = match number as usize {
            0 => usize::from(self.modal.system),
            number @ 1..=WORK_SYSTEMS => number - 1,
            _ => return Err(Error::UnsupportedSystem),
        };
        // Like Grbl, this does not support a rotation (R).
        if meaning != WORK_POSITION && (meaning != OFFSET || words.take(b'R').is_some()) {
            return Err(Error::Unsupported);
        }
        for (axis, mm) in given_mm(words) {
            let offset_mm = if meaning == OFFSET { mm } else { self.zero_mm(axis, mm) - self.shift_mm[axis] };
            self.coordinates.work_offsets_mm[system][axis] = within(offset_mm)?;
        }
        Ok(())
    }

    /// G92.
    fn shift(&mut self, words: &Words) -> Result<(), Error> {
        if !words.has_axes() {
            return Err(Error::AxisWordsMissing);
        }
        let system_mm = self.coordinates.work_offsets_mm[usize::from(self.modal.system)];
        for (axis, mm) in given_mm(words) {
            self.shift_mm[axis] = within(self.zero_mm(axis, mm) - system_mm[axis])?;
        }
        Ok(())
    }

    /// Where the zero of an axis would be if the work position were `mm`, with the tool length subtracted.
    fn zero_mm(&self, axis: usize, mm: f32) -> f32 {
        self.position_mm[axis] - mm - if axis == Z { self.tool_length_mm } else { 0.0 }
    }

    /// G28, G30. With axis words, only the named axes move to the stored position, via the target of those words.
    fn go_to(&self, place: usize, words: &Words) -> Result<(Option<[f32; AXES]>, Option<Move>), Error> {
        let mut target_mm = self.coordinates.places_mm[place];
        let via_mm = if words.has_axes() { Some(self.target_mm(words)?) } else { None };
        if via_mm.is_some() {
            for (axis, _) in words.axes().iter().enumerate().filter(|(_, value)| value.is_none()) {
                target_mm[axis] = self.position_mm[axis];
            }
        }
        let exact_stop = self.modal.exact_stop;
        Ok((via_mm, Some(Move { target_mm, rate: Rate::Rapid, arc: None, exact_stop })))
    }

    /// The target of the axis words; axes without a word keep their position.
    pub(super) fn target_mm(&self, words: &Words) -> Result<[f32; AXES], Error> {
        let mut target_mm = self.position_mm;
        let offset_mm = self.work_offset_mm();
        for (axis, mm) in given_mm(words) {
            target_mm[axis] = within(match words.non_modal {
                Some(NonModal::MachineCoordinates) => mm,
                _ if words.modal.incremental => target_mm[axis] + mm,
                _ => offset_mm[axis] + mm,
            })?;
        }
        Ok(target_mm)
    }
}

/// The named axes, with their values in mm.
fn given_mm(words: &Words) -> impl Iterator<Item = (usize, f32)> {
    let axes = words.axes().into_iter().enumerate();
    axes.filter_map(|(axis, value)| value.map(|value| (axis, in_mm(value, &words.modal))))
}
