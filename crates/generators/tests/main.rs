//! The tests of this package, in one executable.

mod examples;
mod frequency_ramp;
mod generators;
mod staircase;
