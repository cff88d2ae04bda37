//! What a tool did in a run.

mod beginnings;
pub mod figures;
pub(crate) mod spells;
