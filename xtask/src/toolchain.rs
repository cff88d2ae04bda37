//! Cargo for the host and for the chips. The targets are those of rust-toolchain.toml, which rustup installs by itself
//! where it may; otherwise they are added here.

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

/// Without these the compiler computes both sides of a short branch and selects one of them. It takes an operation on
/// floats for a cheap one, but on the chip each is a call. That cost 2.5 % of the short moves a second.
const NO_SPECULATION: &str = " -Cllvm-args=-speculate-one-expensive-inst=false\
    \x20-Cllvm-args=-two-entry-phi-node-folding-threshold=1";

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
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(workspace::root()).arg(verb);
    command
}

/// `cargo VERB` for a board's package and the target of its chip, in its profile, with these features and no others.
pub fn firmware_cargo(verb: &str, target: &str, package: &str, features: &[&str]) -> Command {
    let mut command = cargo(verb);
    command.args(["--profile", workspace::profile(package), "--package", package, "--target", target]);
    command.args(["--no-default-features", &format!("--features={}", features.join(","))]);
    let mut flags = short_paths();
    flags.push(NO_SPECULATION);
    command.env(format!("CARGO_TARGET_{}_RUSTFLAGS", target.to_uppercase().replace(['-', '.'], "_")), flags);
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

/// The folders of PATH.
pub fn path_dirs() -> impl Iterator<Item = PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&path).collect::<Vec<_>>().into_iter()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::workspace::{FIRMWARE_TARGET, RP2350_TARGET};

    /// So whoever has rustup and a network has them with the first command.
    #[test]
    fn every_target_stands_in_rust_toolchain_toml() {
        let file = fs::read_to_string(workspace::root().join("rust-toolchain.toml")).unwrap();
        let listed = file.lines().find_map(|line| line.strip_prefix("targets = ")).unwrap();
        for target in [FIRMWARE_TARGET, RP2350_TARGET, crate::other_chip::TARGET, crate::web::TARGET] {
            assert!(listed.contains(&format!("\"{target}\"")), "{target} is not in {listed}");
        }
    }

    #[test]
    fn a_target_that_cannot_be_had_is_named_with_the_remedy() {
        let error = format!("{:#}", add_target("pdp11-none-none").unwrap_err());
        assert!(error.contains("rust-std-VERSION-pdp11-none-none.tar.xz"), "{error}");
    }

    /// Toolchains installed for the whole computer, and a compiler that is told to be another, are no business of a build.
    #[test]
    fn nothing_is_installed_as_root_and_no_compiler_is_told_to_be_a_nightly() {
        let sources = workspace::root().join("xtask").join("src").read_dir().unwrap();
        for source in sources.map(|file| file.unwrap().path()).filter(|path| path.is_file()) {
            let text = fs::read_to_string(&source).unwrap();
            for word in [["RUSTC", "BOOTSTRAP"].join("_"), ["Command::new(\"apt", "get\")"].join("-")] {
                assert!(!text.contains(&word), "{word} in {}", source.display());
            }
        }
    }

    #[test]
    fn cargo_is_told_the_flags_of_the_target_that_it_compiles_for() {
        for (target, variable) in [
            (FIRMWARE_TARGET, "CARGO_TARGET_THUMBV6M_NONE_EABI_RUSTFLAGS"),
            (RP2350_TARGET, "CARGO_TARGET_THUMBV8M_MAIN_NONE_EABI_RUSTFLAGS"),
        ] {
            let command = firmware_cargo("build", target, workspace::FIRMWARE, &[]);
            assert!(command.get_envs().any(|(name, value)| name == variable && value.is_some()), "{command:?}");
        }
    }

    #[test]
    fn a_verb_of_xtask_gets_no_argument_of_cargo() {
        assert_eq!(cargo_xtask().get_args().collect::<Vec<_>>(), ["xtask"]);
        assert!(cargo("test").get_args().any(|argument| argument == "--target-dir"));
    }
}
