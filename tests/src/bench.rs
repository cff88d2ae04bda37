//! A simulated machine that receives moves and is interfered with at random instants, and checks that must hold for
//! everything that was seen: every edge matches the closed form, counts are exact, paths are straight, and each axis
//! keeps its limits as computed from its edges alone. Every run is the same.

use std::collections::VecDeque;
use std::env;
use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::axes::{words, xyz_a};
use embassy_time::Duration;
use isostep_console::length::PM_PER_MM;
use isostep_motion::{AXES, SpeedOverrides, State, whole_steps};
use isostep_profile::SpeedProfile;
use isostep_sim::measure::limits::{self, LimitRatios};
use isostep_sim::swarm::judge;
use isostep_sim::{Config, MoveRecord, Outcome, Port, Sim};
use oorandom::Rand64;

/// A machine with a speed profile that moves without homing, and its random numbers.
pub struct Bench {
    /// The machine.
    pub sim: Sim,
    /// Random numbers, with a different seed for every case.
    pub random: Rand64,
    /// The length of each line that was sent and not answered. Lines discarded by a reset are removed. No line may be
    /// refused.
    unanswered: VecDeque<usize>,
    /// The overrides, and when they came into force, ns since power-up.
    overrides: Vec<(u64, SpeedOverrides)>,
}

/// Less than the buffer of the console.
const WINDOW_BYTES: usize = 400;

/// The default resolution, which [`Bench`] uses.
const STEPS_PER_MM: f64 = 50.0;
const UM_PER_STEP: i64 = 20;

impl Bench {
    /// The machine for a case. The case decides on the step port and the speed profile.
    ///
    /// # Panics
    /// When the machine refuses its settings. All other functions here panic too when the machine misbehaves.
    #[must_use]
    pub fn new(case: u64) -> Self {
        let port = if case.is_multiple_of(2) { Port::Pio } else { Port::Timer };
        let sim = Sim::new(&Config { port, ..Config::default() });
        let (random, overrides) = (Rand64::new(case.into()), vec![(0, SpeedOverrides::NONE)]);
        let mut bench = Self { sim, random, unanswered: VecDeque::new(), overrides };
        let speed_profile = bench.random.rand_range(0..SpeedProfile::ALL.len() as u64);
        let thirds = bench.random.rand_range(0..2);
        bench.say(&format!("$910=60\n$911=60\n$912=60\n$900={thirds}\n$940={speed_profile}\n$X\n"));
        // Y accelerates less, and some machines brake at another rate than they accelerate.
        let decel = [0, 35, 80][(case % 3) as usize];
        bench.say(&format!("$121=40\n$920={decel}\n$921={decel}\n$922={decel}\n"));
        bench.settle_settings();
        bench
    }

    /// Waits until the settings are stored.
    pub fn settle_settings(&mut self) {
        self.sim.run_for(Duration::from_millis(100)).unwrap();
        self.outcome();
    }

    /// Sends lines, or bytes that are no lines.
    pub fn say(&mut self, text: &str) {
        self.unanswered.extend(text.split_inclusive('\n').filter(|line| line.ends_with('\n')).map(str::len));
        self.sim.send(text.as_bytes());
    }

    /// Sends each line when there is room for it, so that real-time bytes act at once.
    pub fn stream(&mut self, lines: &str) {
        for line in lines.split_inclusive('\n') {
            while self.unanswered.iter().sum::<usize>() + line.len() > WINDOW_BYTES {
                self.sim.run_for(Duration::from_millis(1)).unwrap();
                self.hear();
            }
            self.say(line);
        }
    }

    /// Sends a reset. It discards the lines not answered yet.
    pub fn reset(&mut self) {
        self.hear();
        self.unanswered.clear();
        self.sim.send(&[0x18]);
    }

