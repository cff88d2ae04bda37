//! Feed hold and resume, jog cancel and overrides at random instants of random moves, in virtual time: every edge against the
//! closed form, counts exact, paths straight, and each axis within its limits as its edges alone tell. The same in every run;
//! a failure names its case.

use embassy_time::Duration;
use isostep_motion::{AXES, Alarm, Finish, Overrides, State};
use isostep_profile::SpeedLaw;
use isostep_sim::{Config, MoveRecord, Outcome, Port, Sim, verify};
use isostep_tests::limits::{self, Shares};
use oorandom::Rand64;

const HOLDS: u64 = 500;

/// A machine that need not be homed, under a law, and its random numbers.
struct Bench {
    sim: Sim,
    random: Rand64,
    /// Lines sent, without those that a reset has forgotten, and answers heard: none is refused.
    lines: usize,
    answers: usize,
    /// From when on, ns since power-up, which were in force.
    overrides: Vec<(u64, Overrides)>,
}

impl Bench {
    fn new(case: u64) -> Self {
        let port = if case.is_multiple_of(2) { Port::Pio } else { Port::Timer };
        let sim = Sim::new(&Config { port, ..Config::default() });
        let (random, overrides) = (Rand64::new(case.into()), vec![(0, Overrides::NONE)]);
        let mut bench = Self { sim, random, lines: 0, answers: 0, overrides };
        let law = bench.random.rand_range(0..SpeedLaw::ALL.len() as u64);
        let thirds = bench.random.rand_range(0..2);
        bench.say(&format!("$910=60\n$911=60\n$912=60\n$900={thirds}\n$940={law}\n$X\n"));
        // Y accelerates less; some brake otherwise than they accelerate.
        let decel = [0, 35, 80][(case % 3) as usize];
        bench.say(&format!("$121=40\n$920={decel}\n$921={decel}\n$922={decel}\n"));
        bench.sim.run_for(Duration::from_millis(100)).unwrap();
        bench.outcome();
        bench
    }

    fn say(&mut self, text: &str) {
        self.lines += text.matches('\n').count();
        self.sim.send(text.as_bytes());
    }

    fn reset(&mut self) {
        self.hear();
        self.lines = self.answers;
        self.sim.send(&[0x18]);
    }

    /// Whether the welcome was among what it has said.
    fn hear(&mut self) -> bool {
        let heard = self.sim.replies();
        let is_welcome = |line: &&String| line.starts_with("Grbl 1.1h");
        assert!(heard.iter().all(|line| line == "ok" || is_welcome(&line)), "{heard:?}");
        let welcomes = heard.iter().filter(is_welcome).count();
        self.answers += heard.len() - welcomes;
        welcomes > 0
    }

    /// All that was seen so far, when every line has been answered.
    fn outcome(&mut self) -> Outcome {
        self.hear();
        assert_eq!(self.answers, self.lines, "answers to the lines sent");
        self.sim.outcome()
    }

    fn override_by(&mut self, bytes: &[u8]) {
        let at_ns = self.sim.now_ns();
        self.sim.send(bytes);
        self.sim.run_for(Duration::from_ticks(1)).unwrap();
        self.overrides.push((at_ns, self.sim.machine().overrides()));
    }

    /// The highest overrides in force at any time between two instants, ns since power-up.
    fn highest_overrides(&self, from_ns: u64, until_ns: u64) -> Overrides {
        let begun = self.overrides.partition_point(|(at_ns, _)| *at_ns <= until_ns);
        let over = self.overrides[..begun].partition_point(|(at_ns, _)| *at_ns <= from_ns) - 1;
        let highest = |of: fn(&Overrides) -> u8| self.overrides[over..begun].iter().map(|(_, each)| of(each)).max();
        Overrides {
            feed_percent: highest(|each| each.feed_percent).unwrap_or(100),
            rapid_percent: highest(|each| each.rapid_percent).unwrap_or(100),
        }
    }

    /// The speed that an axis keeps to in a run, `t_s` from its start, steps/s. Its move has this feed, mm/min, or is a
    /// rapid. A lower override is no limit until it has come about: the highest since the run was planned is.
    fn speed_limit(&self, record: &MoveRecord, axis: usize, feed_mm_min: Option<f64>, t_s: f64) -> f64 {
        let config = self.sim.machine().config();
        let planned_ns = record.start_ns - 1_000_000;
        let Overrides { feed_percent, rapid_percent } =
            self.highest_overrides(planned_ns, record.start_ns + (t_s * 1e9) as u64);
        let top = config.limits[axis].top_speed_steps_s;
        let Some(feed) = feed_mm_min else { return top * f64::from(rapid_percent) / 100.0 };
        let mm = |axis: usize| f64::from(record.plan.steps[axis]) / config.steps_per_mm[axis];
        let path_mm = (0..AXES).map(|axis| mm(axis) * mm(axis)).sum::<f64>().sqrt();
        let of_axis = f64::from(record.plan.steps[axis].unsigned_abs()) / path_mm;
        top.min(feed / 60.0 * f64::from(feed_percent) / 100.0 * of_axis)
    }

