//! Tests of the dialect as dialogues: what a sender sends, what it receives, and what the machine is asked to do.

mod arcs;
mod bad_input;
mod coordinates;
mod gcode;
mod probe;
mod status;
mod system;
mod talk;
mod tool;
