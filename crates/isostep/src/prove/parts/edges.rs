//! Every edge of moves of three axes against the closed form.
//!
//! # Method
//! A move has more edges than the chip can keep stamps of. So the same move is made again and again, there and back,
//! and each time another part of its edges is stamped: the first one, which all have in common, and a window that
//! begins where the one before ended. One stamper a pad sees all axes at once. Two on one pad see it to the cycle,
//! with the third on the next axis; there are three such pairs.

use anyhow::Result;

use super::super::judge::{self, Fault, Fineness, PROMISE_NS, Window};
use super::super::stamped::{PADS, Stamped, ramp};
use crate::console::explained;
use crate::measure::edges::Edges;
use crate::measure::errors::Errors;
use crate::measure::planned_move::{NAMES, PROVED};
use crate::measure::{Board, Findings, Machine, Measured, PlannedMove, together};

/// A ramp lasts so long, or longer at rates that would ask for more than the fastest machines.
const RAMP_S: f64 = 0.02;
const CRUISE_S: f64 = 0.01;
/// Faults of a measurement that are reported one by one.
const REPORTED_MAX: usize = 20;
/// The times that a window is tried whose stamper has lost stamps.
const TRIES: u32 = 3;

pub fn measure(board: &mut Stamped, found: &mut Findings) -> Result<()> {
    for rate_steps_s in board.how.effort.rates.clone() {
        let machine = Machine::new(rate_steps_s, ramp(RAMP_S));
        let planned = machine.straight(PROVED, CRUISE_S)?;
        let unit_ns = |fineness: Fineness| fineness.unit_ns(board.chip);
        let edges = |fineness: Fineness| Edges {
            key: format!("edges.{rate_steps_s}.{:.0}", unit_ns(fineness)),
            of: format!("{}, by {:.0} ns", together(rate_steps_s), unit_ns(fineness)),
            unit_ns: unit_ns(fineness),
            flatters: board.method().edges,
            made: planned.edges(),
        };
        let of = [Fineness::Single, Fineness::Pair].map(|fineness| (fineness, edges(fineness)));
        if let Err(refused) = board.set_up(&machine) {
            found.add(of[0].1.worst().missing(format!("{refused:#}")));
            continue;
        }
        for (fineness, edges) in of {
            match see(board, &planned, rate_steps_s, fineness)? {
                Ok(seen) => seen.add_to(found, &edges, rate_steps_s),
                Err(alarm) => {
                    let rate = together(rate_steps_s);
                    found.faults.push(format!("at {rate}: the move ended in {}", explained(&alarm)));
                    found.add(edges.worst().missing(format!("the move ended in {alarm}")));
                    board.settle()?;
                }
            }
        }
    }
    Ok(())
}

/// The edges seen of a kind of move.
#[derive(Default)]
struct Seen {
    errors: Errors,
    /// The edges of each axis that have been stamped already: windows overlap.
    stamped: [Vec<bool>; PROVED],
    /// Windows in which a stamper lost some, however often they were tried.
    windows_lost: u32,
    faults: Vec<Fault>,
}

/// Looks at all windows. A move that ends in an alarm ends that.
fn see(board: &mut Stamped, planned: &PlannedMove, rate_steps_s: u32, fineness: Fineness) -> Result<Measured<Seen>> {
    let most = match fineness {
        Fineness::Single => board.how.effort.windows,
        Fineness::Pair => board.how.effort.pair_windows,
    };
    let skips = board.skips(planned.count(0), most);
    let watched: &[[usize; 3]] = match fineness {
        Fineness::Single => &[[0, 1, 2]],
        Fineness::Pair => &[[0, 0, 1], [1, 1, 2], [2, 2, 0]],
    };
    let (mut seen, mut planned) = (Seen::new(planned), planned.clone());
    for (index, &skip) in skips.iter().enumerate() {
        for axes in watched {
            board.progress.step(&format!(
                "edges at {}, by {:.0} ns: window {} of {}",
                together(rate_steps_s),
                fineness.unit_ns(board.chip),
                index + 1,
                skips.len()
            ));
            match windows(board, &mut planned, *axes, skip, fineness)? {
                Ok(windows) => seen.take(&planned, &windows),
                Err(alarm) => return Ok(Err(alarm)),
            }
        }
    }
    Ok(Ok(seen))
}

/// The windows of one move, which is tried again if a stamper has lost some.
fn windows(
    board: &mut Stamped,
    planned: &mut PlannedMove,
    axes: [usize; 3],
    skip: u32,
    fineness: Fineness,
) -> Result<Measured<Vec<Window>>> {
    let mut windows = Vec::new();
    for _ in 0..TRIES {
        let pads = axes.map(|axis| PADS[axis]);
        let (stamps, alarm) = board.stamped(planned, pads, skip)?;
        if let Some(alarm) = alarm {
            return Ok(Err(alarm));
        }
        *planned = planned.back();
        windows = match fineness {
            Fineness::Single => board.windows(&axes, &stamps, skip),
            // The third stamper is there so that every pad has a turn beside another; its edges are in the other windows.
            Fineness::Pair => vec![board.pair_window(axes[0], skip, [&stamps[0], &stamps[1]])?],
        };
        if windows.iter().all(|window| !window.lost) {
            break;
        }
    }
    Ok(Ok(windows))
}

impl Seen {
    fn new(planned: &PlannedMove) -> Self {
        Self { stamped: std::array::from_fn(|axis| vec![false; planned.count(axis) as usize]), ..Self::default() }
    }

    fn take(&mut self, planned: &PlannedMove, windows: &[Window]) {
        let verdict = judge::judge(planned, windows);
        for (window, judged) in windows.iter().zip(&verdict.judged) {
            self.windows_lost += u32::from(window.lost);
            for one in judged {
                if !std::mem::replace(&mut self.stamped[window.axis][one.number as usize - 1], true) {
                    self.errors.add(one.error_ns);
                }
            }
        }
        self.faults.extend(verdict.faults);
    }

    fn add_to(self, found: &mut Findings, edges: &Edges, rate_steps_s: u32) {
        let at = together(rate_steps_s);
        if self.windows_lost > 0 {
            found.remarks.push(format!(
                "in {} windows at {at} the stampers themselves lost stamps: their edges were not seen; nothing is said of them",
                self.windows_lost
            ));
        }
        tell(&mut found.faults, &self.faults, &at);
        edges.add(found, self.errors, Some(PROMISE_NS + edges.unit_ns));
    }
}

/// Adds faults, each as a sentence; if there are many, how many more there are.
pub fn tell(faults: &mut Vec<String>, found: &[Fault], at: &str) {
    faults.extend(found.iter().take(REPORTED_MAX).map(|fault| format!("at {at}: {fault}")));
    if let Some(more) = found.len().checked_sub(REPORTED_MAX).filter(|more| *more > 0) {
        faults.push(format!("at {at}: and {more} more of this kind on {}", NAMES.join(", ")));
    }
}
