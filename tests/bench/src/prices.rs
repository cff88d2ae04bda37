//! `cargo xtask bench --prices`: what the figures of an RP2350 come to if its core or its flash is slower than is assumed of them.
//!
//! # Design
//! The same measurements on each of the chips, which differ in an assumption. Edges are not among them: hardware makes those.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use isostep::measure::moves::Corners;
use isostep::measure::rates::Trials;
use isostep::measure::{Figure, Findings, load, moves, rates, stops, table};
use isostep::parallel;

use super::chip::Chip;
use super::effort::Effort;
use super::port::Port;
use super::runs::Runs;
use super::{Images, RAMP, causes, curve, emulated};

/// The chips, in the order of the columns.
const CHIPS: [Chip; 5] = [Chip::AsItIs, Chip::CostlyMiss, Chip::DearMiss, Chip::SlowCore, Chip::SlowCoreAndDearMiss];
/// The emulated boards that run at once.
const AT_ONCE: usize = 2;
/// Stops of each kind.
const STOPS: u32 = 8;

/// Runs the verb. `folder` is for the files of the runs.
///
/// # Errors
/// A run that cannot be made.
pub fn run(images: &Images, folder: &Path) -> Result<()> {
    let found = parallel::map(&CHIPS, AT_ONCE, |&chip| measure(images, chip, folder));
    let found = found.into_iter().collect::<Result<Vec<_>>>()?;
    let model = images.candidates[0].model;
    println!(
        "Emulated: {}, {}. Columns: as it is assumed to be; and as it may be instead.\n",
        model.name(),
        model.clocked()
    );
    let all: [&Findings; CHIPS.len()] = std::array::from_fn(|index| &found[index]);
    let rows = table::by_key(all).into_iter().map(|row| {
        let cells = [table::name(&row)].into_iter().chain(row.iter().map(|&cell| table::value(cell)));
        cells.collect::<Vec<_>>().try_into().unwrap_or_default()
    });
    print!("{}", table::text(head(), rows.collect()));
    let missing = CHIPS.iter().zip(&found).flat_map(|(chip, found)| {
        let of_figure =
            |figure: &Figure| Some(format!("{}: {}: {}", chip.name(), figure.what, figure.why_not.clone()?));
        found.figures.iter().filter_map(of_figure)
    });
    missing.for_each(|line| println!("{line}"));
    Ok(())
}

/// The names of the columns.
fn head() -> [&'static str; 1 + CHIPS.len()] {
    std::array::from_fn(|column| column.checked_sub(1).map_or("figure", |index| CHIPS[index].name()))
}

fn measure(images: &Images, chip: Chip, folder: &Path) -> Result<Findings> {
    let folder = folder.join(format!("prices-{}", chip.slug()));
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let (port, effort) = (Port::Pio, Effort { stops: STOPS, ..Effort::quick(Chip::AsItIs) });
    let mut board = emulated(Runs::new(&images.candidates[0], chip, &folder), port, &effort);
    let mut found = Findings::default();
    let trials = Trials { axes: effort.axes, rates: &effort.rates, ramp: RAMP, cruise_s: effort.cruise_s };
    rates::measure(&mut board, &mut found, &trials)?;
    load::measure(&mut board, &mut found, port.load_rates_steps_s())?;
    stops::measure(&mut board, &mut found, causes(port, false), port.target_steps_s(), effort.stops)?;
    moves::measure(&mut board, &mut found, &curve(effort.moves, port.moves_feed_mm_min()), &Corners::ALL)?;
    Ok(found)
}
