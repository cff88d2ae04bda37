//! What must never be, and what pages and pictures promise: the tests of this package, in one executable.

mod house;
mod names;
mod promises;
mod rules;
