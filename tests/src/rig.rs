//! Machines of several kinds that run the same cases: simulated with either step port, or the firmware on the emulated
//! board.

use std::fmt;

use crate::axes::xyz_a;
use embassy_time::{Duration, Instant};
use isostep_motion::{AXES, Axis};
use isostep_sim::drive::MotorData;
use isostep_sim::world::Edge;
use isostep_sim::{Config, Port, Sim, SwitchFault};

use crate::emulated::Board;

/// An input that stops a machine at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The limit switch of an axis.
    Limit(Axis),
    /// The emergency stop.
    Emergency,
    /// The reset byte, twice.
    Reset,
}

/// One action on a machine.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// Sends a line, which must be accepted.
    Line(String),
    /// Lets time pass.
    WaitUs(u32),
    /// Waits until all moves are done.
    WaitIdle,
    /// Stops the machine by this input. The machine must lock itself.
    Press(Stop),
    /// Releases the input.
    Release(Stop),
    /// Requests the position, at rest.
    Report,
    /// Sends a status request in any state and does not wait for the answer.
    Ask,
    /// Empties the processor's cache, if it has one.
    ColdCache,
}

/// Everything observed of a machine.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Every STEP edge, in order.
    pub edges: Vec<Edge>,
    /// Every report: when it came, ns since power-up, and the reported position, steps.
    pub reports: Vec<(u64, [i32; AXES])>,
}

impl Seen {
    /// The position to which the edges up to `t_ns` have taken the machine since power-up, steps.
    #[must_use]
    pub fn counted_steps(&self, t_ns: u64) -> [i32; AXES] {
        let mut counted = [0; AXES];
        for edge in self.edges.iter().take_while(|edge| edge.t_ns <= t_ns) {
            counted[edge.axis] += edge.direction;
        }
        counted
    }
}

/// Limits and a move that suit a machine. All axes have the same limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Top speed, mm/min.
    pub top_mm_min: u32,
    /// Acceleration and deceleration, mm/s².
    pub accel_mm_s2: u32,
    /// Jerk of the S-curve, mm/s³. The acceleration is reached in a hundredth of a second or two.
    pub jerk_mm_s3: u32,
    /// Start speed for the speed profiles that need one, mm/min.
    pub start_mm_min: u32,
    /// A move, mm.
    pub away_mm: [f64; AXES],
    /// A lower bound of its duration, us.
    pub lasts_us: u32,
}

impl Pace {
    /// The parking gantry's limits. The speed profiles over displacement start at 100 steps/s.
    pub const GANTRY: Self = Self {
        top_mm_min: 2_880,
        accel_mm_s2: 50,
        jerk_mm_s3: 500,
        start_mm_min: 120,
        away_mm: xyz_a([40.0, -28.0, 12.0], 18.0),
        lasts_us: 1_780_000,
    };
    /// At most 63,000 steps/s, at 2,000,000 steps/s².
    const HARDWARE: Self = Self {
        top_mm_min: 240_000,
        accel_mm_s2: 40_000,
        jerk_mm_s3: 4_000_000,
        start_mm_min: 1_200,
        lasts_us: 60_000,
        ..Self::GANTRY
    };
    /// At most 10,000 steps/s, at 100,000 steps/s².
    const TASKS: Self = Self {
        top_mm_min: 12_000,
        accel_mm_s2: 2_000,
        jerk_mm_s3: 100_000,
        away_mm: xyz_a([20.0, -14.0, 6.0], 9.0),
        lasts_us: 190_000,
        ..Self::GANTRY
    };

    fn of(port: Port) -> Self {
        match port {
            Port::Pio => Self::HARDWARE,
            Port::Timer => Self::TASKS,
        }
    }

    /// The steepest limits for which the port's starts are tested: 5,000,000 steps/s², or 1,000,000 where tasks make
    /// the steps.
    fn steep(port: Port) -> Self {
        let accel_mm_s2 = match port {
            Port::Pio => 100_000,
            Port::Timer => 20_000,
        };
        Self { accel_mm_s2, ..Self::of(port) }
    }

