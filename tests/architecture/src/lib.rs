//! The files of the project, as the tests of this package read them.

use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the project.
#[must_use]
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The text of a file.
///
/// # Panics
/// When it cannot be read, with its path.
#[must_use]
pub fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The files below a folder, in order, without what is built or installed there.
///
/// # Panics
/// When the folder cannot be read.
#[must_use]
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<_> =
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    entries.retain(|path| !["target", "node_modules", ".git"].iter().any(|name| path.ends_with(name)));
    entries.sort();
    entries.into_iter().flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// The packages that a manifest names as dependencies, with their lines, without those of its tests.
#[must_use]
pub fn dependencies(manifest: &Path) -> Vec<(usize, String)> {
    let mut heading = String::new();
    let mut found = Vec::new();
    for (index, line) in read(manifest).lines().enumerate() {
        if line.starts_with('[') {
            heading = line.trim_matches(['[', ']']).to_owned();
        } else if heading == "dependencies" || heading.ends_with(".dependencies") {
            let name = line.split(['=', '.', ' ']).next().unwrap_or_default();
            if !name.is_empty() && !name.starts_with('#') {
                found.push((index + 1, name.to_owned()));
            }
        }
    }
    found
}
