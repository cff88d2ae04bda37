//! How soon a move stops: from an input, or a second reset byte, to the last edge of any axis.
//!
//! # Method
//! One stamper watches the pad that pulls the input down, two others watch an axis each, in turn. So the input and the
//! last edge are on one clock. Where in a move the stop will come is known from the stop before it, and the window is
//! laid around that. A reset byte pulls the pad down too, in the interrupt that its packet raises; the second one counts.

use anyhow::{Result, ensure};

use super::super::board::{Answer, RESET};
use super::super::course::{Course, NAMES, STEPS_PER_MM};
use super::super::proof::{Better, Figure};
use super::{Bench, Jumper, OUT, PADS, together};

/// A period of this rate is 4 us, and a window lasts some milliseconds.
const RATE_STEPS_S: u32 = 250_000;
const RAMP_S: f64 = 0.1;
const CRUISE_S: f64 = 0.4;
/// When the input is pulled, after its line was carried out, us: in the cruise.
const PULLED_US: u32 = 250_000;
/// The same of a reset byte, s; and the time to the second one, while the machine still brakes.
const RESET_S: f64 = 0.25;
const BETWEEN_S: f64 = 0.005;
/// A stop whose window was laid beside it is made again, at most this many times for each that counts.
const TRIES_EACH: u32 = 3;

pub fn measure(bench: &mut Bench) -> Result<()> {
    for jumper in Jumper::ALL {
        let figure = figure(&format!("stop.{}", jumper.pad()), jumper.name());
        if bench.how.jumpers.contains(&jumper) {
            by(bench, Cause::Wire(jumper), figure)?;
        } else {
            bench.add(figure.missing(format!("needs a wire from GP{OUT} to GP{}", jumper.pad())));
        }
    }
    let reset = figure("stop.reset", "second reset byte");
    if !bench.how.jumpers.is_empty() {
        // The bytes would close the switch too, whose interrupt comes between.
        bench.add(
            reset.missing(format!("needs that no wire is on GP{OUT}: run `isostep prove --only stops` without it")),
        );
        return Ok(());
    }
    by(bench, Cause::SecondReset, reset)
}

/// What stops a move.
#[derive(Clone, Copy)]
enum Cause {
    Wire(Jumper),
    SecondReset,
}

/// One stop, as stamped.
struct Stop {
    /// When the input was pulled, ns.
    pulled_ns: f64,
    /// From there to the last edge of the axes that were watched, us; none if the window was laid beside it.
    latency_us: Option<f64>,
    /// When the first edge of the move came, ns.
    first_ns: f64,
    /// What the reported position is beside the edges counted, steps.
    astray_steps: Option<i64>,
}

fn figure(key: &str, name: &str) -> Figure {
    let period_us = 1e6 / f64::from(RATE_STEPS_S);
    Figure::new(key, format!("from the {name} to the last edge of any axis, at most"), "us")
        .flattered_by("the last edge comes up to a period before the stop; more stops find the worst")
        .compared(Better::Lower, 0.2, period_us)
}

fn by(bench: &mut Bench, cause: Cause, figure: Figure) -> Result<()> {
    let (machine, mut course) = together(RATE_STEPS_S, RAMP_S, CRUISE_S)?;
    bench.set_up(&machine)?;
    let (mut skip, mut latencies_us) = (0, Vec::new());
    let wanted = bench.how.effort.stops;
    let mut others = [[0, 1], [1, 2], [2, 0]].into_iter().cycle();
    for _ in 0..1 + TRIES_EACH * wanted {
        if latencies_us.len() as u32 == wanted {
            break;
        }
        bench.progress.step(&format!("{}: {} of {wanted}", figure.what, latencies_us.len() + 1));
        let axes = others.next().unwrap_or([0, 1]);
        let stop = match one(bench, cause, &course, axes, skip)? {
            Ok(stop) => stop,
            Err(why_not) => {
                bench.proof.faults.push(why_not.clone());
                bench.add(figure.missing(why_not));
                return Ok(());
            }
        };
        latencies_us.extend(stop.latency_us);
        if let Some(steps) = stop.astray_steps.filter(|steps| *steps != 0) {
            bench.proof.faults.push(format!(
                "after a stop by the {}, the reported position was {steps} steps beside the edges counted",
                cause.name()
            ));
        }
        skip = laid(bench, &course, &stop);
        course = course.back();
    }
    let unseen = || format!("the stops came at instants too different for windows of {} edges", bench.identity.window);
    let figure = match latencies_us.iter().copied().reduce(f64::max) {
        Some(most_us) => {
            figure.measured(most_us, format!("16 ns, {} stops at {RATE_STEPS_S} steps/s", latencies_us.len()))
        }
        None => figure.missing(unseen()),
    };
    bench.add(figure);
    Ok(())
}

