//! Paths in the workspace.

use std::env;
use std::path::{Path, PathBuf};

/// The name of the package and of the binary of the gantry's firmware.
pub const FIRMWARE: &str = "pico-gantry";
/// The name of the package and of the binary of the firmware that measures its own run time.
pub const BENCH_FIRMWARE: &str = "rp2040-bench";
/// The name of the package and of the binary of the template of a board.
pub const TEMPLATE_BOARD: &str = "qemu-lm3s6965";
/// The RP2040's cores are Cortex-M0+.
pub const FIRMWARE_TARGET: &str = "thumbv6m-none-eabi";

/// The folder of the root `Cargo.toml`.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace")
}

/// Cargo's output folder: `CARGO_TARGET_DIR`, otherwise `target`.
pub fn target_dir() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), |dir| root().join(dir))
}

/// The profile in which Cargo builds a board's firmware: the template's chip has less flash than the fast one takes.
pub fn profile(package: &str) -> &'static str {
    if package == TEMPLATE_BOARD { "small" } else { "release" }
}

/// A board's firmware with its symbols.
pub fn elf(package: &str) -> PathBuf {
    target_dir().join(FIRMWARE_TARGET).join(profile(package)).join(package)
}

/// A board's firmware in the format of the Pico's boot drive.
pub fn uf2(package: &str) -> PathBuf {
    elf(package).with_extension("uf2")
}

/// The gantry's firmware with its symbols.
pub fn firmware_elf() -> PathBuf {
    elf(FIRMWARE)
}

/// The gantry's firmware in the format of the Pico's boot drive.
pub fn firmware_uf2() -> PathBuf {
    uf2(FIRMWARE)
}

/// The emulated board's Node package.
pub fn emulator_dir() -> PathBuf {
    root().join("tests").join("emulator")
}

/// The emulated board, which Node runs.
pub fn emulator() -> PathBuf {
    emulator_dir().join("run.mjs")
}

/// `path` as a user in the root folder would write it.
pub fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}
