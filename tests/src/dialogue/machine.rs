//! The needs of a dialogue: the simulated one has it, and the emulated board.

use super::step::{Step, With};

/// Steps of each axis.
#[derive(Debug, Default)]
pub struct Counts {
    /// The steps since power-up or homing, upwards less downwards.
    pub counted: Vec<i64>,
    /// The steps since power-up in either direction.
    pub made: Vec<i64>,
    /// The places of the carriages, steps from their switches.
    pub places: Vec<i64>,
}

/// A machine that dialogues are carried out on. Errors say what was found.
pub trait Machine: Sized {
    /// The largest difference between a duty that is written and that of the output, of 65,535.
    const DUTY_TOLERANCE: u16;

    /// A new machine. `name` is that of the dialogue.
    fn power_up(name: &str, changes: &[With]) -> Result<Self, String>;
    /// Switches power off and on.
    fn power_cycle(&mut self, changes: &[With]) -> Result<(), String>;
    /// The time within which it sends its welcome, ns.
    fn starts_within_ns(&self) -> u64;
    /// Bytes for a console.
    fn send(&mut self, console: usize, bytes: &[u8]) -> Result<(), String>;
    /// Lets time pass.
    fn run_for(&mut self, time_ns: u64) -> Result<(), String>;
    /// Lets time pass until nothing can happen any more.
    fn settle(&mut self) -> Result<(), String>;
    /// The lines that a console has received since this was called last.
    fn replies(&mut self, console: usize) -> Vec<String>;
    /// The time since power-up, ns.
    fn now_ns(&self) -> u64;
    /// The steps so far.
    fn counts(&mut self) -> Result<Counts, String>;
    /// The duty of each output of the tool, of 65,535.
    fn tool(&mut self) -> Result<[u16; 5], String>;
    /// The time of the last step, ns.
    fn last_step_ns(&mut self) -> Option<u64>;
    /// When a move has ended, ns, counted from 1, without those of homing.
    fn end_of_move_ns(&self, count: usize) -> Option<u64>;
    /// Does what only this kind of machine knows how to do or to check.
    fn act(&mut self, step: &Step) -> Result<(), String>;
    /// Checks what must be true of every dialogue.
    fn end(self) -> Result<(), String>;
}
