//! The tests of this package, in one executable.

mod expressions;
mod flow;
mod made;
mod parameters;
mod plain;
mod refused;
mod subprograms;
