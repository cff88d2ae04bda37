//! The tests of this package, in one executable.

mod corpus;
mod engraving;
mod equal_bytes;
mod listing;
mod long;
mod motors;
mod ringing;
mod shaped;
