//! Passes the memory map and the linker scripts of the runtime, the HAL and defmt to the linker.

use std::{env, fs, path::Path};

fn main() {
    let out_dir = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let is_proving = env::var_os("CARGO_FEATURE_PROVE").is_some();
    let map = [if is_proving { include_str!("prove.x") } else { "" }, include_str!("memory.x")].concat();
    fs::write(Path::new(&out_dir).join("memory.x"), map).expect("OUT_DIR is writable");
    println!("cargo:rustc-link-search={out_dir}");
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rerun-if-changed=prove.x");
    for argument in ["--nmagic", "-Tlink.x", "-Tlink-rp.x", "-Tdefmt.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
