//! The chip: what differs between an RP2040 and an RP2350A, each in a file that has the same names. The target decides which it is
//! (`build.rs`). All other code is that of both, but for the names of interrupt handlers.

#[cfg(not(rp2350))]
#[allow(dead_code, reason = "not every image uses all of it")]
mod rp2040;
#[cfg(rp2350)]
#[allow(dead_code, reason = "not every image uses all of it")]
mod rp2350;

#[cfg(not(rp2350))]
pub use self::rp2040::*;
#[cfg(rp2350)]
pub use self::rp2350::*;
