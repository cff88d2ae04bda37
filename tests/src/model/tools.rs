//! The tool table, and what counts of it: G43, G43.1, G43.2, G49, and G10 L1, L10, L11, by LinuxCNC's rules.

use super::block::{Block, Refused, near};
use super::machine::Model;
use super::words::ONE;

/// The number of tools that the table has room for.
pub const TOOLS_MAX: usize = 32;
/// The highest number of a tool.
pub const NUMBER_MAX: i64 = 99_999;
/// G59.3 among the systems.
const FIXTURE: usize = 8;
/// The largest radius of a tool, angstroms.
const LARGEST_ANGSTROM: i64 = 1_000 * ONE;

/// An entry of the table, angstroms. A tool that has none counts as one of zeros.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tool {
    /// Along Z.
    pub length: i64,
    /// It is kept, and has no effect.
    pub radius: i64,
}

impl Model {
    /// G43, G43.1, G43.2 or G49.
    ///
    /// # Errors
    /// The number of the error.
    pub(super) fn set_tool_length(&mut self, code: i64, block: &mut Block) -> Result<(), Refused> {
        self.tool_length = match code {
            490 => 0,
            430 => self.length_of(block.take('H').map_or(self.in_spindle, |number| number / ONE)),
            432 => near(self.tool_length + self.length_of(block.take('H').ok_or(28)? / ONE))?,
            _ => match block.lengths() {
                [None, None, Some(z)] => near(z)?,
                _ => return Err(37),
            },
        };
        Ok(())
    }

    /// The length of a tool; no tool has the number 0.
    fn length_of(&self, number: i64) -> i64 {
        self.tools.get(&number).map_or(0, |tool| tool.length)
    }

    /// G10 L1, L10 or L11. The length in force stays.
    ///
    /// # Errors
    /// The number of the error.
    pub(super) fn set_tool(&mut self, kind: i64, block: &mut Block) -> Result<(), Refused> {
        let number = match block.take('P').ok_or(28)? {
            number if number % ONE != 0 => return Err(23),
            number if !(ONE..=NUMBER_MAX * ONE).contains(&number) => return Err(38),
            number => number / ONE,
        };
        if block.has("XY") {
            return Err(37);
        }
        let radius = block.take('R').map(|radius| block.modes.length(radius));
        let z = block.lengths()[2];
        if z.is_none() && (kind != 1 || radius.is_none()) {
            return Err(26);
        }
        let mut tool = self.tools.get(&number).copied().unwrap_or_default();
        if let Some(z) = z {
            tool.length = near(self.length_to_read(z, kind))?;
        }
        tool.radius = radius.unwrap_or(tool.radius);
        if !(0..=LARGEST_ANGSTROM).contains(&tool.radius) {
            return Err(38);
        }
        block.all_used()?;
        self.put_in(number, tool)
    }

    /// The length that G10 gives a tool. G59.3 does not move with G92.
    fn length_to_read(&self, z: i64, kind: i64) -> i64 {
        match kind {
            1 => z,
            10 => self.position[2] - self.systems[self.modes.system][2] - self.shift[2] - z,
            _ => self.position[2] - self.systems[FIXTURE][2] - z,
        }
    }

    fn put_in(&mut self, number: i64, tool: Tool) -> Result<(), Refused> {
        if tool == Tool::default() {
            self.tools.remove(&number);
        } else if self.tools.len() == TOOLS_MAX && !self.tools.contains_key(&number) {
            return Err(38);
        } else {
            self.tools.insert(number, tool);
        }
        Ok(())
    }
}