    /// Reads the replies. Returns whether the welcome was among them.
    pub fn hear(&mut self) -> bool {
        let heard = self.sim.replies();
        let is_welcome = |line: &&String| line.starts_with("Grbl 1.1h");
        let other = heard.iter().find(|line| *line != "ok" && !is_welcome(line));
        assert_eq!(other, None, "neither ok nor a welcome, in {:?}", self.state());
        let welcomes = heard.iter().filter(is_welcome).count();
        let (answers, lines) = (heard.len() - welcomes, self.unanswered.len());
        assert!(answers <= lines, "{answers} answers came to {lines} lines, in {:?}", self.state());
        self.unanswered.drain(..answers);
        welcomes > 0
    }

    /// Discards the replies and the unanswered lines, after a stop and what follows it.
    pub fn forget_answers(&mut self) {
        self.sim.replies();
        self.unanswered.clear();
    }

    /// Everything seen so far. Every line must have been answered.
    pub fn outcome(&mut self) -> Outcome {
        self.hear();
        assert!(self.unanswered.is_empty(), "{} lines unanswered, in {:?}", self.unanswered.len(), self.state());
        self.sim.outcome()
    }

    /// Sends real-time bytes that change overrides.
    pub fn override_by(&mut self, bytes: &[u8]) {
        let at_ns = self.sim.now_ns();
        self.sim.send(bytes);
        self.sim.run_for(Duration::from_ticks(1)).unwrap();
        self.note_overrides(at_ns);
    }

    /// Records the overrides that are in force from `at_ns` on.
    pub fn note_overrides(&mut self, at_ns: u64) {
        self.overrides.push((at_ns, self.sim.machine().overrides()));
    }

    /// The highest overrides in force at any time between two instants, ns since power-up.
    fn highest_overrides(&self, from_ns: u64, until_ns: u64) -> SpeedOverrides {
        let begun = self.overrides.partition_point(|(at_ns, _)| *at_ns <= until_ns);
        let over = self.overrides[..begun].partition_point(|(at_ns, _)| *at_ns <= from_ns) - 1;
        let highest =
            |of: fn(&SpeedOverrides) -> u8| self.overrides[over..begun].iter().map(|(_, each)| of(each)).max();
        SpeedOverrides {
            feed_percent: highest(|each| each.feed_percent).unwrap_or(100),
            rapid_percent: highest(|each| each.rapid_percent).unwrap_or(100),
        }
    }

    /// The speed that an axis must keep in a move, `t_s` from its beginning, steps/s. `feed_mm_min` is the move's feed;
    /// `None` for a rapid. A lower override limits the speed only once it has taken effect, so the limit is computed
    /// from the highest override since the run was planned, at `planned_ns`.
    fn speed_limit(
        &self,
        record: &MoveRecord,
        axis: usize,
        feed_mm_min: Option<f64>,
        planned_ns: u64,
        t_s: f64,
    ) -> f64 {
        let config = self.sim.machine().config();
        let SpeedOverrides { feed_percent, rapid_percent } =
            self.highest_overrides(planned_ns, record.begin_ns() + (t_s * 1e9) as u64);
        let top = config.limits[axis].top_speed_steps_s;
        let Some(feed) = feed_mm_min else { return top * f64::from(rapid_percent) / 100.0 };
        let of_axis = record.plan.axis_steps(axis).abs()
            / limits::way_mm(record, &config).map(|mm| mm * mm).iter().sum::<f64>().sqrt();
        top.min(feed / 60.0 * f64::from(feed_percent) / 100.0 * of_axis)
    }

    /// The ratio of each axis to its limits, computed from its edges, and of corners to theirs, computed
    /// from the speed at which they are taken.
    pub fn ratios(&self, outcome: &Outcome, feed_mm_min: impl Fn(&MoveRecord) -> Option<f64>) -> LimitRatios {
        limits::of_run(outcome, |record, axis, t_s| {
            self.speed_most_steps_s(outcome, record, axis, feed_mm_min(record), t_s)
        })
    }

    /// The speed that an axis must keep in a move, `t_s` from its beginning.
    #[must_use]
    pub fn speed_most_steps_s(
        &self,
        outcome: &Outcome,
        record: &MoveRecord,
        axis: usize,
        feed_mm_min: Option<f64>,
        t_s: f64,
    ) -> f64 {
        // A run is prepared after the last step of the previous run, or, at rest, within the last millisecond before its
        // start.
        let before = outcome.edges.partition_point(|edge| edge.t_ns < record.start_ns).checked_sub(1);
        let planned_ns = before.map_or(u64::MAX, |last| outcome.edges[last].t_ns).min(record.start_ns - 1_000_000);
        self.speed_limit(record, axis, feed_mm_min, planned_ns, t_s)
    }

