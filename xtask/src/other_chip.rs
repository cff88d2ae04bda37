//! The firmwares of boards/stm32g474: the crates on another chip, by its HAL. They are compiled and linked, as by whoever
//! begins with them: by the default toolchain, in the release profile. Nothing here can run them.

use std::process::Command;

use crate::toolchain;

const PACKAGE: &str = "stm32g474";
/// A Cortex-M4 that computes floats of 32 bits.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The remedy where the target cannot be had. It is added if rustup can do that.
pub fn missing() -> Option<String> {
    toolchain::add_target(TARGET).err().map(|error| format!("{error:#}"))
}

/// `cargo VERB` for the firmwares.
pub fn cargo(verb: &str) -> Command {
    let mut command = toolchain::cargo(verb);
    command.args(["--release", "--package", PACKAGE, "--target", TARGET]);
    command
}
