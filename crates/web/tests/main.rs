//! The tests of this package, in one executable.

mod jobs;
mod listing;
mod live;
mod quick;
mod speed_profiles;
mod table;
