//! A page of pictures and tables about a run: one HTML file, nothing loaded from elsewhere but what a laser engraved, which is a
//! picture beside it; the same bytes for the same run.

pub mod bench;
mod engraving;
mod errors;
mod kinematics;
mod moves;
mod page;
pub mod papers;
mod path;
pub mod profile;
mod rack;
mod speed;
mod speed_scale;
mod strokes;
mod theme;
mod time;

pub use page::{files, page};
