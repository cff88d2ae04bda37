//! Says line by line what becomes of the settings of another controller.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use isostep_report::listing::Listing;
use isostep_sim::Config;

use super::print;
use crate::files::{self, Files};
use crate::{project, sim};

/// Prints it for each file, and writes what is taken of the only one to `out`.
pub fn run(files: &[PathBuf], out: Option<&PathBuf>) -> Result<()> {
    Files::default().read("--settings", files).written("--write", out).check()?;
    ensure!(out.is_none() || files.len() == 1, "--write has the settings of one file: name one with --settings");
    let mut bad = 0;
    for path in files {
        let name = project::shown(path);
        let listing = Listing::read(&name, &sim::read_as_settings(path)?, &Config::default());
        print!("{name}\n{}", print::listing(&listing.rows()));
        bad += usize::from(!listing.is_good());
        if let Some(out) = out.filter(|_| listing.settings.is_some()) {
            files::write(out, listing.text().as_bytes())?;
        }
    }
    ensure!(bad == 0, "{bad} of {} cannot be set as they are", files.len());
    Ok(())
}