    /// A random one of `values`.
    pub fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.random.rand_range(0..values.len() as u64) as usize]
    }

    /// Lets a random time pass, at most `longest_s`.
    pub fn wait(&mut self, longest_s: f64) {
        let wait_us = (self.random.rand_float() * longest_s * 1e6) as u64;
        self.sim.run_for(Duration::from_micros(wait_us)).unwrap();
    }

    /// Holds the machine by this byte, sends lines meanwhile, checks that it stands still for up to `longest_s`, and resumes
    /// it.
    pub fn hold(&mut self, byte: u8, lines: &str, longest_s: f64) {
        self.sim.send(&[byte]);
        self.say(lines);
        self.at_rest();
        self.stays(longest_s);
        self.sim.send(b"~");
    }

    /// Lets time pass until nothing moves.
    pub fn at_rest(&mut self) {
        self.sim
            .run_until_state(|state| !matches!(state, State::Hold { still: false } | State::Run | State::Jog))
            .unwrap();
    }

    /// Lets a random time pass, at most `longest_s`, and checks that the machine does not move.
    pub fn stays(&mut self, longest_s: f64) {
        let still = self.steps();
        self.wait(longest_s);
        assert_eq!(self.steps(), still, "it moved at rest");
    }

    /// The position that the machine reports.
    #[must_use]
    pub fn steps(&self) -> [i32; AXES] {
        self.sim.machine().position_steps()
    }

    /// The state of the machine.
    #[must_use]
    pub fn state(&self) -> State {
        self.sim.machine().state()
    }
}

/// A move in one line: its steps, where, when and in which run it began, and how it ended.
fn brief(record: &MoveRecord) -> String {
    let MoveRecord { plan, origin_steps, end_steps, run, finish, parts, .. } = record;
    let at_s = record.begin_ns() as f64 * 1e-9;
    format!(
        "the move of {:?} steps from {origin_steps:?} at {at_s:.6} s in run {run}, {} parts, {finish:?} at {end_steps:?}",
        plan.steps,
        1 + parts.len()
    )
}

/// Checks that the edges of every move match the closed form, that counts are exact and that paths are straight.
///
/// # Panics
/// When a check fails.
pub fn check(outcome: &Outcome, case: u64) {
    if let Err((promise, found)) = judge::steps(outcome) {
        panic!("case {case}: {promise}: {found}");
    }
}

/// The highest ratios over many cases.
#[derive(Default)]
pub struct Highest(LimitRatios);

impl Highest {
    /// Adds a case, which must keep to every limit.
    ///
    /// # Panics
    /// When the case exceeds a limit.
    pub fn add(&mut self, ratios: LimitRatios, case: u64) {
        assert!(ratios.are_within(), "case {case}: {ratios:?}");
        self.0 = self.0.max(ratios);
    }

    /// Prints the ratios and checks that they come near to every limit. Corners are not checked, because blends have
    /// none.
    ///
    /// # Panics
    /// When a ratio is too low.
    pub fn print(&self) {
        let LimitRatios { speed, ends, accel, decel, jerk, .. } = self.0;
        println!("at most, as ratios to the limits, by the edges: {:?}", self.0);
        assert!([speed, accel, decel, jerk].into_iter().all(|ratio| ratio > 0.98) && ends > 0.5, "{:?}", self.0);
    }
}

/// Runs `cases` cases, or only the case that `CASE` names. Returns whether it ran all. A failure prints the command
/// that repeats it.
///
/// # Panics
/// When a case panics.
pub fn all_cases(file: &str, test: &str, cases: u64, mut carry_out: impl FnMut(u64)) -> bool {
    if let Ok(case) = env::var("CASE") {
        carry_out(case.parse().expect("CASE is a number"));
        return false;
    }
    for case in 0..cases {
        if catch_unwind(AssertUnwindSafe(|| carry_out(case))).is_err() {
            panic!("again: CASE={case} cargo test -p isostep-tests -- --exact {file}::{test}");
        }
    }
    true
}

