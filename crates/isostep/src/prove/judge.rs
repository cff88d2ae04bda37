//! Compares stamps with the closed form of a move: which step each stamp is, how far it is from its instant, and which
//! edges are lost, too many, or not on the cycles that the machine compiles.
//!
//! # Method
//! The stampers count from a cycle of their own, so the start of the move on their clock is unknown: one constant for
//! all axes of a run. It is found from the first edges of the axes, and then corrected by the median error. A stamp is
//! taken for the step whose instant is nearest, so a lost edge does not shift the numbers of the others.
//!
//! Between the closed form and the edges are the quadratics that the machine compiles, up to 24 ns off. This tool compiles
//! the same move too, so an edge that is a few cycles off is seen even where it is still as near as is promised.

use std::ops::RangeInclusive;

use crate::chip::Chip;
use crate::measure::PlannedMove;
use crate::measure::errors::median;
use crate::measure::planned_move::NAMES;

/// A step's instant may be this far from the closed form, ns: docs/figures.md promises it for every edge.
pub const PROMISE_NS: f64 = 24.0;
/// For the constant, about this many stamps of an axis are looked at.
const SAMPLES: usize = 200;
/// The first edges that may be lost without losing the constant.
const FIRST_LOST_MAX: u32 = 3;
/// The improvement that a start must bring for each edge that would have been lost before the first, ns. In a cruise all starts
/// that are a period apart fit.
const LOST_NS: f64 = 20.0;

/// The resolutions of stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fineness {
    /// One stamper a pad: two cycles.
    Single,
    /// Two: a cycle.
    Pair,
}

impl Fineness {
    /// The unit of the stamps by this chip's clock, ns.
    pub fn unit_ns(self, chip: Chip) -> f64 {
        let cycles = match self {
            Self::Single => 2.0,
            Self::Pair => 1.0,
        };
        cycles * chip.cycle_ns()
    }

    /// The distance of an edge from the cycle that the machine compiles for it, at most: half a unit, and a cycle by which a pad may be
    /// seen sooner or later. An edge that is three cycles off is beyond this wherever rounding has it.
    fn line_max_ns(self, chip: Chip) -> f64 {
        let cycles = match self {
            Self::Single => 1.875,
            Self::Pair => 1.5,
        };
        cycles * chip.cycle_ns()
    }
}

/// The stamps of one axis in one move.
#[derive(Clone, Debug)]
pub struct Window {
    /// Index of the axis.
    pub axis: usize,
    /// The instants, ns from the stampers' cycle.
    pub instants_ns: Vec<f64>,
    /// The number of each edge, as the stamper has counted them.
    pub counted: Vec<u32>,
    /// It ended because it was full, not because the move was over.
    pub is_full: bool,
    /// The stamper says that it has lost stamps.
    pub lost: bool,
    /// The resolution of the stamps.
    pub fineness: Fineness,
    /// The chip whose clock the stamps count.
    pub chip: Chip,
}

/// A stamp whose step is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// Number of the step, from 1.
    pub number: u32,
    /// Its lateness, ns.
    pub error_ns: f64,
}

/// Something that no edge may do.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// Edges that did not come: from this step to that.
    Lost { axis: usize, numbers: RangeInclusive<u32> },
    /// So many of these steps did not come; which of them was not stamped.
    LostUnseen { axis: usize, count: u32, among: RangeInclusive<u32> },
    /// Edges that are no step of the move: the first of them is beside this step.
    Extra { axis: usize, count: u32, beside: u32 },
    /// An edge that is not on the cycle which the machine compiles for it, beside the others.
    OutOfLine { axis: usize, number: u32, beside_ns: f64 },
    /// An edge farther from its instant than is promised.
    Far { axis: usize, number: u32, error_ns: f64 },
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let late = |ns: f64| if ns < 0.0 { "early" } else { "late" };
        match self {
            Self::Lost { axis, numbers } if numbers.start() == numbers.end() => {
                write!(f, "edge {} of {} was lost", numbers.start(), NAMES[*axis])
            }
            Self::Lost { axis, numbers } => {
                write!(f, "edges {} to {} of {} were lost", numbers.start(), numbers.end(), NAMES[*axis])
            }
            Self::LostUnseen { axis, count, among } => {
                let name = NAMES[*axis];
                write!(f, "{count} of the edges {} to {} of {name} did not come", among.start(), among.end())
            }
            Self::Extra { axis, count, beside } => {
                write!(f, "{count} edges too many came on {}, at edge {beside}", NAMES[*axis])
            }
            Self::OutOfLine { axis, number, beside_ns } => {
                let name = NAMES[*axis];
                write!(
                    f,
                    "edge {number} of {name} was {:.0} ns {} beside the others",
                    beside_ns.abs(),
                    late(*beside_ns)
                )
            }
            Self::Far { axis, number, error_ns } => {
                let name = NAMES[*axis];
                write!(f, "edge {number} of {name} was {:.0} ns {}", error_ns.abs(), late(*error_ns))
            }
        }
    }
}

