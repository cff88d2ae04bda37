//! Puts the page into the tool, if `ISOSTEP_PAGE` names its folder: `cargo xtask web --install` does so.

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

fn main() -> std::io::Result<()> {
    println!("cargo:rerun-if-env-changed=ISOSTEP_PAGE");
    let mut files = String::new();
    if let Some(folder) = env::var_os("ISOSTEP_PAGE") {
        let folder = fs::canonicalize(folder)?;
        println!("cargo:rerun-if-changed={}", folder.display());
        list(&mut files, &folder, "")?;
    }
    let out = env::var_os("OUT_DIR").expect("cargo sets it");
    fs::write(Path::new(&out).join("page.rs"), format!("&[{files}]"))
}

/// A line of Rust for each file.
fn list(files: &mut String, folder: &Path, before: &str) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = format!("{before}{}", path.file_name().unwrap_or_default().to_string_lossy());
        if path.is_dir() {
            list(files, &path, &format!("{name}/"))?;
        } else {
            let _ = writeln!(files, "({name:?}, include_bytes!({:?})),", path.display().to_string());
        }
    }
    Ok(())
}
