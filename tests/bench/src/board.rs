//! The emulated board for the measurements: the emulator knows every edge, and presses every switch.

use std::fmt::Write;
use std::ops::Range;

use anyhow::{Context, Result, ensure};
use isostep::chip::Chip;
use isostep::measure::board::Followed;
use isostep::measure::load::{Awake, Load};
use isostep::measure::moves::{Carried, Stream};
use isostep::measure::planned_move::{PROVED, UNIT_STEPS};
use isostep::measure::starts::Starts;
use isostep::measure::stops::{Cause, Stops};
use isostep::measure::{Board, Machine, Measured, Method, PlannedMove, Ramp, finely};
use oorandom::Rand32;

use super::edges::{Astray, Edge, follow};
use super::port::Port;
use super::runs::{GREETING, Job, Runs, Summary, unreadable};
use super::{ACCEL_MAX_STEPS_S2, RAMP};

/// The most steps that moves with an RP2350 leave out more than those with an RP2040.
const FAST_LEAVE_OUT_MORE_PERCENT: usize = 4;

fn method(chip: Chip) -> Method {
    Method {
        unit_ns: chip.cycle_ns(),
        start_from: "the arrival of its line",
        edges: "instants count from the first edge, so a delay common to all does not show",
        rates: "",
        load: "",
        starts: "",
        moves: "a curve of one shape",
    }
}

/// A fixed seed, so that every run has the same moves, rests and stops.
const SEED: u64 = 1;
/// When a move is stopped, us after its line was accepted: in the second half of the ramp, or in the cruise after it.
const STOPPED_US: Range<f64> = 100_000.0..300_000.0;
/// Stops per run. All its moves go in the same direction, so their number must keep within the 10 m that a target may
/// be from zero.
const RUN_STOPS: u32 = 40;
/// Time from a stop to the next command, ms. The debounce takes 5.
const SETTLE_MS: u32 = 20;
/// Time for which the machine rests before a line is sent, us.
const REST_US: Range<f64> = 1_000.0..100_000.0;
/// The distance of an axis in a move that is started, in [`UNIT_STEPS`].
const WAY_UNITS: Range<u32> = 1..40;
/// The run does not wait for a core that makes fewer moves per second than this.
const SLOWEST_MOVES_S: f64 = 100.0;

/// The emulated board.
pub struct Emulated<'a> {
    pub runs: Runs<'a>,
    pub port: Port,
    /// Duration of the cruise in which the load is measured, s.
    pub load_s: f64,
}

impl Emulated<'_> {
    fn moving(&self, machine: &Machine, cruise_s: f64) -> Result<Measured<Summary>> {
        let planned = machine.straight(PROVED, cruise_s)?;
        self.runs.run(Job::Script(&script(machine, std::slice::from_ref(&planned))), planned.duration_s())
    }

    /// Moves that are stopped in as many runs as necessary, at other instants in each run.
    fn stopped(&self, cause: Cause, rate_steps_s: u32, count: u32) -> Result<Measured<Stops>> {
        let (mut random, machine) = (Rand32::new(SEED), Machine::new(rate_steps_s, RAMP));
        let mut stops = Stops { rate_steps_s, latencies_us: Vec::new(), astray_steps: Some(0) };
        for begun in (0..count).step_by(RUN_STOPS as usize) {
            let count = RUN_STOPS.min(count - begun);
            let script = stopping(&machine, cause, count, &mut random)?;
            let summary = match self.runs.run(Job::Script(&script), f64::from(count))? {
                Ok(summary) => summary,
                Err(why_not) => return Ok(Err(why_not)),
            };
            let timed = summary.stops.len();
            ensure!(timed == count as usize, "the emulator timed {timed} of {count} stops");
            stops.latencies_us.extend(summary.stops.iter().map(|stop| stop.latency_ns * 1e-3));
            stops.astray_steps =
                stops.astray_steps.zip(summary.position_error_steps()).map(|(one, other)| one.max(other));
        }
        Ok(Ok(stops))
    }

    /// Moves that ask too much of the port, each of which ends in its fault. All axes make the same steps, so the port that
    /// faulted is the one whose last edge is the earliest. A state machine that runs dry halts with that edge; a step that comes
    /// too late is noticed half a period of the top speed and more after it was due.
    fn faulted(&self, cause: Cause, count: u32) -> Result<Measured<Stops>> {
        let (rate_steps_s, accel_steps_s2) = if cause == Cause::DryPort { (248_000, 1e7) } else { (30_000, 1e6) };
        let ran =
            self.runs.edges(Job::Script(&faulting(cause, rate_steps_s, accel_steps_s2, count)), f64::from(count))?;
        let (summary, edges) = match ran {
            Ok(ran) => ran,
            Err(why_not) => return Ok(Err(why_not)),
        };
        let latencies_us = apart_us(&edges);
        ensure!(latencies_us.len() == count as usize, "{} of {count} moves ended in the fault", latencies_us.len());
        Ok(Ok(Stops { rate_steps_s, latencies_us, astray_steps: summary.position_error_steps() }))
    }
}

