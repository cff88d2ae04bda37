//! Runs a program only to find how long it takes, and how far it leaves its path.

use isostep_report::timing;
use isostep_sim::verify::HomingTime;
use serde::Serialize;

use crate::config;
use crate::departures::Departures;
use crate::sent::Sent;
use crate::trouble::Trouble;

/// A program under way of which nothing is drawn or checked. No edges are made, unless it homes: that needs carriages that move.
pub struct Quick {
    sent: Sent,
    homing: HomingTime,
    departures: Departures,
}

/// The findings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// The time of the program without homing, s.
    pub program_s: f64,
    /// Why it does not reach its end, if it does not.
    pub stopped: Option<String>,
    /// How far the axes leave its path.
    #[serde(flatten)]
    pub departures: Departures,
}

impl Quick {
    /// Sends `program` to a machine at power-up with these settings, lines of `$n=v`.
    ///
    /// # Errors
    /// [`Trouble`] with the line of the program, or of the settings, that cannot be.
    pub fn new(program: &[u8], settings: &str) -> Result<Self, Trouble> {
        let sent = Sent::new(program, config(settings)?, true)?;
        Ok(Self { sent, homing: HomingTime::default(), departures: Departures::default() })
    }

    /// Runs until `until_us` since power-up, and returns whether the program has come to its end.
    ///
    /// # Errors
    /// [`Trouble`] if it never ends.
    pub fn advance(&mut self, until_us: f64) -> Result<bool, Trouble> {
        let (has_ended, piece) = self.sent.advance(until_us)?;
        self.homing.add(&piece);
        self.departures.add(&piece);
        Ok(has_ended)
    }

    /// Machine time, us since power-up.
    pub fn now_us(&self) -> f64 {
        self.sent.now_us()
    }

    /// Lines answered so far.
    pub fn answered(&self) -> usize {
        self.sent.answered()
    }

    /// Lines of the program.
    pub fn lines(&self) -> usize {
        self.sent.lines()
    }

    /// Its end.
    ///
    /// # Errors
    /// [`Trouble`] if the machine did not answer a line.
    pub fn end(self) -> Result<Found, Trouble> {
        let Self { sent, mut homing, mut departures } = self;
        let end = sent.end()?;
        homing.add(&end);
        departures.add(&end);
        let program_ns = end.duration_ns - homing.total_ns();
        Ok(Found { program_s: program_ns as f64 * 1e-9, stopped: timing::stopped(&end), departures })
    }
}
