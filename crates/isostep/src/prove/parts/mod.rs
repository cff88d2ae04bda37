//! The measurements of a proof, in order: those that every board has ([`crate::measure`]), and those that only the proving image
//! has, a file each.

mod chip;
pub mod edges;
mod intervals;

use anyhow::{Context, Result};

use super::how::Part;
use super::stamped::{Stamped, ramp};
use crate::measure::moves::{Corners, Curve};
use crate::measure::rates::Trials;
use crate::measure::stops::Cause;
use crate::measure::{Findings, load, moves, rates, starts, stops};

/// The step outputs of the proving image carry 4,166,666 steps/s, and it refuses more.
const RATE_MAX_STEPS_S: u32 = 4_150_000;
/// A period of this rate is 4 us, and a window lasts some milliseconds.
const STOPPED_STEPS_S: u32 = 250_000;
const STOPS: [Cause; 3] = [Cause::LimitSwitch, Cause::EmergencyStop, Cause::SecondReset];
/// Length of a short move, mm. Their curve is an ellipse in space about this place, of this radius.
const MOVE_MM: f64 = 0.2;
const CENTRE_MM: f64 = 500.0;
const RADIUS_MM: f64 = 20.0;

/// A measurement, and its name in words.
type Measurement = (Part, &'static str, fn(&mut Stamped, &mut Findings) -> Result<()>);

/// All of them, in order.
const ALL: [Measurement; 11] = [
    (Part::Ready, "time from power to ready", chip::ready),
    (Part::Edges, "edges against the closed form", edges::measure),
    (Part::Intervals, "equal intervals", intervals::measure),
    (Part::Rates, "highest rates", |board, found| {
        let step = board.how.effort.rate_step;
        let all: Vec<u32> = (1..=RATE_MAX_STEPS_S / step).map(|number| number * step).collect();
        let trials = Trials { axes: &[1, 2, 3], rates: &all, ramp: ramp(0.1), cruise_s: 0.05 };
        rates::measure(board, found, &trials).map(drop)
    }),
    (Part::Stops, "stops", |board, found| {
        let count = board.how.effort.stops;
        stops::measure(board, found, &STOPS, STOPPED_STEPS_S, count)
    }),
    (Part::Moves, "short moves", |board, found| {
        let curve = curve(board.how.effort.moves);
        moves::measure(board, found, &curve, &[Corners::Exact, Corners::Blends, Corners::Together, Corners::Zv])
    }),
    (Part::Load, "load of the core", |board, found| load::measure(board, found, &[10_000, 100_000, 1_000_000])),
    (Part::Cache, "flash and its cache", chip::cache),
    (Part::Starts, "starts", |board, found| {
        let count = board.how.effort.starts;
        starts::measure(board, found, count)
    }),
    (Part::Crystal, "the crystal", chip::crystal),
    (Part::Laser, "the laser's pin", chip::laser),
];

/// Makes every measurement. One that fails on a board that still answers is a remark, and the next one follows.
///
/// # Errors
/// When the board is gone, or the user has interrupted.
pub fn all(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    // The reset before this has pulled the pad down, to which a wire may lead from a switch.
    board.settle()?;
    let only = &board.how.only;
    let wanted: Vec<Measurement> =
        ALL.into_iter().filter(|(part, ..)| only.is_empty() || only.contains(part)).collect();
    for (index, (_, name, measure)) in wanted.iter().enumerate() {
        board.progress.part(&format!("{}/{} {name}", index + 1, wanted.len()));
        let measured = measure(board, found);
        found.faults.append(&mut board.faults);
        // The next one begins with a machine at rest and without an alarm.
        board.settle().context("the board is not at rest after a measurement").or_else(|unsettled| {
            // What broke the measurement is the cause of that.
            measured.as_ref().map_or(Ok(()), |()| Err(unsettled))
        })?;
        if let Err(error) = measured {
            board.session.ask("$PROVE").map_err(|_| anyhow::anyhow!("{name}: {error:#}"))?;
            found.remarks.push(format!("{name}: not measured: {error:#}"));
        }
    }
    Ok(())
}

/// A curve of short moves at a feed that the core cannot keep.
fn curve(count: u32) -> Curve {
    let line = |index: u32| {
        let angle = f64::from(index + 1) * MOVE_MM / RADIUS_MM;
        let (x, y) = (CENTRE_MM + RADIUS_MM * angle.cos(), CENTRE_MM + RADIUS_MM * angle.sin());
        format!("X{x:.3}Y{y:.3}Z{:.3}", CENTRE_MM + (y - CENTRE_MM) / 2.0)
    };
    let begin_mm = [CENTRE_MM + RADIUS_MM, CENTRE_MM, CENTRE_MM];
    Curve { begin_mm, feed_mm_min: 48_000.0, lines: (0..count).map(line).collect(), steps: Vec::new() }
}
