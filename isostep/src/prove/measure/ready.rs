//! The time from power to ready, as the image itself has noted it.

use anyhow::Result;

use super::super::proof::{Better, Figure};
use super::Bench;

pub fn measure(bench: &mut Bench) -> Result<()> {
    let board = &bench.identity;
    let ready = figure("ready", "from the start of the timer to ready consoles", board.ready_us)
        .flattered_by("what is before it: the boot loader in ROM, and a part of what is copied to RAM");
    let copied = figure("ready.copy", "of that, copying the image to RAM", board.copy_us)
        .flattered_by("the clock of the chip is then its ring oscillator, which differs by tens of percent");
    bench.add(ready);
    bench.add(copied);
    Ok(())
}

fn figure(key: &str, what: &str, us: Option<f64>) -> Figure {
    let figure = Figure::new(key, what, "ms").compared(Better::Lower, 0.3, 1.0);
    match us {
        Some(us) => figure.measured(us * 1e-3, "1 us"),
        None => figure.missing("the image does not say"),
    }
}
