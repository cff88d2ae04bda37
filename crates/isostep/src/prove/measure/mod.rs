//! The measurements, one file each, and what they have in common.

mod cache;
mod crystal;
mod edges;
mod intervals;
mod laser;
mod load;
mod moves;
mod rates;
mod ready;
mod starts;
mod stops;

use anyhow::{Context, Result, ensure};

use super::board::{Board, Identity};
use super::course::{Course, Machine, PROVED, STEP};
use super::edges::{Fineness, Window};
use super::progress::Progress;
use super::proof::{Figure, Proof};
use super::stamps::{self, Stamps};

/// The pad of the image that pulls an input down.
pub const OUT: u8 = 28;

/// An input that a wire connects with GP28.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Jumper {
    /// X's limit switch, GP9
    Limit,
    /// the emergency stop, GP12
    Estop,
}

impl Jumper {
    /// Every input that a wire may go to.
    pub const ALL: [Self; 2] = [Self::Limit, Self::Estop];

    /// Its pad.
    pub fn pad(self) -> u8 {
        match self {
            Self::Limit => 9,
            Self::Estop => 12,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Limit => "limit switch",
            Self::Estop => "emergency stop",
        }
    }
}

/// How much is measured.
#[derive(Clone, Debug)]
pub struct Effort {
    /// The rates at which edges are compared, steps/s.
    pub rates: Vec<u32>,
    /// Windows of a move, at most; those of a whole move if it has fewer.
    pub windows: usize,
    /// The same for the finer stamps by two stampers.
    pub pair_windows: usize,
    /// The step of the search for the highest rate, steps/s.
    pub rate_step: u32,
    /// Stops of each kind.
    pub stops: u32,
    /// Starts of each kind.
    pub starts: u32,
    /// Short moves.
    pub moves: u32,
    /// For how long the crystal is compared, s.
    pub crystal_s: f64,
}

impl Effort {
    /// Everything.
    pub fn full() -> Self {
        Self {
            rates: vec![100_000, 1_000_000, 2_000_000],
            windows: usize::MAX,
            // Three pairs for each window: all would take most of the time.
            pair_windows: 24,
            rate_step: 50_000,
            stops: 24,
            starts: 12,
            moves: 4_000,
            crystal_s: 30.0,
        }
    }

    /// A look: a minute.
    pub fn quick() -> Self {
        Self { windows: 6, pair_windows: 4, stops: 6, starts: 4, moves: 800, crystal_s: 3.0, ..Self::full() }
    }
}

/// What is measured.
#[derive(Clone, Debug)]
pub struct How {
    /// The wires that are there.
    pub jumpers: Vec<Jumper>,
    /// How much.
    pub effort: Effort,
    /// Whether the laser's pin may be switched on.
    pub laser: bool,
    /// The measurements to make; all if none is named.
    pub only: Vec<Part>,
}

/// What can be measured alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
#[expect(missing_docs, reason = "each has the words of its measurement")]
pub enum Part {
    Ready,
    Edges,
    Intervals,
    Rates,
    Stops,
    Moves,
    Load,
    Cache,
    Starts,
    Crystal,
    Laser,
}

/// A board that is measured, and what was found so far.
pub struct Bench<'b, 'l> {
    /// The board.
    pub board: &'b mut Board<'l>,
    /// What it is.
    pub identity: Identity,
    /// What is measured.
    pub how: &'b How,
    /// What was found.
    pub proof: &'b mut Proof,
    /// Shows how far a measurement is.
    pub progress: &'b Progress,
}

