//! Compiles the published crates with the oldest Rust that they name. Clippy's `incompatible_msrv` knows functions that are
//! newer, but not syntax, and not what dependencies need.

use std::collections::BTreeMap;
use std::process::Command;

use anyhow::{Context, Result};
use serde::Deserialize;

use crate::process::{self, announce};
use crate::toolchain::RUSTUP_PATIENCE;
use crate::workspace;

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    rust_version: Option<String>,
    /// The registries that it may be published in; none of them for what is not published.
    publish: Option<Vec<String>>,
}

/// Checks them all but those that need the Rust of this computer, with which everything else is compiled. Where rustup
/// cannot add a toolchain, it says so and goes on.
pub fn check() -> Result<()> {
    let present = process::output(Command::new("rustc").arg("--version"), "install Rust by rustup")?;
    for (version, packages) in published(&metadata()?)? {
        if present.starts_with(&format!("rustc {version}.")) {
            continue;
        }
        announce(&format!("Rust {version}: {}", packages.join(", ")));
        if let Err(why) = add(&version) {
            println!("left out, because Rust {version} cannot be added: {why:#}");
            continue;
        }
        let mut check = rustup(&["run", &version, "cargo", "check", "--target-dir"]);
        check.arg(workspace::target_dir().join("oldest"));
        process::run(check.args(packages.iter().map(|name| format!("--package={name}"))))?;
    }
    Ok(())
}

fn metadata() -> Result<String> {
    let mut metadata = Command::new("cargo");
    metadata.current_dir(workspace::root()).args(["metadata", "--no-deps", "--format-version=1"]);
    process::output(&mut metadata, "install Rust by rustup")
}

/// The names of what is published, by the oldest Rust.
fn published(metadata: &str) -> Result<BTreeMap<String, Vec<String>>> {
    let metadata: Metadata = serde_json::from_str(metadata).context("what `cargo metadata` says")?;
    let mut by_version = BTreeMap::<_, Vec<_>>::new();
    for package in metadata.packages.into_iter().filter(|package| package.publish.is_none()) {
        let version = package.rust_version.with_context(|| format!("{} names no rust-version", package.name))?;
        by_version.entry(version).or_default().push(package.name);
    }
    Ok(by_version)
}

fn add(version: &str) -> Result<()> {
    if process::printed(&mut rustup(&["run", version, "rustc", "--version"])).is_some() {
        return Ok(());
    }
    let mut install = rustup(&["toolchain", "install", version, "--profile=minimal", "--no-self-update"]);
    process::run_within(install.env("RUSTUP_MAX_RETRIES", "0"), RUSTUP_PATIENCE)
}

fn rustup(args: &[&str]) -> Command {
    let mut rustup = Command::new("rustup");
    rustup.current_dir(workspace::root()).args(args);
    rustup
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_published_is_checked_and_nothing_else() {
        let by_version = published(&metadata().unwrap()).unwrap();
        let names: Vec<_> = by_version.into_values().flatten().collect();
        assert!(
            ["isostep", "isostep-profile", "isostep-host"].iter().all(|name| names.iter().any(|other| other == name))
        );
        assert!(!["xtask", "isostep-web"].iter().any(|name| names.iter().any(|other| other == name)));
    }

    #[test]
    fn a_crate_that_names_no_version_is_refused() {
        let metadata = r#"{ "packages": [{ "name": "old", "rust_version": null, "publish": null }] }"#;
        assert_eq!(published(metadata).unwrap_err().to_string(), "old names no rust-version");
    }
}