impl Board for Emulated<'_> {
    fn method(&self) -> Method {
        method(self.runs.candidate.model.chip())
    }

    fn note(&mut self, what: &str) {
        let second = if self.runs.has_second { ", two motors on Y" } else { "" };
        eprintln!("    {}: {}{second}: {what}", self.runs.chip.name(), self.port.name());
    }

    fn follow(&mut self, machine: &Machine, moves: &[PlannedMove]) -> Result<Measured<Followed>> {
        let moving_s = moves.iter().map(PlannedMove::duration_s).sum();
        let followed = self.runs.recorded(Job::Script(&script(machine, moves)), moving_s, |_, path| {
            match follow(self.runs.read(path)?, moves) {
                Ok(followed) => Ok(Ok(followed)),
                Err(Astray::Read(error)) => Err(error).with_context(|| unreadable(path)),
                Err(astray) => Ok(Err(astray.to_string())),
            }
        });
        Ok(followed?.and_then(|followed| followed))
    }

    /// Two moves have the same ramps, and one of them also has a cruise. The difference of their cycles is the cost of the
    /// cruise.
    fn load(&mut self, rate_steps_s: u32) -> Result<Measured<Load>> {
        let machine = Machine::new(rate_steps_s, RAMP);
        let (ramping, whole) = match (self.moving(&machine, 0.0)?, self.moving(&machine, self.load_s)?) {
            (Ok(ramping), Ok(whole)) => (ramping.moving, whole.moving),
            (Err(why_not), _) | (_, Err(why_not)) => return Ok(Err(why_not)),
        };
        let cruising = whole.less(&ramping);
        let resolution = format!("{} of {:.0} ms", finely(self.method().unit_ns), cruising.time_ns * 1e-6);
        let [cruising, ramping] = [cruising, ramping]
            .map(|moving| Awake { ratio: moving.load, cycles_per_step: Some(moving.awake_cycles_per_edge) });
        Ok(Ok(Load { cruising, ramping: Some(ramping), waited_us: None, resolution }))
    }

    fn stops(&mut self, cause: Cause, rate_steps_s: u32, count: u32) -> Result<Measured<Stops>> {
        match cause {
            Cause::DryPort | Cause::LateStep => self.faulted(cause, count),
            _ => self.stopped(cause, rate_steps_s, count),
        }
    }

    fn starts(&mut self, count: u32) -> Result<Measured<Starts>> {
        let (script, moves) = starting(self.port, count)?;
        let moving_s = moves.iter().map(PlannedMove::duration_s).sum();
        let ran = self.runs.edges(Job::Script(&script), moving_s)?;
        Ok(ran.and_then(|(summary, edges)| delays(&moves, &summary, &edges)))
    }

    fn stream(&mut self, stream: &Stream) -> Result<Measured<Carried>> {
        let program = stream.before.iter().chain(&stream.lines).map(|line| format!("{line}\n")).collect::<String>();
        let ran = self.runs.edges(Job::Program(&program), stream.lines.len() as f64 / SLOWEST_MOVES_S)?;
        Ok(ran.and_then(|(summary, edges)| {
            let at_s = carried_s(&leaving_out(stream, self.runs.candidate.model.chip()), &edges)?;
            Ok(Carried { at_s, by: "the edges", awake_ratio: Some(summary.moving.load) })
        }))
    }
}

