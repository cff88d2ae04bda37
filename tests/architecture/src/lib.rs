//! A package for its tests alone, so that they build in a second: `cargo test -p isostep-architecture`.