    /// Lines that send these limits to the machine.
    #[must_use]
    pub fn settings(&self) -> Vec<String> {
        let Self { top_mm_min, accel_mm_s2, jerk_mm_s3, .. } = self;
        let values = [(110, top_mm_min), (120, accel_mm_s2), (930, jerk_mm_s3)];
        let limits = (0..AXES).flat_map(|axis| values.map(|(number, value)| format!("${}={value}", number + axis)));
        // An axis without an end does not stop at its switch.
        limits.chain((AXES == 4).then(|| "$133=1000".to_owned())).collect()
    }
}

/// A kind of machine. Its display says how to repeat its test.
pub trait Rig: fmt::Display {
    /// Limits and a move that suit the machine.
    fn pace(&self) -> Pace {
        Pace::of(self.port())
    }

    /// The same top speed with the highest acceleration.
    fn steep_pace(&self) -> Pace {
        Pace::steep(self.port())
    }

    /// The port that makes the steps.
    fn port(&self) -> Port;

    /// The largest deviation of a step from its closed-form instant, ns. Both are counted from the first step of the
    /// move.
    fn jitter_max_ns(&self) -> f64;

    /// Performs all actions on a machine that was just powered up. `case` is the name of the test case.
    ///
    /// # Panics
    /// When a line is refused, a stop does not lock the machine, or an edge breaks the driver's timing.
    fn carry_out(&self, case: &str, acts: &[Act]) -> Seen;
}

/// The whole controller in virtual time. Its motors are so strong that they follow any edge.
#[derive(Clone, Copy, Debug)]
pub struct Simulated(pub Port);

impl Simulated {
    /// Performs one action. Returns the position for a report.
    fn act(sim: &mut Sim, act: &Act) -> Option<[i32; AXES]> {
        const SOON: Duration = Duration::from_millis(1);
        match act {
            Act::Line(line) => {
                sim.send(format!("{line}\n").as_bytes());
                sim.run_for(SOON).unwrap();
                if line.starts_with("G4") {
                    // A dwell is answered at its end, and begins when the previous plan has ended.
                    sim.run_until_idle().unwrap();
                }
                let heard = sim.replies();
                assert_eq!(heard.last().map(String::as_str), Some("ok"), "`{line}` was answered with {heard:?}");
            }
            Act::WaitUs(us) => sim.run_for(Duration::from_micros((*us).into())).unwrap(),
            Act::WaitIdle => sim.run_until_idle().unwrap(),
            Act::Press(stop) => {
                match *stop {
                    Stop::Limit(axis) => sim.set_switch(axis, SwitchFault::StuckClosed),
                    Stop::Emergency => sim.set_emergency_stop(true),
                    Stop::Reset => sim.send(b"\x18\x18"),
                }
                sim.run_for(SOON).unwrap();
                let heard = sim.replies();
                let is_locked = heard.iter().any(|line| line.starts_with("ALARM:"));
                assert!(is_locked, "{stop:?} was answered with {heard:?}, where an alarm was expected");
            }
            Act::Release(Stop::Limit(axis)) => sim.set_switch(*axis, SwitchFault::None),
            Act::Release(Stop::Emergency) => sim.set_emergency_stop(false),
            Act::Release(Stop::Reset) => {}
            Act::Report => {
                sim.run_for(SOON).unwrap();
                return Some(sim.machine().position_steps());
            }
            Act::Ask => sim.send(b"?"),
            Act::ColdCache => {}
        }
        None
    }
}

impl Rig for Simulated {
    fn port(&self) -> Port {
        self.0
    }

    fn jitter_max_ns(&self) -> f64 {
        // The tolerance applies to the step and to the first step.
        2.0 * self.0.tolerance_ns()
    }

    fn carry_out(&self, _case: &str, acts: &[Act]) -> Seen {
        let motor = MotorData::RIGID;
        let mut sim = Sim::new(&Config { port: self.0, motor, ..Config::default() });
        sim.run_for(Duration::from_millis(50)).unwrap();
        let mut reports = Vec::new();
        for act in acts {
            if let Some(report) = Self::act(&mut sim, act) {
                reports.push(((sim.now() - Instant::MIN).as_nanos(), report));
            }
        }
        let outcome = sim.outcome();
        assert_eq!(first_of(&outcome.violations), None, "{self}");
        Seen { edges: outcome.edges, reports }
    }
}

