//! Measures how soon a move stops: the time from a limit switch, the emergency stop, a second reset byte or the last edge
//! of an axis whose port faults to the last edge of any axis.

use std::fmt::Write;

use anyhow::{Result, ensure};
use oorandom::Rand32;
use serde::Serialize;

use super::board::{Board, CLOCK_HZ, Summary};
use super::edges::{Edge, NS_PER_CYCLE};
use super::effort::Effort;
use super::measured::Measured;
use super::port::Port;
use super::progress::Case;
use super::rates::RAMP_S;
use super::trial::{AXES, Machine};

/// When a move is stopped, us after its line was accepted: in the second half of the ramp, or in the cruise after it.
const WINDOW_US: std::ops::Range<f64> = 100_000.0..300_000.0;
/// A fixed seed, so that the stops come at the same instants in every run.
const SEED: u64 = 1;
/// Stops per run. All its moves go in the same direction, so their number must keep within the 10 m that a target may
/// be from zero.
const RUN_STOPS: u32 = 40;
/// Time from a stop to the next command, ms. The debounce takes 5.
const SETTLE_MS: u32 = 20;

/// An input that stops a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Input {
    /// X's limit switch.
    LimitSwitch,
    /// That of the first of Y's two motors.
    FirstMotor,
    /// That of the second.
    SecondMotor,
    /// The emergency stop.
    EmergencyStop,
    /// The byte 0x18 from the console, while the machine brakes because of a first one.
    SecondReset,
    /// No input: a step port that runs dry, because the task that feeds it gets no time.
    DryPort,
    /// No input: a step that comes too late, because the processor cannot make the steps as fast as they are due.
    LateStep,
}

/// The results for one input.
#[derive(Clone, Debug, Serialize)]
pub struct StopMeasurement {
    /// The input that was pressed or sent.
    pub input: Input,
    /// The rate of each of the three axes.
    pub rate_steps_s: u32,
    /// Time from the input to the last edge.
    pub latency: Measured<Latency>,
}

/// The latencies of some stops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Latency {
    /// Number of stops.
    pub stops: usize,
    /// The longest, us.
    pub max_us: f64,
    /// The mean, us.
    pub mean_us: f64,
    /// After all stops, the reported position minus the position counted from the edges, steps; null if no position was
    /// reported.
    pub position_error_steps: Option<[i64; AXES]>,
}

impl Input {
    const ALL: [Self; 3] = [Self::LimitSwitch, Self::EmergencyStop, Self::SecondReset];
    const WITH_SECOND: [Self; 4] = [Self::FirstMotor, Self::SecondMotor, Self::EmergencyStop, Self::SecondReset];

    /// The inputs that are measured on a machine with or without a second motor.
    pub fn of(has_second: bool) -> &'static [Self] {
        if has_second { &Self::WITH_SECOND } else { &Self::ALL }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::LimitSwitch => "limit switch",
            Self::FirstMotor => "limit switch of Y's first motor",
            Self::SecondMotor => "limit switch of its second motor",
            Self::EmergencyStop => "emergency stop",
            Self::SecondReset => "second reset byte",
            Self::DryPort => "a step port that runs dry",
            Self::LateStep => "a step that comes too late",
        }
    }

    /// Script commands that stop the machine and make it ready again.
    fn commands(self) -> &'static [&'static str] {
        match self {
            Self::LimitSwitch => &["switch X stuck-closed", "expect ALARM:1", "switch X normal"],
            Self::FirstMotor => &["switch Y stuck-closed", "expect ALARM:1", "switch Y normal"],
            Self::SecondMotor => &["switch 2 stuck-closed", "expect ALARM:1", "switch 2 normal"],
            Self::EmergencyStop => &["estop pressed", "expect ALARM:10", "estop released"],
            Self::SecondReset => &["bytes 18", "wait-ms 5", "bytes 18", "expect Grbl"],
            // The executor of the axes gets no time for a while, or that of the task that makes the steps.
            Self::DryPort => &["mask-irq 28", "wait-ms 12", "unmask-irq 28", "expect ALARM:22"],
            Self::LateStep => &["mask-irq 29", "wait-ms 2", "unmask-irq 29", "expect ALARM:20"],
        }
    }

    /// The fault of a port that gets no time. A TimerPort does not run dry: its steps come too late.
    fn fault(port: Port) -> Self {
        match port {
            Port::Pio => Self::DryPort,
            Port::Timer => Self::LateStep,
        }
    }

    /// The settings of moves that are to end in this fault, with the numbers of the first axis's; and their rate, steps/s.
    fn settings(self) -> ([(u32, u32); 3], u32) {
        match self {
            Self::DryPort => ([(110, 14_880), (100, 1_000), (120, 10_000)], 248_000),
            _ => ([(110, 1_800), (100, 1_000), (120, 1_000)], 30_000),
        }
    }
}