impl Cause {
    fn name(self) -> &'static str {
        match self {
            Self::Wire(jumper) => jumper.name(),
            Self::SecondReset => "second reset byte",
        }
    }
}

/// How many edges to leave out, so that a stop that comes as late in the move as this one is in the middle of the window.
fn laid(bench: &Bench, course: &Course, stop: &Stop) -> u32 {
    let into_s = (stop.pulled_ns - stop.first_ns + course.due_ns(0, 1)) * 1e-9;
    course.steps_by(0, into_s).saturating_sub(bench.identity.window as u32 / 2)
}

/// One stop; or in words why there was none.
fn one(bench: &mut Bench, cause: Cause, course: &Course, axes: [usize; 2], skip: u32) -> Result<Result<Stop, String>> {
    bench.board.ask("$PROVE=OUT")?;
    let before = bench.board.rest()?;
    bench.board.arm([PADS[axes[0]], PADS[axes[1]], OUT], skip)?;
    match cause {
        Cause::Wire(_) => pull(bench, course)?,
        Cause::SecondReset => reset_twice(bench, course)?,
    }
    let after = bench.board.rest()?;
    let alarm = bench.board.take_alarm();
    let stamps = bench.board.read(skip)?;
    bench.board.ask("$PROVE=OUT")?;
    // The switch is debounced before an alarm can be cleared.
    bench.board.wait(0.03)?;
    bench.unlock()?;
    if let (Cause::Wire(jumper), None) = (cause, alarm.as_ref().or((after.state == "Alarm").then_some(&after.state))) {
        return Ok(Err(format!(
            "the {} did not stop the move: is the wire from GP{OUT} to GP{} there?",
            jumper.name(),
            jumper.pad()
        )));
    }
    // The last time that the pad fell: by the second of two reset bytes.
    let falls = match cause {
        Cause::Wire(_) => 1,
        Cause::SecondReset => 2,
    };
    let Some(pulled_ns) = stamps[2].instants_ns().get(falls - 1).copied() else {
        return Ok(Err(format!("GP{OUT} was not seen to go low {falls} times: the {} was not stamped", cause.name())));
    };
    let window = bench.identity.window;
    let watched = &stamps[..2];
    let seen = watched.iter().all(|stamps| stamps.cycles.len() > 1 && stamps.cycles.len() < window && !stamps.lost);
    let last_ns = watched.iter().filter_map(|stamps| stamps.instants_ns().last().copied()).fold(f64::MIN, f64::max);
    let first_ns = watched.iter().filter_map(|stamps| stamps.instants_ns().first().copied()).fold(f64::MAX, f64::min);
    ensure!(
        first_ns < f64::MAX,
        "{} and {} made no edge in a move that was to be stopped",
        NAMES[axes[0]],
        NAMES[axes[1]]
    );
    let place_steps = |place_mm: &[f64]| place_mm.get(axes[0]).map(|mm| (mm * STEPS_PER_MM).round() as i64);
    let astray_steps = seen.then(|| {
        let counted = i64::from(*watched[0].counted.last()?);
        Some((place_steps(&after.place_mm)? - place_steps(&before.place_mm)?).abs() - counted)
    });
    Ok(Ok(Stop {
        pulled_ns,
        latency_us: seen.then(|| ((last_ns - pulled_ns) * 1e-3).max(0.0)),
        first_ns,
        astray_steps: astray_steps.flatten(),
    }))
}

/// Has the input pulled during the move.
fn pull(bench: &mut Bench, course: &Course) -> Result<()> {
    let (pulled, moved) = (format!("$PROVE=OUT,{PULLED_US}"), course.line());
    // In one packet, so that the time from one line to the other is always the same.
    bench.board.say(&format!("{pulled}\n{moved}\n"))?;
    for line in [&pulled, &moved] {
        let answer = bench.board.answer(line)?;
        ensure!(matches!(answer, Answer::Done(_)), "`{line}` was answered {answer:?}");
    }
    bench.board.wait(f64::from(PULLED_US) * 1e-6 + BETWEEN_S)
}

/// Sends two reset bytes during the move.
fn reset_twice(bench: &mut Bench, course: &Course) -> Result<()> {
    bench.board.ask(&course.line())?;
    bench.board.wait(RESET_S)?;
    bench.board.say(RESET)?;
    bench.board.wait(BETWEEN_S)?;
    bench.board.restart()
}
