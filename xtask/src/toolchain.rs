//! Finds a compiler that can build for the chip: rustc with the core library of thumbv6m-none-eabi, either precompiled
//! or built from the library's sources.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result};

use crate::process::{self, announce};
use crate::workspace::{self, FIRMWARE_TARGET};

/// Older compilers do not support the workspace's edition or its dependencies.
const RUSTC_MINOR_MIN: u32 = 90;
/// Without a network, rustup retries for minutes. The download itself is about 10 MB.
const RUSTUP_PATIENCE: Duration = Duration::from_secs(60);
const DEBIAN_PACKAGES: [&str; 3] = ["rustc-web", "rust-web-src", "cargo-web"];

/// Without these the compiler computes both sides of a short branch and selects one of them. It takes an operation on
/// floats for a cheap one, but on the chip each is a call. That cost 2.5 % of the short moves a second.
const NO_SPECULATION: &str = " -Cllvm-args=-speculate-one-expensive-inst=false\
    \x20-Cllvm-args=-two-entry-phi-node-folding-threshold=1";

/// How the firmware is compiled.
pub enum Toolchain {
    /// The default cargo: its rustc has the target's core library.
    Ready,
    /// A rustc that has the library's sources, from which cargo builds core for the target.
    FromSource { bin_dir: PathBuf, linker: PathBuf },
}

impl Toolchain {
    /// The first toolchain that works. Installs what is missing where that is possible.
    pub fn set_up() -> Result<Self> {
        if has_target(FIRMWARE_TARGET) {
            return Ok(Self::Ready);
        }
        let found = Self::from_source().map_or_else(Self::from_debian, Ok)?;
        let _ = fs::create_dir_all(workspace::target_dir()).and_then(|()| fs::write(source_marker(), ""));
        Ok(found)
    }

    /// The toolchain that the last [`Toolchain::set_up`] found, without trying rustup again. If there is none, calls
    /// it.
    pub fn ensure() -> Result<Self> {
        let known_source = source_marker().exists() && !has_core_library(FIRMWARE_TARGET);
        match known_source.then(Self::from_source).flatten() {
            Some(found) => Ok(found),
            None => Self::set_up(),
        }
    }

    fn from_source() -> Option<Self> {
        let linker = rust_lld()?;
        let bin_dir = path_dirs().find(|dir| can_build_core(dir))?;
        Some(Self::FromSource { bin_dir, linker })
    }

    fn from_debian() -> Result<Self> {
        install_debian_packages()?;
        Self::from_source().with_context(remedy)
    }

    /// The toolchain in words for the user.
    pub fn description(&self) -> String {
        match self {
            Self::Ready => format!("the default Rust toolchain, which has {FIRMWARE_TARGET}"),
            Self::FromSource { bin_dir, .. } => {
                format!("{} with -Zbuild-std=core (it has the library's sources)", bin_dir.join("rustc").display())
            }
        }
    }

    /// `cargo VERB` for a board's package and the chip, in the release profile, with these features and no others.
    pub fn cargo(&self, verb: &str, package: &str, features: &[&str]) -> Command {
        let mut command = match self {
            Self::Ready => cargo(verb),
            Self::FromSource { bin_dir, linker } => from_source(verb, bin_dir, linker),
        };
        command.args(["--release", "--package", package, "--target", FIRMWARE_TARGET]);
        command.args(["--no-default-features", &format!("--features={}", features.join(","))]);
        let mut flags = short_paths();
        flags.push(NO_SPECULATION);
        command.env("CARGO_TARGET_THUMBV6M_NONE_EABI_RUSTFLAGS", flags);
        command
    }
}

/// The default `cargo VERB` in the workspace.
pub fn cargo(verb: &str) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(workspace::root()).arg(verb).arg("--target-dir").arg(workspace::target_dir());
    command
}

