//! The values that survive a reset in addition to the settings: work offsets, stored positions, tools, start-up lines, and a
//! text of the user.

use heapless::String;

use crate::{AXES, ToolTable};

/// Work coordinate systems, G54 to G59 and G59.1 to G59.3.
pub const WORK_SYSTEMS: usize = 9;
/// The index of G59.3, where tools are measured.
pub(crate) const TOOL_SETTER: usize = 8;
/// Start-up lines, `$N0` and `$N1`.
pub const STARTUP_LINES: usize = 2;
/// The longest text that is stored: what a line of [`MAX_LINE_CHARS`](crate::MAX_LINE_CHARS) has left after `$I=`.
pub const STORED_LINE_CHARS: usize = crate::MAX_LINE_CHARS - 3;

/// A start-up line or a text, stripped by [`LineAssembler`](crate::LineAssembler); empty for none.
pub type StoredLine = String<STORED_LINE_CHARS>;

/// Work offsets and stored positions, in machine coordinates, in [picometres](crate::length); by default all zero.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coordinates {
    /// The origins of G54 to G59, then of G59.1 to G59.3.
    pub work_offsets_pm: [[i64; AXES]; WORK_SYSTEMS],
    /// The positions of G28 and G30.
    pub places_pm: [[i64; AXES]; 2],
}

impl Coordinates {
    /// All of them: of G54 to G59 and G59.1 to G59.3, then of G28 and G30.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut [i64; AXES]> {
        self.work_offsets_pm.iter_mut().chain(&mut self.places_pm)
    }
}

/// Stored parameters; by default all zero and empty. `$RST=#` restores the defaults, except for the text.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parameters {
    /// Work offsets and stored positions.
    pub coordinates: Coordinates,
    /// The table of tools.
    pub tools: ToolTable,
    /// The lines of `$N0=` and `$N1=`.
    pub startup: [StoredLine; STARTUP_LINES],
    /// The text of `$I=`.
    pub build_text: StoredLine,
}
