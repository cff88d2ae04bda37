//! A model of the dialect, written from docs/console.md, docs/programs.md, docs/moves.md and Grbl's documents, not from
//! the code; and random programs that are run on it and on the simulated machine. After each line the machine must
//! report what the model says.
//!
//! Lengths are whole numbers of angstroms (1e-7 mm), in which inches are exact too. The carriages may be away from a
//! place by half a step.

mod arcs;
mod bench;
mod block;
mod bytes;
mod console;
mod cycles;
mod job;
mod line;
mod machine;
mod modes;
mod program;
mod report;
mod settings;
mod tools;
mod words;

pub use bench::run;
pub use console::{run_holes, run_lengths};
pub use job::{Followed, follow};
pub use tools::TOOLS_MAX;
