//! The tests of this package, in one executable.

mod common;
mod config;
mod shaping;
