//! The tests of this package, in one executable.

mod blended_corpus;
mod chains;
mod circle;
mod contract;
mod core_xy;
mod corpus;
mod dependencies;
mod dialect_model;
#[path = "dialogues/main.rs"]
mod dialogues;
mod documented;
mod homing;
mod preemption;
mod programs;
mod qemu;
mod rasters;
mod real_time_orders;
mod registers;
mod round;
mod seeks;
mod short_moves;
mod squared;
mod starts;
mod step_port;
mod step_tally;
mod store;
mod together;
mod turns;
mod vfd;
mod whole_steps;
mod words_corpus;

// What the dialogues share, by the paths that they name.
use dialogues::{drivers, heard, talk};
