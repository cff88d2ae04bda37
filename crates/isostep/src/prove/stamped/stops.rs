//! Stops of a board that stamps its own edges.
//!
//! # Method
//! One stamper watches the pad that pulls the input down, two others watch an axis each, in turn. So the input and the
//! last edge are on one clock. Where in a move the stop will come is known from the stop before it, and the window is
//! laid around that. A reset byte pulls the pad down too, in the interrupt that its packet raises; the second one counts.

use anyhow::{Result, ensure};

use super::super::how::Jumper;
use super::super::session::RESET;
use super::{OUT, PADS, Stamped, ramp};
use crate::measure::planned_move::{NAMES, PROVED, STEPS_PER_MM};
use crate::measure::stops::{Cause, Stops};
use crate::measure::{Machine, Measured, PlannedMove};

const RAMP_S: f64 = 0.1;
const CRUISE_S: f64 = 0.4;
/// Time from the line of a pull to the pull, us: in the cruise.
const PULLED_US: u32 = 250_000;
/// The same of a reset byte, s; and the time to the second one, while the machine still brakes.
const RESET_S: f64 = 0.25;
const BETWEEN_S: f64 = 0.005;
/// A stop whose window was laid beside it is made again, at most this many times for each that counts.
const TRIES_EACH: u32 = 3;

/// One stop, as stamped.
struct Stop {
    /// When the input was pulled, ns.
    pulled_ns: f64,
    /// From there to the last edge of the axes that were watched, us; none if the window was laid beside it.
    latency_us: Option<f64>,
    /// When the first edge of the move came, ns.
    first_ns: f64,
    /// The reported position beside the edges counted, steps.
    astray_steps: Option<u64>,
}

pub fn measure(board: &mut Stamped, cause: Cause, rate_steps_s: u32, wanted: u32) -> Result<Measured<Stops>> {
    let jumpers = &board.how.jumpers;
    let wire = match cause {
        Cause::LimitSwitch => Some(Jumper::Limit),
        Cause::EmergencyStop => Some(Jumper::Estop),
        Cause::SecondReset if jumpers.is_empty() => None,
        // The bytes would close the switch too, whose interrupt comes between.
        Cause::SecondReset => {
            let why = format!("needs that no wire is on GP{OUT}: run `isostep prove --only stops` without it");
            return Ok(Err(why));
        }
        _ => return Ok(Err("the image cannot make this happen".to_owned())),
    };
    if let Some(wire) = wire.filter(|wire| !jumpers.contains(wire)) {
        return Ok(Err(format!("needs a wire from GP{OUT} to GP{}", wire.pad())));
    }
    let machine = Machine::new(rate_steps_s, ramp(RAMP_S));
    let mut planned = machine.straight(PROVED, CRUISE_S)?;
    board.set_up(&machine)?;
    let mut stops = Stops { rate_steps_s, ..Stops::default() };
    let mut skip = 0;
    let mut others = [[0, 1], [1, 2], [2, 0]].into_iter().cycle();
    for _ in 0..1 + TRIES_EACH * wanted {
        if stops.latencies_us.len() as u32 == wanted {
            break;
        }
        board.progress.step(&format!("{}: {} of {wanted}", cause.name(), stops.latencies_us.len() + 1));
        let axes = others.next().unwrap_or([0, 1]);
        let stop = match one(board, cause, wire, &planned, axes, skip)? {
            Ok(stop) => stop,
            Err(why_not) => {
                board.faults.push(why_not.clone());
                return Ok(Err(why_not));
            }
        };
        stops.latencies_us.extend(stop.latency_us);
        stops.astray_steps = stops.astray_steps.max(stop.astray_steps);
        skip = laid(board, &planned, &stop);
        planned = planned.back();
    }
    if stops.latencies_us.is_empty() {
        let window = board.identity.window;
        return Ok(Err(format!("the stops came at instants too different for windows of {window} edges")));
    }
    Ok(Ok(stops))
}

