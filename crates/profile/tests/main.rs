//! The tests of this package, in one executable.

mod chain;
mod examples;
mod papers;
mod phases;
mod properties;
mod refusals;
mod s_curve;
mod segments;
mod shaper;
mod speed_profiles;
