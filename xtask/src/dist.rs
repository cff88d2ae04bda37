//! `cargo xtask dist`: makes the files of a release, for users without a toolchain.

mod which;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use clap::ValueEnum;
use serde::Deserialize;
use sha2::{Digest, Sha256};

use crate::process;
use crate::variant::{Axes, Board, Contact, Driver, Port, Variant};
use crate::{build, workspace};

/// Make the files of a release: UF2 files, a table of them, checksums, licences
#[derive(clap::Args)]
#[command(after_help = "\
The files, in target/dist:
  isostep-VERSION-PORT-DRIVER.uf2    one for each step port and driver; copied onto the boot drive of a Pico
  isostep-VERSION-PORT-skr-pico.uf2  the same for an SKR Pico
  isostep-VERSION-PORT-DRIVER-estop-nc.uf2
                                     the same for an emergency stop that is wired normally closed
  isostep-VERSION-PORT-DRIVER[-estop-nc]-4-axes.uf2
                                     the same for X, Y, Z and A; the others are for three axes and a second motor
  isostep-VERSION-prove-PORT.uf2     the image that measures itself, for `isostep prove`; it never energises a motor
  WHICH.md                           a table: which of them is for which board, driver, number of axes, emergency stop and
                                     step port; it is printed too
  LICENCES.txt                       of the project, and of every package that is linked into the firmware
  SHA256SUMS                         of the files above; `sha256sum --check SHA256SUMS` compares them

The same sources and the same compiler make the same bytes.")]
pub struct Args {}

pub fn run(Args {}: Args) -> Result<()> {
    let folder = workspace::target_dir().join("dist");
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("{} cannot be emptied", folder.display()))?;
    }
    fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    let mut files = Vec::new();
    let variants: Vec<_> = released().collect();
    let mut by_features = variants.clone();
    by_features.sort_by_key(|variant| variant.features());
    for same_link in by_features.chunk_by(|one, other| one.features() == other.features()) {
        build::link(same_link[0])?;
        for &variant in same_link {
            build::finish(variant)?;
            let uf2 = fs::read(workspace::firmware_uf2())?;
            files.push(written(&folder, &name(variant), &uf2)?);
        }
    }
    files.sort();
    let which = which::table(&variants);
    files.push(written(&folder, "WHICH.md", which.as_bytes())?);
    files.push(written(&folder, "LICENCES.txt", licences(&linked()?)?.as_bytes())?);
    let sums = files.iter().map(|path| checksum(path)).collect::<Result<String>>()?;
    written(&folder, "SHA256SUMS", sums.as_bytes())?;
    print!("\n{which}");
    Ok(())
}

/// Those that move a machine, and those that measure a board.
fn released() -> impl Iterator<Item = Variant> {
    variants().chain(Port::value_variants().iter().map(|&port| Variant::proving(port)))
}

/// Every port with every driver and board, every contact of the emergency stop and every number of axes.
fn variants() -> impl Iterator<Item = Variant> {
    let on_pico = Driver::value_variants().iter().map(|&driver| (Board::Pico, Some(driver)));
    let machines = on_pico.chain([(Board::SkrPico, None)]);
    machines.flat_map(|(board, driver)| {
        Port::value_variants().iter().flat_map(move |&port| {
            Contact::value_variants().iter().flat_map(move |&estop| {
                let with = move |&axes| Variant { board, port, driver, estop, axes, ..Variant::default() };
                Axes::value_variants().iter().map(with)
            })
        })
    })
}

fn name(variant: Variant) -> String {
    let port = variant.port.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
    if variant.prove {
        return format!("isostep-{}-prove-{port}.uf2", env!("CARGO_PKG_VERSION"));
    }
    let machine = match variant.board {
        Board::Pico => variant.driver_name(),
        Board::SkrPico => variant.board.name(),
    };
    let contact = if variant.estop == Contact::Nc { "-estop-nc" } else { "" };
    let axes = if variant.axes == Axes::Four { "-4-axes" } else { "" };
    format!("isostep-{}-{port}-{machine}{contact}{axes}.uf2", env!("CARGO_PKG_VERSION"))
}

fn written(folder: &Path, name: &str, bytes: &[u8]) -> Result<PathBuf> {
    let path = folder.join(name);
    fs::write(&path, bytes).with_context(|| format!("{} cannot be written", path.display()))?;
    println!("{}", workspace::shown(&path));
    Ok(path)
}

