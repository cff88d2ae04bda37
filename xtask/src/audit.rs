//! `cargo xtask audit`: checks the project's dependencies against deny.toml, the advisories of RustSec and npm, and the oldest Rust.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::process::{self, announce};
use crate::{node, oldest, tools, workspace};

/// Version of cargo-deny. Other versions may read deny.toml differently.
const VERSION: &str = "0.20.2";
const WORKSPACE: &str = "Cargo.toml";
/// The tool that writes JavaScript while the page is built. Duplicates in it are its own business.
const BINDGEN: &str = "web/bindgen/Cargo.toml";
const FETCH_PATIENCE: Duration = Duration::from_secs(120);

/// Hold the dependencies against deny.toml, and what is published against the oldest Rust that it names
#[derive(clap::Args)]
#[command(after_help = "\
What deny.toml allows is held by cargo-deny, which is compiled from crates.io into target/tools when it is not there: some 200
packages, minutes on a fast computer and much more on a slow one. Its advisories come from the RustSec database on GitHub, which
is fetched. Looked at are Cargo.lock and, but for duplicates, web/bindgen/Cargo.lock. Of what npm installs, by the package-lock.json
of web and of tests/emulator, npm's registry is asked. Where GitHub or the registry cannot be asked, a line says so, and that is an
error only with --advisories.

What is published is compiled with the oldest Rust that it names, which rustup adds; where it cannot, a line says so.

`cargo xtask test` holds licences, sources and duplicates by itself, without cargo-deny, those of npm's packages too. docs/security.md: what is known of
packages that nobody maintains.

Examples:
  cargo xtask audit                 all that can be looked at here
  cargo xtask audit --advisories    and fail if the advisories cannot be")]
pub struct Args {
    /// Fail where advisories cannot be had
    #[arg(long)]
    advisories: bool,
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    oldest::check()?;
    let cargo_deny = tools::installed("cargo-deny", VERSION)?;
    // It looks for deny.toml from a manifest upwards.
    let deny = |manifest: &str| {
        let mut deny = Command::new(&cargo_deny);
        deny.current_dir(workspace::root()).arg("--manifest-path").arg(workspace::root().join(manifest));
        deny
    };
    let check = |manifest: &str, checks: &[&str]| {
        let mut check = deny(manifest);
        // What the one workspace needs of the lists the other need not need.
        let allowed: &[_] = if manifest == BINDGEN { &["--allow", "license-not-encountered"] } else { &[] };
        process::run(check.arg("check").args(allowed).args(checks))
    };
    announce("licences, sources and duplicates");
    check(WORKSPACE, &["bans", "licenses", "sources"])?;
    check(BINDGEN, &["licenses", "sources"])?;
    announce("advisories of RustSec");
    let mut unknown = Vec::new();
    let mut fetch = deny(WORKSPACE);
    fetch.args(["fetch", "db"]).stdout(Stdio::null()).stderr(Stdio::null());
    if process::run_within(&mut fetch, FETCH_PATIENCE).is_ok() {
        for manifest in [WORKSPACE, BINDGEN] {
            check(manifest, &["advisories"])?;
        }
    } else {
        unknown.push(
            "the RustSec database cannot be fetched from github.com, so its advisories were not looked at".to_owned(),
        );
    }
    announce("advisories of npm");
    for folder in [workspace::root().join("web"), workspace::emulator_dir()] {
        unknown.extend(advisories_of_npm(&folder)?);
    }
    for line in &unknown {
        println!("{line}");
    }
    ensure!(
        unknown.is_empty() || !args.advisories,
        "advisories are missing: run it where GitHub and npm's registry can be reached"
    );
    Ok(())
}

/// Asks npm's registry for advisories against what a lock file names, and says so if it gives no answer.
///
/// # Errors
/// When there are some.
fn advisories_of_npm(folder: &Path) -> Result<Option<String>> {
    let shown = workspace::shown(folder);
    let mut audit = node::npm_in(folder, "audit");
    // It fails when it finds something, and when it is not answered: its words tell which.
    let output = audit.args(["--json", "--package-lock-only"]).stderr(Stdio::null()).output();
    let output = output.context("npm is not there: it comes with Node.js")?;
    let report = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let Some(found) = found_by_npm(&report) else {
        let why = report["message"].as_str().unwrap_or("no answer");
        return Ok(Some(format!("npm's registry gives no advisories for {shown} ({why}), so they were not looked at")));
    };
    if !found.is_empty() {
        bail!("advisories of npm against packages of {shown}/package-lock.json: {}", found.join("; "));
    }
    println!("{shown}: none");
    Ok(None)
}

/// Packages with their advisories, of a report of `npm audit`; `None` if it is not one.
fn found_by_npm(report: &Value) -> Option<Vec<String>> {
    let packages = report["vulnerabilities"].as_object()?;
    let words = |(name, package): (&String, &Value)| {
        let titles = package["via"].as_array().into_iter().flatten().filter_map(|via| via["title"].as_str());
        format!(
            "{name}, {}: {}",
            package["severity"].as_str().unwrap_or("unknown"),
            titles.collect::<Vec<_>>().join(", ")
        )
    };
    Some(packages.iter().map(words).collect())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_report_of_npm_is_told_from_no_report() {
        assert_eq!(found_by_npm(&json!({ "auditReportVersion": 2, "vulnerabilities": {} })), Some(vec![]));
        assert_eq!(found_by_npm(&json!({ "message": "405 Method Not Allowed" })), None);
        assert_eq!(found_by_npm(&Value::Null), None);
        let via = json!([{ "title": "a hole", "severity": "high" }, "another package"]);
        let report = json!({ "vulnerabilities": { "left-pad": { "severity": "high", "via": via } } });
        assert_eq!(found_by_npm(&report), Some(vec!["left-pad, high: a hole".to_owned()]));
    }
}