/// A script that makes these moves.
fn script(machine: &Machine, moves: &[PlannedMove]) -> String {
    let moves = moves.iter().map(|planned| sent(&planned.line())).collect::<String>();
    format!("{}{moves}wait-idle\n", set_up(machine))
}

fn set_up(machine: &Machine) -> String {
    GREETING.to_owned() + &machine.lines().iter().map(|line| sent(line)).collect::<String>()
}

fn sent(line: &str) -> String {
    format!("send {line}\nexpect ok\n")
}

/// Script commands that stop the machine and make it ready again.
fn commands(cause: Cause) -> &'static str {
    match cause {
        Cause::LimitSwitch => "switch X stuck-closed\nexpect ALARM:1\nswitch X normal",
        Cause::FirstMotor => "switch Y stuck-closed\nexpect ALARM:1\nswitch Y normal",
        Cause::SecondMotor => "switch 2 stuck-closed\nexpect ALARM:1\nswitch 2 normal",
        Cause::EmergencyStop => "estop pressed\nexpect ALARM:10\nestop released",
        Cause::SecondReset => "bytes 18\nwait-ms 5\nbytes 18\nexpect Grbl",
        // The executor of the axes gets no time for a while, or that of the task that makes the steps.
        Cause::DryPort => "mask-irq 28\nwait-ms 12\nunmask-irq 28\nexpect ALARM:22",
        Cause::LateStep => "mask-irq 29\nwait-ms 2\nunmask-irq 29\nexpect ALARM:20",
    }
}

/// A move, its stop after a time, and what makes the machine ready again.
fn stopped_move(script: &mut String, line: &str, wait_us: &str, cause: Cause) {
    let stop = commands(cause);
    write!(script, "{}wait-us {wait_us}\n{stop}\nwait-ms {SETTLE_MS}\n{}", sent(line), sent("$X"))
        .expect("a String takes any text");
}

/// Long moves in one direction. Each is stopped before its end.
fn stopping(machine: &Machine, cause: Cause, stops: u32, random: &mut Rand32) -> Result<String> {
    let far = machine.straight(PROVED, 1.0)?.line();
    let mut script = set_up(machine);
    for _ in 0..stops {
        let ratio = f64::from(random.rand_float());
        let wait_us = STOPPED_US.start + ratio * (STOPPED_US.end - STOPPED_US.start);
        stopped_move(&mut script, &far, &format!("{wait_us:.3}"), cause);
    }
    Ok(script + "wait-idle\n")
}

/// Moves that ask too much of the port, each of which ends in an alarm.
fn faulting(cause: Cause, rate_steps_s: u32, accel_steps_s2: f64, moves: u32) -> String {
    let ramp = Ramp { s: f64::from(rate_steps_s) / accel_steps_s2, accel_max_steps_s2: accel_steps_s2 };
    let (mut script, mut random) = (set_up(&Machine::new(rate_steps_s, ramp)), Rand32::new(SEED));
    for _ in 0..moves {
        let wait_us = 100_000 + (1e5 * random.rand_float()) as u32;
        stopped_move(&mut script, "G91 G0 X80 Y80 Z80", &wait_us.to_string(), cause);
    }
    script + "wait-idle\n"
}

/// For each move, the time from the earliest last edge of an axis to the latest, us. A pause of half the settling time
/// is between moves.
fn apart_us(edges: &[Edge]) -> Vec<f64> {
    let pause_ns = f64::from(SETTLE_MS) * 0.5e6;
    let moves = edges.chunk_by(|edge, next| next.t_ns - edge.t_ns < pause_ns);
    let last = |of: &[Edge], axis| of.iter().rfind(|edge| edge.axis == axis).map_or(of[0].t_ns, |edge| edge.t_ns);
    let spread_us = |of: &[Edge]| {
        let lasts = [0, 1, 2].map(|axis| last(of, axis));
        let [earliest_ns, latest_ns] = [f64::min, f64::max].map(|most| lasts.into_iter().fold(lasts[0], most));
        (latest_ns - earliest_ns) * 1e-3
    };
    moves.map(spread_us).collect()
}

