//! Timed dialogues with the whole controller in virtual time: what a sender sends, what it receives, and what moves.
//! They follow the tables of docs/console.md.

mod ahead;
mod alarms;
mod arcs;
mod blends;
mod blends_beside;
mod blends_in_hand;
mod commands;
mod consoles;
mod door;
mod drivers;
mod dwell;
mod errors;
mod feeds;
mod heard;
mod homing;
mod laser;
mod light;
mod motion;
mod probe;
mod real_time;
mod reports;
mod resets;
mod senders;
mod settings;
mod shapers;
mod stall;
mod states;
mod stops;
mod stored;
mod tables;
mod talk;
mod tool;
mod unlike_axes;
mod words;
