//! Every edge of moves of three axes against the closed form.
//!
//! # Method
//! A move has more edges than the chip can keep stamps of. So the same move is made again and again, there and back,
//! and each time another part of its edges is stamped: the first one, which all have in common, and a window that
//! begins where the one before ended. One stamper a pad sees all axes at once. Two on one pad see it to the cycle,
//! with the third on the next axis; there are three such pairs.

use anyhow::Result;

use super::super::course::{Course, NAMES, PROVED};
use super::super::edges::{self, Fault, Fineness, PROMISE_NS, Window};
use super::super::errors::Errors;
use super::super::proof::{Better, EdgeErrors, Figure};
use super::{Bench, PADS, together};
use crate::console::explained;
use crate::screen::grouped;

/// A ramp lasts so long, or longer at rates that would ask for more than the fastest machines.
const RAMP_S: f64 = 0.02;
const CRUISE_S: f64 = 0.01;
/// Faults of a measurement that are reported one by one.
const REPORTED_MAX: usize = 20;
/// How often a window is tried whose stamper has lost stamps.
const TRIES: u32 = 3;

pub fn measure(bench: &mut Bench) -> Result<()> {
    for rate_steps_s in bench.how.effort.rates.clone() {
        let (machine, course) = together(rate_steps_s, RAMP_S, CRUISE_S)?;
        if let Err(refused) = bench.set_up(&machine) {
            bench.add(worst(rate_steps_s, Fineness::Single).missing(format!("{refused:#}")));
            continue;
        }
        for fineness in [Fineness::Single, Fineness::Pair] {
            match see(bench, &course, rate_steps_s, fineness)? {
                Ok(seen) => seen.add_to(bench, &course, rate_steps_s, fineness),
                Err(alarm) => {
                    let rate = grouped(rate_steps_s.into());
                    bench.proof.faults.push(format!("at 3 x {rate} steps/s: the move ended in {}", explained(&alarm)));
                    bench.add(worst(rate_steps_s, fineness).missing(format!("the move ended in {alarm}")));
                    bench.settle()?;
                }
            }
        }
    }
    Ok(())
}

/// What was seen of a kind of move.
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
fn see(bench: &mut Bench, course: &Course, rate_steps_s: u32, fineness: Fineness) -> Result<Result<Seen, String>> {
    let most = match fineness {
        Fineness::Single => bench.how.effort.windows,
        Fineness::Pair => bench.how.effort.pair_windows,
    };
    let skips = bench.skips(course.count(0), most);
    let watched: &[[usize; 3]] = match fineness {
        Fineness::Single => &[[0, 1, 2]],
        Fineness::Pair => &[[0, 0, 1], [1, 1, 2], [2, 2, 0]],
    };
    let (mut seen, mut course) = (Seen::new(course), course.clone());
    for (index, &skip) in skips.iter().enumerate() {
        for axes in watched {
            let rate = grouped(rate_steps_s.into());
            bench.progress.step(&format!(
                "edges at 3 x {rate} steps/s, by {:.0} ns: window {} of {}",
                fineness.unit_ns(),
                index + 1,
                skips.len()
            ));
            match windows(bench, &mut course, *axes, skip, fineness)? {
                Ok(windows) => seen.take(&course, &windows),
                Err(alarm) => return Ok(Err(alarm)),
            }
        }
    }
    Ok(Ok(seen))
}

/// The windows of one move, which is tried again if a stamper has lost some.
fn windows(
    bench: &mut Bench,
    course: &mut Course,
    axes: [usize; 3],
    skip: u32,
    fineness: Fineness,
) -> Result<Result<Vec<Window>, String>> {
    let mut windows = Vec::new();
    for _ in 0..TRIES {
        let pads = axes.map(|axis| PADS[axis]);
        let (stamps, alarm) = bench.stamped(course, pads, skip)?;
        if let Some(alarm) = alarm {
            return Ok(Err(alarm));
        }
        *course = course.back();
        windows = match fineness {
            Fineness::Single => bench.windows(&axes, &stamps, skip),
            // The third stamper is there so that every pad has a turn beside another; its edges are in the other windows.
            Fineness::Pair => vec![bench.pair_window(axes[0], skip, [&stamps[0], &stamps[1]])?],
        };
        if windows.iter().all(|window| !window.lost) {
            break;
        }
    }
    Ok(Ok(windows))
}