/// Moves of three axes from rest on a machine with steep ramps, each with its rest before. In each pair, the first move has a
/// cold cache, and the second is the move back right after it.
fn starting(port: Port, starts: u32) -> Result<(String, Vec<PlannedMove>)> {
    let (rate_steps_s, accel_steps_s2) = port.start_steps_s_and_s2();
    let ramp = Ramp { s: f64::from(rate_steps_s) / accel_steps_s2, accel_max_steps_s2: ACCEL_MAX_STEPS_S2 };
    let machine = Machine::new(rate_steps_s, ramp);
    let mut random = Rand32::new(SEED);
    let (mut script, mut moves) = (set_up(&machine), Vec::new());
    for _ in 0..starts {
        let steps = std::array::from_fn(|_| random.rand_range(WAY_UNITS) as i32 * UNIT_STEPS);
        let there = machine.planned(steps)?;
        for (cold, planned) in [("cold-cache\n", there.clone()), ("", there.back())] {
            let rest_us = REST_US.start + f64::from(random.rand_float()) * (REST_US.end - REST_US.start);
            script += &format!("wait-us {rest_us:.3}\n{cold}{}wait-idle\n", sent(&planned.line()));
            moves.push(planned);
        }
    }
    Ok((script, moves))
}

/// The delay of each move, if the edges match the plans.
fn delays(moves: &[PlannedMove], summary: &Summary, edges: &[Edge]) -> Measured<Starts> {
    follow(edges.iter().copied().map(Ok), moves).map_err(|astray| astray.to_string())?;
    let lines = summary.replies.iter().filter(|line| line.text.starts_with("G91"));
    let delays = lines.filter_map(|line| line.arrived_ns).zip(moves).map(|(arrived_ns, planned)| {
        let next = edges.partition_point(|edge| edge.t_ns < arrived_ns);
        let first_ns = edges.get(next).map_or(f64::NAN, |edge| edge.t_ns);
        let planned_ns = (0..PROVED).map(|axis| planned.due_ns(axis, 1)).fold(f64::INFINITY, f64::min);
        (first_ns - arrived_ns - planned_ns) * 1e-6
    });
    let delays_ms: Vec<f64> = delays.collect();
    let of = |turn| delays_ms.iter().copied().skip(turn).step_by(2).collect();
    Ok(Starts { cold_ms: of(0), warm_ms: of(1) })
}

/// The stream with the steps that this chip may leave out of it: moves that come faster are rounded more.
pub fn leaving_out(stream: &Stream, chip: Chip) -> Stream {
    let is_faster = chip == Chip::Rp2350 && stream.leaves_out_percent > 0;
    let more_percent = if is_faster { FAST_LEAVE_OUT_MORE_PERCENT } else { 0 };
    Stream { leaves_out_percent: stream.leaves_out_percent + more_percent, ..stream.clone() }
}