/// The findings of a move's windows.
#[derive(Clone, Debug, Default)]
pub struct Verdict {
    /// The steps of each window, in its order.
    pub judged: Vec<Vec<Judged>>,
    /// The faults of its edges.
    pub faults: Vec<Fault>,
    /// When the move began, ns on the stampers' clock.
    pub start_ns: f64,
}

/// Judges the windows of one move, which all have its start in common.
pub fn judge(planned: &PlannedMove, windows: &[Window]) -> Verdict {
    let Some(start_ns) = start_ns(planned, windows) else {
        let silent =
            windows.iter().map(|window| Fault::Lost { axis: window.axis, numbers: 1..=planned.count(window.axis) });
        return Verdict { judged: vec![Vec::new(); windows.len()], faults: silent.collect(), start_ns: 0.0 };
    };
    let mut verdict = Verdict { start_ns, ..Verdict::default() };
    for window in windows {
        let judged = steps_of(planned, window, start_ns);
        verdict.faults.extend(missing(planned, window, &judged));
        let judged = without_extras(judged);
        verdict.faults.extend(astray(planned, window, &judged));
        verdict.judged.push(judged);
    }
    verdict
}

/// When the move began: of what the first edges of the axes say, that with which all stamps agree best, corrected by
/// the median of all errors.
fn start_ns(planned: &PlannedMove, windows: &[Window]) -> Option<f64> {
    let firsts =
        windows.iter().filter_map(|window| Some((window.axis, *window.counted.first()?, *window.instants_ns.first()?)));
    let candidates: Vec<(u32, f64)> = (0..=FIRST_LOST_MAX)
        .flat_map(|lost| {
            firsts.clone().map(move |(axis, counted, at_ns)| (lost, at_ns - due_ns(planned, axis, counted + lost)))
        })
        .collect();
    let misfit = |start_ns: f64| {
        let of_all = windows.iter().flat_map(|window| samples(planned, window, start_ns));
        let of_firsts = firsts.clone().map(|(axis, _, at_ns)| {
            let nearest = nearest(planned, axis, at_ns - start_ns);
            (at_ns - start_ns - planned.due_ns(axis, nearest)).abs()
        });
        median(of_all.map(f64::abs).collect()) + of_firsts.fold(0.0, f64::max)
    };
    let weighed =
        candidates.into_iter().map(|(lost, start_ns)| (misfit(start_ns) + f64::from(lost) * LOST_NS, start_ns));
    let best = weighed.min_by(|one, other| one.0.total_cmp(&other.0))?.1;
    Some(best + median(windows.iter().flat_map(|window| samples(planned, window, best)).collect()))
}

/// The instant of a step; for a number beyond the last, the last's.
fn due_ns(planned: &PlannedMove, axis: usize, number: u32) -> f64 {
    planned.due_ns(axis, number.min(planned.count(axis)).max(1))
}

/// The errors of some stamps of a window, evenly chosen.
fn samples(planned: &PlannedMove, window: &Window, start_ns: f64) -> impl Iterator<Item = f64> {
    let stride = window.instants_ns.len().div_ceil(SAMPLES).max(1);
    window.instants_ns.iter().step_by(stride).map(move |at_ns| {
        let number = nearest(planned, window.axis, at_ns - start_ns);
        at_ns - start_ns - planned.due_ns(window.axis, number)
    })
}

/// The step whose instant is nearest.
fn nearest(planned: &PlannedMove, axis: usize, at_ns: f64) -> u32 {
    let before = planned.steps_by(axis, at_ns * 1e-9).clamp(1, planned.count(axis));
    let around = before.saturating_sub(1).max(1)..=(before + 1).min(planned.count(axis));
    let far = |number: &u32| (at_ns - planned.due_ns(axis, *number)).abs();
    around.min_by(|one, other| far(one).total_cmp(&far(other))).unwrap_or(before)
}

fn steps_of(planned: &PlannedMove, window: &Window, start_ns: f64) -> Vec<Judged> {
    let judged = window.instants_ns.iter().map(|at_ns| {
        let number = nearest(planned, window.axis, at_ns - start_ns);
        Judged { number, error_ns: at_ns - start_ns - planned.due_ns(window.axis, number) }
    });
    judged.collect()
}

