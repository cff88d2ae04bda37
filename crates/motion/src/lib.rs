//! Isostep motion.
#![no_std]
#![forbid(unsafe_code)]
