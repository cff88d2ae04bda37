//! Timed dialogues with the whole controller in virtual time: what a sender sends, what it receives, and what moves.
//! They follow the tables of docs/console.md.

mod ahead;
mod arcs;
mod blends;
mod blends_beside;
mod blends_in_hand;
mod commands;
mod consoles;
pub mod drivers;
mod feeds;
pub mod heard;
mod homing;
mod laser;
mod light;
mod motion;
mod probe;
mod real_time;
mod reports;
mod senders;
mod senders_change_tools;
mod settings;
mod shapers;
mod stall;
mod stops;
mod tables;
pub mod talk;
mod tool;
mod unlike_axes;
mod wrong;

/// The dialogues of `tests/dialogues`.
mod text {
    include!(concat!(env!("OUT_DIR"), "/simulated.rs"));
}
