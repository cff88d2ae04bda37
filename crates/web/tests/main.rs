//! The tests of this package, in one executable.

mod jobs;
mod live;
mod speed_profiles;
mod table;
