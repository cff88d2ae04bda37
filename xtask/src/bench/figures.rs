//! All that was measured, as `--json` writes it.

use serde::Serialize;

use super::accuracy::AccuracyFigures;
use super::candidate;
use super::laws;
use super::levels::LevelFigures;
use super::load::LoadFigures;
use super::measured::Measured;
use super::micro::MicroFigures;
use super::moves::{self, MoveFigures};
use super::outputs::OffFigures;
use super::rates::{self, RateFigures};
use super::starts::StartMeasurement;
use super::stops::{Input, StopMeasurement};
use super::target::Target;
use super::trial::AXES;
use crate::variant::Port;
use isostep::screen::grouped;

/// From an input to the last edge.
const STOP_MAX_US: f64 = 10.0;
/// Short moves a second of PioPort.
const MOVES_MIN_S: f64 = 1_000.0;

/// A whole run of the benchmark.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// How they were come by.
    pub conditions: Conditions,
    /// The chip as it is.
    #[serde(flatten)]
    pub chip: ChipFigures,
    /// A chip with flash that reads like RAM.
    pub ideal_flash: ChipFigures,
    /// A chip on which what flash's cache does not hold takes twice as long to come.
    pub miss_twice_as_dear: ChipFigures,
}

/// What was measured on one chip.
#[derive(Clone, Debug, Serialize)]
pub struct ChipFigures {
    /// Each port's.
    pub ports: Vec<PortFigures>,
    /// What the mathematics of a move costs on the chip; null if it was not measured.
    pub mathematics: Option<MicroFigures>,
    /// What was aimed at.
    pub targets: Vec<Target>,
}

impl ChipFigures {
    pub fn new(ports: Vec<PortFigures>, mathematics: Option<MicroFigures>) -> Self {
        let targets = ports.iter().flat_map(PortFigures::targets);
        let targets = targets.chain(mathematics.iter().flat_map(mathematics_targets)).collect();
        Self { ports, mathematics, targets }
    }

    /// That target, if this chip was put to it.
    pub fn target(&self, what: &str) -> Option<&Target> {
        self.targets.iter().find(|target| target.what == what)
    }

    /// Those of a port; none where it was not measured.
    pub fn port(&self, port: Port) -> Option<&PortFigures> {
        self.ports.iter().find(|figures| figures.port == port)
    }
}

/// What every figure depends on.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Conditions {
    /// The command that prints them.
    pub command: String,
    /// Where the firmware ran.
    pub board: &'static str,
    /// Of the core, Hz.
    pub clock_hz: u32,
    /// How what runs from flash is read.
    pub flash: &'static str,
    /// Of a word that flash's cache does not hold.
    pub miss_cycles: u32,
    /// How it was built.
    pub build: String,
    /// Whose least times every edge was held to.
    pub driver: &'static str,
    /// Status reports asked for over USB meanwhile, Hz.
    pub poll_hz: u32,
    /// From rest to the rate, s, unless that took more than the highest acceleration.
    pub ramp_s: f64,
    /// The highest acceleration, steps/s2.
    pub accel_max_steps_s2: f64,
}

/// What was measured of a port.
#[derive(Clone, Debug, Serialize)]
pub struct PortFigures {
    #[serde(serialize_with = "candidate::serialize_port")]
    pub port: Port,
    pub rates: Vec<RateFigures>,
    pub accuracy: AccuracyFigures,
    pub load: Vec<LoadFigures>,
    pub stops: Vec<StopMeasurement>,
    pub starts: Vec<StartMeasurement>,
    pub moves: MoveFigures,
    pub levels: LevelFigures,
    pub outputs: Measured<OffFigures>,
}

impl PortFigures {
    /// What is aimed at with this port.
    pub fn targets(&self) -> Vec<Target> {
        // By TimerPort the processor makes the steps, and hears a byte on USB only between them.
        let hears_late = |input: &Input| self.port == Port::Timer && *input == Input::SecondReset;
        let stops = Input::ALL.into_iter().filter(|input| !hears_late(input)).map(|input| self.stop_target(input));
        let moves = (self.port == Port::Pio).then(|| self.moves_target());
        [self.rate_target(), self.accuracy_target()].into_iter().chain(stops).chain(moves).collect()
    }

    fn rate_target(&self) -> Target {
        let highest = rates::highest_steps_s(&self.rates, AXES).map(f64::from);
        let what = format!("{}, {AXES} axes at once, each", self.port.name());
        Target::at_least(what, highest, self.port.target_steps_s().into(), "steps/s")
    }

    /// Errors at a lower rate than is aimed at are none of it.
    fn accuracy_target(&self) -> Target {
        let rate_steps_s = self.port.target_steps_s();
        let at_it = Some(&self.accuracy).filter(|accuracy| accuracy.rate_steps_s >= rate_steps_s);
        let errors = at_it.and_then(|accuracy| accuracy.edges.figure()).map(|edges| edges.errors);
        let (which, error_ns) = match self.port {
            Port::Pio => ("max", errors.map(|errors| errors.max_ns)),
            Port::Timer => ("p99", errors.map(|errors| errors.p99_ns)),
        };
        let what = format!("{}, edge error at {}, {which}", self.port.name(), together(rate_steps_s));
        Target::at_most(what, error_ns, self.port.error_bound_ns(), "ns")
    }

    fn stop_target(&self, input: Input) -> Target {
        let by_it = self.stops.iter().find(|stop| stop.input == input);
        let max_us = by_it.and_then(|stop| stop.latency.figure()).map(|latency| latency.max_us);
        let what = format!("{}, {} to the last edge, max", self.port.name(), input.name());
        Target::at_most(what, max_us, STOP_MAX_US, "us")
    }

    fn moves_target(&self) -> Target {
        let what = format!("{}, moves of {}, streamed", self.port.name(), moves::name(&self.moves));
        let carried = self.moves.carried.figure().map(|carried| carried.rate_moves_s);
        Target::at_least(what, carried, MOVES_MIN_S, "moves/s")
    }

    /// Whether anything at all was sustained.
    pub fn moved(&self) -> bool {
        self.rates.iter().any(|rates| rates.highest_steps_s.is_some())
    }
}

/// What is aimed at with the mathematics.
fn mathematics_targets(figures: &MicroFigures) -> Vec<Target> {
    laws::targets(&figures.laws).collect()
}

/// A rate of all axes at once.
pub fn together(rate_steps_s: u32) -> String {
    format!("{AXES} x {} steps/s", grouped(rate_steps_s.into()))
}
