//! Moves that follow each other without a stop, against a slow and obvious reckoning of how fast they may be, and against
//! their limits; the same in every run. A failure prints the smallest case, and the same command fails again;
//! `PROPTEST_RNG_SEED=n cargo test -p isostep-profile --test chain` tries others.

mod case;
mod drive;
mod edges;
mod follow;
mod holds;
mod model;
mod optimum;
mod overrides;
mod pushes;