impl fmt::Display for Simulated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "simulated machine, {} port", self.0)
    }
}

/// The firmware with this step port on the emulated board.
#[derive(Clone, Copy, Debug)]
pub struct Emulated(pub Port);

impl Emulated {
    fn script(acts: &[Act]) -> String {
        let line = |act: &Act| match act {
            Act::Line(line) => format!("send {line}\nexpect ok\n"),
            Act::WaitUs(us) => format!("wait-us {us}\n"),
            Act::WaitIdle => "wait-idle\n".to_owned(),
            Act::Press(Stop::Limit(axis)) => format!("switch {axis} stuck-closed\nexpect ALARM:\n"),
            Act::Press(Stop::Emergency) => "estop pressed\nexpect ALARM:\n".to_owned(),
            Act::Press(Stop::Reset) => "bytes 18 18\nexpect ALARM:\n".to_owned(),
            Act::Release(Stop::Limit(axis)) => format!("switch {axis} normal\n"),
            Act::Release(Stop::Emergency) => "estop released\n".to_owned(),
            Act::Release(Stop::Reset) => String::new(),
            Act::Report => "bytes 3f\nexpect <\n".to_owned(),
            Act::Ask => "bytes 3f\n".to_owned(),
            Act::ColdCache => "cold-cache\n".to_owned(),
        };
        "expect Grbl\n".to_owned() + &acts.iter().map(line).collect::<String>()
    }

    fn folder(case: &str, port: Port) -> String {
        format!("{case}-{port}")
    }
}

impl Rig for Emulated {
    fn port(&self) -> Port {
        self.0
    }

    fn jitter_max_ns(&self) -> f64 {
        match self.0 {
            Port::Pio => 50.0,
            // A step that is due while another axis's step is made has to wait: 10 us for three axes. Sometimes a critical
            // section also delays the wake-up.
            Port::Timer => 10_000.0 / 3.0 * AXES as f64,
        }
    }

    fn carry_out(&self, case: &str, acts: &[Act]) -> Seen {
        let run = Board::stepped_by(self.0, &Self::folder(case, self.0)).script(&Self::script(acts));
        assert!(run.ok, "{self}, case {case}:\n{}", end_of(&run.printed));
        let reports = reports(&run.printed);
        Seen { edges: run.edges, reports }
    }
}

impl fmt::Display for Emulated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "emulated board, {} port (target/emulated/CASE-{0}/script.txt has the script)", self.0)
    }
}

/// The number of faults and the first one; `None` if there is none.
pub(crate) fn first_of<T: fmt::Display>(faults: &[T]) -> Option<String> {
    faults.first().map(|first| format!("{} of them, the first: {first}", faults.len()))
}

/// The last lines of a transcript, which say how the board failed.
fn end_of(transcript: &str) -> String {
    const LINES: usize = 30;
    let lines: Vec<_> = transcript.lines().collect();
    lines[lines.len().saturating_sub(LINES)..].join("\n")
}

/// The answers to [`Act::Report`] in a transcript. [`Act::Ask`] and waits for idle also send requests, but no `expect`
/// follows those.
fn reports(transcript: &str) -> Vec<(u64, [i32; AXES])> {
    let mut asked = false;
    let mut reports = Vec::new();
    // Each line begins with its instant, s.
    for (at_s, said) in transcript.lines().filter_map(|line| line.trim_start().split_once(' ')) {
        asked |= said == "# expect <";
        if let (true, Some(steps)) = (asked, position_steps(said)) {
            reports.push(((at_s.parse::<f64>().expect("an instant") * 1e9) as u64, steps));
            asked = false;
        }
    }
    reports
}

/// The position in a status report, in steps at the default 50 steps/mm.
fn position_steps(report: &str) -> Option<[i32; AXES]> {
    let (_, position) = report.split_once("|MPos:")?;
    let mm = position.split(['|', '>']).next()?.split(',');
    let steps: Vec<_> =
        mm.map(|mm| mm.parse::<f64>().map(|mm| (mm * 50.0).round() as i32)).collect::<Result<_, _>>().ok()?;
    steps.try_into().ok()
}