/// The edges to leave out, so that a stop that comes as late in the move as this one is in the middle of the window.
fn laid(board: &Stamped, planned: &PlannedMove, stop: &Stop) -> u32 {
    let into_s = (stop.pulled_ns - stop.first_ns + planned.due_ns(0, 1)) * 1e-9;
    planned.steps_by(0, into_s).saturating_sub(board.identity.window as u32 / 2)
}

/// One stop; or in words why there was none.
fn one(
    board: &mut Stamped,
    cause: Cause,
    wire: Option<Jumper>,
    planned: &PlannedMove,
    axes: [usize; 2],
    skip: u32,
) -> Result<Measured<Stop>> {
    board.session.ask("$PROVE=OUT")?;
    let before = board.session.rest()?;
    board.session.arm([PADS[axes[0]], PADS[axes[1]], OUT], skip)?;
    if wire.is_some() {
        pull(board, planned)?
    } else {
        reset_twice(board, planned)?
    }
    let after = board.session.rest()?;
    let alarm = board.session.take_alarm();
    let stamps = board.session.read(skip)?;
    board.session.ask("$PROVE=OUT")?;
    // The switch is debounced before an alarm can be cleared.
    board.session.wait(0.03)?;
    board.unlock()?;
    if let (Some(wire), None) = (wire, alarm.as_ref().or((after.state == "Alarm").then_some(&after.state))) {
        let (name, pad) = (cause.name(), wire.pad());
        return Ok(Err(format!("the {name} did not stop the move: is the wire from GP{OUT} to GP{pad} there?")));
    }
    // The last time that the pad fell: by the second of two reset bytes.
    let falls = if wire.is_some() { 1 } else { 2 };
    let Some(pulled_ns) = stamps[2].instants_ns(board.chip).get(falls - 1).copied() else {
        return Ok(Err(format!("GP{OUT} was not seen to go low {falls} times: the {} was not stamped", cause.name())));
    };
    let window = board.identity.window;
    let watched = &stamps[..2];
    let seen = watched.iter().all(|stamps| stamps.cycles.len() > 1 && stamps.cycles.len() < window && !stamps.lost);
    let instants_ns = [0, 1].map(|index| watched[index].instants_ns(board.chip));
    let last_ns = instants_ns.iter().filter_map(|of_axis| of_axis.last().copied()).fold(f64::MIN, f64::max);
    let first_ns = instants_ns.iter().filter_map(|of_axis| of_axis.first().copied()).fold(f64::MAX, f64::min);
    ensure!(
        first_ns < f64::MAX,
        "{} and {} made no edge in a move that was to be stopped",
        NAMES[axes[0]],
        NAMES[axes[1]]
    );
    let place_steps = |place_mm: &[f64]| place_mm.get(axes[0]).map(|mm| (mm * STEPS_PER_MM).round() as i64);
    let astray_steps = seen.then(|| {
        let counted = i64::from(*watched[0].counted.last()?);
        let moved = (place_steps(&after.place)? - place_steps(&before.place)?).abs();
        Some((moved - counted).unsigned_abs())
    });
    Ok(Ok(Stop {
        pulled_ns,
        latency_us: seen.then(|| ((last_ns - pulled_ns) * 1e-3).max(0.0)),
        first_ns,
        astray_steps: astray_steps.flatten(),
    }))
}

/// Has the input pulled during the move.
fn pull(board: &mut Stamped, planned: &PlannedMove) -> Result<()> {
    board.ask_both([&format!("$PROVE=OUT,{PULLED_US}"), &planned.line()])?;
    board.session.wait(f64::from(PULLED_US) * 1e-6 + BETWEEN_S)
}

/// Sends two reset bytes during the move.
fn reset_twice(board: &mut Stamped, planned: &PlannedMove) -> Result<()> {
    board.session.ask(&planned.line())?;
    board.session.wait(RESET_S)?;
    board.session.say(RESET)?;
    board.session.wait(BETWEEN_S)?;
    board.session.restart()
}
