//! The tests of this package, in one executable.

mod examples;
mod frequency_law;
mod generators;
mod staircase;
