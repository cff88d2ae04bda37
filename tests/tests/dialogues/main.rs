//! Timed dialogues with the whole controller in virtual time: what a sender says, what it hears, what moved.

mod motion;
mod talk;
