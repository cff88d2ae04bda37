//! What outlives a reset beside the settings: work offsets, places to go to, start-up lines, a text of the user's.

use heapless::String;

use crate::AXES;

/// Work coordinate systems, G54 to G59.
pub const WORK_SYSTEMS: usize = 6;
/// Start-up lines, `$N0` and `$N1`.
pub const STARTUP_LINES: usize = 2;
/// The longest that is kept: what is left of a line of [`MAX_LINE_CHARS`](crate::MAX_LINE_CHARS) after `$I=`.
pub const STORED_LINE_CHARS: usize = crate::MAX_LINE_CHARS - 3;

/// A start-up line or a text, as [`LineAssembler`](crate::LineAssembler) strips it; empty for none.
pub type StoredLine = String<STORED_LINE_CHARS>;

/// Work offsets and places, in machine coordinates; by default all zero.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coordinates {
    /// The origins of G54 to G59.
    pub work_offsets_mm: [[f32; AXES]; WORK_SYSTEMS],
    /// Where G28 and G30 go to.
    pub places_mm: [[f32; AXES]; 2],
}

impl Coordinates {
    /// The origin of G54 to G59, then where G28 and G30 go to.
    ///
    /// # Panics
    /// Beyond them.
    #[must_use]
    pub fn place(&self, index: usize) -> &[f32; AXES] {
        match index.checked_sub(WORK_SYSTEMS) {
            None => &self.work_offsets_mm[index],
            Some(place) => &self.places_mm[place],
        }
    }

    /// The same, to be changed.
    ///
    /// # Panics
    /// Beyond them.
    pub fn place_mut(&mut self, index: usize) -> &mut [f32; AXES] {
        match index.checked_sub(WORK_SYSTEMS) {
            None => &mut self.work_offsets_mm[index],
            Some(place) => &mut self.places_mm[place],
        }
    }
}

/// Plain data, by default all zero and empty. `$RST=#` puts that back, the text apart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parameters {
    /// Work offsets and places.
    pub coordinates: Coordinates,
    /// What `$N0=` and `$N1=` have stored.
    pub startup: [StoredLine; STARTUP_LINES],
    /// What `$I=` has stored.
    pub build_text: StoredLine,
}
