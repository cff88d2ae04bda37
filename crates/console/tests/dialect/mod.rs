//! Tests of the dialect as dialogues: what a sender sends, what it receives, and what the machine is asked to do.

mod arcs;
mod bad_input;
mod coordinates;
mod cycles;
#[cfg(feature = "trinamic")]
mod drivers;
mod gcode;
mod probe;
mod reported;
mod status;
mod system;
mod talk;
mod tool;
mod tools;
mod unknown;
