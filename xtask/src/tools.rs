//! Installs tools from crates.io in a fixed version under `target/tools`.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::process::{self, announce};
use crate::workspace;

/// The path of a tool's binary, which has the same name as its package. Installs the tool if this version is missing.
pub fn installed(name: &str, version: &str) -> Result<PathBuf> {
    let root = workspace::target_dir().join("tools");
    let binary = root.join("bin").join(name).with_extension(std::env::consts::EXE_EXTENSION);
    // The marker records the version, because not every tool reports its own.
    let marker = root.join(format!("{name}-{version}"));
    if binary.is_file() && marker.is_file() {
        return Ok(binary);
    }
    announce(&format!("cargo install {name}@{version}, into {} (some minutes, once)", workspace::shown(&root)));
    let mut install = Command::new("cargo");
    // Without optimisation: compiling a tool takes longer than running it.
    install.args(["install", &format!("{name}@{version}"), "--debug", "--locked", "--force", "--root"]).arg(&root);
    install.env("CARGO_PROFILE_DEV_DEBUG", "0");
    process::run(&mut install)?;
    std::fs::write(&marker, "")?;
    Ok(binary)
}
