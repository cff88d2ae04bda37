//! What the end-to-end tests share: the project's folder, and the firmware on the emulated board.

use std::path::Path;

pub mod emulated;

/// The project's folder.
///
/// # Panics
/// Never: this package is a folder of the project.
#[must_use]
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests is a folder of the project")
}
