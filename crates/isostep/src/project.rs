//! Finds the files of the project, and shortens paths for display.

use std::env;
use std::path::{Path, PathBuf};

/// The path of a file of the project that contains the current folder. Outside a project, `path` unchanged.
pub fn file(path: &str) -> PathBuf {
    let here = env::current_dir().unwrap_or_default();
    here.ancestors().map(|folder| folder.join(path)).find(|path| path.exists()).unwrap_or_else(|| path.into())
}

/// `path` as a user in the current folder would write it.
pub fn shown(path: &Path) -> String {
    let here = env::current_dir().unwrap_or_default();
    path.strip_prefix(here).unwrap_or(path).display().to_string()
}