/// When the moves of a stream were over, by the first edge of the next one, if they made all their steps. The queue may grow
/// or shrink meanwhile, so answers say less.
pub fn carried_s(stream: &Stream, edges: &[Edge]) -> Measured<Vec<f64>> {
    let (made, all) = (edges.len(), stream.steps.last().map_or(0, |steps| *steps as usize));
    if made == 0
        || match stream.leaves_out_percent {
            0 => made != all,
            percent => made * 100 <= all * (100 - percent),
        }
    {
        return Err(format!("{made} edges of {all} steps"));
    }
    let edge = |steps: &u64| &edges[(*steps as usize * made / all).min(made - 1)];
    Ok(stream.steps.iter().map(|steps| edge(steps).t_ns * 1e-9).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_stops_each_move_and_unlocks_the_machine() {
        let machine = Machine::new(1_000_000, RAMP);
        let script = stopping(&machine, Cause::LimitSwitch, 20, &mut Rand32::new(SEED)).unwrap();
        let count = |line: &str| script.lines().filter(|each| *each == line).count();
        assert_eq!((count("switch X stuck-closed"), count("switch X normal"), count("send $X")), (20, 20, 20));
        let waits = script.lines().filter_map(|line| line.strip_prefix("wait-us ")?.parse().ok());
        let waits: std::collections::BTreeSet<u64> = waits.map(|us: f64| us as u64).collect();
        assert!(waits.len() == 20 && waits.iter().all(|us| (100_000..=300_000).contains(us)), "{waits:?}");
    }

    #[test]
    fn from_the_last_edge_of_the_dry_port_to_the_last_of_any() {
        let edge = |us: u32, axis| Edge { t_ns: f64::from(us) * 1e3, axis, direction: 1 };
        let two_moves = [(0, 0), (1, 1), (2, 2), (4, 0), (5, 1), (20_000, 2), (20_001, 0), (20_007, 1)];
        assert_eq!(apart_us(&two_moves.map(|(us, axis)| edge(us, axis))), [3.0, 7.0]);
    }

    #[test]
    fn every_other_start_is_cold() {
        let (script, moves) = starting(Port::Pio, 3).unwrap();
        let lines: Vec<&str> =
            script.lines().filter(|line| line.starts_with("cold") || line.starts_with("send G91")).collect();
        assert_eq!(
            lines.iter().map(|line| line.starts_with("cold")).collect::<Vec<_>>(),
            [true, false, false].repeat(3)
        );
        assert!(script.contains("send $120=5000\n"), "steep: {script}");
        assert!(moves.len() == 6 && moves[1].steps == moves[0].steps.map(|n| -n));
    }

    #[test]
    fn a_delay_is_what_the_plan_does_not_take() {
        let (_, moves) = starting(Port::Pio, 1).unwrap();
        let (mut edges, mut replies) = (Vec::new(), Vec::new());
        for (planned, (arrived_ns, delay_ns)) in moves.iter().zip([(1e9, 800_000.0), (2e9, 600_000.0)]) {
            replies.push(format!(r#"{{"text": "G91 G0", "arrived_ns": {arrived_ns}}}"#));
            let mut of: Vec<Edge> = (0..PROVED)
                .flat_map(|axis| (1..=planned.count(axis)).map(move |k| (axis, k)))
                .map(|(axis, k)| {
                    let t_ns = arrived_ns + delay_ns + planned.due_ns(axis, k);
                    Edge { t_ns, axis, direction: planned.steps[axis].signum() }
                })
                .collect();
            of.sort_by(|one, other| one.t_ns.total_cmp(&other.t_ns));
            edges.extend(of);
        }
        let summary = Summary::of_replies(&replies.join(","));
        let starts = delays(&moves, &summary, &edges).unwrap();
        assert!((starts.cold_ms[0] - 0.8).abs() < 1e-5 && (starts.warm_ms[0] - 0.6).abs() < 1e-5, "{starts:?}");
        assert!(delays(&moves, &summary, &edges[1..]).is_err(), "a lost step");
    }

    #[test]
    fn a_move_is_carried_when_its_last_edge_has_come_and_no_step_is_missing() {
        let edges: Vec<Edge> =
            (0..40).map(|step| Edge { t_ns: f64::from(step) * 1e3, axis: 0, direction: 1 }).collect();
        let stream = Stream {
            before: Vec::new(),
            lines: vec![String::new(); 3],
            steps: vec![10, 30, 40],
            leaves_out_percent: 0,
        };
        let us: Vec<f64> = carried_s(&stream, &edges).unwrap().iter().map(|s| (s * 1e6).round()).collect();
        assert_eq!(us, [10.0, 30.0, 39.0]);
        assert_eq!(carried_s(&stream, &edges[1..]).unwrap_err(), "39 edges of 40 steps");
        assert!(
            carried_s(&Stream { leaves_out_percent: 1, ..stream }, &edges[1..]).is_err(),
            "one of 40 is more than 1 %"
        );
    }
}
