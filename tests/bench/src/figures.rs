//! All results, in the form that `--json` writes.

use serde::Serialize;

use super::accuracy::AccuracyFigures;
use super::board::WITH_SECOND;
use super::laws;
use super::levels::LevelFigures;
use super::load::LoadFigures;
use super::measured::Measured;
use super::micro::MicroFigures;
use super::moves::{self, MoveFigures};
use super::outputs::OffFigures;
use super::port::Port;
use super::rates::{self, RateFigures};
use super::starts::StartMeasurement;
use super::stops::{Input, StopMeasurement};
use super::target::Target;
use super::trial::AXES;
use isostep::screen::grouped;

/// Target for the time from an input to the last edge.
const STOP_MAX_US: f64 = 10.0;
/// Target for PioPort: short moves per second.
const MOVES_MIN_S: f64 = 1_000.0;

/// The results of a whole run of the benchmark.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// The conditions of the measurements.
    pub conditions: Conditions,
    /// The results on the real chip.
    #[serde(flatten)]
    pub chip: ChipFigures,
    /// The results on a chip with flash that reads like RAM.
    pub ideal_flash: ChipFigures,
    /// The results on a chip on which a word that is not in flash's cache takes twice as long.
    pub miss_costs_twice: ChipFigures,
}

/// The results on one chip.
#[derive(Clone, Debug, Serialize)]
pub struct ChipFigures {
    /// The results of each port.
    pub ports: Vec<PortFigures>,
    /// The cost of the mathematics of a move; null if it was not measured.
    pub mathematics: Option<MicroFigures>,
    /// The targets and whether they were met.
    pub targets: Vec<Target>,
}

impl ChipFigures {
    pub fn new(ports: Vec<PortFigures>, mathematics: Option<MicroFigures>) -> Self {
        let targets = ports.iter().flat_map(PortFigures::targets);
        let targets = targets.chain(mathematics.iter().flat_map(mathematics_targets)).collect();
        Self { ports, mathematics, targets }
    }

    /// The target with this name, if it was measured on this chip.
    pub fn target(&self, what: &str) -> Option<&Target> {
        self.targets.iter().find(|target| target.what == what)
    }

    /// The results of a port; `None` if it was not measured.
    pub fn port(&self, port: Port) -> Option<&PortFigures> {
        self.ports.iter().find(|figures| figures.port == port)
    }
}

/// The conditions on which every figure depends.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Conditions {
    /// The command that prints the figures.
    pub command: String,
    /// The board on which the firmware ran.
    pub board: &'static str,
    /// Clock of the core, Hz.
    pub clock_hz: u32,
    /// How code in flash is read.
    pub flash: &'static str,
    /// Cycles to read a word that is not in flash's cache.
    pub miss_cycles: u32,
    /// How the firmware was built.
    pub build: String,
    /// The driver whose minimum times every edge had to keep.
    pub driver: &'static str,
    /// Rate at which status reports were polled over USB, Hz.
    pub poll_hz: u32,
    /// Time from rest to the rate, s, unless the highest acceleration takes longer.
    pub ramp_s: f64,
    /// The highest acceleration, steps/s2.
    pub accel_max_steps_s2: f64,
}

/// The results of one port.
#[derive(Clone, Debug, Serialize)]
pub struct PortFigures {
    #[serde(serialize_with = "super::port::serialize_port")]
    pub port: Port,
    /// The results on the machine with a motor on each axis.
    #[serde(flatten)]
    pub machine: MachineFigures,
    pub starts: Vec<StartMeasurement>,
    pub levels: LevelFigures,
    pub outputs: Measured<OffFigures>,
    /// The results on the machine with two motors on Y; null if it was not measured.
    pub with_second: Option<MachineFigures>,
}

/// What is measured of a port on a machine with or without a second motor.
#[derive(Clone, Debug, Serialize)]
pub struct MachineFigures {
    #[serde(skip)]
    pub has_second: bool,
    pub rates: Vec<RateFigures>,
    pub accuracy: AccuracyFigures,
    pub load: Vec<LoadFigures>,
    pub stops: Vec<StopMeasurement>,
    pub moves: MoveFigures,
}

impl PortFigures {
    /// The targets for this port.
    pub fn targets(&self) -> Vec<Target> {
        [&self.machine].into_iter().chain(&self.with_second).flat_map(|machine| machine.targets(self.port)).collect()
    }

    /// Whether any rate was sustained.
    pub fn moved(&self) -> bool {
        self.machine.rates.iter().any(|rates| rates.highest_steps_s.is_some())
    }
}

impl MachineFigures {
    /// In the names of what is measured on this machine.
    pub fn suffix(&self) -> &'static str {
        if self.has_second { WITH_SECOND } else { "" }
    }

    fn targets(&self, port: Port) -> Vec<Target> {
        // With TimerPort the processor makes the steps and receives a byte on USB only between them.
        let hears_late = |input: &Input| port == Port::Timer && *input == Input::SecondReset;
        let inputs = Input::of(self.has_second).iter().filter(|input| !hears_late(input));
        let stops = inputs.map(|&input| self.stop_target(port, input));
        let moves = (port == Port::Pio).then(|| self.moves_target(port));
        [self.rate_target(port), self.accuracy_target(port)].into_iter().chain(stops).chain(moves).collect()
    }

    fn rate_target(&self, port: Port) -> Target {
        let highest = rates::highest_steps_s(&self.rates, AXES).map(f64::from);
        let what = format!("{}, {AXES} axes at once{}, each", port.name(), self.suffix());
        Target::at_least(what, highest, port.target_steps_s().into(), "steps/s")
    }

    /// Only errors measured at the target rate count.
    fn accuracy_target(&self, port: Port) -> Target {
        let rate_steps_s = port.target_steps_s();
        let at_it = Some(&self.accuracy).filter(|accuracy| accuracy.rate_steps_s >= rate_steps_s);
        let errors = at_it.and_then(|accuracy| accuracy.edges.figure()).map(|edges| edges.errors);
        let (which, error_ns) = match port {
            Port::Pio => ("max", errors.map(|errors| errors.max_ns)),
            Port::Timer => ("p99", errors.map(|errors| errors.p99_ns)),
        };
        let what = format!("{}, edge error at {}{}, {which}", port.name(), together(rate_steps_s), self.suffix());
        Target::at_most(what, error_ns, port.error_bound_ns(), "ns")
    }

    fn stop_target(&self, port: Port, input: Input) -> Target {
        let by_it = self.stops.iter().find(|stop| stop.input == input);
        let max_us = by_it.and_then(|stop| stop.latency.figure()).map(|latency| latency.max_us);
        let what = format!("{}, {} to the last edge{}, max", port.name(), input.name(), self.suffix());
        Target::at_most(what, max_us, STOP_MAX_US, "us")
    }

    fn moves_target(&self, port: Port) -> Target {
        let what = format!("{}, moves of {}{}, streamed", port.name(), moves::name(&self.moves), self.suffix());
        let carried = self.moves.carried.figure().map(|carried| carried.rate_moves_s);
        Target::at_least(what, carried, MOVES_MIN_S, "moves/s")
    }
}

/// The targets for the mathematics.
fn mathematics_targets(figures: &MicroFigures) -> Vec<Target> {
    laws::targets(&figures.laws).collect()
}

/// A rate of all axes at once, in words.
pub fn together(rate_steps_s: u32) -> String {
    format!("{AXES} x {} steps/s", grouped(rate_steps_s.into()))
}
