//! The promises, each a test of ports. One that is broken panics, with what was seen.

mod edges;
mod faults;
mod reversals;
mod starts;
mod stops;

pub use edges::*;
pub use faults::*;
pub use reversals::*;
pub use starts::*;
pub use stops::*;
