//! How a machine on a pseudo-terminal is told to end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Result;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

/// Whether the machine is to end. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct Ending(Arc<AtomicBool>);

impl Ending {
    /// On Ctrl-C, SIGTERM, or when the terminal goes away; at the second time at once, without a summary.
    pub fn by_signal() -> Result<Self> {
        let ending = Self::default();
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            // In this order: the flag is looked at before it is set.
            flag::register_conditional_shutdown(signal, 128 + signal, ending.0.clone())?;
            flag::register(signal, ending.0.clone())?;
        }
        Ok(ending)
    }

    /// Asks it to end.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
