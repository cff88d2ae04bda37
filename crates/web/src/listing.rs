//! A `$$` of somebody's machine, read for this one.

use isostep_report::check::Row;
use isostep_report::listing::Listing;
use isostep_sim::Config;
use serde::Serialize;

/// What becomes of a listing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Listed {
    /// What is taken, as lines of `$n=v`: those that `isostep check --settings --write` writes. `None` if that does not work together.
    pub taken: Option<String>,
    /// What is said of each line that is not simply taken, as `isostep check --settings` prints it.
    pub rows: Vec<Row>,
}

/// Reads the listing `text` of Grbl, grblHAL, FluidNC or Isostep.
pub fn read(text: &[u8]) -> Listed {
    let listing = Listing::read("settings", text, &Config::default());
    Listed { taken: listing.settings.is_some().then(|| listing.text()), rows: listing.rows() }
}
