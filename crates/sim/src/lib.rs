//! The controller in virtual time on the host.
pub mod config;
pub mod driver;
pub mod executor;
pub mod link;
pub mod measure;
pub mod motor;
mod outcome;
pub mod pin;
pub mod plant;
pub mod program;
mod sim;
pub mod stream;
pub mod time;
pub mod trace;
pub mod vcd;
pub mod verify;
pub mod world;

pub use config::{Config, StartOutside, Streaming};
pub use executor::RunError;
pub use outcome::{MoveRecord, Outcome};
pub use sim::{Sim, SimError, run};
