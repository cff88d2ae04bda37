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
//! let before_ma = wire[1].setup().run_ma;
//! assert_eq!(wire.exchange(tell.bytes()), tell.bytes());
//! assert!(wire[1].setup().run_ma < before_ma);
//! ```

mod tmc2209;
mod wire;

use std::fmt;

use embassy_time::Timer;
use isostep_controller::exchange_time;

pub use self::tmc2209::Tmc2209;
pub use self::wire::Wire;
use crate::time::Clock;
use crate::world::Shared;

/// The settings of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriverSetup {
    /// Microsteps of a full step.
    pub microsteps: u16,
    /// Effective current of a motor that moves, mA.
    pub run_ma: u32,
    /// Effective current of one that stands, mA.
    pub hold_ma: u32,
    /// It chops by SpreadCycle now, not by StealthChop.
    pub is_spread_cycle: bool,
    /// It reports stalls: at some speed (`TCOOLTHRS`), below some load (`SGTHRS`).
    pub reports_stalls: bool,
}

/// A fault of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DriverFault {
    /// Its supply is off: it hears nothing and says nothing. When it comes back, its registers have their reset values.
    Off,
    /// Its reply is heard before the echo of the next datagram, not after that of its own.
    Late,
    /// A bit of every second reply is wrong.
    Garbled,
    /// Warmer than 120 degrees: `DRV_STATUS.otpw`.
    Hot,
    /// Warmer than 143 degrees: `DRV_STATUS.ot`, and the motor is off.
    Overheated,
    /// A phase is shorted to ground: `DRV_STATUS.s2ga`, and the motor is off. Both stay so when that is mended, until `TOFF` has
    /// been 0.
    Shorted,
    /// A coil is not connected: `DRV_STATUS.ola`.
    OpenCoil,
}

impl DriverFault {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Off, Self::Late, Self::Garbled, Self::Hot, Self::Overheated, Self::Shorted, Self::OpenCoil];

    /// Its bits of `DRV_STATUS`.
    pub(super) fn status(self) -> u32 {
        const OTPW: u32 = 1 | T120;
        const OT: u32 = 1 << 1 | T143;
        const OLA: u32 = 1 << 6;
        const T120: u32 = 1 << 8;
        const T143: u32 = 1 << 9;
        match self {
            Self::Hot => OTPW,
            Self::Overheated => OTPW | OT,
            Self::OpenCoil => OLA,
            // What a driver has found of a short, it keeps itself.
            Self::Shorted | Self::Off | Self::Late | Self::Garbled => 0,
        }
    }
}

impl fmt::Display for DriverFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::Late => "late",
            Self::Garbled => "garbled",
            Self::Hot => "hot",
            Self::Overheated => "overheated",
            Self::Shorted => "shorted",
            Self::OpenCoil => "open-coil",
        })
    }
}

/// That of the firmware.
const BAUD: u32 = 115_200;

/// The board's end of the wire, with the times of the firmware.
pub(crate) struct DriverWire {
    world: Shared,
    clock: Clock,
}

impl DriverWire {
    pub(crate) fn new(world: &Shared, clock: &Clock) -> Self {
        Self { world: world.clone(), clock: clock.clone() }
    }

    pub(crate) fn clock(&self) -> &Clock {
        &self.clock
    }
}

impl isostep_controller::Wire for DriverWire {
    async fn exchange(&mut self, sent: &[u8], heard: &mut [u8]) -> usize {
        let bytes = self.world.borrow_mut().exchange_with_drivers(sent);
        Timer::after(exchange_time(heard.len(), BAUD)).await;
        heard.iter_mut().zip(bytes).map(|(heard, byte)| *heard = byte).count()
    }
}
