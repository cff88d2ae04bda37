//! Names the chip of the target to the sources, and passes its memory map and the linker scripts of the runtime, the HAL and defmt
//! to the linker.

use std::{env, fs, path::Path};

const RP2350_TARGET: &str = "thumbv8m.main-none-eabi";

fn main() {
    let out_dir = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let is_proving = env::var_os("CARGO_FEATURE_PROVE").is_some();
    let is_rp2350 = env::var("TARGET").is_ok_and(|target| target == RP2350_TARGET);
    let chip = if is_rp2350 { include_str!("rp2350.x") } else { include_str!("rp2040.x") };
    let map = [if is_proving { include_str!("prove.x") } else { "" }, chip, include_str!("memory.x")].concat();
    fs::write(Path::new(&out_dir).join("memory.x"), map).expect("OUT_DIR is writable");
    println!("cargo:rustc-check-cfg=cfg(rp2350)");
    if is_rp2350 {
        println!("cargo:rustc-cfg=rp2350");
    }
    // An axis's second motor beside A: its state machine is one of a third PIO block.
    println!("cargo:rustc-check-cfg=cfg(five_motors)");
    let has_five_motors = is_rp2350 && env::var_os("CARGO_FEATURE_FOUR_AXES").is_some();
    if has_five_motors {
        println!("cargo:rustc-cfg=five_motors");
    }
    // An input for the alarm of all drives, on a pin that others use otherwise.
    println!("cargo:rustc-check-cfg=cfg(drive_alarm)");
    if !has_five_motors && !is_proving && env::var_os("CARGO_FEATURE_SKR_PICO").is_none() {
        println!("cargo:rustc-cfg=drive_alarm");
    }
    println!("cargo:rustc-link-search={out_dir}");
    for script in ["memory.x", "prove.x", "rp2040.x", "rp2350.x"] {
        println!("cargo:rerun-if-changed={script}");
    }
    // The HAL's script is for the second-stage boot loader, which an RP2350 does without.
    let of_hal = (!is_rp2350).then_some("-Tlink-rp.x");
    for argument in ["--nmagic", "-Tlink.x"].into_iter().chain(of_hal).chain(["-Tdefmt.x"]) {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
