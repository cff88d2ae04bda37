//! Speed laws side by side: their steps, and their figures as `isostep profile` prints them.

mod curve;
mod differences;
mod exact;
mod table;

pub use self::curve::{Curve, Step, steps_at};
pub use self::differences::{by_differences, differences, peak, peak_mean};
pub use self::exact::Exact;
pub use self::table::{Row, rows};

/// The largest number of steps of a move. It is bounded because every step is kept for table, file and picture.
pub const STEPS_MAX: u32 = 1_000_000;
