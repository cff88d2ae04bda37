//! Makes one machine of the console and the motion.
//!
//! A [`Controller`] holds the settings and the program's modal state; [`Controller::serve`] runs one console (USB, a
//! UART, the simulator's link) against the [`Machine`](isostep_motion::Machine). Several consoles may be served at
//! once: each has its own lines and replies, and they share one machine, one modal state and one set of settings, which
//! a [`Store`] keeps in flash.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod arcs;
mod beyond;
mod boot;
mod commands;
mod config;
mod controller;
mod cycles;
#[cfg(feature = "trinamic")]
mod drivers;
mod input;
mod intake;
mod jogs;
pub mod least_times;
mod moves;
mod news;
mod output;
mod prove;
mod resets;
mod serve;
mod status;
pub mod store;
mod tool;
mod tool_change;
mod vfd;

pub use config::{carries_steps_s, config};
pub use controller::Controller;
#[cfg(feature = "trinamic")]
pub use drivers::{DriverHardware, Wire, exchange_time};
pub use isostep_console::{Error, Parameters, Settings};
pub use prove::Prove;
pub use serve::{FlowControl, LinkError};
pub use status::alarm_code;
pub use store::Store;
pub use vfd::{LineFormat, Parity, VFD_HEARD_BYTES_MAX, VFD_SENT_BYTES_MAX, VfdWire};
