//! Figures and pictures of a simulated run, and what a program would do, told without a machine.
//!
//! The machine and its checks are in [`isostep_sim`]. Nothing here changes a run.
//!
//! - [`Figures`] are those of a run as one value, for a screen, a page or JSON. Parts of them are [`kinematics`], [`tool`],
//!   [`shaping`], which tells what shapers cost, and [`ringing`], which puts a load on a spring behind an axis and computes how it
//!   swings.
//! - [`pace`] says what limits the speed of a program.
//! - [`survey`] reads a program without a machine, and [`check`] says in words what would become of it on one. Their words are in
//!   [`remarks`] and [`pace::words`].
//! - [`listing`] reads the settings of another controller.
//! - [`speed_profiles`] puts speed profiles side by side.
//! - [`compare`] holds the trace of another machine against the plans of a run.
//! - [`again`] asks for the same program beside a run, without shapers or by the other rule at corners.
//! - `pictures`, a feature that is there by default, draws all of it on a page.
#![forbid(unsafe_code)]

pub mod again;
pub mod check;
pub mod compare;
mod digits;
pub mod fastest;
mod figures;
pub mod kinematics;
pub mod listing;
pub mod pace;
#[cfg(feature = "pictures")]
pub mod pictures;
pub mod remarks;
pub mod ringing;
pub mod shaping;
pub mod speed_profiles;
pub mod survey;
pub mod timing;
pub mod tool;

pub use figures::{Figures, Listed, MoveFigures};

/// The examples of the README are run as those here are.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
