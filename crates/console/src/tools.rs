//! The table of tools, which G10 L1, L10 and L11 fill and G43 reads.

use crate::Error;

/// The number of tools of which lengths are kept.
pub const TOOLS: usize = 32;
/// The largest radius of a tool, nm.
pub const RADIUS_MAX_NM: u32 = 1_000_000_000;
pub(crate) const NM_PM: i64 = 1_000;

/// A tool of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ToolEntry {
    /// Its number; 0 for a place of the table that is free.
    pub number: u32,
    /// Its length along Z, in [picometres](crate::length).
    pub length_pm: i64,
    /// Its radius, nm, at most [`RADIUS_MAX_NM`]. It is kept for the operator: no move depends on it.
    pub radius_nm: u32,
}

/// Up to [`TOOLS`] tools by any numbers. A tool that is not in it has length 0 and radius 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ToolTable([ToolEntry; TOOLS]);

impl ToolTable {
    /// The tool of this number.
    #[must_use]
    pub fn tool(&self, number: u32) -> ToolEntry {
        let found = self.0.iter().find(|tool| tool.number == number && number != 0);
        found.copied().unwrap_or(ToolEntry { number, ..ToolEntry::default() })
    }

    /// The tool with the lowest number above this one.
    #[must_use]
    pub fn next_above(&self, number: u32) -> Option<&ToolEntry> {
        self.0.iter().filter(|tool| tool.number > number).min_by_key(|tool| tool.number)
    }

    /// Puts a tool into the table, in place of what it has by its number. One with neither length nor radius leaves its place
    /// free.
    ///
    /// # Errors
    /// [`Error::ToolNumber`] if all places are taken by other tools.
    pub fn put(&mut self, tool: ToolEntry) -> Result<(), Error> {
        let is_nothing = tool.length_pm == 0 && tool.radius_nm == 0;
        let own = self.0.iter().position(|other| other.number == tool.number);
        let place = own.or_else(|| self.0.iter().position(|other| other.number == 0));
        match place {
            Some(place) if is_nothing => self.0[place] = ToolEntry::default(),
            Some(place) => self.0[place] = tool,
            None if is_nothing => {}
            None => return Err(Error::ToolNumber),
        }
        Ok(())
    }

    /// The places of the table, taken or free, as a store keeps them.
    #[must_use]
    pub fn places(&self) -> &[ToolEntry; TOOLS] {
        &self.0
    }

    /// As [`places`](Self::places), but mutable. No two may have the same number.
    pub fn places_mut(&mut self) -> &mut [ToolEntry; TOOLS] {
        &mut self.0
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    fn of(number: u32, length_pm: i64) -> ToolEntry {
        ToolEntry { number, length_pm, ..ToolEntry::default() }
    }

    #[test]
    fn tools_are_found_by_their_numbers_and_listed_in_their_order() {
        let mut table = ToolTable::default();
        for tool in [of(606, 5), of(1, -3), of(99_999, 1), of(7, 2)] {
            assert_eq!(table.put(tool), Ok(()));
        }
        assert_eq!((table.tool(606), table.tool(2)), (of(606, 5), of(2, 0)));
        let listed = || core::iter::successors(table.next_above(0), |tool| table.next_above(tool.number));
        assert_eq!(listed().map(|tool| tool.number).collect::<Vec<_>>(), [1, 7, 606, 99_999]);
        assert_eq!(table.put(of(7, 0)), Ok(()));
        assert_eq!((table.tool(7), table.next_above(1).map(|tool| tool.number)), (of(7, 0), Some(606)));
        assert_eq!(table.tool(0), of(0, 0), "a free place is no tool");
    }

    #[test]
    fn a_full_table_takes_what_it_has_and_nothing_new() {
        let mut table = ToolTable::default();
        for number in 1..=TOOLS as u32 {
            assert_eq!(table.put(of(number, 10)), Ok(()));
        }
        let full = table;
        assert_eq!(table.put(of(33, 1)), Err(Error::ToolNumber));
        assert_eq!(table.put(of(33, 0)), Ok(()), "it is not in the table anyway");
        assert_eq!(table, full);
        assert_eq!(table.put(of(32, 11)), Ok(()));
        assert_eq!(table.tool(32), of(32, 11));
        assert_eq!((table.put(of(5, 0)), table.put(of(33, 1))), (Ok(()), Ok(())));
        assert_eq!((table.tool(5), table.tool(33)), (of(5, 0), of(33, 1)));
    }
}
