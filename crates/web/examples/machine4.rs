//! The machine with a fourth axis, A, for a page: all of `isostep_web`, compiled with the feature `four-axes`. It is a target of its own,
//! so that neither machine is compiled anew because the other was.

pub use isostep_web::*;
