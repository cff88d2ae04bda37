//! Interprets the words of tools' lengths: G43 to G43.2, and G10 L1, L10 and L11.

use super::{Interpreter, coordinates, within};
use crate::{
    AXES, Error, RADIUS_MAX_NM, ToolEntry,
    axes::Z,
    parameters::TOOL_SETTER,
    tools::NM_PM,
    words::block::{BlockWords, MAX_TOOL, ToolLength},
};

/// What the Z of G10 L1, L10 and L11 says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EntryMeaning {
    /// L1: the length itself.
    Length,
    /// L10: the place at which the tool's end is, in the work coordinate system in force.
    Place,
    /// L11: the same in G59.3, whatever G92 shifts.
    PlaceAtSetter,
}

impl Interpreter {
    /// A code that brings a tool's length into force.
    #[cold]
    #[inline(never)]
    pub(super) fn tool_length(&mut self, length: ToolLength, words: &mut BlockWords) -> Result<(), Error> {
        self.tool_length_pm = match length {
            ToolLength::Zero => 0,
            ToolLength::Given => self.given_length_pm(words)?,
            ToolLength::OfTool => {
                let number = words.take(b'H').map_or(self.tool_in_spindle, |number| number as u32);
                self.tools.tool(number).length_pm
            }
            ToolLength::Added => {
                let number = words.take(b'H').ok_or(Error::ValueMissing)?;
                within(self.tool_length_pm + self.tools.tool(number as u32).length_pm)?
            }
        };
        Ok(())
    }

    fn given_length_pm(&self, words: &BlockWords) -> Result<i64, Error> {
        match words.has_axes().then(|| one_along_z_pm(words)) {
            Some(Ok(Some(z_pm))) => within(z_pm),
            _ => Err(Error::ToolAxis),
        }
    }

    /// G10 L1, L10 or L11. The length in force stays as it is.
    #[cold]
    #[inline(never)]
    pub(super) fn set_tool(&mut self, entry: EntryMeaning, words: &mut BlockWords) -> Result<(), Error> {
        let number = words.take(b'P').ok_or(Error::ValueMissing)?;
        if number % 1.0 != 0.0 {
            return Err(Error::IntegerRequired);
        }
        match number {
            0.0 => return Err(Error::ToolNumber),
            _ if number > MAX_TOOL => return Err(Error::ToolNumber),
            _ => {}
        }
        let given_pm = one_along_z_pm(words)?;
        let radius_pm = words.take_length_pm(b'R');
        if given_pm.is_none() && (entry != EntryMeaning::Length || radius_pm.is_none()) {
            return Err(Error::AxisWordsMissing);
        }
        let mut tool: ToolEntry = self.tools.tool(number as u32);
        if let Some(z_pm) = given_pm {
            tool.length_pm = within(self.length_of_entry_pm(entry, z_pm))?;
        }
        if let Some(radius_pm) = radius_pm {
            let radius_nm = u32::try_from(radius_pm / NM_PM).map_err(|_| Error::ToolNumber)?;
            tool.radius_nm =
                Some(radius_nm).filter(|&nm| radius_pm >= 0 && nm <= RADIUS_MAX_NM).ok_or(Error::ToolNumber)?;
        }
        // Nothing behind it refuses the line, so the table needs no undoing.
        words.check_all_used()?;
        self.tools.put(tool)
    }

    /// Where tools are changed and measured, G59.3, in machine coordinates: X, Y and Z of its origin, and the other axes where they are.
    pub fn tool_setter_pm(&self) -> [i64; AXES] {
        let mut setter_pm = self.position_pm;
        let origin_pm = self.coordinates.work_offsets_pm[TOOL_SETTER];
        setter_pm.iter_mut().zip(origin_pm).take(Z + 1).for_each(|(to, pm)| *to = pm);
        setter_pm
    }

    fn length_of_entry_pm(&self, entry: EntryMeaning, z_pm: i64) -> i64 {
        let along_z_pm = |place_pm: &[i64; AXES]| place_pm.get(Z).copied().unwrap_or_default();
        let offset_pm = |system: usize| along_z_pm(&self.coordinates.work_offsets_pm[system]);
        let zero_pm = match entry {
            EntryMeaning::Length => return z_pm,
            EntryMeaning::Place => offset_pm(self.modal.system.into()) + along_z_pm(&self.shift_pm),
            // What measures tools stays where it is.
            EntryMeaning::PlaceAtSetter => offset_pm(TOOL_SETTER),
        };
        along_z_pm(&self.position_pm) - zero_pm - z_pm
    }
}

/// The Z word, if there is one.
///
/// # Errors
/// [`Error::ToolAxis`] if there is a word of another axis.
fn one_along_z_pm(words: &BlockWords) -> Result<Option<i64>, Error> {
    let mut z_pm = None;
    for (axis, pm) in coordinates::given_pm(words) {
        if axis != Z {
            return Err(Error::ToolAxis);
        }
        z_pm = Some(pm);
    }
    Ok(z_pm)
}
