//! The tests of this package, in one executable.

mod interrupted;
mod named;
mod printed;
mod swarm_shards;
