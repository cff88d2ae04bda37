//! `cargo xtask bench`: builds the firmwares, and has them measured on the emulated board.

use std::fs;

use anyhow::{Context, Result};
use isostep_bench::least_times::{self, Words};
use isostep_bench::{Candidate, Images, Model, prices};

use crate::variant::{Driver, Port, Variant};
use crate::{board_words, build, node, workspace};

pub use isostep_bench::Args;

/// The drivers of every axis. They are fast enough not to limit the rate.
const DRIVER: Option<Driver> = Some(Driver::Tmc2209);

pub fn run(args: Args) -> Result<()> {
    args.check()?;
    let folder = workspace::target_dir().join("bench");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    node::prepare()?;
    let candidates = candidates(args.model(), &args.ports(), args.proves())?;
    if args.mathematics() {
        build::bench_firmware()?;
    }
    let mathematics = workspace::elf(workspace::FIRMWARE_TARGET, workspace::BENCH_FIRMWARE);
    let images = Images { candidates, mathematics, emulator: workspace::emulator() };
    if args.least_times() {
        let words = Words { read: board_words::least_times, write: board_words::with_least_times };
        return least_times::run(&images, &words, &folder);
    }
    if args.prices() {
        return prices::run(&images, &folder);
    }
    isostep_bench::run(&args, &images, &folder)
}

/// Builds the firmware with each of `ports`, or its proving image. Builds the usual variant for the chip last, because every other
/// verb expects it in its place.
fn candidates(model: Model, ports: &[Port], proves: bool) -> Result<Vec<Candidate>> {
    let candidates = ports.iter().map(|&port| candidate(model, port, proves)).collect();
    let usual = if model == Model::Pico2 { model } else { Model::default() };
    build::firmware(Variant { board: usual, ..Variant::default() })?;
    candidates
}

fn candidate(model: Model, port: Port, proves: bool) -> Result<Candidate> {
    let variant = Variant { board: model, port, driver: DRIVER, prove: proves, ..Variant::default() };
    let of = if proves { "bench-prove" } else { "bench" };
    let elf = build::kept_firmware(variant, &format!("{of}-{}-{}", model.name(), port.name().to_lowercase()))?;
    Ok(Candidate { model, port, driver: variant.driver_name(), proves, elf, emulator: workspace::emulator() })
}
