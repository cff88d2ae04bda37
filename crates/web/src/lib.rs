//! The simulated machine for a page: it runs in pieces of machine time and is checked on the way. What a page has taken is
//! forgotten, so that memory does not grow with the program.
//!
//! ```text
//!             program, settings                       bytes, contacts
//!                    |                                      |
//! Streamed <------- Job                                    Live -------> Sim
//!                    |                                      |
//!                    +-- pieces -- Watch: Gathered, Motion, trace
//! ```
//! - [`Job`] runs a whole program, with the sender of isostep-sim: its edges are those of [`isostep_sim::run`].
//! - [`Live`] is a machine to operate.
//! - [`Motion`] is how axes move, in phases that a page can draw, and [`Lines`] which line moves them.
//! - [`table`] is what a form of settings is made from.
//! - [`Quick`] runs a program for its time alone, and [`ringing`] tells how loads would swing.
//! - [`listing`] reads a `$$` of another controller.
//! - [`whole`] says what the tool says of a whole program.
//!
//! Only `bindings` knows JavaScript. All else runs, and is tested, on a computer.
#![forbid(unsafe_code)]

#[cfg(target_arch = "wasm32")]
mod bindings;
mod departures;
mod job;
mod lines;
pub mod listing;
mod live;
mod motion;
#[cfg(target_arch = "wasm32")]
mod panic;
pub mod piece;
mod power;
mod quick;
pub mod ringing;
mod sent;
pub mod speed_profiles;
mod summary;
pub mod table;
mod trouble;
mod watch;
pub mod whole;

pub use departures::Departures;
pub use job::{End, Job, Kept};
pub use lines::Lines;
pub use live::Live;
pub use motion::{COLUMNS, Kind, LOAD_PARTS, LOADS, Motion};
pub use power::Power;
pub use quick::{Found, Quick};
pub use trouble::{About, Trouble};

use isostep_sim::Config;
use isostep_sim::settings;

/// The examples of the README are run as those here are.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// The default machine with these settings, lines of `$n=v`; none for all defaults.
fn config(lines: &str) -> Result<Config, Trouble> {
    // Changes of wires are most of a record, and nothing here shows them.
    let mut config = Config { keep_waves: false, ..Config::default() };
    if !lines.trim().is_empty() {
        config.settings = settings::read("settings", lines.as_bytes(), config.port, config.driver)?;
    }
    config.check()?;
    Ok(config)
}
