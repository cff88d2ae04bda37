//! The Grbl 1.1 dialect without input or output: bytes in, commands out; replies and status in, bytes out.
//!
//! ```text
//! byte -> realtime::classify --(not real-time)--> LineAssembler -> Interpreter -> Command
//! Settings, Modal, StatusReport, Error, AlarmCode -> report, StatusReporter -> bytes
//! real-time byte -> Overrides
//! ```
//!
//! Nothing here reads a clock, awaits or allocates: the caller brings the bytes, the machine's [`ReportedState`] and
//! the [`Settings`]. A line that ends in an error leaves every modal value as it was.
//!
//! ```
//! use isostep_console::{Block, Command, Interpreter, LineAssembler, BlockMove, PathControl, Rate, Settings, ReportedState};
//!
//! let (mut lines, mut interpreter) = (LineAssembler::new(), Interpreter::new());
//! for &byte in b"g1 x10 (a comment) f600\n" {
//!     let Some(line) = lines.push(byte) else { continue };
//!     let command = line.and_then(|line| interpreter.interpret(line, ReportedState::Idle, &Settings::DEFAULT));
//!     let rate = Rate::Feed { mm_min: 600.0 };
//!     let motion = Some(BlockMove { target_pm: [10_000_000_000, 0, 0], rate, arc: None, path: PathControl::Blend });
//!     assert_eq!(command, Ok(Command::Block(Block { motion, ..Block::default() })));
//! }
//! ```
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod alarm;
mod arc;
mod axes;
mod catalogue;
mod codes;
mod command;
mod cycle;
mod error;
mod fixed;
mod interpreter;
pub mod length;
mod line;
mod modal;
mod overrides;
pub mod parameters;
mod path;
pub mod realtime;
mod refusal;
mod relation;
pub mod report;
mod rotary;
mod setting_error;
mod setting_form;
mod setting_table;
mod settings;
mod status;
mod system;
mod tools;
mod words;

pub use alarm::AlarmCode;
pub use arc::{Arc, ArcEnds, Chords, Misfit, Polygon, Within};
pub use axes::{AXES, AXIS_NAMES};
pub use catalogue::Catalogue;
pub use command::{Block, BlockMove, Command, DoorPhase, Jog, Probe, Rate, ReportedState};
pub use cycle::{Cycle, CyclePart, CycleProgress};
pub use error::Error;
pub use fixed::{Coordinate, Fixed};
pub use interpreter::{CycleFault, Interpreter, MAX_COORDINATE_PM, MIN_FEED_MM_MIN};
pub use line::{LineAssembler, MAX_LINE_CHARS};
pub use modal::{Coolant, Modal, MotionMode, PathControl, SpindleMode, ToolChange};
pub use overrides::Overrides;
pub use parameters::{Coordinates, Parameters};
pub use realtime::Realtime;
pub use refusal::{Explanation, Refusal, Unused, stopped_at};
pub use relation::{Conflict, Unfit};
pub use setting_error::SettingError;
pub use setting_form::{NamedValues, SettingGroup, SettingKind};
pub use setting_table::{Setting, TABLE as SETTING_TABLE};
pub use settings::{Carries, Settings};
pub use status::{StatusReport, StatusReporter};
pub use tools::{RADIUS_MAX_NM, TOOLS, ToolEntry, ToolTable};

/// The examples of the README are run as those here are.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