/// Edges that did not come, and those that came too often. Where the stamper has lost stamps itself, nobody knows.
fn missing(planned: &PlannedMove, window: &Window, judged: &[Judged]) -> Vec<Fault> {
    let (axis, count) = (window.axis, planned.count(window.axis));
    let lost = |from: u32, to: u32| Fault::Lost { axis, numbers: from..=to };
    if window.lost {
        return Vec::new();
    }
    let Some(last) = judged.last() else { return vec![lost(1, count)] };
    let mut faults = Vec::new();
    // As if the edge before the first were the zeroth, which both counts agree on.
    let (mut number, mut counted) = (0, 0);
    for (one, &by_count) in judged.iter().zip(&window.counted) {
        let (due, found) = (number + (by_count - counted), one.number);
        if found > due && by_count - counted > 1 {
            faults.push(Fault::LostUnseen { axis, count: found - due, among: number + 1..=found - 1 });
        } else if found > due {
            faults.push(lost(due, found - 1));
        } else if found < due {
            faults.push(Fault::Extra { axis, count: due - found, beside: found });
        }
        (number, counted) = (found, by_count);
    }
    if !window.is_full && last.number < count {
        faults.push(lost(last.number + 1, count));
    }
    faults
}

/// The nearest stamp of each step.
fn without_extras(judged: Vec<Judged>) -> Vec<Judged> {
    let mut kept: Vec<Judged> = Vec::with_capacity(judged.len());
    for one in judged {
        match kept.last_mut() {
            Some(last) if last.number == one.number => {
                if one.error_ns.abs() < last.error_ns.abs() {
                    *last = one;
                }
            }
            _ => kept.push(one),
        }
    }
    kept
}

/// Edges too far from their instants, and those out of line.
fn astray(planned: &PlannedMove, window: &Window, judged: &[Judged]) -> Vec<Fault> {
    let (axis, chip) = (window.axis, window.chip);
    let limit_ns = PROMISE_NS + window.fineness.unit_ns(chip);
    let far = judged.iter().filter(|one| one.error_ns.abs() > limit_ns);
    let far = far.map(|one| Fault::Far { axis, number: one.number, error_ns: one.error_ns });
    let beside_ns = beside_compiled(planned, window, judged);
    let out = judged.iter().zip(beside_ns).filter_map(|(one, beside_ns)| {
        let is_out = beside_ns.abs() > window.fineness.line_max_ns(chip) && one.error_ns.abs() <= limit_ns;
        is_out.then_some(Fault::OutOfLine { axis, number: one.number, beside_ns })
    });
    far.chain(out).collect()
}