    /// How near each axis came to its limits, by its edges.
    fn shares(&self, outcome: &Outcome, feed_mm_min: impl Fn(&MoveRecord) -> Option<f64>) -> Shares {
        let config = self.sim.machine().config();
        let off_s = outcome.config.port.tolerance_ns() * 1e-9;
        let mut highest = Shares::default();
        for record in &outcome.moves {
            let times_s = verify::axis_times_s(record, &outcome.edges[record.edges.clone()]);
            for (axis, times_s) in times_s.iter().enumerate() {
                let speed_at = |t_s: f64| self.speed_limit(record, axis, feed_mm_min(record), t_s);
                let own = &config.limits[axis];
                highest = highest.max(limits::shares(times_s, off_s, own, config.speed_law, speed_at));
            }
        }
        highest
    }

    /// A random place, mm.
    fn place(&mut self) -> [f64; 3] {
        [60.0, 60.0, 30.0].map(|most| (self.random.rand_float() * most * 50.0).round() / 50.0)
    }

    fn wait(&mut self, longest_s: f64) {
        let wait_us = (self.random.rand_float() * longest_s * 1e6) as u64;
        self.sim.run_for(Duration::from_micros(wait_us)).unwrap();
    }

    fn at_rest(&mut self) {
        self.sim
            .run_until_state(|state| !matches!(state, State::Hold { still: false } | State::Run | State::Jog))
            .unwrap();
    }

    fn steps(&self) -> [i32; 3] {
        self.sim.machine().position_steps()
    }
}

fn steps_of(place_mm: [f64; 3]) -> [i32; 3] {
    place_mm.map(|mm| (mm * 50.0).round() as i32)
}

/// Every move's edges are where the closed form has them, counts exact, paths straight.
fn check(outcome: &Outcome, case: u64) {
    for check in verify::moves(outcome) {
        let record = &outcome.moves[check.index];
        assert!(check.exact, "case {case}: {:?} in {record:?}", check.emitted_steps);
        let off_ns = check.error_max_ns.into_iter().flatten().fold(0.0, f64::max);
        assert!(off_ns <= outcome.config.port.tolerance_ns(), "case {case}: {off_ns} ns off in {record:?}");
        assert!(check.is_straight(), "case {case}: {:?} of half a step apart in {record:?}", check.path_deviation);
    }
    assert!(outcome.violations.is_empty(), "case {case}: {:?}", outcome.violations);
    assert_eq!(outcome.alarm_code, None, "case {case}");
}

/// The highest of many cases, which come near to every limit that there is.
#[derive(Default)]
struct Highest(Shares);

impl Highest {
    fn add(&mut self, shares: Shares, case: u64) {
        assert!(shares.are_within(), "case {case}: {shares:?}");
        self.0 = self.0.max(shares);
    }

    fn tell(&self) {
        let Shares { speed, ends, accel, decel, jerk } = self.0;
        println!("at most, as shares of the limits, by the edges: {:?}", self.0);
        assert!([speed, accel, decel, jerk].into_iter().all(|share| share > 0.98) && ends > 0.5, "{:?}", self.0);
    }
}

#[test]
fn holds_at_any_instant_lose_nothing() {
    let (mut held, mut highest) = (0, Highest::default());
    for case in 0..HOLDS {
        let mut bench = Bench::new(case);
        let place = bench.place();
        let [x, y, z] = place;
        let feed = (100.0 + bench.random.rand_float() * 4_000.0).round();
        bench.say(&format!("G90\nG1 X{x} Y{y} Z{z} F{feed}\nG0 X0 Y0 Z0\n"));
        for _ in 0..bench.random.rand_range(1..4) {
            bench.wait(2.5);
            // Slower, or faster, and held before that has come about.
            let byte = [0x90, 0x91, 0x92, 0x92][bench.random.rand_range(0..4) as usize];
            bench.override_by(&[byte; 3]);
            bench.wait(0.3);
            bench.say("!");
            bench.at_rest();
            let still = bench.steps();
            bench.wait(0.5);
            assert_eq!(bench.steps(), still, "case {case}: it moved while held");
            bench.say("~");
        }
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        assert_eq!(
            outcome.counted_steps,
            [0; 3],
            "case {case}: {:?} at {:?}",
            bench.sim.machine().status(),
            bench.sim.now()
        );
        check(&outcome, case);
        let is_feed = |record: &MoveRecord| record.plan.steps == steps_of(place);
        highest.add(bench.shares(&outcome, |record| is_feed(record).then_some(feed)), case);
        held += outcome.moves.iter().filter(|record| record.finish == Finish::Held).count();
    }
    println!("{HOLDS} random programs were held in mid-move {held} times");
    highest.tell();
    assert!(held as u64 > HOLDS / 2, "only {held} holds fell into a move");
}