/// A move of a random chain, or an arc.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// The steps of the move; `None` for an arc.
    pub steps: Option<[i32; AXES]>,
    /// The place where it ends, steps.
    pub end_steps: [i32; AXES],
    /// The feed, mm/min; `None` for a rapid.
    pub feed_mm_min: Option<f64>,
    /// True if it ends in a stop.
    pub stops: bool,
}

/// Random moves, requested one after the other.
#[derive(Clone, Debug, Default)]
pub struct Moves {
    /// The requested moves in order, without those of length zero.
    pub asked: Vec<Asked>,
    place_steps: [i32; AXES],
    last_steps: [i32; AXES],
    /// True if the program is beside the place, because its last line led to between two steps.
    is_between: bool,
}

/// The way in which random moves are requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// As blocks of a program.
    Program,
    /// As jogs.
    Jog,
}

/// The room for the moves, steps.
const ROOM_STEPS: [i32; AXES] = xyz_a([3_000, 3_000, 1_500], 1_500);

impl Moves {
    /// Moves that begin at this position.
    #[must_use]
    pub fn from(place_steps: [i32; AXES]) -> Self {
        Self { place_steps, ..Self::default() }
    }

    /// The place where the last one ends, steps.
    #[must_use]
    pub fn end_steps(&self) -> [i32; AXES] {
        self.place_steps
    }

    /// The lines of `count` more moves.
    pub fn more(&mut self, count: u64, kind: Kind, random: &mut Rand64) -> String {
        let mut lines = String::new();
        for _ in 0..count {
            if kind == Kind::Program && random.rand_range(0..6) == 0 && self.arc(&mut lines, random) {
                continue;
            }
            let steps = self.near(random);
            self.line(&mut lines, steps, kind, random);
        }
        lines
    }

    /// The lines of `count` moves to anywhere in the room.
    pub fn far(&mut self, count: u64, kind: Kind, random: &mut Rand64) -> String {
        let mut lines = String::new();
        for _ in 0..count {
            let end_steps = ROOM_STEPS.map(|most| random.rand_range(0..most as u64 + 1) as i32);
            self.line(&mut lines, self.way_steps(end_steps), kind, random);
        }
        lines
    }

    fn way_steps(&self, end_steps: [i32; AXES]) -> [i32; AXES] {
        std::array::from_fn(|axis| end_steps[axis] - self.place_steps[axis])
    }

    /// The steps of a move of any kind that stays in the room.
    fn near(&self, random: &mut Rand64) -> [i32; AXES] {
        let mut any = |most: f64| ((random.rand_float() * 2.0 - 1.0) * most).round() as i32;
        // The longest distance of the move: from one step to some millimetres.
        let far = 1_000.0_f64.powf(f64::from(any(100.0).abs()) / 100.0);
        let mut steps = match any(5.0) {
            -5 | -4 => self.last_steps.map(|steps| -steps),
            -3 => self.last_steps,
            // Nearly straight on.
            -2 | -1 => self.last_steps.map(|steps| steps + any(2.0)),
            // A single step, possibly none.
            0 | 1 => xyz_a([any(far), any(1.0), 0], 0),
            2 => std::array::from_fn(|_| any(1.0)),
            _ => std::array::from_fn(|axis| any(if axis < 2 { far } else { far / 2.0 })),
        };
        for axis in 0..AXES {
            if !(0..=ROOM_STEPS[axis]).contains(&(self.place_steps[axis] + steps[axis])) {
                steps[axis] = -steps[axis];
            }
            if !(0..=ROOM_STEPS[axis]).contains(&(self.place_steps[axis] + steps[axis])) {
                steps[axis] = 0;
            }
        }
        steps
    }

