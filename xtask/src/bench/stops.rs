//! How soon a move ends: from a limit switch, the emergency stop or a reset byte to the last edge of any axis.

use std::fmt::Write;

use anyhow::{Result, ensure};
use oorandom::Rand32;
use serde::Serialize;

use super::board::{Board, Summary};
use super::effort::Effort;
use super::measured::Measured;
use super::progress::Case;
use super::rates::RAMP_S;
use super::trial::{AXES, Machine};
use super::variant::Port;

/// When in a move it is stopped, us after its line was taken: in the second half of the ramp, and in the cruise after.
const WINDOW_US: std::ops::Range<f64> = 100_000.0..300_000.0;
/// The first stop comes at the same instants in every run.
const SEED: u64 = 1;
/// From one stop to what is done after it, ms: the debounce is 5.
const SETTLE_MS: u32 = 20;

/// What stops a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Input {
    /// X's limit switch.
    LimitSwitch,
    /// The emergency stop.
    EmergencyStop,
    /// The byte 0x18 from the console.
    ResetByte,
}

/// The stops by one input.
#[derive(Clone, Debug, Serialize)]
pub struct StopMeasurement {
    /// What was pressed or sent.
    pub input: Input,
    /// Of each of the three axes.
    pub rate_steps_s: u32,
    /// From it to the last edge.
    pub latency: Measured<Latency>,
}

/// How long some stops took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Latency {
    /// How many.
    pub stops: usize,
    /// The longest, us.
    pub max_us: f64,
    /// The mean, us.
    pub mean_us: f64,
}

impl Input {
    const ALL: [Self; 3] = [Self::LimitSwitch, Self::EmergencyStop, Self::ResetByte];

    pub fn name(self) -> &'static str {
        match self {
            Self::LimitSwitch => "limit switch",
            Self::EmergencyStop => "emergency stop",
            Self::ResetByte => "reset byte",
        }
    }

    /// Stops the machine, and makes it ready again.
    fn commands(self) -> &'static [&'static str] {
        match self {
            Self::LimitSwitch => &["switch X stuck-closed", "expect ALARM:1", "switch X normal"],
            Self::EmergencyStop => &["estop pressed", "expect ALARM:10", "estop released"],
            Self::ResetByte => &["bytes 18", "expect Grbl"],
        }
    }
}

/// By every input, in moves at `rate_steps_s` of each axis.
pub fn measure(board: &Board, port: Port, rate_steps_s: u32, effort: &Effort) -> Result<Vec<StopMeasurement>> {
    Input::ALL.into_iter().map(|input| by(board, port, rate_steps_s, input, effort)).collect()
}

fn by(board: &Board, port: Port, rate_steps_s: u32, input: Input, effort: &Effort) -> Result<StopMeasurement> {
    let case = Case::begin(port, AXES, rate_steps_s, &format!("{} stops by {}", effort.stops, input.name()));
    let run = board.run(&script(rate_steps_s, input, effort.stops), f64::from(effort.stops))?;
    let latency = match run {
        Measured::Figure(summary) => judge(&summary, effort.stops)?.into(),
        Measured::Missing { why_not } => Measured::Missing { why_not },
    };
    case.end(&latency.words(|latency| format!("at most {:.1} us", latency.max_us)));
    Ok(StopMeasurement { input, rate_steps_s, latency })
}

fn judge(summary: &Summary, stops: u32) -> Result<Result<Latency, String>> {
    let latencies_ns: Vec<f64> = summary.stops.iter().filter_map(|stop| stop.latency_ns).collect();
    ensure!(latencies_ns.len() == stops as usize, "the emulator timed {} of {stops} stops", latencies_ns.len());
    Ok(if summary.knows_position() {
        Ok(latency(latencies_ns))
    } else {
        Err("the position reported at the end is not that of the edges counted".to_owned())
    })
}

fn latency(latencies_ns: Vec<f64>) -> Latency {
    let stops = latencies_ns.len();
    let max_us = latencies_ns.iter().copied().fold(0.0, f64::max) * 1e-3;
    let mean_us = latencies_ns.iter().sum::<f64>() / stops.max(1) as f64 * 1e-3;
    Latency { stops, max_us, mean_us }
}

/// Long moves one way, each stopped on its way.
fn script(rate_steps_s: u32, input: Input, stops: u32) -> String {
    let machine = Machine::new(rate_steps_s, RAMP_S);
    let far = machine.rapid([machine.steps_of(1.0); AXES]);
    let mut random = Rand32::new(SEED);
    let mut script = machine.set_up();
    for _ in 0..stops {
        let share = f64::from(random.rand_float());
        let wait_us = WINDOW_US.start + share * (WINDOW_US.end - WINDOW_US.start);
        let stop = input.commands().join("\n");
        write!(
            script,
            "send G91 {far}\nexpect ok\nwait-us {wait_us:.3}\n{stop}\nwait-ms {SETTLE_MS}\nsend $X\nexpect ok\n"
        )
        .expect("a String takes any text");
    }
    script + "wait-idle\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_stops_each_move_and_unlocks_the_machine() {
        let script = script(1_000_000, Input::LimitSwitch, 20);
        let count = |line: &str| script.lines().filter(|each| *each == line).count();
        assert_eq!((count("switch X stuck-closed"), count("switch X normal"), count("send $X")), (20, 20, 20));
        let waits = script.lines().filter_map(|line| line.strip_prefix("wait-us ")?.parse().ok());
        let waits: std::collections::BTreeSet<u64> = waits.map(|us: f64| us as u64).collect();
        assert!(waits.len() == 20 && waits.iter().all(|us| (100_000..=300_000).contains(us)), "{waits:?}");
    }

    #[test]
    fn latencies_are_in_us() {
        assert_eq!(latency(vec![1_000.0, 3_000.0]), Latency { stops: 2, max_us: 3.0, mean_us: 2.0 });
    }
}
