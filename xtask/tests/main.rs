//! The tests of this package, in one executable.

mod options;
mod stand_ins;
