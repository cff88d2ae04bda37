//! Moves that follow each other without a stop, compared with a slow and obvious computation of how fast they may be,
//! and with their limits. Every run tries the same cases. A failure prints the smallest case, and the same command
//! fails again; `PROPTEST_RNG_SEED=n cargo test -p isostep-profile chain::` tries others.

mod bent;
mod blends;
mod case;
mod drive;
mod edges;
mod follow;
mod found;
mod holds;
mod late;
mod lengthened;
mod model;
mod optimum;
mod overrides;
mod pushes;
mod sees;
mod shaped;
