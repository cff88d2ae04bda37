//! Work offsets, stored positions, and how axis words refer to them.

use super::{Interpreter, tools::EntryMeaning, within};
use crate::{
    AXES, Block, BlockMove, Error, MotionMode, Rate,
    axes::Z,
    parameters::WORK_SYSTEMS,
    words::block::{BlockWords, NonModal},
};

/// G10 L2 gives the offset itself. G10 L20 gives the work position that the current position shall have.
const OFFSET: f32 = 2.0;
const WORK_POSITION: f32 = 20.0;

impl Interpreter {
    /// Executes a code of group 0. G28 and G30 move, perhaps via another point.
    pub(super) fn non_modal(&mut self, words: &mut BlockWords, block: &mut Block) -> Result<(), Error> {
        match words.non_modal {
            Some(NonModal::Set) => self.set(words, block)?,
            Some(NonModal::Shift) => self.shift(words)?,
            Some(NonModal::Unshift) => self.shift_pm = [0; AXES],
            Some(NonModal::Keep(place)) => self.coordinates.places_pm[place] = self.position_pm,
            Some(NonModal::GoTo(place)) => self.go_to(place, words, block)?,
            Some(NonModal::MachineCoordinates)
                if !matches!(self.modal.motion, MotionMode::Rapid | MotionMode::Linear) =>
            {
                return Err(Error::AbsoluteNeedsMotion);
            }
            Some(NonModal::MachineCoordinates | NonModal::Dwell) | None => {}
        }
        Ok(())
    }

    /// G10.
    #[cold]
    #[inline(never)]
    fn set(&mut self, words: &mut BlockWords, block: &mut Block) -> Result<(), Error> {
        let meaning = words.take(b'L');
        let entry = match meaning.unwrap_or_default() as u32 {
            1 => EntryMeaning::Length,
            10 => EntryMeaning::Place,
            11 => EntryMeaning::PlaceAtSetter,
            _ => return self.set_work_offset(meaning, words),
        };
        if AXES <= Z {
            return Err(Error::Unsupported);
        }
        let before = self.tools;
        self.set_tool(entry, words)?;
        block.changes_parameters = self.tools != before;
        Ok(())
    }

    /// G10 L2 and L20. P0 is the work coordinate system in force.
    fn set_work_offset(&mut self, meaning: Option<f32>, words: &mut BlockWords) -> Result<(), Error> {
        if !words.has_axes() {
            return Err(Error::AxisWordsMissing);
        }
        let (Some(number), Some(meaning)) = (words.take(b'P'), meaning) else {
            return Err(Error::ValueMissing);
        };
        if number % 1.0 != 0.0 {
            return Err(Error::IntegerRequired);
        }
        let system = match number as usize {
            0 => usize::from(self.modal.system),
            number @ 1..=WORK_SYSTEMS => number - 1,
            _ => return Err(Error::UnsupportedSystem),
        };
        // Like Grbl, this does not support a rotation (R).
        if meaning != WORK_POSITION && (meaning != OFFSET || words.use_up(b'R')) {
            return Err(Error::Unsupported);
        }
        for (axis, pm) in given_pm(words) {
            let offset_pm = if meaning == OFFSET { pm } else { self.zero_pm(axis, pm) - self.shift_pm[axis] };
            self.coordinates.work_offsets_pm[system][axis] = within(offset_pm)?;
        }
        Ok(())
    }

    /// G92.
    fn shift(&mut self, words: &BlockWords) -> Result<(), Error> {
        if !words.has_axes() {
            return Err(Error::AxisWordsMissing);
        }
        let system_pm = self.coordinates.work_offsets_pm[usize::from(self.modal.system)];
        for (axis, pm) in given_pm(words) {
            self.shift_pm[axis] = within(self.zero_pm(axis, pm) - system_pm[axis])?;
        }
        Ok(())
    }

    /// The place where the zero of an axis would be if the work position were `pm`, with the tool length subtracted.
    #[cold]
    fn zero_pm(&self, axis: usize, pm: i64) -> i64 {
        self.position_pm[axis] - pm - if axis == Z { self.tool_length_pm } else { 0 }
    }

    /// G28, G30. With axis words, only the named axes move to the stored position, via the target of those words.
    fn go_to(&self, place: usize, words: &BlockWords, block: &mut Block) -> Result<(), Error> {
        let mut target_pm = self.coordinates.places_pm[place];
        let via_pm = if words.has_axes() { Some(self.target_pm(words)?) } else { None };
        if via_pm.is_some() {
            for (axis, _) in words.axes_pm().iter().enumerate().filter(|(_, value)| value.is_none()) {
                target_pm[axis] = self.position_pm[axis];
            }
        }
        let path = self.modal.path;
        (block.via_pm, block.motion) = (via_pm, Some(BlockMove { target_pm, rate: Rate::Rapid, arc: None, path }));
        Ok(())
    }

    /// The target of the axis words; axes without a word keep their position.
    pub(super) fn target_pm(&self, words: &BlockWords) -> Result<[i64; AXES], Error> {
        let mut target_pm = self.position_pm;
        let offset_pm = self.work_offset_pm();
        for (axis, pm) in given_pm(words) {
            target_pm[axis] = within(match words.non_modal {
                Some(NonModal::MachineCoordinates) => pm,
                _ if words.modal.incremental => target_pm[axis] + pm,
                _ => offset_pm[axis] + pm,
            })?;
        }
        Ok(target_pm)
    }
}

/// The named axes, with their values.
pub(super) fn given_pm(words: &BlockWords) -> impl Iterator<Item = (usize, i64)> {
    let axes = words.axes_pm().into_iter().enumerate();
    axes.filter_map(|(axis, pm)| pm.map(|pm| (axis, pm)))
}
