//! Paths in the workspace.

use std::env;
use std::path::{Path, PathBuf};

/// The folder of the root `Cargo.toml`.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("xtask/first lies in the workspace")
}

/// Cargo's output folder: `CARGO_TARGET_DIR`, otherwise `target`.
pub fn target_dir() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), |dir| root().join(dir))
}

/// The emulated board's Node package.
pub fn emulator_dir() -> PathBuf {
    root().join("tests").join("emulator")
}

/// `path` as a user in the root folder would write it.
pub fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}
