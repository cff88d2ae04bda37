//! `cargo xtask setup`: finds or installs what the other verbs need.

use anyhow::Result;

use crate::node;
use crate::process::announce;
use crate::toolchain::Toolchain;

/// Find or install what building and emulating need
#[derive(clap::Args)]
#[command(after_help = "\
The compiler is the first of these that works, and setup says which:
  1. the Rust toolchain in use already has thumbv6m-none-eabi
  2. `rustup target add thumbv6m-none-eabi`
  3. a rustc on PATH with its library's sources, from which core is built
  4. on Debian as root: apt-get install rustc-web rust-web-src cargo-web, then as 3

For the emulated board: Node.js 20 or later, and `npm ci` in tests/emulator.
The other verbs do all this themselves; setup is for doing it ahead, for example before going offline.")]
pub struct Args {}

pub fn run(Args {}: Args) -> Result<()> {
    let toolchain = Toolchain::set_up()?;
    announce(&format!("firmware compiler: {}", toolchain.description()));
    node::prepare()?;
    announce("emulated board: its Node packages are installed");
    Ok(())
}
