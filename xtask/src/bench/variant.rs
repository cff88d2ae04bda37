//! The builds of the gantry's firmware that are compared: the same tasks, another step port.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::ValueEnum;
use serde::Serialize;

use crate::{build, workspace};

/// The driver whose least times every edge is held to: fast enough not to be what limits the rate.
pub const DRIVER: &str = "tmc2209";

/// How the steps of a build leave the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Port {
    /// PIO and DMA.
    Pio,
    /// A timer and a pin.
    Timer,
}

/// A build of the firmware, kept beside the benchmark's files.
#[derive(Clone, Debug)]
pub struct Variant {
    pub port: Port,
    pub elf: PathBuf,
}

impl Port {
    pub const ALL: [Self; 2] = [Self::Pio, Self::Timer];

    pub fn name(self) -> &'static str {
        match self {
            Self::Pio => "PioPort",
            Self::Timer => "TimerPort",
        }
    }

    /// What three axes are to carry at once, steps/s each.
    pub fn target_steps_s(self) -> u32 {
        match self {
            Self::Pio => 1_000_000,
            Self::Timer => 30_000,
        }
    }

    /// Rates of three axes at which the load is measured, steps/s each.
    pub fn load_rates_steps_s(self) -> &'static [u32] {
        match self {
            Self::Pio => &[10_000, 100_000, 1_000_000],
            Self::Timer => &[10_000, 20_000, 30_000],
        }
    }

    /// The firmware's cargo features.
    fn features(self) -> &'static [&'static str] {
        match self {
            Self::Pio => &["tmc2209"],
            Self::Timer => &["timer-port", "tmc2209"],
        }
    }
}

/// Builds the firmware with each of `ports`, copies each ELF into `folder`, and leaves the default build where every
/// other verb expects it.
pub fn build(ports: &[Port], folder: &Path) -> Result<Vec<Variant>> {
    let variants = ports.iter().map(|&port| build_one(port, folder)).collect();
    build::firmware(Default::default())?;
    variants
}

/// How the release profile compiles, from the workspace's own manifest: `opt-level s, lto fat; opt-level 3 for ...`.
pub fn build_options() -> String {
    let manifest = include_str!("../../../Cargo.toml");
    let all = lines(manifest, "[profile.release]").filter(|(name, _)| ["opt-level", "lto"].contains(name));
    let all: Vec<_> = all.map(|(name, value)| format!("{name} {value}")).collect();
    let raised = lines(manifest, "[profile.release.package]").filter(|(_, value)| value.contains("opt-level = 3"));
    let raised: Vec<_> = raised.map(|(package, _)| package).collect();
    format!("{}; opt-level 3 for {}", all.join(", "), raised.join(", "))
}

/// Names and values of a section.
fn lines<'a>(manifest: &'a str, section: &str) -> impl Iterator<Item = (&'a str, &'a str)> {
    let after = manifest.split_once(section).map_or("", |(_, after)| after);
    let lines = after.lines().take_while(|line| !line.starts_with('['));
    lines.filter_map(|line| line.split_once('=')).map(|(name, value)| (name.trim(), value.trim().trim_matches('"')))
}

fn build_one(port: Port, folder: &Path) -> Result<Variant> {
    build::build_firmware(workspace::FIRMWARE, port.features())?;
    let elf = folder.join(port.name().to_lowercase()).with_extension("elf");
    let from = workspace::elf(workspace::FIRMWARE);
    fs::copy(&from, &elf).with_context(|| format!("cannot copy {} to {}", from.display(), elf.display()))?;
    Ok(Variant { port, elf })
}

#[cfg(test)]
mod tests {
    use super::build_options;

    #[test]
    fn the_build_names_its_optimisation() {
        let options = build_options();
        assert!(options.starts_with("opt-level s, lto fat; opt-level 3 for isostep-profile"), "{options}");
    }
}
