//! Code shared by the end-to-end tests: the project's folder, the firmware on the emulated board, test cases for
//! machines of every kind, and the fuzz targets.

use std::path::Path;

pub mod axes;
pub mod bench;
pub mod cases;
pub mod contract;
pub mod dialogue;
pub mod emulated;
pub mod fuzz;
pub mod model;
pub mod rig;
pub mod speed_profiles;
pub mod talk;

/// The project's folder.
///
/// # Panics
/// Never: this package is a folder of the project.
#[must_use]
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests is a folder of the project")
}
