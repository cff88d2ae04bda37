//! Isostep profile.
#![no_std]
#![forbid(unsafe_code)]
