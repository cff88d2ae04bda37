//! The tests of this package, in one executable.

mod jobs;
mod laws;
mod live;
mod table;
