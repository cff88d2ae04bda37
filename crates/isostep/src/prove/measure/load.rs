//! The core's load while three axes cruise, and how long an interrupt waits meanwhile.

use anyhow::Result;

use super::super::proof::{Better, Figure};
use super::{Bench, together};
use crate::screen::grouped;

const RATES: [u32; 3] = [10_000, 100_000, 1_000_000];
const RAMP_S: f64 = 0.1;
/// How long the load is measured, and how long the move cruises around that.
const MEASURED_S: f64 = 0.5;
const CRUISE_S: f64 = 1.0;

pub fn measure(bench: &mut Bench) -> Result<()> {
    let mut waited_cycles = 0.0_f64;
    for rate_steps_s in RATES {
        let (machine, course) = together(rate_steps_s, RAMP_S, CRUISE_S)?;
        bench.set_up(&machine)?;
        // This begins to measure, and the one after the move ends it: programming settings into the flash masks interrupts
        // for long, at rest, and does not count.
        bench.board.numbers::<1>("$PROVE=MASK", "MASK")?;
        bench.board.ask(&course.line())?;
        bench.board.wait(course.profile().t_accel_s() + (CRUISE_S - MEASURED_S) / 2.0)?;
        bench.board.numbers::<2>("$PROVE=LOAD", "LOAD")?;
        bench.board.wait(MEASURED_S)?;
        let [asleep_us, all_us] = bench.board.numbers("$PROVE=LOAD", "LOAD")?;
        bench.board.rest()?;
        let [cycles] = bench.board.numbers("$PROVE=MASK", "MASK")?;
        waited_cycles = waited_cycles.max(cycles);
        let awake = 100.0 * (1.0 - asleep_us / all_us.max(1.0));
        let rate = grouped(rate_steps_s.into());
        let figure = Figure::new(
            format!("load.{rate_steps_s}"),
            format!("core awake while 3 axes cruise at {rate} steps/s"),
            "%",
        )
        .measured((awake * 100.0).round() / 100.0, format!("1 us of {:.0} ms", all_us * 1e-3))
        .flattered_by("nobody asks for reports meanwhile, and a cruise is less work than a ramp")
        .compared(Better::Lower, 0.1, 0.5);
        bench.add(figure);
    }
    let figure = Figure::new("mask", "longest time for which an interrupt waited, in these moves", "us")
        .measured(waited_cycles * 8e-3, "8 ns, a look each 160 us")
        .flattered_by("a look each 160 us may miss the longest; programming the flash, at rest, is not in it")
        .compared(Better::Lower, 0.2, 0.5);
    bench.add(figure);
    Ok(())
}
