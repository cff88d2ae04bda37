//! The simulated machine behind the bridge's interface.

use anyhow::Result;
use isostep_sim::{Config, Sim};

use super::{Closing, Machine};

/// Grbl's baud rate.
pub const BAUD: u32 = 115_200;

/// The controller in virtual time.
pub struct Simulated(Sim);

impl Simulated {
    /// A machine at power-up with its console on a UART. `config` must have been checked.
    pub fn new(config: Config) -> Self {
        Self(Sim::new(&Config { baud: Some(BAUD), ..config }))
    }

    /// The simulation itself.
    pub fn sim(&self) -> &Sim {
        &self.0
    }
}

/// The default machine, without a record of what it does.
impl Default for Simulated {
    fn default() -> Self {
        Self::new(Config { keep_record: false, ..Config::default() })
    }
}

impl Machine for Simulated {
    fn now_ns(&self) -> u64 {
        self.0.now_ns()
    }

    fn unread(&self) -> usize {
        self.0.unread()
    }

    fn set_open(&mut self, open: bool) -> Result<bool> {
        if open {
            self.0.open_console();
        }
        Ok(open)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.0.send(bytes);
        Ok(())
    }

    fn run_to(&mut self, at_ns: u64) -> Result<Vec<u8>> {
        self.0.run_to(at_ns)?;
        Ok(self.0.received())
    }

    fn close(&mut self) -> Result<Closing> {
        let outcome = self.0.outcome();
        Ok(Closing {
            state: outcome.state_words(),
            position_mm: outcome.position_mm,
            position_steps: outcome.position_steps,
            steps: self.0.steps(),
            steps_lost: Some(outcome.losses.iter().map(|loss| u64::from(loss.steps)).sum()),
            timing_violations: outcome.violations.len() as u64,
        })
    }
}
