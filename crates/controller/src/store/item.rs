//! The items that are kept, and the bytes of each.

use heapless::Vec;
use isostep_console::parameters::{STARTUP_LINES, STORED_LINE_CHARS, StoredLine, WORK_SYSTEMS};
use isostep_console::{
    AXES, Coordinates, MAX_COORDINATE_PM, Parameters, RADIUS_MAX_NM, SETTING_TABLE, Settings, TOOLS, ToolEntry,
    ToolTable, length,
};

/// The bytes of an item: settings as 32-bit floats, places as 64-bit whole numbers of picometres, little-endian; a
/// line as its characters; a tool as its number, its length and its radius.
pub type Value = Vec<u8, STORED_LINE_CHARS>;

/// One thing that a line can change, by its key. The key of a setting is its number, 999 at most. A key never means
/// another item, in any version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item(pub(super) u16);

/// The keys of the places: the origins of G54 to G59, then where G28 and G30 go to.
const FIRST_PLACE: u16 = 0x4000;
const FIRST_SYSTEMS: u16 = 6;
/// The keys of the start-up lines.
const FIRST_LINE: u16 = FIRST_PLACE + FIRST_SYSTEMS + 2;
/// The key of the user's text.
const TEXT: u16 = FIRST_LINE + STARTUP_LINES as u16;
/// The keys of the origins of G59.1 to G59.3.
const FIRST_MORE: u16 = TEXT + 1;
/// The keys of the places of the table of tools.
const FIRST_TOOL: u16 = FIRST_MORE + WORK_SYSTEMS as u16 - FIRST_SYSTEMS;
const END: u16 = FIRST_TOOL + TOOLS as u16;
/// A number of 32 bits, a length of 64, and a radius of 32.
const TOOL_BYTES: usize = 16;

/// References to all that is kept.
pub(crate) type KeptRefs<'a> =
    (&'a Settings, &'a Coordinates, &'a ToolTable, &'a [StoredLine; STARTUP_LINES], &'a StoredLine);

/// What an item is, by its key.
enum ItemKind {
    Setting(u16),
    System(usize),
    /// G28, G30.
    Place(usize),
    Line(usize),
    Text,
    Tool(usize),
}

impl Item {
    /// Every item.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..).map_while(Self::at)
    }

    /// The item with this index, in the order of the keys; `None` after the last.
    pub(super) fn at(index: u16) -> Option<Self> {
        let mut left = index;
        for row in SETTING_TABLE {
            let numbers = row.numbers();
            if left < numbers.len() as u16 {
                return Some(Self(numbers.start + left));
            }
            left -= numbers.len() as u16;
        }
        (left < END - FIRST_PLACE).then_some(Self(FIRST_PLACE + left))
    }

    pub(super) fn is_setting(self) -> bool {
        self.0 < FIRST_PLACE
    }

    fn kind(self) -> ItemKind {
        let from = |first| usize::from(self.0 - first);
        match self.0 {
            FIRST_TOOL..END => ItemKind::Tool(from(FIRST_TOOL)),
            FIRST_MORE..FIRST_TOOL => ItemKind::System(from(FIRST_MORE) + usize::from(FIRST_SYSTEMS)),
            TEXT => ItemKind::Text,
            FIRST_LINE..TEXT => ItemKind::Line(from(FIRST_LINE)),
            FIRST_PLACE..FIRST_LINE => match from(FIRST_PLACE).checked_sub(FIRST_SYSTEMS.into()) {
                None => ItemKind::System(from(FIRST_PLACE)),
                Some(place) => ItemKind::Place(place),
            },
            number => ItemKind::Setting(number),
        }
    }

    /// The length of its longest value.
    pub(super) fn bytes_max(self) -> usize {
        match self.kind() {
            ItemKind::Line(_) | ItemKind::Text => STORED_LINE_CHARS,
            ItemKind::System(_) | ItemKind::Place(_) => AXES * size_of::<i64>(),
            ItemKind::Tool(_) => TOOL_BYTES,
            ItemKind::Setting(_) => size_of::<f32>(),
        }
    }

    /// Its value, from these data.
    pub(crate) fn value(self, (settings, coordinates, tools, startup, text): KeptRefs<'_>) -> Value {
        let mut value = Value::new();
        let mut put = |bytes: &[u8]| {
            // There is room: the longest is a line.
            let _ = value.extend_from_slice(bytes);
        };
        match self.kind() {
            ItemKind::Text => put(text.as_bytes()),
            ItemKind::Line(index) => put(startup[index].as_bytes()),
            ItemKind::System(index) => coordinates.work_offsets_pm[index].iter().for_each(|pm| put(&pm.to_le_bytes())),
            ItemKind::Place(index) => coordinates.places_pm[index].iter().for_each(|pm| put(&pm.to_le_bytes())),
            ItemKind::Tool(place) => {
                let ToolEntry { number, length_pm, radius_nm } = tools.places()[place];
                put(&number.to_le_bytes());
                put(&length_pm.to_le_bytes());
                put(&radius_nm.to_le_bytes());
            }
            ItemKind::Setting(number) => put(&settings.get(number).unwrap_or_default().to_le_bytes()),
        }
        value
    }

    /// Sets it to a value; false if the value is not valid for it. An item that only another version knows has no
    /// effect.
    pub(super) fn set(self, value: &[u8], settings: &mut Settings, parameters: &mut Parameters) -> bool {
        let Parameters { coordinates, tools, startup, build_text } = parameters;
        let understood = match self.kind() {
            ItemKind::Text => line(value).map(|line| *build_text = line),
            ItemKind::Line(index) => line(value).map(|line| startup[index] = line),
            ItemKind::System(index) => place_pm(value).map(|place_pm| coordinates.work_offsets_pm[index] = place_pm),
            ItemKind::Place(index) => place_pm(value).map(|place_pm| coordinates.places_pm[index] = place_pm),
            ItemKind::Tool(place) => tool(value).map(|tool| tools.places_mut()[place] = tool),
            ItemKind::Setting(number) => float(value).map(|value| {
                settings.set(number, value);
            }),
        };
        understood.is_some()
    }
}