/// A measurement, and its name in words.
type Measurement = (Part, &'static str, fn(&mut Bench) -> Result<()>);

/// All of them, in order.
const ALL: [Measurement; 11] = [
    (Part::Ready, "time from power to ready", ready::measure),
    (Part::Edges, "edges against the closed form", edges::measure),
    (Part::Intervals, "equal intervals", intervals::measure),
    (Part::Rates, "highest rates", rates::measure),
    (Part::Stops, "stops", stops::measure),
    (Part::Moves, "short moves", moves::measure),
    (Part::Load, "load of the core", load::measure),
    (Part::Cache, "flash and its cache", cache::measure),
    (Part::Starts, "starts", starts::measure),
    (Part::Crystal, "the crystal", crystal::measure),
    (Part::Laser, "the laser's pin", laser::measure),
];

/// Makes every measurement. One that fails on a board that still answers is a remark, and the next one follows.
///
/// # Errors
/// When the board is gone, or the user has interrupted.
pub fn all(bench: &mut Bench) -> Result<()> {
    // The reset before this has pulled the pad down, to which a wire may lead from a switch.
    bench.settle()?;
    let only = &bench.how.only;
    let wanted: Vec<Measurement> =
        ALL.into_iter().filter(|(part, ..)| only.is_empty() || only.contains(part)).collect();
    for (index, (_, name, measure)) in wanted.iter().enumerate() {
        let shown = format!("{}/{} {name}", index + 1, wanted.len());
        bench.progress.part(&shown);
        let measured = measure(bench);
        // The next one begins with a machine at rest and without an alarm.
        bench.settle().context("the board is not at rest after a measurement").or_else(|unsettled| {
            // What broke the measurement is the cause of that.
            measured.as_ref().map_or(Ok(()), |()| Err(unsettled))
        })?;
        if let Err(error) = measured {
            bench.still_there().map_err(|_| anyhow::anyhow!("{name}: {error:#}"))?;
            bench.proof.remarks.push(format!("{name}: not measured: {error:#}"));
        }
    }
    Ok(())
}

impl Bench<'_, '_> {
    /// Adds a figure.
    pub fn add(&mut self, figure: Figure) {
        self.proof.figures.push(figure);
    }

    /// Makes the board this machine.
    pub fn set_up(&mut self, machine: &Machine) -> Result<()> {
        for line in machine.lines() {
            self.board.ask(&line)?;
        }
        Ok(())
    }

    /// Resets the machine, lets go of the wire, and clears an alarm.
    pub fn settle(&mut self) -> Result<()> {
        self.board.restart()?;
        self.board.ask("$PROVE=OUT")?;
        // A switch is debounced.
        self.board.wait(0.03)?;
        self.unlock()
    }

    /// Clears an alarm, if there is one.
    pub fn unlock(&mut self) -> Result<()> {
        if self.board.rest()?.state == "Alarm" {
            self.board.ask("$X")?;
        }
        self.board.take_alarm();
        Ok(())
    }

    fn still_there(&mut self) -> Result<()> {
        self.board.ask("$PROVE").map(drop)
    }

    /// Makes a move while the stampers watch these pads. Returns the stamps, and the alarm if one came.
    pub fn stamped(&mut self, course: &Course, pads: [u8; 3], skip: u32) -> Result<([Stamps; 3], Option<String>)> {
        self.board.arm(pads, skip)?;
        self.board.ask(&course.line())?;
        self.board.wait(course.duration_s())?;
        self.board.rest()?;
        let alarm = self.board.take_alarm();
        Ok((self.board.read(skip)?, alarm))
    }

    /// The windows of these axes, each seen by one stamper.
    pub fn windows(&self, axes: &[usize], stamps: &[Stamps; 3], skip: u32) -> Vec<Window> {
        let of = |(&axis, stamps): (&usize, &Stamps)| {
            self.window(axis, skip, stamps, stamps.instants_ns(), Fineness::Single)
        };
        axes.iter().zip(stamps).map(of).collect()
    }

    /// The window of an axis that two stampers have seen.
    ///
    /// # Errors
    /// When they do not agree.
    pub fn pair_window(&self, axis: usize, skip: u32, of: [&Stamps; 2]) -> Result<Window> {
        if of.iter().any(|stamps| stamps.lost) {
            let lost = Stamps { lost: true, ..Stamps::default() };
            return Ok(self.window(axis, skip, &lost, Vec::new(), Fineness::Pair));
        }
        let exact = stamps::both(of[0], of[1]);
        let instants_ns =
            exact.context("two stampers of one pad have seen different edges: is the image of this release?")?;
        Ok(self.window(axis, skip, of[0], instants_ns, Fineness::Pair))
    }

    fn window(&self, axis: usize, skip: u32, stamps: &Stamps, instants_ns: Vec<f64>, fineness: Fineness) -> Window {
        let is_full = stamps.counted.last().is_some_and(|last| *last >= skip + self.identity.window as u32);
        Window { axis, instants_ns, counted: stamps.counted.clone(), is_full, lost: stamps.lost, fineness }
    }

    /// How many edges are left out in each of the windows that cover a move of `count` steps: all of them, or `most`,
    /// evenly from its beginning to its end.
    pub fn skips(&self, count: u32, most: usize) -> Vec<u32> {
        // Each window has the first edge again.
        let own = (self.identity.window - 1) as u32;
        let needed = (count.saturating_sub(1)).div_ceil(own).max(1);
        let shown = u32::try_from(most).unwrap_or(u32::MAX).clamp(1, needed);
        let last = needed - 1;
        (0..shown).map(|index| own * if shown == 1 { 0 } else { (index * last).div_ceil(shown - 1) }).collect()
    }
}

/// A machine and its move there, at the same rate and for the same distance on all axes.
pub fn together(rate_steps_s: u32, ramp_s: f64, cruise_s: f64) -> Result<(Machine, Course)> {
    let machine = Machine::new(rate_steps_s, ramp_s);
    let steps = machine.steps_of(cruise_s);
    ensure!(steps > 0, "a move at {rate_steps_s} steps/s has no steps");
    let course = machine.course([steps; PROVED])?;
    Ok((machine, course))
}

/// The pads of all axes.
pub const PADS: [u8; 3] = STEP;