impl Seen {
    fn new(course: &Course) -> Self {
        Self { stamped: std::array::from_fn(|axis| vec![false; course.count(axis) as usize]), ..Self::default() }
    }

    fn take(&mut self, course: &Course, windows: &[Window]) {
        let verdict = edges::judge(course, windows);
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

    fn add_to(self, bench: &mut Bench, course: &Course, rate_steps_s: u32, fineness: Fineness) {
        let made: u64 = (0..PROVED).map(|axis| u64::from(course.count(axis))).sum();
        let rate = grouped(rate_steps_s.into());
        let key = key(rate_steps_s, fineness);
        bench.add(worst(rate_steps_s, fineness).measured(self.errors.max_ns(), resolution(fineness)));
        let of = |what: &str| format!("{what}, 3 x {rate} steps/s, by {:.0} ns", fineness.unit_ns());
        let p99 = Figure::new(format!("{key}.p99"), of("99 % of the edges within"), "ns");
        bench.add(p99.measured(self.errors.quantile_ns(0.99), resolution(fineness)).compared(
            Better::Lower,
            0.0,
            fineness.unit_ns(),
        ));
        let seen = Figure::new(format!("{key}.seen"), of("edges that were stamped"), "");
        let unseen = made.saturating_sub(self.errors.count());
        let reported = format!(
            "of {} in a move of three axes; {} were not looked at, or not seen",
            grouped(made),
            grouped(unseen)
        );
        bench.add(seen.measured(self.errors.count() as f64, reported).compared(Better::Unjudged, 0.0, 0.0));
        if self.windows_lost > 0 {
            bench.proof.remarks.push(format!(
                "in {} windows at 3 x {rate} steps/s the stampers themselves lost stamps: their edges were not seen; nothing is said of them",
                self.windows_lost
            ));
        }
        tell(&mut bench.proof.faults, &self.faults, &format!("3 x {rate} steps/s"));
        bench.proof.edges.push(EdgeErrors {
            what: of("Edges"),
            made,
            errors: self.errors,
            unit_ns: fineness.unit_ns(),
        });
    }
}

/// Adds faults, each as a sentence; if there are many, how many more there are.
pub fn tell(faults: &mut Vec<String>, found: &[Fault], at: &str) {
    faults.extend(found.iter().take(REPORTED_MAX).map(|fault| format!("at {at}: {fault}")));
    if let Some(more) = found.len().checked_sub(REPORTED_MAX).filter(|more| *more > 0) {
        faults.push(format!("at {at}: and {more} more of this kind on {}", NAMES.join(", ")));
    }
}

fn key(rate_steps_s: u32, fineness: Fineness) -> String {
    format!("edges.{rate_steps_s}.{:.0}", fineness.unit_ns())
}

fn worst(rate_steps_s: u32, fineness: Fineness) -> Figure {
    let rate = grouped(rate_steps_s.into());
    let what = format!("farthest edge from the closed form, 3 x {rate} steps/s, by {:.0} ns", fineness.unit_ns());
    Figure::new(format!("{}.max", key(rate_steps_s, fineness)), what, "ns")
        .flattered_by(
            "the start of the move is fitted as the median error, so a delay common to all edges does not show",
        )
        .compared(Better::Lower, 0.0, fineness.unit_ns())
        .promised(PROMISE_NS + fineness.unit_ns())
}

fn resolution(fineness: Fineness) -> String {
    format!("{:.0} ns, so up to {:.0} ns of it are the stamps'", fineness.unit_ns(), fineness.unit_ns() / 2.0)
}
