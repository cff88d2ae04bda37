//! Ends a machine on a pseudo-terminal.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Result;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

/// The machine should end. Clones share the flag.
#[derive(Clone, Debug, Default)]
pub struct Ending(Arc<AtomicBool>);

impl Ending {
    /// Set by Ctrl-C, by SIGTERM, or when the terminal closes. The second signal ends the process at once, without a
    /// summary.
    pub fn by_signal() -> Result<Self> {
        let ending = Self::default();
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            // The order matters: the shutdown must test the flag before the second handler sets it.
            flag::register_conditional_shutdown(signal, 128 + signal, ending.0.clone())?;
            flag::register(signal, ending.0.clone())?;
        }
        Ok(ending)
    }

    /// Requests the end.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// The end was requested.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
