#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod cursor;
mod expression;
mod glance;
mod label;
mod number;
mod operation;
mod parameters;
mod problem;
mod run;
mod structure;
mod tool_comment;
mod words;

pub use problem::{LineError, Problem};
pub use run::{PlainLine, PlainLines};
pub use tool_comment::{ToolAsked, changes_tool, tool_comment, tools_asked};

/// Subroutines that may be under way at a time, one called by another.
pub const NESTED_CALLS_MAX: usize = 32;
/// Values that may be read one in another: brackets, functions, signs and parameters whose number is a parameter's value.
pub const NESTED_VALUES_MAX: usize = 32;
/// Lines that may be carried out without one for the machine.
pub const STATEMENTS_MAX: u32 = 1_000_000;
/// Lines that may be made for the machine, if the file does not have more.
pub const LINES_MADE_MAX: usize = 1_000_000;

/// The plain lines of a program, whose lines `source` has without their line ends. They are made as they are asked for.
///
/// # Errors
/// [`LineError`] if its blocks do not fit: then no line is made. What is wrong with a line that is carried out is an error of the
/// iterator.
pub fn plain_lines<L: AsRef<[u8]>>(source: &[L]) -> Result<PlainLines<'_, L>, LineError> {
    PlainLines::new(source)
}
