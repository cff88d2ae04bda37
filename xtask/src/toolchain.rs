//! Cargo for the host and for the chips. The targets are those of rust-toolchain.toml, which rustup installs by itself
//! where it may; otherwise they are added here.

use std::env;
use std::path::PathBuf;
use std::process::Command;

pub use xtask_first::toolchain::{RUSTUP_PATIENCE, add_target, cargo, cargo_xtask, short_paths};

use crate::workspace;

/// Without these the compiler computes both sides of a short branch and selects one of them. It takes an operation on
/// floats for a cheap one, but on the chip each is a call. That cost 2.5 % of the short moves a second.
const NO_SPECULATION: &str = " -Cllvm-args=-speculate-one-expensive-inst=false\
    \x20-Cllvm-args=-two-entry-phi-node-folding-threshold=1";

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

    /// Toolchains installed for the whole computer, and a compiler that is told to be another, are no business of a build.
    #[test]
    fn nothing_is_installed_as_root_and_no_compiler_is_told_to_be_a_nightly() {
        let folders = ["xtask/src", "xtask/first/src"].map(|folder| workspace::root().join(folder));
        let sources = folders.iter().flat_map(|folder| folder.read_dir().unwrap().map(|file| file.unwrap().path()));
        for source in sources.filter(|path| path.is_file()) {
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
}
