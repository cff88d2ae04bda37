//! Files as the user names them, and those that come with the project.

use std::env;
use std::path::{Path, PathBuf};

/// A file of the project that the current folder lies in; under its own name if there is none.
pub fn file(path: &str) -> PathBuf {
    let here = env::current_dir().unwrap_or_default();
    here.ancestors().map(|folder| folder.join(path)).find(|path| path.exists()).unwrap_or_else(|| path.into())
}

/// `path` as a user in the current folder would write it.
pub fn shown(path: &Path) -> String {
    let here = env::current_dir().unwrap_or_default();
    path.strip_prefix(here).unwrap_or(path).display().to_string()
}
