//! A page of pictures and tables about a run: one HTML file, which loads nothing except the picture of what a laser
//! engraved, a file beside it. The same run gives the same bytes.

pub mod bench;
mod by_accel;
pub mod chart;
pub mod document;
mod engraving;
mod errors;
mod kinematics;
mod moves;
mod page;
mod path;
mod plane;
pub mod profile;
mod ringing;
mod scales;
mod speed;
mod strokes;
pub mod theme;
mod time;
mod together;

pub use page::{BothRules, page};