/// Measures stops by every input in moves at `rate_steps_s` of each axis. A port that faults is measured without a
/// second motor, which has its words from the same one.
pub fn measure(board: &Board, port: Port, rate_steps_s: u32, effort: &Effort) -> Result<Vec<StopMeasurement>> {
    let by_inputs = Input::of(board.has_second).iter().map(|&input| by(board, port, rate_steps_s, input, effort));
    by_inputs.chain((!board.has_second).then(|| by_fault(board, port, effort))).collect()
}

fn by(board: &Board, port: Port, rate_steps_s: u32, input: Input, effort: &Effort) -> Result<StopMeasurement> {
    let case = Case::begin(
        board.chip,
        port,
        AXES,
        rate_steps_s,
        &board.named(&format!("{} stops by {}", effort.stops, input.name())),
    );
    let latency = all(board, rate_steps_s, input, effort.stops)?;
    case.end(&latency.words(Latency::words));
    Ok(StopMeasurement { input, rate_steps_s, latency })
}

/// Measures how soon a port that faults stops the other axes. All axes make the same steps, so the port that faulted is
/// the one whose last edge is the earliest. A state machine that runs dry halts with that edge; a step that comes too late
/// is noticed half a period of the top speed and more after it was due.
fn by_fault(board: &Board, port: Port, effort: &Effort) -> Result<StopMeasurement> {
    let (input, stops) = (Input::fault(port), effort.stops);
    let rate_steps_s = input.settings().1;
    let case = Case::begin(board.chip, port, AXES, rate_steps_s, &format!("{stops} stops by {}", input.name()));
    let ran = board.run_for_edges(&fault_script(input, stops, &mut Rand32::new(SEED)), f64::from(stops))?;
    let latency = match ran {
        Measured::Figure((summary, edges)) => {
            let latencies_us = latencies_us(&edges);
            ensure!(latencies_us.len() == stops as usize, "{} of {stops} moves ended in the fault", latencies_us.len());
            Measured::Figure(Latency::of(&latencies_us, &summary))
        }
        Measured::Missing { why_not } => Measured::Missing { why_not },
    };
    case.end(&latency.words(Latency::words));
    Ok(StopMeasurement { input, rate_steps_s, latency })
}

/// For each move, the time from the earliest last edge of an axis to the latest, us. A pause of half the settling time
/// is between moves.
fn latencies_us(edges: &[Edge]) -> Vec<f64> {
    let pause_cycles = u64::from(SETTLE_MS) * u64::from(CLOCK_HZ) / 2_000;
    let moves = edges.chunk_by(|edge, next| next.cycle - edge.cycle < pause_cycles);
    let last = |of: &[Edge], axis| of.iter().rfind(|edge| edge.axis == axis).map_or(of[0].cycle, |edge| edge.cycle);
    let spread_us = |of: &[Edge]| {
        let lasts = [0, 1, 2].map(|axis| last(of, axis));
        let [earliest, latest] = [lasts.into_iter().min(), lasts.into_iter().max()].map(Option::unwrap_or_default);
        (latest - earliest) as f64 * NS_PER_CYCLE * 1e-3
    };
    moves.map(spread_us).collect()
}

/// Moves that ask too much of the port, each of which ends in an alarm.
fn fault_script(input: Input, moves: u32, random: &mut Rand32) -> String {
    let (of_axes, _) = input.settings();
    let mut script = "expect Grbl\nsend $0=0\nexpect ok\n".to_owned();
    for axis in 0..AXES as u32 {
        script.extend(of_axes.map(|(number, value)| format!("send ${}={value}\nexpect ok\n", number + axis)));
    }
    for _ in 0..moves {
        let (mm, wait_us) = (80, 100_000 + (1e5 * random.rand_float()) as u32);
        let stop = input.commands().join("\n");
        write!(
            script,
            "send G91 G0 X{mm} Y{mm} Z{mm}\nexpect ok\nwait-us {wait_us}\n{stop}\nwait-ms {SETTLE_MS}\nsend $X\nexpect ok\n"
        )
        .expect("a String takes any text");
    }
    script + "wait-idle\n"
}

/// Makes this number of stops in as many runs as necessary, at different instants in each run.
fn all(board: &Board, rate_steps_s: u32, input: Input, stops: u32) -> Result<Measured<Latency>> {
    let mut random = Rand32::new(SEED);
    let mut all = Latency::NONE;
    for begun in (0..stops).step_by(RUN_STOPS as usize) {
        let count = RUN_STOPS.min(stops - begun);
        match board.run(&script(rate_steps_s, input, count, &mut random), f64::from(count))? {
            Measured::Figure(summary) => {
                let timed = summary.stops.len();
                ensure!(timed == count as usize, "the emulator timed {timed} of {count} stops");
                all = all.and(&latency(&summary));
            }
            Measured::Missing { why_not } => return Ok(Measured::Missing { why_not }),
        }
    }
    Ok(Measured::Figure(all))
}

