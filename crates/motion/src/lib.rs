//! Asynchronous axes, coordinator and homing, for any executor and any pins.
//!
//! One shared [`Machine`] ties a handful of never-ending tasks together. A board, or the simulator, spawns:
//!
//! - [`axis::run`], once for each axis, at a high priority: it hands each run to the axis's [`StepPort`], which takes
//!   compiled segments from the axis's queue and makes the edges.
//! - [`limit::watch`] and [`limit::watch_emergency_stop`], at a higher one: they debounce a switch and stop the
//!   axes.
//! - [`tool::run`], [`probing::watch`] and the tasks of [`buttons`], at that priority too: they serve spindle,
//!   laser and coolant; the probe; feed hold, cycle start and safety door.
//! - [`coordinator::run`], at a lower priority: it plans moves that follow each other, compiles them into the axes'
//!   queues ahead of time, starts all axes of a run at one instant, homes, and keeps the machine's state.
//!
//! Other tasks ask for motion through [`Machine`]. No task allocates, and none knows its executor or chip.
#![no_std]
#![forbid(unsafe_code)]

mod axes;
pub mod axis;
pub mod buttons;
mod chunks;
mod clock;
mod cold_path;
mod config;
pub mod coordinator;
mod effort;
mod event;
mod flow;
mod group;
mod homing;
mod kinematics;
pub mod limit;
mod link;
mod machine;
mod marks;
mod motor;
mod port;
pub mod probing;
mod run;
mod shaping;
mod sources;
mod start_barrier;
mod stream;
mod switch;
mod tag;
mod timer_port;
pub mod tool;

pub use axes::{AXES, Axis};
pub use cold_path::cold_path;
pub use config::{Config, ConfigError, HomingConfig, Squared, beside_steps, whole_steps};
pub use effort::{LeastTimes, RampTimes};
pub use event::{Alarm, Event, Finish, HomingPhase, SpindleFault, State, Unplannable};
pub use kinematics::Kinematics;
pub use machine::{Busy, Door, MOVES_AHEAD, Machine, Motion, Move, ProbeMove, Probed, SpeedOverrides, Status};
pub use motor::{GangedMotor, LimitInput, Motor, SecondMotor};
pub use port::{
    Capabilities, Direction, DriverTiming, Inhibit, Motors, PortFault, Run, StepCounter, StepPort, StreamItem,
    StreamQueue, Wiring, ticks_covering,
};
pub use shaping::Shaping;
pub use start_barrier::StartBarrier;
pub use switch::Contact;
pub use timer_port::{MotorPins, TimerBank, TimerPort};
pub use tool::{Duties, Level, Outputs, Power, Spindle, SpindleWanted, Switches, ToolConfig, ToolPort};
