//! The time from power to ready, as the image itself has noted it.

use anyhow::Result;

use super::super::stamped::Stamped;
use crate::measure::{Better, Figure, Findings};

pub fn measure(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    let figure = Figure::new("ready", "from the start of the chip's timer to ready consoles", "ms");
    let figure = figure.compared(Better::Lower, 0.3, 1.0);
    found.add(match board.identity.ready_us {
        Some(us) => figure.measured(us * 1e-3, "1 us").flattered_by(
            "what is before it, some 0.3 s: the boot loader in ROM, and copying the image to RAM by the slow first clock",
        ),
        None => figure.missing("the image does not say"),
    });
    Ok(())
}
