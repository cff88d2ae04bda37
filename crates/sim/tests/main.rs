//! The tests of this package, in one executable.

mod drivers;
mod examples;
mod hard_ends;
mod pieces;
mod stall;
mod stall_homing;