#[test]
fn overrides_at_any_instant_lose_nothing() {
    let (mut changed, mut highest) = (0, Highest::default());
    for case in 0..HOLDS {
        let mut bench = Bench::new(case);
        let place = bench.place();
        let [x, y, z] = place;
        let feed = (100.0 + bench.random.rand_float() * 2_000.0).round();
        let feed = (bench.random.rand_range(0..3) > 0).then_some(feed);
        let motion = feed.map_or("G0".to_owned(), |feed| format!("G1 F{feed}"));
        bench.say(&format!("G90\n{motion} X{x} Y{y} Z{z}\n"));
        for _ in 0..bench.random.rand_range(1..5) {
            bench.wait(1.5);
            let bytes = [0x90, 0x91, 0x92, 0x91, 0x92, 0x91, 0x95, 0x96, 0x97];
            let byte = bytes[bench.random.rand_range(0..bytes.len() as u64) as usize];
            bench.override_by(&[byte; 5]);
        }
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        assert_eq!(outcome.counted_steps, steps_of(place), "case {case}");
        check(&outcome, case);
        highest.add(bench.shares(&outcome, |_| feed), case);
        changed += outcome.moves.iter().filter(|record| !record.parts.is_empty()).count();
    }
    println!("of {HOLDS} random moves {changed} went on at another speed");
    highest.tell();
    assert!(changed as u64 > HOLDS / 4, "only {changed} moves went on at another speed");
}

/// Faster than one of them comes about; then the move is held while the last does.
#[test]
fn overrides_in_quick_succession_lose_nothing() {
    let mut highest = Highest::default();
    for case in 0..HOLDS / 5 {
        let mut bench = Bench::new(case);
        // So fast that a full queue is a few milliseconds of motion.
        bench.say(&[0, 1, 2].map(|axis| format!("$12{axis}=4000\n$93{axis}=80000\n")).concat());
        bench.sim.run_for(Duration::from_millis(100)).unwrap();
        let place = bench.place();
        let [x, y, z] = place;
        bench.say(&format!("G90\nG1 F1500 X{x} Y{y} Z{z}\n"));
        bench.wait(0.2);
        for _ in 0..30 {
            let byte = [0x91, 0x92, 0x93, 0x94][bench.random.rand_range(0..4) as usize];
            bench.override_by(&[byte]);
            bench.wait(0.005);
        }
        bench.say("!");
        bench.at_rest();
        bench.say("~");
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        assert_eq!(outcome.counted_steps, steps_of(place), "case {case}");
        check(&outcome, case);
        highest.add(bench.shares(&outcome, |_| Some(1_500.0)), case);
    }
    highest.tell();
}

#[test]
fn jogs_are_cancelled_at_any_instant() {
    let mut highest = Highest::default();
    for case in 0..HOLDS / 5 {
        let mut bench = Bench::new(case);
        let [x, y, z] = bench.place();
        bench.say(&format!("$J=G90 X{x} Y{y} Z{z} F1500\n$J=G91 X5 F1500\n"));
        bench.wait(2.0);
        bench.sim.send(&[0x85]);
        bench.at_rest();
        let still = bench.steps();
        bench.wait(0.5);
        assert_eq!((bench.steps(), bench.sim.machine().state()), (still, State::Idle), "case {case}");
        // What follows counts from where it stands.
        bench.say("G91\nG0 X1\n");
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        assert_eq!(outcome.counted_steps, [still[0] + 50, still[1], still[2]], "case {case}");
        check(&outcome, case);
        let is_rapid = |record: &MoveRecord| record.plan.steps == [50, 0, 0];
        highest.add(bench.shares(&outcome, |record| (!is_rapid(record)).then_some(1_500.0)), case);
    }
    highest.tell();
}

