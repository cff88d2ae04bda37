//! `cargo xtask`: `cargo xtask web` is carried out here, without compiling the simulator and all that other commands need for this computer.
//! Every other command is one of the package `xtask`, which Cargo compiles and starts.

use std::env;
use std::ffi::OsString;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};
use xtask_first::{page, process, toolchain};

fn main() -> ExitCode {
    let words: Vec<OsString> = env::args_os().skip(1).collect();
    let done = if words == ["web"] {
        page::build_and_tell(&page::default_out()).map(|()| ExitCode::SUCCESS)
    } else {
        hand_on(&words)
    };
    done.unwrap_or_else(|error| {
        process::tell(&format!("error: {error:#}"));
        ExitCode::FAILURE
    })
}

/// Becomes the command, so that signals reach it.
#[cfg(unix)]
fn hand_on(words: &[OsString]) -> Result<ExitCode> {
    use std::os::unix::process::CommandExt;

    Err(command(words).exec()).context("cannot start Cargo")
}

#[cfg(not(unix))]
fn hand_on(words: &[OsString]) -> Result<ExitCode> {
    let status = command(words).status().context("cannot start Cargo")?;
    Ok(u8::try_from(status.code().unwrap_or(1)).map_or(ExitCode::FAILURE, ExitCode::from))
}

/// In the folder where the user is, as files are named from there.
fn command(words: &[OsString]) -> Command {
    let mut command = toolchain::cargo_here("run");
    command.args(["--package", "xtask", "--"]).args(words);
    command
}
