//! The builds of the gantry's firmware that are compared. They have the same tasks and different step ports.

use std::path::PathBuf;

use anyhow::Result;
use serde::Serializer;

use super::trial::ACCEL_MAX_STEPS_S2;
use crate::build;
use crate::variant::{Driver, Port, Variant};

/// The drivers of every axis. They are fast enough not to limit the rate.
const DRIVER: Driver = Driver::Tmc2209;

/// A firmware with one of the ports.
#[derive(Clone, Debug)]
pub struct Candidate {
    pub port: Port,
    pub variant: Variant,
    pub elf: PathBuf,
}

/// Builds the firmware with each of `ports`, or its proving image. Builds the default variant last, because every other verb expects it in
/// its place.
pub fn build(ports: &[Port], prove: bool) -> Result<Vec<Candidate>> {
    let candidates = ports.iter().map(|&port| candidate(port, prove)).collect();
    build::firmware(Variant::default())?;
    candidates
}

fn candidate(port: Port, prove: bool) -> Result<Candidate> {
    let variant = Variant { port, driver: DRIVER, prove, ..Variant::default() };
    let of = if prove { "bench-prove" } else { "bench" };
    let elf = build::kept_firmware(variant, &format!("{of}-{}", port.name().to_lowercase()))?;
    Ok(Candidate { port, variant, elf })
}

/// The driver's name for the emulated board's options.
pub fn driver_name() -> &'static str {
    Variant { driver: DRIVER, ..Variant::default() }.driver_name()
}

/// Targets and limits of the measurements for each port.
impl Port {
    pub const ALL: [Self; 2] = [Self::Pio, Self::Timer];

    pub fn name(self) -> &'static str {
        match self {
            Self::Pio => "PioPort",
            Self::Timer => "TimerPort",
        }
    }

    /// The target rate of three axes at once, steps/s each.
    pub fn target_steps_s(self) -> u32 {
        match self {
            Self::Pio => 1_000_000,
            Self::Timer => 30_000,
        }
    }

    /// The target for the error of an edge, ns. With PioPort it holds for every edge, with TimerPort for 99 of 100.
    pub fn error_bound_ns(self) -> f64 {
        match self {
            Self::Pio => 50.0,
            Self::Timer => 2_000.0,
        }
    }

    /// The top speed, steps/s, and the acceleration, steps/s2, at which starts are measured. They are as steep as in
    /// any other measurement; where tasks make the steps, as steep as the tasks can sustain with axes at different
    /// speeds.
    pub fn start_steps_s_and_s2(self) -> (u32, f64) {
        match self {
            Self::Pio => (self.target_steps_s(), ACCEL_MAX_STEPS_S2),
            Self::Timer => (20_000, 1e6),
        }
    }

    /// The feed of the streamed short moves, mm/min. It is more than a core can keep up with; where tasks make the
    /// steps, it stays below the rate at which they would leave no time to plan.
    pub fn moves_feed_mm_min(self) -> f64 {
        match self {
            Self::Pio => 60_000.0,
            Self::Timer => 12_000.0,
        }
    }

    /// The rates of three axes at which the load is measured, steps/s each.
    pub fn load_rates_steps_s(self) -> &'static [u32] {
        match self {
            Self::Pio => &[10_000, 100_000, 1_000_000],
            Self::Timer => &[10_000, 20_000, 30_000],
        }
    }
}

/// Serialises a port as its name.
pub fn serialize_port<S: Serializer>(port: &Port, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(port.name())
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
