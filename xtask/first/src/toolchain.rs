//! Cargo for this computer, and the targets of its toolchain.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result};

use crate::process::{self, announce};
use crate::workspace;

/// Without a network, rustup retries for minutes. The largest download is some 20 MB.
pub const RUSTUP_PATIENCE: Duration = Duration::from_secs(120);

/// `cargo VERB` in the workspace.
pub fn cargo(verb: &str) -> Command {
    let mut command = plain_cargo(verb);
    command.arg("--target-dir").arg(workspace::target_dir());
    command
}

/// `cargo xtask`, to which everything behind it is an argument of its own.
pub fn cargo_xtask() -> Command {
    plain_cargo("xtask")
}

fn plain_cargo(verb: &str) -> Command {
    let mut command = cargo_here(verb);
    command.current_dir(workspace::root());
    command
}

/// `cargo VERB` in the present folder.
pub fn cargo_here(verb: &str) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.arg(verb);
    command
}

/// Flags that remove the path of the registry on this computer from panic messages. The paths would take flash, and
/// would make the firmware's size depend on who builds it.
pub fn short_paths() -> OsString {
    let cargo_home = env::var_os("CARGO_HOME").map(PathBuf::from).or_else(|| Some(env::home_dir()?.join(".cargo")));
    let registries = cargo_home.and_then(|home| home.join("registry/src").read_dir().ok());
    let mut flags = OsString::new();
    for registry in registries.into_iter().flatten().flatten() {
        flags.push(" --remap-path-prefix=");
        flags.push(registry.path().join(""));
        flags.push("=");
    }
    flags
}

/// Adds `target` to the toolchain if it is not there.
///
/// # Errors
/// The words of rustup, and what to do.
pub fn add_target(target: &str) -> Result<()> {
    if has_target(target) {
        return Ok(());
    }
    announce(&format!("rustup target add {target}"));
    let mut rustup = Command::new("rustup");
    rustup.current_dir(workspace::root()).env("RUSTUP_MAX_RETRIES", "0").args(["target", "add", target]);
    process::run_within(&mut rustup, RUSTUP_PATIENCE).with_context(|| remedy(target))
}

fn has_target(target: &str) -> bool {
    let mut rustc = Command::new("rustc");
    rustc.current_dir(workspace::root()).args(["--print", "target-libdir", "--target", target]);
    let Some(dir) = process::printed(&mut rustc) else { return false };
    let Ok(files) = Path::new(&dir).read_dir() else { return false };
    files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
}

fn remedy(target: &str) -> String {
    format!(
        "Rust's library for {target} is missing: where there is a network, `rustup target add {target}`; where there is none, \
         unpack rust-std-VERSION-{target}.tar.xz of https://static.rust-lang.org/dist, VERSION as of `rustc --version`, and run \
         its install.sh with --prefix=\"$(rustc --print sysroot)\""
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_that_cannot_be_had_is_named_with_the_remedy() {
        let error = format!("{:#}", add_target("pdp11-none-none").unwrap_err());
        assert!(error.contains("rust-std-VERSION-pdp11-none-none.tar.xz"), "{error}");
    }

    #[test]
    fn a_verb_of_xtask_gets_no_argument_of_cargo() {
        assert_eq!(cargo_xtask().get_args().collect::<Vec<_>>(), ["xtask"]);
        assert!(cargo("test").get_args().any(|argument| argument == "--target-dir"));
    }
}