/// The lateness of each edge beside what the machine compiles, ns: the start of the move is on a cycle that is the same for all,
/// which the median finds.
fn beside_compiled(planned: &PlannedMove, window: &Window, judged: &[Judged]) -> Vec<f64> {
    let compiled = |one: &Judged| {
        let due_ns = planned.due_ns(window.axis, one.number);
        one.error_ns + due_ns - planned.compiled_ns(window.chip, window.axis, one.number)
    };
    let all: Vec<f64> = judged.iter().map(compiled).collect();
    let middle_ns = median(all.clone());
    all.into_iter().map(|ns| ns - middle_ns).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{Machine, Ramp};

    const START_NS: f64 = 3_456_784.0;
    /// Of the tests in which it makes no difference.
    const CHIP: Chip = Chip::Rp2040;

    fn planned() -> PlannedMove {
        Machine::new(1_000_000, Ramp { s: 0.001, accel_max_steps_s2: 2e7 }).planned([12_500, -12_500, 12_500]).unwrap()
    }

    /// The windows that stampers see of edges that are on the cycles of the compiled move, `skip` of them left out.
    fn windows(
        chip: Chip,
        planned: &PlannedMove,
        skip: u32,
        count: usize,
        cycle: impl FnMut(usize, u32) -> Option<u64>,
    ) -> Vec<Window> {
        by(chip, Fineness::Single, planned, skip, count, cycle)
    }

    fn by(
        chip: Chip,
        fineness: Fineness,
        planned: &PlannedMove,
        skip: u32,
        count: usize,
        mut cycle: impl FnMut(usize, u32) -> Option<u64>,
    ) -> Vec<Window> {
        let instant_ns = |cycle: u64| match fineness {
            Fineness::Single => ((cycle / 2 * 2) as f64 + 0.5) * chip.cycle_ns(),
            Fineness::Pair => cycle as f64 * chip.cycle_ns(),
        };
        let of = |axis| {
            let cycles: Vec<u64> = (1..=planned.count(axis)).filter_map(|number| cycle(axis, number)).collect();
            let stamped = (1..).zip(&cycles).filter(|(number, _)| *number == 1 || *number > skip + 1).take(count);
            let (counted, instants_ns): (Vec<u32>, Vec<f64>) =
                stamped.map(|(number, cycle)| (number, instant_ns(*cycle))).unzip();
            let is_full = instants_ns.len() == count;
            Window { axis, instants_ns, counted, is_full, lost: false, fineness, chip }
        };
        (0..3).map(of).collect()
    }

    fn exact(chip: Chip, planned: &PlannedMove) -> impl Fn(usize, u32) -> Option<u64> + '_ {
        move |axis, number| Some(((START_NS + planned.compiled_ns(chip, axis, number)) / chip.cycle_ns()).round() as u64)
    }

    #[test]
    fn exact_edges_have_no_fault_and_errors_of_a_unit_at_most() {
        let planned = planned();
        let looks = [(0, 2_000), (5_000, 2_000), (11_000, 2_000)];
        for (chip, (skip, count)) in Chip::ALL.into_iter().flat_map(|chip| looks.map(|look| (chip, look))) {
            let verdict = judge(&planned, &windows(chip, &planned, skip, count, exact(chip, &planned)));
            assert_eq!(verdict.faults, [], "{chip:?}, skip {skip}");
            let all = verdict.judged.iter().flatten();
            assert!(all.clone().all(|one| one.error_ns.abs() <= 40.0), "{chip:?}, skip {skip}");
            assert!((verdict.start_ns - START_NS).abs() <= chip.cycle_ns(), "{chip:?}: {}", verdict.start_ns);
            assert_eq!(verdict.judged[1][1].number, skip + 2);
        }
    }

    #[test]
    fn an_edge_that_is_three_cycles_off_is_named_wherever_it_is() {
        let planned = planned();
        let edges = [(0, 1_000, 3_i64), (5_000, 6_002, -3), (11_000, 12_345, 3), (0, 3, 3), (5_000, 5_002, 3)];
        for (chip, (skip, wanted, late)) in Chip::ALL.into_iter().flat_map(|chip| edges.map(|edge| (chip, edge))) {
            let shifted = |axis, number| {
                let cycle = exact(chip, &planned)(axis, number)?;
                Some(if axis == 1 && number == wanted { cycle.checked_add_signed(late)? } else { cycle })
            };
            let faults = judge(&planned, &by(chip, Fineness::Pair, &planned, skip, 2_000, shifted)).faults;
            // Where the compiled move is off the closed form itself, it is beyond the promise too.
            let named = matches!(faults.as_slice(),
                [Fault::OutOfLine { axis: 1, number, beside_ns: off_ns } | Fault::Far { axis: 1, number, error_ns: off_ns }]
                    if *number == wanted && (off_ns.signum() as i64) == late.signum());
            assert!(named, "{chip:?}, skip {skip}, edge {wanted}: {faults:?}");
        }
    }

    #[test]
    fn a_lost_edge_is_named_or_counted() {
        let planned = planned();
        let without = |lost: u32| {
            let planned = &planned;
            move |axis, number| if axis == 2 && number == lost { None } else { exact(CHIP, planned)(axis, number) }
        };
        let faults = |skip, lost| judge(&planned, &windows(CHIP, &planned, skip, 2_000, without(lost))).faults;
        assert_eq!(faults(0, 1_234), [Fault::Lost { axis: 2, numbers: 1_234..=1_234 }]);
        assert_eq!(faults(0, 1), [Fault::Lost { axis: 2, numbers: 1..=1 }]);
        assert_eq!(faults(11_000, 12_500), [Fault::Lost { axis: 2, numbers: 12_500..=12_500 }]);
        assert_eq!(faults(5_000, 1_234), [Fault::LostUnseen { axis: 2, count: 1, among: 2..=5_002 }]);
        assert_eq!(faults(5_000, 6_000)[0].to_string(), "edge 6000 of Z was lost");
    }

    #[test]
    fn a_late_edge_an_edge_too_many_and_a_still_axis_are_named() {
        let planned = planned();
        let late = |axis, number| {
            exact(CHIP, &planned)(axis, number).map(|at| if (axis, number) == (0, 700) { at + 9 } else { at })
        };
        let faults = judge(&planned, &windows(CHIP, &planned, 0, 2_000, late)).faults;
        assert!(matches!(faults.as_slice(), [Fault::Far { axis: 0, number: 700, .. }]), "{faults:?}");
        let mut extra = windows(CHIP, &planned, 0, 2_000, exact(CHIP, &planned));
        let between = extra[0].instants_ns[900] + 200.0;
        extra[0].instants_ns.insert(901, between);
        extra[0].counted = (1..).take(extra[0].instants_ns.len()).collect();
        let faults = judge(&planned, &extra).faults;
        assert!(matches!(faults.as_slice(), [Fault::Extra { axis: 0, count: 1, .. }]), "{faults:?}");
        let still = |axis, number| if axis == 1 { None } else { exact(CHIP, &planned)(axis, number) };
        let faults = judge(&planned, &windows(CHIP, &planned, 0, 2_000, still)).faults;
        assert_eq!(faults, [Fault::Lost { axis: 1, numbers: 1..=12_500 }]);
    }
}
