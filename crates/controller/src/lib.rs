//! Isostep controller.
#![no_std]
#![forbid(unsafe_code)]