/// A line in the format of sha256sum.
fn checksum(path: &Path) -> Result<String> {
    let digest = Sha256::digest(fs::read(path)?);
    let hex = digest.iter().fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    });
    let name = path.file_name().context("a file has a name")?.to_string_lossy();
    Ok(format!("{hex}  {name}\n"))
}

/// The part of the output of `cargo metadata` that is used here.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
    license: Option<String>,
    manifest_path: PathBuf,
}

/// The packages from other authors that are linked into the firmware, by name.
fn linked() -> Result<Vec<Package>> {
    let cargo = |args: &[&str]| {
        process::output(Command::new("cargo").current_dir(workspace::root()).args(args), "cargo comes with Rust")
    };
    let firmware = ["tree", "--package", workspace::FIRMWARE, "--target", workspace::FIRMWARE_TARGET, "--all-features"];
    // A procedural macro runs in the compiler, so no code of it is linked in.
    let tree = cargo(&[&firmware[..], &["--edges=normal,no-proc-macro", "--prefix=none", "--format={p}"]].concat())?;
    let linked: BTreeSet<_> = tree.lines().map(|line| line.trim_end_matches(" (*)")).collect();
    let metadata = cargo(&["metadata", "--format-version=1"])?;
    let Metadata { mut packages } = serde_json::from_str(&metadata).context("cargo metadata")?;
    // The tree names a folder behind a package of this workspace.
    packages.retain(|package| linked.contains(&*format!("{} v{}", package.name, package.version)));
    packages.sort_by(|one, other| (&one.name, &one.version).cmp(&(&other.name, &other.version)));
    Ok(packages)
}

/// All packages, followed by the text of each licence once.
fn licences(packages: &[Package]) -> Result<String> {
    let mut text = String::from(
        "Isostep is under MIT or Apache-2.0, as you like. Linked into its firmware is Rust's core library, under MIT or\n\
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
        let packages = linked().unwrap();
        let names: Vec<&str> = packages.iter().map(|package| package.name.as_str()).collect();
        assert!(names.contains(&"embassy-rp") && names.contains(&"libm"), "{names:?}");
        // These run in the compiler or on the host, or are our own.
        assert!(!["syn", "clap", "isostep-motion", "embassy-executor-macros"].iter().any(|name| names.contains(name)));
        let text = licences(&packages).unwrap();
        for name in names {
            assert!(text.contains(&format!("\n  {name} ")), "{name}");
        }
        assert!(text.contains("Permission is hereby granted"));
    }

    #[test]
    fn a_checksum_is_as_sha256sum_writes_it() {
        let path = std::env::temp_dir().join(format!("isostep-sum-{}", std::process::id()));
        fs::write(&path, "abc").unwrap();
        let line = checksum(&path).unwrap();
        fs::remove_file(&path).unwrap();
        // The expected hash is from FIPS 180-4, appendix B.1.
        assert!(
            line.starts_with("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  isostep-sum-"),
            "{line}"
        );
    }

    #[test]
    fn a_file_says_what_it_is_for() {
        let name = name(Variant { port: Port::Timer, driver: Some(Driver::Tmc2209), ..Variant::default() });
        assert_eq!(name, format!("isostep-{}-timer-tmc2209.uf2", env!("CARGO_PKG_VERSION")));
        let names: BTreeSet<_> = variants().map(super::name).collect();
        assert_eq!(names.len(), 24, "{names:?}");
        assert!(names.contains(&name.replace("tmc2209", "skr-pico")), "{names:?}");
        for end in [".uf2", "-estop-nc.uf2", "-4-axes.uf2", "-estop-nc-4-axes.uf2"] {
            assert!(names.contains(&name.replace(".uf2", end)), "{names:?}");
        }
    }
    #[test]
    fn the_files_that_the_readme_names_are_made() {
        let readme = fs::read_to_string(workspace::root().join("README.md")).unwrap();
        let named: Vec<_> =
            readme.split('`').filter(|word| word.starts_with("isostep-") && word.ends_with(".uf2")).collect();
        let made: BTreeSet<_> = released().map(super::name).collect();
        assert!(named.len() >= 4, "{named:?}");
        assert!(named.iter().all(|name| made.contains(*name)), "{named:?} of {made:?}");
    }
}
