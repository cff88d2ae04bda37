//! The licences of what is linked into the files of a release.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use isostep::chip::Chip;
use serde::Deserialize;

use crate::{process, web, workspace};

/// The name of the file that has them; the page has one of its packages of npm.
pub const LICENCES: &str = "LICENCES.txt";

/// The part of the output of `cargo metadata` that is used here.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

/// A package of another author, with its licence.
#[derive(Deserialize)]
pub struct Package {
    name: String,
    version: String,
    license: Option<String>,
    manifest_path: PathBuf,
}

/// A package of ours, and for what it is linked.
pub struct Linked<'a> {
    package: &'a str,
    target: &'a str,
    features: &'a [&'a str],
}

impl<'a> Linked<'a> {
    /// Every image of the firmware for a chip.
    pub fn firmware(chip: Chip) -> Self {
        Self { package: workspace::FIRMWARE, target: workspace::target(chip), features: &["--all-features"] }
    }

    /// The machine on the page.
    pub fn page() -> Self {
        Self { package: "isostep-web", target: web::TARGET, features: &[] }
    }

    /// The tool for a platform.
    pub fn tool(target: &'a str) -> Self {
        Self { package: "isostep", target, features: &[] }
    }

    /// All packages in it, as `cargo tree` writes them. A procedural macro runs in the compiler, so no code of it is linked in.
    fn tree(&self) -> Result<String> {
        let tree = ["tree", "--package", self.package, "--target", self.target];
        cargo(&[&tree[..], self.features, &["--edges=normal,no-proc-macro", "--prefix=none", "--format={p}"]].concat())
    }
}

fn cargo(args: &[&str]) -> Result<String> {
    process::output(Command::new("cargo").current_dir(workspace::root()).args(args), "cargo comes with Rust")
}

/// The packages from other authors that are linked into any of these, by name.
///
/// # Errors
/// When cargo does not know them.
pub fn packages(linked: &[Linked]) -> Result<Vec<Package>> {
    let trees = linked.iter().map(Linked::tree).collect::<Result<Vec<_>>>()?;
    let linked: BTreeSet<_> =
        trees.iter().flat_map(|tree| tree.lines()).map(|line| line.trim_end_matches(" (*)")).collect();
    let metadata = cargo(&["metadata", "--format-version=1"])?;
    let Metadata { mut packages } = serde_json::from_str(&metadata).context("cargo metadata")?;
    // The tree names a folder behind a package of this workspace.
    packages.retain(|package| linked.contains(&*format!("{} v{}", package.name, package.version)));
    packages.sort_by(|one, other| (&one.name, &one.version).cmp(&(&other.name, &other.version)));
    Ok(packages)
}

/// All packages, followed by the text of each licence once, and by what the page says of its packages of npm.
///
/// # Errors
/// When a package does not name its licence.
pub fn text(packages: &[Package], page: Option<&Path>) -> Result<String> {
    let mut text = String::from(
        "Isostep is under MIT or Apache-2.0, as you like. Linked into what these files run are Rust's libraries, under MIT or\n\
         Apache-2.0, and these packages of crates.io:\n\n",
    );
    let mut texts: Vec<(String, Vec<String>)> = Vec::new();
    for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
        texts.push((fs::read_to_string(workspace::root().join(license))?, vec![format!("isostep: {license}")]));
    }
    for package in packages {
        let Package { name, version, license, .. } = package;
        let license = license.as_deref().with_context(|| format!("{name} does not name its licence"))?;
        writeln!(text, "  {name} {version}: {license}")?;
        for (file, words) in license_files(package)? {
            let whose = format!("{name} {version}: {file}");
            match texts.iter_mut().find(|(known, _)| *known == words) {
                Some((_, names)) => names.push(whose),
                None => texts.push((words, vec![whose])),
            }
        }
    }
    for (words, names) in texts {
        write!(text, "\n{}\n{}\n\n{}\n", "-".repeat(80), names.join("\n"), words.trim_end())?;
    }
    if let Some(page) = page {
        write!(text, "\n{}\n{}", "=".repeat(80), fs::read_to_string(page.join(LICENCES))?)?;
    }
    Ok(text)
}

/// The licence files of a package, sorted by name.
fn license_files(package: &Package) -> Result<Vec<(String, String)>> {
    let folder = package.manifest_path.parent().context("a manifest lies in a folder")?;
    let entries = fs::read_dir(folder).with_context(|| format!("{} cannot be read", folder.display()))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let is_license = |name: &String| {
        let name = name.to_uppercase();
        ["LICENSE", "LICENCE", "COPYING", "NOTICE"].iter().any(|word| name.starts_with(word))
    };
    let names: BTreeSet<String> = names.filter(is_license).collect();
    let files: Vec<_> = names.into_iter().filter(|name| folder.join(name).is_file()).collect();
    files.into_iter().map(|name| Ok((name.clone(), fs::read_to_string(folder.join(name))?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_linked_package_is_named_with_its_licence() {
        let firmware = packages(&Chip::ALL.map(Linked::firmware)).unwrap();
        let names: Vec<&str> = firmware.iter().map(|package| package.name.as_str()).collect();
        assert!(names.contains(&"embassy-rp") && names.contains(&"libm"), "{names:?}");
        // These run in the compiler or on the host, or are our own.
        assert!(!["syn", "clap", "isostep-motion", "embassy-executor-macros"].iter().any(|name| names.contains(name)));
        let text = text(&firmware, None).unwrap();
        for name in names {
            assert!(text.contains(&format!("\n  {name} ")), "{name}");
        }
        assert!(text.contains("Permission is hereby granted"));
        // The page is drawn by none of them, and the tool has more.
        let of = |linked| packages(&[linked]).unwrap().into_iter().map(|package| package.name).collect::<Vec<_>>();
        let (page, tool) = (of(Linked::page()), of(Linked::tool(&super::super::page::host().unwrap())));
        assert!(page.iter().any(|name| name == "wasm-bindgen") && !page.iter().any(|name| name == "clap"), "{page:?}");
        assert!(tool.iter().any(|name| name == "clap") && !tool.iter().any(|name| name == "wasm-bindgen"), "{tool:?}");
    }
}
