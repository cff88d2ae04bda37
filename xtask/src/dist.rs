//! `cargo xtask dist`: makes the files of a release, for users without a toolchain.

mod licences;
mod page;
mod which;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::ValueEnum;
use isostep::chip::Chip;
use sha2::{Digest, Sha256};

use licences::{LICENCES, Linked};

use crate::variant::{Axes, Board, Contact, Driver, Port, Variant};
use crate::{build, workspace};

/// Make the files of a release: firmware, the page, the tool; a table of them, checksums, licences
#[derive(clap::Args)]
#[command(after_help = "\
The files, in target/dist:
  isostep-VERSION-PORT-DRIVER.uf2    one for each step port and driver; copied onto the boot drive of a Pico
  isostep-VERSION-PORT-pico2-DRIVER.uf2
                                     the same for a Pico 2
  isostep-VERSION-PORT-skr-pico.uf2  the same for an SKR Pico
  isostep-VERSION-PORT-DRIVER-estop-nc.uf2
                                     the same for an emergency stop that is wired normally closed
  isostep-VERSION-PORT-DRIVER[-estop-nc]-4-axes.uf2
                                     the same for X, Y, Z and A; the others are for three axes and a second motor
  isostep-VERSION-prove-PORT[-pico2].uf2
                                     the image that measures itself, for `isostep prove`; it never energises a motor
  isostep-VERSION-page.zip           the page, for any file server: unpack it there
  isostep-VERSION-TARGET             the tool for this platform with the page in it, for `isostep web` without Rust and Node.js
  WHICH.md                           a table: which of them is for which board, driver, number of axes, emergency stop and
                                     step port; it is printed too
  LICENCES.txt                       of the project, and of every package that is in these files
  SHA256SUMS                         of the files above; `sha256sum --check SHA256SUMS` compares them

The same sources and the same compiler make the same bytes.

Examples:
  cargo xtask dist                   all of them: sixteen links of the firmware, the page, and the tool
  cargo xtask dist --only page       the page and the tool, some minutes")]
pub struct Args {
    /// Make the files of this part alone
    #[arg(long, value_name = "PART")]
    only: Option<Part>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Part {
    /// What boards run
    Firmware,
    /// The page, and the tool that has it in it
    Page,
}

pub fn run(Args { only }: Args) -> Result<()> {
    let makes = |part| only.is_none_or(|only| only == part);
    let folder = workspace::target_dir().join("dist");
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("{} cannot be emptied", folder.display()))?;
    }
    fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    let (mut files, mut which, mut linked, mut of_page) = (Vec::new(), Vec::new(), Vec::new(), None);
    if makes(Part::Firmware) {
        files.extend(firmware(&folder)?);
        which.push(which::table(&released().collect::<Vec<_>>()));
        linked.extend(Chip::ALL.map(Linked::firmware));
    }
    let host = page::host()?;
    if makes(Part::Page) {
        of_page = Some(page::build()?);
        which.push(page::which(&host));
        linked.extend([Linked::page(), Linked::tool(&host)]);
    }
    let licences = licences::text(&licences::packages(&linked)?, of_page.as_deref())?;
    if let Some(page) = of_page {
        files.push(written(&folder, &page::archive_name(), &page::archive(&page, &licences)?)?);
        files.push(copied(&page::tool(&page, &host)?, &folder.join(page::tool_name(&host)))?);
    }
    files.sort();
    let which = which.join("\n");
    files.push(written(&folder, "WHICH.md", which.as_bytes())?);
    files.push(written(&folder, LICENCES, licences.as_bytes())?);
    let sums = files.iter().map(|path| checksum(path)).collect::<Result<String>>()?;
    written(&folder, "SHA256SUMS", sums.as_bytes())?;
    print!("\n{which}");
    Ok(())
}

/// Builds every image, and writes it into the folder.
fn firmware(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let linked = |variant: &Variant| (variant.chip(), variant.features());
    let mut by_link: Vec<_> = released().collect();
    by_link.sort_by_key(linked);
    for same_link in by_link.chunk_by(|one, other| linked(one) == linked(other)) {
        build::link(same_link[0])?;
        for &variant in same_link {
            build::finish(variant)?;
            files.push(written(folder, &name(variant), &fs::read(variant.uf2())?)?);
        }
    }
    Ok(files)
}

/// The boards with bare drivers, which can be measured too.
const BARE: [Board; 2] = [Board::Pico, Board::Pico2];

/// Those that move a machine, and those that measure a board.
fn released() -> impl Iterator<Item = Variant> {
    let ports = Port::value_variants();
    let proving = BARE.into_iter().flat_map(|board| ports.iter().map(move |&port| Variant::proving(board, port)));
    variants().chain(proving)
}

/// Every port with every driver and board, every contact of the emergency stop and every number of axes.
fn variants() -> impl Iterator<Item = Variant> {
    let bare =
        BARE.into_iter().flat_map(|board| Driver::value_variants().iter().map(move |&driver| (board, Some(driver))));
    let machines = bare.chain([(Board::SkrPico, None)]);
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
        let board = if variant.board == Board::Pico2 { "-pico2" } else { "" };
        return format!("isostep-{}-prove-{port}{board}.uf2", env!("CARGO_PKG_VERSION"));
    }
    let machine = match variant.board {
        Board::Pico => variant.driver_name().to_owned(),
        Board::Pico2 => format!("{}-{}", variant.board.name(), variant.driver_name()),
        Board::SkrPico => variant.board.name().to_owned(),
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

/// A copy that may be executed as the original may.
fn copied(from: &Path, to: &Path) -> Result<PathBuf> {
    fs::copy(from, to).with_context(|| format!("{} cannot be copied to {}", from.display(), to.display()))?;
    println!("{}", workspace::shown(to));
    Ok(to.to_owned())
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

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
        assert_eq!(names.len(), 40, "{names:?}");
        for machine in ["skr-pico", "pico2-tmc2209", "pico2-drv8825"] {
            assert!(names.contains(&name.replace("tmc2209", machine)), "{names:?}");
        }
        for end in [".uf2", "-estop-nc.uf2", "-4-axes.uf2", "-estop-nc-4-axes.uf2"] {
            assert!(names.contains(&name.replace(".uf2", end)), "{names:?}");
        }
    }

    #[test]
    fn the_files_that_the_readme_names_are_made() {
        let readme = fs::read_to_string(workspace::root().join("README.md")).unwrap();
        let is_file =
            |word: &&str| word.starts_with("isostep-") && [".uf2", ".zip"].iter().any(|end| word.ends_with(end));
        let named: Vec<_> = readme.split('`').filter(is_file).collect();
        let made: BTreeSet<_> = released().map(super::name).chain([page::archive_name()]).collect();
        assert!(named.len() >= 5, "{named:?}");
        assert!(named.iter().all(|name| made.contains(*name)), "{named:?} of {made:?}");
    }
}
