//! `cargo xtask setup`: finds or installs what the other verbs need.

use anyhow::Result;

use crate::node;
use crate::process::announce;
use crate::toolchain;
use crate::workspace::{FIRMWARE_TARGET, RP2350_TARGET};

/// Find or install what building and emulating need
#[derive(clap::Args)]
#[command(after_help = "\
For the chips: `rustup target add thumbv6m-none-eabi thumbv8m.main-none-eabi`, unless rustup has installed them by
rust-toolchain.toml already.
For the emulated board: Node.js 20 or later, and `npm ci` in tests/emulator.
The other verbs do all this themselves; setup is for doing it ahead, for example before going offline.")]
pub struct Args {}

pub fn run(Args {}: Args) -> Result<()> {
    for target in [FIRMWARE_TARGET, RP2350_TARGET] {
        toolchain::add_target(target)?;
        announce(&format!("firmware compiler: the Rust toolchain in use, which has {target}"));
    }
    node::prepare()?;
    announce("emulated board: its Node packages are installed");
    Ok(())
}
