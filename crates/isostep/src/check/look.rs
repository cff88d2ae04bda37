//! Checks a program on each of several machines.

use std::path::Path;

use indicatif::ProgressBar;
use isostep_console::Settings;
use isostep_report::check::{Check, Stand};
use serde::Serialize;

use crate::{project, sim};

/// A machine that programs are checked for.
pub struct Machine {
    pub name: String,
    pub settings: Settings,
}

/// A program and the results of its check.
#[derive(Serialize)]
pub struct Checked {
    pub program: String,
    /// Why the file is not a readable program.
    pub unreadable: Option<String>,
    /// The results on each machine.
    pub on: Vec<On>,
}

/// The results of a program on one machine.
#[derive(Serialize)]
pub struct On {
    pub machine: String,
    #[serde(flatten)]
    pub check: Check,
}

impl Checked {
    /// The program would run unchanged on each machine.
    pub fn is_good(&self) -> bool {
        self.unreadable.is_none() && self.on.iter().all(|on| on.check.is_good())
    }
}

/// Checks a program. A file that cannot be read counts as a program that would not run.
pub fn check(path: &Path, machines: &[Machine], stand: Stand, bar: &ProgressBar) -> Checked {
    let program = project::shown(path);
    match sim::raw_lines(path) {
        Ok(lines) => {
            bar.inc_length((lines.len() * machines.len()) as u64);
            let on = |machine: &Machine| On {
                machine: machine.name.clone(),
                check: Check::of(&lines, &machine.settings, stand, &mut |done| bar.inc(done as u64)),
            };
            Checked { program, unreadable: None, on: machines.iter().map(on).collect() }
        }
        Err(error) => Checked { program, unreadable: Some(error.root_cause().to_string()), on: Vec::new() },
    }
}