fn latency(summary: &Summary) -> Latency {
    let latencies_us: Vec<f64> = summary.stops.iter().map(|stop| stop.latency_ns * 1e-3).collect();
    Latency::of(&latencies_us, summary)
}

impl Latency {
    fn of(latencies_us: &[f64], summary: &Summary) -> Self {
        let stops = latencies_us.len();
        Self {
            stops,
            max_us: latencies_us.iter().copied().fold(0.0, f64::max),
            mean_us: latencies_us.iter().sum::<f64>() / stops.max(1) as f64,
            position_error_steps: summary.position_error_steps(),
        }
    }

    const NONE: Self = Self { stops: 0, max_us: 0.0, mean_us: 0.0, position_error_steps: Some([0; AXES]) };

    /// The latencies of the stops of both runs. The first position that is not exact is kept.
    fn and(&self, other: &Self) -> Self {
        let stops = self.stops + other.stops;
        let sum_us = self.mean_us * self.stops as f64 + other.mean_us * other.stops as f64;
        Self {
            stops,
            max_us: self.max_us.max(other.max_us),
            mean_us: sum_us / stops.max(1) as f64,
            position_error_steps: match self.position_error_steps {
                Some([0, 0, 0]) => other.position_error_steps,
                wrong => wrong,
            },
        }
    }

    pub fn words(&self) -> String {
        let Self { stops, max_us, mean_us, .. } = self;
        let position = match self.position_error_steps {
            Some([0, 0, 0]) => "position exact".to_owned(),
            Some(steps) => format!("POSITION WRONG by {steps:?} steps"),
            None => "NO POSITION reported".to_owned(),
        };
        format!("max {max_us:.2} us, mean {mean_us:.2} us of {stops} stops, {position}")
    }
}

/// Long moves in one direction. Each is stopped before its end.
fn script(rate_steps_s: u32, input: Input, stops: u32, random: &mut Rand32) -> String {
    let machine = Machine::new(rate_steps_s, RAMP_S);
    let far = machine.rapid([machine.steps_of(1.0); AXES]);
    let mut script = machine.set_up();
    for _ in 0..stops {
        let ratio = f64::from(random.rand_float());
        let wait_us = WINDOW_US.start + ratio * (WINDOW_US.end - WINDOW_US.start);
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
        let script = script(1_000_000, Input::LimitSwitch, 20, &mut Rand32::new(SEED));
        let count = |line: &str| script.lines().filter(|each| *each == line).count();
        assert_eq!((count("switch X stuck-closed"), count("switch X normal"), count("send $X")), (20, 20, 20));
        let waits = script.lines().filter_map(|line| line.strip_prefix("wait-us ")?.parse().ok());
        let waits: std::collections::BTreeSet<u64> = waits.map(|us: f64| us as u64).collect();
        assert!(waits.len() == 20 && waits.iter().all(|us| (100_000..=300_000).contains(us)), "{waits:?}");
    }

    #[test]
    fn from_the_last_edge_of_the_dry_port_to_the_last_of_any() {
        let edge = |us: u64, axis| Edge { cycle: us * 125, axis, direction: 1 };
        let two_moves = [(0, 0), (1, 1), (2, 2), (4, 0), (5, 1), (20_000, 2), (20_001, 0), (20_007, 1)];
        assert_eq!(latencies_us(&two_moves.map(|(us, axis)| edge(us, axis))), [3.0, 7.0]);
    }

    #[test]
    fn stops_of_several_runs_are_as_of_one() {
        let [one, two] = [(1, 3.0), (3, 5.0)].map(|(stops, us)| Latency {
            stops,
            max_us: us,
            mean_us: us,
            position_error_steps: Some([0; AXES]),
        });
        let both = Latency::NONE.and(&one).and(&two);
        assert_eq!((both.stops, both.max_us, both.mean_us), (4, 5.0, 4.5));
        let lost = Latency { position_error_steps: Some([1, 0, 0]), ..one };
        assert_eq!(both.and(&lost).and(&two).position_error_steps, Some([1, 0, 0]));
    }

    #[test]
    fn a_lost_step_is_reported_with_the_latency() {
        let latency = Latency { stops: 2, max_us: 3.0, mean_us: 2.0, position_error_steps: Some([0, 1, 0]) };
        assert_eq!(latency.words(), "max 3.00 us, mean 2.00 us of 2 stops, POSITION WRONG by [0, 1, 0] steps");
    }
}
