//! What reading flash costs on this chip: the one assumption of the emulator that no data sheet settles.

use anyhow::Result;

use super::super::stamped::{Stamped, ramp};
use crate::measure::course::PROVED;
use crate::measure::{Better, Figure, Findings, Machine};

/// A mean is given in hundredths of a cycle.
const PARTS: f64 = 100.0;

pub fn measure(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    let [hit, cold, uncached] = board.session.numbers::<3>("$PROVE=CACHE", "CACHE")?.map(|parts| parts / PARTS);
    let costs = [
        ("cache.hit", "reading a word of flash that is in the cache", hit),
        ("cache.cold", "the same if it is not, a line of 8 bytes each", cold),
        ("cache.uncached", "the same by the alias that has no cache", uncached),
        ("cache.miss", "what a miss costs more than a hit", cold - hit),
    ];
    for (key, what, cycles) in costs {
        let figure = Figure::new(key, what, "cycles")
            .measured(cycles, "0.01 cycles, a mean of many reads")
            .flattered_by("reads one after the other; the instructions around them are counted in")
            .compared(Better::Lower, 0.05, 0.5);
        found.add(figure);
    }
    let machine = Machine::new(100_000, ramp(0.02));
    let course = machine.straight(PROVED, 0.1)?;
    board.set_up(&machine)?;
    board.session.numbers::<2>("$PROVE=COUNT", "COUNT")?;
    for course in [course.clone(), course.back()] {
        board.make(&course)?;
    }
    let [hits, accesses] = board.session.numbers("$PROVE=COUNT", "COUNT")?;
    let share = if accesses > 0.0 { 100.0 * hits / accesses } else { 0.0 };
    let what = "reads of flash that its cache answered, in two moves and their lines, by the chip's counters";
    let figure = Figure::new("cache.hits", what, "%")
        .measured((share * 100.0).round() / 100.0, format!("{hits} of {accesses} reads"))
        .compared(Better::Higher, 0.0, 1.0);
    found.add(figure);
    Ok(())
}
