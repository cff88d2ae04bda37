//! A dry run of publishing: each crate that could be published compiles from what would be uploaded.

use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result};

use crate::{process, workspace};

/// The parts of cargo's home that are used as they are: what has been downloaded already.
const DOWNLOADED: [&str; 3] = ["config.toml", "registry/index", "registry/cache"];

/// Packs and compiles all of them. Cargo unpacks our packages to verify them, and would take those of an earlier commit for
/// them, whose version is the same. So it unpacks and compiles in a folder that is made anew.
pub fn check() -> Result<()> {
    let home = workspace::target_dir().join("publish");
    if home.exists() {
        fs::remove_dir_all(&home).with_context(|| format!("{} cannot be emptied", home.display()))?;
    }
    fs::create_dir_all(home.join("registry")).with_context(|| format!("{} cannot be made", home.display()))?;
    let users = cargo_home().context("cargo's home is not known: set CARGO_HOME")?;
    for part in DOWNLOADED {
        link(&users.join(part), &home.join(part))?;
    }
    let mut publish = Command::new("cargo");
    publish.current_dir(workspace::root()).args(["publish", "--workspace", "--dry-run", "--target-dir"]);
    // Nobody debugs what is compiled there.
    publish.arg(home.join("target")).env("CARGO_HOME", &home).env("CARGO_PROFILE_DEV_DEBUG", "0");
    process::run(&mut publish)
}

fn cargo_home() -> Option<PathBuf> {
    env::var_os("CARGO_HOME").map(PathBuf::from).or_else(|| Some(env::home_dir()?.join(".cargo")))
}

#[cfg(unix)]
fn link(of: &std::path::Path, at: &std::path::Path) -> Result<()> {
    std::os::unix::fs::symlink(of, at).with_context(|| format!("{} cannot be made", at.display()))
}

/// Nothing: cargo downloads once more what it needs.
#[cfg(not(unix))]
fn link(_of: &std::path::Path, _at: &std::path::Path) -> Result<()> {
    Ok(())
}