fn from_source(verb: &str, bin_dir: &Path, linker: &Path) -> Command {
    let mut command = Command::new(bin_dir.join("cargo"));
    command
        .current_dir(workspace::root())
        .env("RUSTC", bin_dir.join("rustc"))
        .env("RUSTC_BOOTSTRAP", "1")
        .env("CARGO_TARGET_THUMBV6M_NONE_EABI_LINKER", linker)
        // The cargo that runs xtask sets these for its own toolchain.
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("LD_LIBRARY_PATH")
        .args([verb, "-Zbuild-std=core", "--target-dir"])
        .arg(workspace::target_dir());
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

/// A file that is written when rustup could not install the core library, so that it is not tried again before every
/// build.
fn source_marker() -> PathBuf {
    workspace::target_dir().join(".firmware-core-from-source")
}

/// Whether the default toolchain can build for `target`. Installs the target where rustup can.
pub fn has_target(target: &str) -> bool {
    if has_core_library(target) {
        return true;
    }
    add_rustup_target(target);
    has_core_library(target)
}

/// Whether the default toolchain can build for `target`.
pub fn has_core_library(target: &str) -> bool {
    let mut rustc = Command::new("rustc");
    rustc.current_dir(workspace::root()).args(["--print", "target-libdir", "--target", target]);
    let Some(dir) = process::printed(&mut rustc) else { return false };
    let Ok(files) = Path::new(&dir).read_dir() else { return false };
    files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
}

/// The folders of PATH.
pub fn path_dirs() -> impl Iterator<Item = PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&path).collect::<Vec<_>>().into_iter()
}

fn can_build_core(bin_dir: &Path) -> bool {
    let rustc = bin_dir.join("rustc");
    bin_dir.join("cargo").is_file()
        && process::printed(Command::new(&rustc).arg("--version")).is_some_and(|version| is_recent(&version))
        && sysroot(&rustc).is_some_and(|dir| dir.join("lib/rustlib/src/rust/library/core/src/lib.rs").is_file())
}

/// Whether `rustc --version` printed 1.90 or later.
fn is_recent(version: &str) -> bool {
    let minor = version.strip_prefix("rustc 1.").and_then(|rest| rest.split('.').next());
    minor.and_then(|minor| minor.parse::<u32>().ok()).is_some_and(|minor| minor >= RUSTC_MINOR_MIN)
}

fn sysroot(rustc: &Path) -> Option<PathBuf> {
    process::printed(Command::new(rustc).args(["--print", "sysroot"])).map(PathBuf::from)
}

/// The linker of the default toolchain, otherwise the system's.
fn rust_lld() -> Option<PathBuf> {
    let host_libdir = process::printed(Command::new("rustc").args(["--print", "target-libdir"]))?;
    let bundled = Path::new(&host_libdir).parent()?.join("bin/rust-lld");
    let system = path_dirs().flat_map(|dir| [dir.join("rust-lld"), dir.join("ld.lld")]);
    std::iter::once(bundled).chain(system).find(|linker| linker.is_file())
}

fn add_rustup_target(target: &str) {
    announce(&format!("rustup target add {target}"));
    let mut rustup = Command::new("rustup");
    rustup.current_dir(workspace::root()).env("RUSTUP_MAX_RETRIES", "0").args(["target", "add", target]);
    if let Err(error) = process::run_within(&mut rustup, RUSTUP_PATIENCE) {
        eprintln!("    no: {error:#}");
    }
}

fn install_debian_packages() -> Result<()> {
    let is_root = process::printed(Command::new("id").arg("-u")).is_some_and(|id| id == "0");
    if !is_root || process::printed(Command::new("apt-get").arg("--version")).is_none() {
        return Ok(());
    }
    announce(&format!(
        "apt-get install {} (a system-wide rustc with the library's sources)",
        DEBIAN_PACKAGES.join(" ")
    ));
    process::run(Command::new("apt-get").arg("update"))?;
    let mut install = Command::new("apt-get");
    install
        .env("DEBIAN_FRONTEND", "noninteractive")
        .args(["install", "-y", "--no-install-recommends"])
        .args(DEBIAN_PACKAGES);
    process::run(&mut install)
}

fn remedy() -> String {
    format!(
        "no compiler for {FIRMWARE_TARGET} was found. Install one of:\n  \
         - with rustup:    rustup target add {FIRMWARE_TARGET}\n  \
         - with rustup:    rustup component add rust-src (core is then built from its sources)\n  \
         - on Debian:      apt-get install {} (beside a rustup toolchain or the package lld)",
        DEBIAN_PACKAGES.join(" ")
    )
}

#[cfg(test)]
mod tests {
    use super::is_recent;

    #[test]
    fn a_compiler_is_recent_from_1_90_on() {
        assert!(is_recent("rustc 1.90.0 (1159e78c4 2025-09-14)"));
        assert!(is_recent("rustc 1.96.0 (ac68faa20 2026-05-25) (built from a source tarball)"));
        assert!(!is_recent("rustc 1.63.0"));
        assert!(!is_recent("error: no default toolchain"));
    }
}
