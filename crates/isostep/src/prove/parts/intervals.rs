//! Equal intervals: of a diagonal move, each axis's times of acceleration, cruise and deceleration from its own edges.

use anyhow::{Context, Result, ensure};
use isostep_sim::Port;
use isostep_sim::measure::{self, Way};

use super::super::judge;
use super::super::stamped::{PADS, Stamped, ramp};
use super::edges::tell;
use crate::measure::planned_move::{NAMES, PROVED, UNIT_STEPS};
use crate::measure::{Better, Figure, Findings, Machine};

/// Slow enough that a whole move is one window, and its ramps have many edges.
const RATE_STEPS_S: u32 = 20_000;
const RAMP_S: f64 = 0.02;
/// The steps of the axes are as these numbers.
const SHARES: [i32; PROVED] = [4, 3, 2];

pub fn measure(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    let unit = board.identity.window as i32 / SHARES[0];
    let unit = (unit / UNIT_STEPS).min(3) * UNIT_STEPS;
    ensure!(
        unit > 0,
        "a window of {} stamps holds no whole move: {} are needed",
        board.identity.window,
        SHARES[0] * UNIT_STEPS
    );
    let machine = Machine::new(RATE_STEPS_S, ramp(RAMP_S));
    board.set_up(&machine)?;
    let planned = machine.planned(SHARES.map(|share| share * unit))?;
    let (stamps, alarm) = board.stamped(&planned, PADS, 0)?;
    ensure!(alarm.is_none(), "the move ended in {}", alarm.unwrap_or_default());
    let windows = board.windows(&[0, 1, 2], &stamps, 0);
    let verdict = judge::judge(&planned, &windows);
    tell(&mut found.faults, &verdict.faults, "the diagonal move");
    let measured = windows.iter().map(|window| {
        let times_s: Vec<f64> = window.instants_ns.iter().map(|ns| (ns - verdict.start_ns) * 1e-9).collect();
        let way = Way::whole(planned.count(window.axis) as usize);
        measure::intervals_of(planned.profile(), &way, &times_s, Port::Pio)
            .with_context(|| format!("the edges of {} lie on no trapezoid", NAMES[window.axis]))
    });
    let measured: Vec<_> = measured.collect::<Result<_>>()?;
    let apart = |one: usize, other: usize| measured[one].intervals.apart_s(&measured[other].intervals) * 1e9;
    let resolution_ns = measured.iter().map(|each| each.resolution_s * 1e9).fold(0.0, f64::max);
    let figure =
        Figure::new("intervals", "intervals of three axes of a diagonal move, from the edges of each: apart by", "ns")
            .measured(
                apart(0, 1).max(apart(0, 2)).max(apart(1, 2)).round(),
                format!("{resolution_ns:.0} ns, by the edges' own distances"),
            )
            .flattered_by("lines are fitted through many edges, so what one edge is off does not show")
            .compared(Better::Lower, 0.0, resolution_ns.round())
            .promised((2.0 * resolution_ns).round());
    found.add(figure);
    Ok(())
}
