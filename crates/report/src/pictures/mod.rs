//! A page of pictures and tables about a run: one HTML file, which loads nothing except the picture of what a laser
//! engraved, a file beside it. The same run gives the same bytes.

pub mod bench;
mod both_rules;
mod by_accel;
pub mod chart;
pub mod document;
mod engraving;
mod errors;
mod kinematics;
mod moves;
mod other_rule;
mod page;
mod path;
mod plane;
pub mod profile;
mod rack;
mod ratio_scale;
mod ringing;
mod speed;
mod speed_scale;
mod strokes;
pub mod theme;
mod time;

pub use both_rules::BothRules;
pub use other_rule::other_rule;
pub use page::page;
