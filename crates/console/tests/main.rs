//! The tests of this package, in one executable.

mod dialect;
mod examples;
