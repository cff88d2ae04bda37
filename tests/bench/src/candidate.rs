//! The builds of the gantry's firmware that are compared. They have the same tasks and different step ports.

use std::path::PathBuf;

use clap::ValueEnum;
use isostep::chip::Chip;

use super::port::Port;

/// A board that can be had, and with it the use of each pin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Model {
    /// A Raspberry Pi Pico with a bare driver for each motor
    #[default]
    Pico,
    /// A Raspberry Pi Pico 2, or another board with an RP2350A, with a bare driver for each motor
    Pico2,
    /// A BIGTREETECH SKR Pico V1.0
    SkrPico,
}

impl Model {
    /// Its name for the emulated board's options, and in file names.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pico => "pico",
            Self::Pico2 => "pico2",
            Self::SkrPico => "skr-pico",
        }
    }

    /// Its chip.
    #[must_use]
    pub const fn chip(self) -> Chip {
        match self {
            Self::Pico | Self::SkrPico => Chip::Rp2040,
            Self::Pico2 => Chip::Rp2350,
        }
    }

    /// Its chip and the clock of that, in words.
    #[must_use]
    pub fn clocked(self) -> String {
        format!("{}, {} MHz", self.chip().name(), self.chip().clock_hz() / 1_000_000)
    }
}

/// A firmware with one of the ports, in the release profile. Its drivers are fast enough not to limit the rate.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The board whose pins it has.
    pub model: Model,
    /// Its step port.
    pub port: Port,
    /// The drivers that it is built for, by their name for the emulated board.
    pub driver: &'static str,
    /// It is the proving image, which keeps the drivers off.
    pub proves: bool,
    /// The image.
    pub elf: PathBuf,
    /// The emulated board, which Node runs.
    pub emulator: PathBuf,
}

/// The compiler options of the release profile, from the workspace's manifest: `opt-level s, lto fat; opt-level 3 for
/// ...`.
pub fn build_options() -> String {
    let manifest = include_str!("../../../Cargo.toml");
    let all = lines(manifest, "[profile.release]").filter(|(name, _)| ["opt-level", "lto"].contains(name));
    let all: Vec<_> = all.map(|(name, value)| format!("{name} {value}")).collect();
    let raised = lines(manifest, "[profile.release.package]").filter(|(_, value)| value.contains("opt-level = 3"));
    let raised: Vec<_> = raised.map(|(package, _)| package).collect();
    format!("{}; opt-level 3 for {}", all.join(", "), raised.join(", "))
}

/// Names and values in a section of the manifest.
fn lines<'a>(manifest: &'a str, section: &str) -> impl Iterator<Item = (&'a str, &'a str)> {
    let after = manifest.split_once(section).map_or("", |(_, after)| after);
    let lines = after.lines().take_while(|line| !line.starts_with('['));
    lines.filter_map(|line| line.split_once('=')).map(|(name, value)| (name.trim(), value.trim().trim_matches('"')))
}

#[cfg(test)]
mod tests {
    use super::build_options;

    #[test]
    fn the_build_names_its_optimisation() {
        let options = build_options();
        assert!(
            options.starts_with("opt-level s, lto fat; opt-level 3 for isostep-generators, isostep-profile, "),
            "{options}"
        );
    }
}
