//! `cargo xtask audit`: checks the project's dependencies against deny.toml, the RustSec advisories and the oldest Rust.

use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Result, bail};

use crate::process::{self, announce};
use crate::{oldest, tools, workspace};

/// Version of cargo-deny. Other versions may read deny.toml differently.
const VERSION: &str = "0.20.2";
const FETCH_PATIENCE: Duration = Duration::from_secs(120);

/// Hold the dependencies against deny.toml, and what is published against the oldest Rust that it names
#[derive(clap::Args)]
#[command(after_help = "\
What deny.toml allows is held by cargo-deny, which is compiled from crates.io into target/tools when it is not there: some 200
packages, minutes on a fast computer and much more on a slow one. Its advisories come from the RustSec database on GitHub, which
is fetched; where it cannot be, a line says so, and that is an error only with --advisories.

What is published is compiled with the oldest Rust that it names, which rustup adds; where it cannot, a line says so.

`cargo xtask test` holds licences, sources and duplicates by itself, without cargo-deny. docs/security.md: what is known of
packages that nobody maintains.

Examples:
  cargo xtask audit                 all that can be looked at here
  cargo xtask audit --advisories    and fail if the advisories cannot be")]
pub struct Args {
    /// Fail where the database of advisories cannot be fetched
    #[arg(long)]
    advisories: bool,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    oldest::check()?;
    let cargo_deny = tools::installed("cargo-deny", VERSION)?;
    let deny = || {
        let mut deny = Command::new(&cargo_deny);
        deny.current_dir(workspace::root());
        deny
    };
    announce("licences, sources and duplicates");
    process::run(deny().args(["check", "bans", "licenses", "sources"]))?;
    announce("advisories");
    let mut fetch = deny();
    fetch.args(["fetch", "db"]).stdout(Stdio::null()).stderr(Stdio::null());
    if process::run_within(&mut fetch, FETCH_PATIENCE).is_ok() {
        return process::run(deny().args(["check", "--disable-fetch", "advisories"]));
    }
    let unknown = "the RustSec database cannot be fetched from github.com, so advisories were not looked at";
    if args.advisories {
        bail!("{unknown}: run it where GitHub can be reached");
    }
    println!("{unknown}");
    Ok(())
}
