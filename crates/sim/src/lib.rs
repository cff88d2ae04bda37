//! The controller in virtual time on the host.
pub mod config;
pub mod driver;
pub mod executor;
pub mod link;
pub mod motor;
pub mod pin;
pub mod plant;
pub mod program;
pub mod stream;
pub mod time;
pub mod trace;
pub mod vcd;
pub mod world;
