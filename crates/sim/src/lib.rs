//! The controller in virtual time on the host.
pub mod config;
pub mod driver;
pub mod executor;
mod figures;
pub mod link;
pub mod measure;
pub mod motor;
mod outcome;
pub mod pin;
pub mod plant;
pub mod program;
pub mod report;
mod sim;
pub mod stream;
pub mod time;
pub mod trace;
pub mod vcd;
pub mod verify;
pub mod world;

pub use isostep_console::Error as ConsoleError;
pub use isostep_motion::State;

pub use config::{Config, StartOutside, Streaming};
pub use executor::RunError;
pub use figures::{Figures, MoveFigures};
pub use outcome::{MoveRecord, Outcome};
pub use plant::SwitchFault;
pub use sim::{Sim, SimError, run};
