//! What may be wrong with a driver.

use std::fmt;

/// What may be wrong with a driver.
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
