//! What the end-to-end tests share: the firmware on the emulated board.

pub mod emulated;
