//! The step ports that are compared, with the targets and limits of the measurements for each.

use clap::ValueEnum;
use isostep::measure::stops::Cause;

/// The step port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Port {
    /// PIO and DMA, to the clock cycle
    #[default]
    Pio,
    /// the processor, a timer wake-up per step
    Timer,
}

/// Targets and limits of the measurements for each port.
impl Port {
    /// All ports.
    pub const ALL: [Self; 2] = [Self::Pio, Self::Timer];

    /// Its name in the sources.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pio => "PioPort",
            Self::Timer => "TimerPort",
        }
    }

    /// The beginning of its figures' keys.
    pub fn key(self) -> &'static str {
        match self {
            Self::Pio => "pio",
            Self::Timer => "timer",
        }
    }

    /// The target rate of three axes at once, steps/s each.
    pub fn target_steps_s(self) -> u32 {
        match self {
            Self::Pio => 1_000_000,
            Self::Timer => 30_000,
        }
    }

    /// The target for the error of an edge, ns. With PioPort it holds for every edge, with TimerPort for 99 of 100.
    pub fn error_bound_ns(self) -> f64 {
        match self {
            Self::Pio => 50.0,
            Self::Timer => 2_000.0,
        }
    }

    /// The targets of a machine, by the keys of their figures.
    pub fn targets(self) -> Vec<(String, f64)> {
        let rate_steps_s = self.target_steps_s();
        let farthest = if self == Self::Pio { "max" } else { "p99" };
        // With TimerPort the processor makes the steps and receives a byte on USB only between them.
        let inputs = [Cause::LimitSwitch, Cause::FirstMotor, Cause::SecondMotor, Cause::EmergencyStop].into_iter();
        let stops = inputs.chain((self == Self::Pio).then_some(Cause::SecondReset));
        let stops = stops.map(|cause| (cause.key().to_owned(), STOP_MAX_US));
        let moves = (self == Self::Pio).then(|| ("moves.exact".to_owned(), MOVES_MIN_S));
        let edges = (format!("edges.{rate_steps_s}.{farthest}"), self.error_bound_ns());
        [("rate.3".to_owned(), rate_steps_s.into()), edges].into_iter().chain(stops).chain(moves).collect()
    }

    /// The top speed, steps/s, and the acceleration, steps/s2, at which starts are measured. They are as steep as in
    /// any other measurement; where tasks make the steps, as steep as the tasks can sustain with axes at different
    /// speeds.
    pub fn start_steps_s_and_s2(self) -> (u32, f64) {
        match self {
            Self::Pio => (self.target_steps_s(), super::ACCEL_MAX_STEPS_S2),
            Self::Timer => (20_000, 1e6),
        }
    }

    /// The feed of the streamed short moves, mm/min. It is more than a core can keep up with; where tasks make the
    /// steps, it stays below the rate at which they would leave no time to plan.
    pub fn moves_feed_mm_min(self) -> f64 {
        match self {
            Self::Pio => 60_000.0,
            Self::Timer => 12_000.0,
        }
    }

    /// The rates of three axes at which the load is measured, steps/s each.
    pub fn load_rates_steps_s(self) -> &'static [u32] {
        match self {
            Self::Pio => &[10_000, 100_000, 1_000_000],
            Self::Timer => &[10_000, 20_000, 30_000],
        }
    }
}

/// Target for the time from an input to the last edge.
const STOP_MAX_US: f64 = 10.0;
/// Target for PioPort: short moves per second.
const MOVES_MIN_S: f64 = 1_000.0;