fn tool(value: &[u8]) -> Option<ToolEntry> {
    let (number, rest) = value.split_first_chunk()?;
    let (length_pm, rest) = rest.split_first_chunk()?;
    let tool = ToolEntry {
        number: u32::from_le_bytes(*number),
        length_pm: i64::from_le_bytes(*length_pm),
        radius_nm: u32::from_le_bytes(rest.try_into().ok()?),
    };
    let may_be = (-MAX_COORDINATE_PM..=MAX_COORDINATE_PM).contains(&tool.length_pm) && tool.radius_nm <= RADIUS_MAX_NM;
    may_be.then_some(tool)
}

fn float(value: &[u8]) -> Option<f32> {
    value.try_into().ok().map(f32::from_le_bytes)
}

/// A place in picometres, of three axes or four. Firmware that kept places in mm has stored them as 32-bit floats, of
/// three axes.
fn place_pm(value: &[u8]) -> Option<[i64; AXES]> {
    let width = match value.len() {
        12 => 4,
        24 | 32 => 8,
        _ => return None,
    };
    // Firmware with fewer axes has stored fewer, and what is stored of an axis that is not there means nothing.
    let mut place_pm = [0; AXES];
    for (pm, value) in place_pm.iter_mut().zip(value.chunks(width)) {
        let read_pm = match value.try_into() {
            Ok(bytes) => i64::from_le_bytes(bytes),
            Err(_) => float(value).filter(|mm| mm.is_finite()).map(|mm| length::from_mm(mm.into()))?,
        };
        *pm = Some(read_pm).filter(|pm| (-MAX_COORDINATE_PM..=MAX_COORDINATE_PM).contains(pm))?;
    }
    Some(place_pm)
}

fn line(value: &[u8]) -> Option<StoredLine> {
    core::str::from_utf8(value).ok()?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places that firmware for another number of axes has stored are understood, and so are those in mm.
    #[test]
    fn places_of_three_axes_and_of_four_are_understood() {
        let bytes = |places: &[i64]| places.iter().flat_map(|pm| pm.to_le_bytes()).collect::<Vec<u8, 64>>();
        for stored in [&[1, -2, 3][..], &[1, -2, 3, 0]] {
            let mut expected = [0; AXES];
            expected[..3].copy_from_slice(&[1, -2, 3]);
            assert_eq!(place_pm(&bytes(stored)), Some(expected));
        }
        let in_mm: Vec<u8, 12> = [1.5_f32, 0.0, -2.0].iter().flat_map(|mm| mm.to_le_bytes()).collect();
        assert_eq!(place_pm(&in_mm).map(|pm| pm[0]), Some(1_500_000_000));
        for wrong in [&bytes(&[1, 2])[..], &bytes(&[1; 5]), &[0; 13], &bytes(&[MAX_COORDINATE_PM + 1, 0, 0])] {
            assert_eq!(place_pm(wrong), None);
        }
    }
}