/// In the middle of moves, dwells and jogs, sometimes while they are held or about to be: no alarm, and the welcome once it
/// stands still.
#[test]
fn resets_at_any_instant_keep_the_position() {
    let (mut braked, mut highest) = (0, Highest::default());
    for case in 0..HOLDS / 2 {
        let mut bench = Bench::new(case);
        let place = bench.place();
        let [x, y, z] = place;
        let feed = (100.0 + bench.random.rand_float() * 4_000.0).round();
        match bench.random.rand_range(0..3) {
            0 => bench.say(&format!("$J=G90 X{x} Y{y} Z{z} F{feed}\n$J=G91 X-5 F{feed}\n")),
            _ => bench.say(&format!("G90\nG1 X{x} Y{y} Z{z} F{feed}\nG4 P0.2\nG0 X0 Y0 Z0\n")),
        }
        bench.wait(3.0);
        let byte = ["", "!", "!~", "\u{85}"][bench.random.rand_range(0..4) as usize];
        bench.sim.send(&byte.chars().map(|byte| byte as u8).collect::<Vec<_>>());
        bench.wait(0.1);
        let was = bench.sim.machine().state();
        bench.reset();
        bench.sim.run_for(Duration::from_micros(1)).unwrap();
        let brakes = bench.sim.machine().state() == State::Hold { still: false };
        assert!(brakes || was == State::Idle || bench.sim.machine().state() == State::Idle, "case {case}");
        bench.at_rest();
        let still = bench.steps();
        bench.wait(0.5);
        assert_eq!((bench.steps(), bench.sim.machine().state()), (still, State::Idle), "case {case}");
        assert!(bench.hear(), "case {case}: no welcome");
        // What follows counts from where it stands.
        bench.say("G91\nG0 X1\n");
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        assert_eq!(outcome.counted_steps, [still[0] + 50, still[1], still[2]], "case {case}");
        check(&outcome, case);
        let is_feed = |record: &MoveRecord| [steps_of(place), [-250, 0, 0]].contains(&record.plan.steps);
        highest.add(bench.shares(&outcome, |record| is_feed(record).then_some(feed)), case);
        braked += u64::from(outcome.moves.iter().any(|record| record.finish == Finish::Held));
    }
    println!("of {} resets {braked} had a move brake", HOLDS / 2);
    highest.tell();
    assert!(braked > HOLDS / 8, "only {braked} resets fell into a move");
}

#[test]
fn a_second_reset_stops_what_brakes_at_once() {
    for case in 0..HOLDS / 5 {
        let mut bench = Bench::new(case);
        bench.say("G90\nG1 X60 Y37 Z12 F3000\n");
        bench.sim.run_for(Duration::from_millis(500)).unwrap();
        bench.reset();
        bench.wait(0.3);
        let braking = bench.sim.machine().state() == State::Hold { still: false };
        bench.reset();
        bench.sim.run_for(Duration::from_micros(10)).unwrap();
        let stopped = bench.steps();
        bench.wait(0.5);
        let wanted = if braking { State::Alarm(Alarm::ResetInMotion) } else { State::Idle };
        assert_eq!((bench.steps(), bench.sim.machine().state()), (stopped, wanted), "case {case}");
        assert_eq!(bench.sim.outcome().counted_steps, stopped, "case {case}");
    }
}

#[test]
fn a_reset_of_a_held_machine_keeps_its_position() {
    let mut bench = Bench::new(0);
    bench.say("G90\nG1 X40 F1500\nG1 X0\n");
    bench.sim.run_for(Duration::from_millis(700)).unwrap();
    bench.say("!");
    bench.at_rest();
    let still = bench.steps();
    assert!(still[0] > 0 && bench.sim.machine().state() == State::Hold { still: true });
    bench.reset();
    bench.sim.run_for(Duration::from_millis(500)).unwrap();
    assert_eq!(
        (bench.steps(), bench.sim.machine().state()),
        (still, State::Idle),
        "it is ready, and forgot what was held"
    );
}

#[test]
fn a_hold_takes_effect_within_100_ms() {
    let mut bench = Bench::new(0);
    bench.say("$940=0\n$900=0\n");
    bench.sim.run_for(Duration::from_millis(20)).unwrap();
    bench.say("G90\nG1 X60 Y1 F2400\n");
    bench.sim.run_for(Duration::from_millis(1_400)).unwrap();
    let before = bench.steps();
    bench.say("!");
    bench.at_rest();
    // From 40 mm/s at 50 mm/s² it brakes over 16 mm; the start speed makes that a little less.
    let braking_steps = (40.0 * 40.0 - 1.0) / (2.0 * 50.0) * 50.0;
    let went_on_s = (f64::from(bench.steps()[0] - before[0]) - braking_steps) / 50.0 / 40.0;
    println!("a hold took effect {:.1} ms after its byte", went_on_s * 1e3);
    assert!((0.0..0.1).contains(&went_on_s), "{went_on_s} s");
}
