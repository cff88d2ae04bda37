//! The tests of this package, in one executable.

mod bends;
mod chain;
mod corpus;
mod examples;
mod laws;
mod papers;
mod properties;
mod refusals;
mod s_curve;
mod segments;
mod shaper;