    /// A line that leads so many steps on, or to between two steps there.
    fn line(&mut self, lines: &mut String, steps: [i32; AXES], kind: Kind, random: &mut Rand64) {
        let beside_um = if random.rand_range(0..6) == 0 { [3, 6, 10][random.rand_range(0..3) as usize] } else { 0 };
        let um: [i64; AXES] =
            std::array::from_fn(|axis| i64::from(self.place_steps[axis] + steps[axis]) * UM_PER_STEP + beside_um);
        let words = words(um.map(|um| um as f64 / 1e3));
        // As the controller rounds.
        let end_steps = um.map(|um| whole_steps((um * 1_000_000) as f64, STEPS_PER_MM / PM_PER_MM));
        let steps = self.way_steps(end_steps);
        let feed = (60.0 * 60.0_f64.powf(random.rand_float())).round();
        let (word, feed_mm_min, stops) = match (kind, random.rand_range(0..8)) {
            (Kind::Jog, _) => (format!("$J=G90 F{feed}"), Some(feed), false),
            (Kind::Program, 0 | 1) => ("G64 G0".to_owned(), None, false),
            (Kind::Program, 2) => (format!("G61.1 G1 F{feed}"), Some(feed), true),
            (Kind::Program, _) => (format!("G64 G1 F{feed}"), Some(feed), false),
        };
        writeln!(lines, "{word} {words}").unwrap();
        if steps != [0; AXES] {
            self.asked.push(Asked { steps: Some(steps), end_steps, feed_mm_min, stops });
            (self.place_steps, self.last_steps) = (end_steps, steps);
        }
        self.is_between = beside_um != 0;
    }

    /// Adds a quarter of a circle or a whole one. Returns false if there is no room for it.
    fn arc(&mut self, lines: &mut String, random: &mut Rand64) -> bool {
        let [x_steps, y_steps, ..] = self.place_steps;
        let radius_steps = random.rand_range(5..120) as i32;
        let room = 2 * radius_steps..=ROOM_STEPS[0] - 2 * radius_steps;
        if self.is_between || !room.contains(&x_steps) || !room.contains(&y_steps) {
            return false;
        }
        let mm = |steps: i32| f64::from(steps) / STEPS_PER_MM;
        let feed = random.rand_range(300..3_000) as f64;
        let is_whole = random.rand_range(0..3) == 0;
        let turn = if random.rand_range(0..2) == 0 { 2 } else { 3 };
        let up = if turn == 2 { radius_steps } else { -radius_steps };
        let mut end_steps = self.place_steps;
        if !is_whole {
            (end_steps[0], end_steps[1]) = (x_steps + radius_steps, y_steps + up);
        }
        let ([x, y, ..], i) = (end_steps.map(mm), mm(radius_steps));
        writeln!(lines, "G64 G{turn} X{x} Y{y} I{i} F{feed}").unwrap();
        self.asked.push(Asked { steps: None, end_steps, feed_mm_min: Some(feed), stops: false });
        self.place_steps = end_steps;
        true
    }

    /// For each record, the index in `asked` of the move that it belongs to. The records must be in order. Each is a
    /// whole move or a part that continues where the move was held. Some of the last moves may have no record.
    ///
    /// # Panics
    /// When the records do not match the requested moves.
    #[must_use]
    pub fn of(&self, records: &[MoveRecord]) -> Vec<usize> {
        let mut next = 0;
        let found = records.iter().enumerate().map(|(at, record)| {
            let index = next;
            let asked = self.asked.get(index).unwrap_or_else(|| panic!("nobody asked for {}", brief(record)));
            let is_same = asked.steps.is_none_or(|steps| steps == record.plan.steps);
            assert!(is_same, "{asked:?} was made as {}", brief(record));
            let is_whole =
                (0..AXES).all(|axis| record.step_numbers(axis).end == record.plan.steps[axis].unsigned_abs() + 1);
            // A blend leads on to the next move, or to the next chord.
            let end_steps =
                records.get(at + 1).filter(|_| record.ends_in_blend).map_or(record.end_steps, MoveRecord::corner_steps);
            if (record.ends_in_blend || is_whole) && end_steps == asked.end_steps {
                next += 1;
            }
            index
        });
        found.collect()
    }
}
