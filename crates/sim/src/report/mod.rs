//! A page of pictures and tables about a run: one HTML file, nothing loaded from elsewhere, the same bytes for the
//! same run.

pub mod bench;
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
