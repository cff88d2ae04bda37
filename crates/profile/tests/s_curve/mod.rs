//! The S-curve, compared with its limits and with a published planner, on random moves.
//!
//! Every random move follows from its number, so every run tries the same ones. A failure prints the move and the
//! command that tries it alone: `S_CURVE_CASE=n cargo test -p isostep-profile s_curve`.
//!
//! The comparison of its durations with those of Ruckig is printed by
//! `cargo test -p isostep-profile s_curve::ruckig -- --nocapture` (computed on the host).

mod case;
mod limits;
mod phases;
mod ruckig;
mod shape;
