//! Paths in the workspace.

use std::path::PathBuf;

use isostep::chip::Chip;
pub use xtask_first::workspace::{emulator_dir, root, shown, target_dir};

/// The name of the package and of the binary of the gantry's firmware.
pub const FIRMWARE: &str = "pico-gantry";
/// The name of the package and of the binary of the firmware that measures its own run time.
pub const BENCH_FIRMWARE: &str = "rp2040-bench";
/// The name of the package and of the binary of the template of a board.
pub const TEMPLATE_BOARD: &str = "qemu-lm3s6965";
/// The RP2040's cores are Cortex-M0+. For such a core the other firmwares are compiled, too.
pub const FIRMWARE_TARGET: &str = "thumbv6m-none-eabi";
/// The RP2350's are Cortex-M33, of which the FPU is left alone: it computes no doubles, and interrupts would have to save its
/// registers.
pub const RP2350_TARGET: &str = "thumbv8m.main-none-eabi";

/// The compiler's target for a chip.
pub fn target(chip: Chip) -> &'static str {
    match chip {
        Chip::Rp2040 => FIRMWARE_TARGET,
        Chip::Rp2350 => RP2350_TARGET,
    }
}

/// The profile in which Cargo builds a board's firmware: the template's chip has less flash than the fast one takes.
pub fn profile(package: &str) -> &'static str {
    if package == TEMPLATE_BOARD { "small" } else { "release" }
}

/// A board's firmware with its symbols.
pub fn elf(target: &str, package: &str) -> PathBuf {
    target_dir().join(target).join(profile(package)).join(package)
}

/// The emulated board, which Node runs.
pub fn emulator() -> PathBuf {
    emulator_dir().join("run.mjs")
}
