//! Progress of the verb, on a terminal in one line that is written again and again, elsewhere only the beginning of each
//! measurement.

use std::time::Duration;

use indicatif::ProgressBar;

use crate::screen::announce;

/// The interval at which the line moves.
const TICK: Duration = Duration::from_millis(120);

/// The line.
pub struct Progress(ProgressBar);

impl Progress {
    /// Begins to show.
    pub fn begin() -> Self {
        let bar = ProgressBar::new_spinner();
        bar.enable_steady_tick(TICK);
        Self(bar)
    }

    /// A measurement begins.
    pub fn part(&self, name: &str) {
        self.0.suspend(|| announce(name));
    }

    /// Shows what it is at now.
    pub fn step(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
