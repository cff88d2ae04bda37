//! Stepper drivers that are set up by registers: TMC2209s on one wire, as a board hears them.
//!
//! A driver has the registers of its data sheet, and what a motor does to them is told to it: speed, load and steps. It
//! measures the load where a full step ends. It has no clock: whoever tells it the speed must do so too when the motor has
//! come to rest. A reply is there at once, whatever `NODECONF` says, and the current goes from run to hold when the motor
//! stands. Thresholds of speed have no hysteresis. Nor are there coils: `MSCURACT`, `PWM_SCALE` and `PWM_AUTO` read 0,
//! `COOLCONF` and `VACTUAL` are kept without effect.
//!
//! ```
//! use isostep_sim::drivers::Wire;
//! use tmc2209::reg::CHOPCONF;
//! use tmc2209::{ReadRequest, WriteRequest};
//!
//! let mut wire = Wire::new([0, 2, 1, 3]);
//! let ask = ReadRequest::new::<CHOPCONF>(2);
//! assert_eq!(wire.exchange(ask.bytes()), [ask.bytes(), &[5, 0xFF, 0x6C, 0x10, 0, 0, 0x53, 0x51]].concat());
//!
//! let tell = WriteRequest::new(2, CHOPCONF::from(0x1002_0053));
//! let before_ma = wire.run_current_ma(1);
//! assert_eq!(wire.exchange(tell.bytes()), tell.bytes());
//! assert!(wire.run_current_ma(1) < before_ma);
//! ```

mod board;
mod datagram;
mod fault;
mod tmc2209;
mod wire;

pub(crate) use board::DriverWire;
pub use fault::DriverFault;
pub use wire::{DriverSetup, Wire};
