//! Random programs on random machines, interfered with at random instants, in virtual time with both step ports. The lines
//! have reversals and single steps, ends between two steps, arcs, rapids and feeds, and come in any number of bursts. Every
//! edge must match the closed form, counts must be exact, moves straight, and each axis within its limits, corners included,
//! and within the speed that was asked for, as the edges alone say. A failure prints the command that repeats it.

use embassy_time::Duration;
use isostep_motion::{AXES, Alarm, Axis, Finish, State};
use isostep_sim::measure::{across, limits};
use isostep_sim::{MoveRecord, Outcome, SwitchFault};
use isostep_tests::bench::{Bench, Highest, Kind, Moves, all_cases, check};
use isostep_trials::cases_that_count;

/// Number of interferences of each kind.
fn instants() -> u64 {
    cases_that_count(200, 4_000).into()
}
const PER_CASE: u64 = 10;
/// By what fraction the edges may show more than a limit that is kept.
const GRAIN: f64 = 0.02;

/// The kinds of machines and of their programs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum World {
    /// Any speed profile, and long moves alone.
    Alone,
    /// Any speed profile; the path goes to its corners, but for a few that are blends.
    Exact,
    /// A trapezoid without a start speed, so that all corners are blends. Where a block of G61.1 begins it stops (`$11`).
    Blended,
    /// A trapezoid with shapers on two axes, with blends or without.
    Shaped,
}

/// The machines of the cases, by turns, each with both ports.
const WORLDS: [World; 5] = [World::Alone, World::Blended, World::Exact, World::Shaped, World::Blended];

/// A machine and what it was asked for.
struct Asked {
    bench: Bench,
    world: World,
    /// The moves asked for since the machine last forgot what it had not made, and how many had been made before.
    moves: Moves,
    first: usize,
}

impl Asked {
    fn new(case: u64) -> Self {
        let world = WORLDS[(case / 2) as usize % WORLDS.len()];
        let mut bench = Bench::new(case);
        let times: &[_] = match world {
            World::Alone => &[1, 4, 20, 80],
            World::Shaped => &[1, 4, 20, 40, 80],
            World::Exact | World::Blended => &[1, 4, 20],
        };
        let times = bench.one_of(times);
        let mut lines =
            [50, 40, 50].map(|accel| accel * times).iter().enumerate().fold(String::new(), |lines, (axis, accel)| {
                lines + &format!("$12{axis}={accel}\n$93{axis}={}\n", 500 * times)
            });
        lines += &match world {
            World::Alone => String::new(),
            World::Exact => {
                let (deviation_mm, blend_mm) = (bench.one_of(&[0.0, 0.01, 0.05, 0.2]), bench.one_of(&[0.0, 0.03]));
                // Most cases run as fast as possible.
                let thirds = bench.one_of(&[0, 0, 0, 0, 1]);
                format!("$11={deviation_mm}\n$900={thirds}\n$904={blend_mm}\n")
            }
            World::Blended => {
                let blend_mm = bench.one_of(&[0.01, 0.05, 0.3, 1.0]);
                format!("$11=0\n$900=0\n$940=0\n$910=0\n$911=0\n$912=0\n$904={blend_mm}\n")
            }
            World::Shaped => {
                let (start, hz) = (bench.one_of(&[0, 60]), bench.one_of(&[15, 40]));
                let kinds = [1 + case % 5, case / 2 % 6];
                let blend_mm = bench.one_of(&[0.0, 0.01, 0.05, 0.3]);
                format!(
                    "$940=0\n$900=0\n$910={start}\n$911={start}\n$912={start}\n$904={blend_mm}\n$960={hz}\n$961=35\n$950={}\n$951={}\n",
                    kinds[0], kinds[1]
                )
            }
        };
        bench.stream(&lines);
        bench.settle_settings();
        Self { bench, world, moves: Moves::default(), first: 0 }
    }

    /// The lines of so many more moves; of one or two where each is long.
    fn lines(&mut self, count: u64, kind: Kind) -> String {
        match self.world {
            World::Alone => self.moves.far(count.min(2), kind, &mut self.bench.random),
            _ => self.moves.more(count, kind, &mut self.bench.random),
        }
    }

    fn ask(&mut self, count: u64, kind: Kind) {
        let lines = self.lines(count, kind);
        self.bench.stream(&lines);
    }

    /// Lets a random time pass, longer where moves are long.
    fn wait(&mut self, longest_s: f64) {
        self.bench.wait(if self.world == World::Alone { 2.5 } else { longest_s });
    }
}

/// The findings of all cases.
#[derive(Default)]
struct Seen {
    highest: Highest,
    accel_ratio: f64,
    blends: u64,
    held: u64,
    stopped: u64,
    replanned: u64,
}

impl Seen {
    /// Judges the moves since the machine last forgot: they must be those that were asked for, in order, stop where they
    /// should, and be no faster than was asked.
    fn judge_moves(&mut self, asked: &Asked, outcome: &Outcome, case: u64) {
        let records = &outcome.moves[asked.first..];
        let found: Vec<_> = asked.moves.of(records).into_iter().map(|index| asked.moves.asked[index]).collect();
        let feeds: Vec<_> = found.iter().map(|asked| asked.feed_mm_min).collect();
        for (pair, asked) in records.windows(2).zip(&found) {
            if asked.stops && pair[0].end_steps == asked.end_steps && pair[0].run == pair[1].run {
                let config = outcome.config_of(&pair[0]);
                let [_, exit_mm_s] = limits::speeds_mm_s(&pair[0], config);
                assert!(limits::are_rests(&pair[0], config)[1], "case {case}: {exit_mm_s} mm/s at an exact stop");
            }
        }
        let mut since = outcome.clone();
        since.moves = records.to_vec();
        keeps_speeds(&asked.bench, &since, &feeds, case);
        let at = |record: &MoveRecord| records.iter().position(|each| each == record).expect("one of them");
        self.highest.add(asked.bench.ratios(&since, |record| feeds[at(record)]), case);
    }

    /// Judges all that a machine has made.
    fn judge(&mut self, asked: &Asked, outcome: &Outcome, case: u64) {
        check(outcome, case);
        if asked.world == World::Blended {
            let most = across::highest(outcome).expect("moves");
            assert!(most.ratio < 1.0 + GRAIN, "case {case}: {most:?}");
            self.accel_ratio = self.accel_ratio.max(most.ratio);
        }
        let count = |of: fn(&MoveRecord) -> bool| outcome.moves.iter().filter(|record| of(record)).count() as u64;
        self.blends += count(|record| record.blend.is_some());
        self.held += count(|record| record.finish == Finish::Held);
        self.stopped += count(|record| record.finish == Finish::Stopped);
        self.replanned += count(|record| !record.parts.is_empty());
    }

    fn print(&self, test: &str) {
        let Self { accel_ratio, blends, held, stopped, replanned, .. } = self;
        println!(
            "{test}, {} of them: {blends} blends, {held} moves held, {stopped} stopped, {replanned} went on otherwise; \
             accelerations {accel_ratio:.4} at most",
            instants()
        );
        self.highest.print();
        assert!(*accel_ratio > 0.98, "{accel_ratio}");
    }

    /// Checks that so many interferences fell into a move, and that there were so many blends.
    fn is_enough(&self, fell: u64, least: u64, blends_least: u64) {
        assert!(fell > least && self.blends >= blends_least, "{fell} fell into a move, {} blends", self.blends);
    }
}

/// Where a blend begins and ends, no axis is faster than its line may be there.
fn keeps_speeds(bench: &Bench, outcome: &Outcome, feeds: &[Option<f64>], case: u64) {
    for (index, pair) in outcome.moves.windows(2).enumerate() {
        let Some(blend) = pair[1].blend else { continue };
        for (of, t_s) in [(0, blend.begin_s()), (1, blend.end_s())] {
            let (record, feed) = (&pair[of], feeds[index + of]);
            for axis in 0..AXES {
                let most = bench.speed_most_steps_s(outcome, record, axis, feed, t_s - record.begin_s());
                let speed = blend.speed_at(axis, t_s).abs();
                assert!(speed <= most * (1.0 + 1e-6) + 1e-6, "case {case}: axis {axis} at {speed} of {most} steps/s");
            }
        }
    }
}

/// Interferes with random worlds. If the machine goes on, it comes to where the last move ends. If it `forgets` what it has not
/// made, what follows begins where it stands. Returns what was seen, unless one case alone was tried.
fn at_any_instant(test: &str, forgets: bool, interfere: fn(&mut Asked, u64)) -> Option<Seen> {
    let mut seen = Seen::default();
    let are_all = all_cases("chains", test, instants() / PER_CASE, |case| {
        let mut asked = Asked::new(case);
        for round in 0..PER_CASE {
            interfere(&mut asked, round);
            if forgets {
                let outcome = asked.bench.outcome();
                seen.judge_moves(&asked, &outcome, case);
                (asked.moves, asked.first) = (Moves::from(asked.bench.steps()), outcome.moves.len());
            }
        }
        if forgets {
            asked.bench.say("G90 G0 X0 Y0 Z0\n");
        }
        asked.bench.sim.run_until_idle().unwrap();
        let outcome = asked.bench.outcome();
        let end_steps = if forgets { [0; AXES] } else { asked.moves.end_steps() };
        assert_eq!(outcome.counted_steps, end_steps, "case {case}: where it ends, in {:?}", asked.bench.state());
        if !forgets {
            seen.judge_moves(&asked, &outcome, case);
        }
        seen.judge(&asked, &outcome, case);
    });
    are_all.then(|| {
        seen.print(test);
        seen
    })
}

#[test]
fn holds_at_any_instant_lose_nothing() {
    let seen = at_any_instant("holds_at_any_instant_lose_nothing", false, |asked, _| {
        let count = asked.bench.random.rand_range(1..10);
        asked.ask(count, Kind::Program);
        asked.wait(0.6);
        // An override makes the moves slower or faster, and the hold comes before the override has taken effect.
        if asked.bench.one_of(&[true, false]) {
            let byte = asked.bench.one_of(&[0x90, 0x91, 0x92, 0x92]);
            asked.bench.override_by(&[byte; 5]);
            let longest_s = asked.bench.one_of(&[0.05, 0.3]);
            asked.bench.wait(longest_s);
        }
        // The hold, or the door's byte; and a line that comes before it has taken effect.
        let byte = asked.bench.one_of(&[b'!', b'!', b'!', 0x84]);
        let line = if asked.bench.one_of(&[true, false]) { asked.lines(1, Kind::Program) } else { String::new() };
        asked.bench.hold(byte, &line, 0.5);
        if asked.bench.one_of(&[true, false]) {
            asked.bench.wait(0.2);
            asked.bench.hold(b'!', "", 0.1);
        }
    });
    seen.into_iter().for_each(|seen| seen.is_enough(seen.held, instants(), instants()));
}

#[test]
fn overrides_at_any_instant_lose_nothing() {
    let seen = at_any_instant("overrides_at_any_instant_lose_nothing", false, |asked, round| {
        let count = asked.bench.random.rand_range(1..8);
        asked.ask(count, Kind::Program);
        asked.wait(0.4);
        let feed = asked.bench.one_of(&[0x90, 0x91, 0x92, 0x91, 0x92]);
        let rapid = asked.bench.one_of(&[0x95, 0x96, 0x97]);
        match asked.bench.random.rand_range(0..3) {
            // Faster than they take effect. Then the moves are held while the last one does.
            _ if round == 0 => {
                for _ in 0..30 {
                    let byte = asked.bench.one_of(&[0x91, 0x92, 0x93, 0x94]);
                    asked.bench.override_by(&[byte]);
                    asked.bench.wait(0.005);
                }
                asked.bench.hold(b'!', "", 0.0);
            }
            0 => asked.bench.override_by(&[feed; 5]),
            1 => asked.bench.override_by(&[rapid]),
            // Both at once.
            _ => asked.bench.override_by(&[feed, feed, feed, rapid, feed]),
        }
    });
    seen.into_iter().for_each(|seen| seen.is_enough(seen.replanned, instants() / 5, instants()));
}

#[test]
fn jogs_are_cancelled_at_any_instant() {
    let seen = at_any_instant("jogs_are_cancelled_at_any_instant", true, |asked, _| {
        asked.ask(10, Kind::Jog);
        asked.wait(1.0);
        asked.bench.sim.send(&[0x85]);
        asked.bench.at_rest();
        asked.bench.stays(0.3);
        assert_eq!(asked.bench.state(), State::Idle);
    });
    seen.into_iter().for_each(|seen| seen.is_enough(seen.held, instants() / 3, 0));
}

/// Resets in the middle of moves, dwells and jogs, some of them during or just before a hold. There must be no alarm,
/// and the welcome must come once the machine stands still.
#[test]
fn resets_at_any_instant_keep_the_position() {
    let seen = at_any_instant("resets_at_any_instant_keep_the_position", true, |asked, _| {
        let kind = asked.bench.one_of(&[Kind::Program, Kind::Program, Kind::Jog]);
        asked.ask(5, kind);
        if kind == Kind::Program && asked.bench.one_of(&[true, false]) {
            asked.bench.stream("G4 P0.2\n");
        }
        asked.ask(5, kind);
        asked.wait(1.0);
        let before: &[u8] = asked.bench.one_of(&[b"", b"!", b"!~", b"\x85"]);
        asked.bench.sim.send(before);
        asked.bench.wait(0.1);
        let was = asked.bench.state();
        asked.bench.reset();
        asked.bench.sim.run_for(Duration::from_micros(1)).unwrap();
        let brakes = asked.bench.state() == State::Hold { still: false };
        assert!(
            brakes || was == State::Idle || asked.bench.state() == State::Idle,
            "{was:?}, then {:?}",
            asked.bench.state()
        );
        asked.bench.at_rest();
        asked.bench.stays(0.5);
        asked.bench.sim.run_until_idle().unwrap();
        assert!(asked.bench.hear(), "no welcome");
        assert_eq!(asked.bench.state(), State::Idle);
    });
    seen.into_iter().for_each(|seen| seen.is_enough(seen.held, instants() / 3, instants()));
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stop {
    Limit(Axis),
    Emergency,
    /// Two resets at once.
    Resets,
    /// A reset, and another while it brakes.
    SecondReset,
}

#[test]
fn stops_at_any_instant_leave_the_exact_count() {
    let seen = at_any_instant("stops_at_any_instant_leave_the_exact_count", true, |asked, round| {
        asked.ask(10, Kind::Program);
        asked.wait(1.0);
        let bench = &mut asked.bench;
        let axis = bench.one_of(&Axis::ALL);
        let stop = [Stop::Limit(axis), Stop::Emergency, Stop::Resets, Stop::SecondReset][(round % 4) as usize];
        if stop == Stop::SecondReset {
            bench.reset();
            bench.wait(0.3);
        }
        let was = bench.state();
        match stop {
            Stop::Limit(axis) => bench.sim.set_switch(axis, SwitchFault::StuckClosed),
            Stop::Emergency => bench.sim.set_emergency_stop(true),
            Stop::Resets => bench.sim.send(b"\x18\x18"),
            Stop::SecondReset => bench.sim.send(b"\x18"),
        }
        bench.sim.run_for(Duration::from_micros(20)).unwrap();
        bench.stays(0.1);
        let expected = match (stop, was) {
            (Stop::Emergency, _) => State::Alarm(Alarm::EmergencyStop),
            (_, State::Idle) => State::Idle,
            (Stop::Limit(axis), _) => State::Alarm(Alarm::HardLimit { motor: axis.into() }),
            (Stop::Resets | Stop::SecondReset, _) => State::Alarm(Alarm::ResetInMotion),
        };
        assert_eq!(bench.state(), expected, "{stop:?} in {was:?}");
        match stop {
            Stop::Limit(axis) => bench.sim.set_switch(axis, SwitchFault::None),
            Stop::Emergency => bench.sim.set_emergency_stop(false),
            Stop::Resets | Stop::SecondReset => {}
        }
        bench.sim.run_for(Duration::from_millis(50)).unwrap();
        bench.sim.send(b"$X\n");
        bench.sim.run_until_idle().unwrap();
        bench.forget_answers();
        assert_eq!(bench.state(), State::Idle, "after {stop:?}");
        let outcome = bench.sim.outcome();
        assert_eq!(outcome.counted_steps, outcome.position_steps, "after {stop:?}");
    });
    seen.into_iter().for_each(|seen| seen.is_enough(seen.stopped, instants() / 3, instants()));
}

#[test]
fn a_reset_of_a_held_machine_keeps_its_position() {
    let mut bench = Bench::new(0);
    bench.say("G90\nG1 X40 F1500\nG1 X0\n");
    bench.sim.run_for(Duration::from_millis(700)).unwrap();
    bench.say("!");
    bench.at_rest();
    let still = bench.steps();
    assert!(still[0] > 0 && bench.state() == State::Hold { still: true });
    bench.reset();
    bench.sim.run_for(Duration::from_millis(500)).unwrap();
    assert_eq!((bench.steps(), bench.state()), (still, State::Idle), "it is ready, and forgot what was held");
}

#[test]
fn a_hold_takes_effect_within_60_ms() {
    let mut bench = Bench::new(0);
    bench.say("$940=0\n$900=0\n");
    bench.sim.run_for(Duration::from_millis(20)).unwrap();
    bench.say("G90\nG1 X60 Y1 F2400\n");
    bench.sim.run_for(Duration::from_millis(1_400)).unwrap();
    let before = bench.steps();
    bench.say("!");
    bench.at_rest();
    // From 40 mm/s at 50 mm/s² the machine brakes over 16 mm, and over a little less because of the start speed.
    let braking_steps = (40.0 * 40.0 - 1.0) / (2.0 * 50.0) * 50.0;
    let went_on_s = (f64::from(bench.steps()[0] - before[0]) - braking_steps) / 50.0 / 40.0;
    println!("a hold took effect {:.1} ms after its byte", went_on_s * 1e3);
    assert!((0.0..0.06).contains(&went_on_s), "{went_on_s} s");
}

/// The host stops sending in the middle of a line. The machine must brake to rest at the end of the known moves and
/// continue when more lines come; if they come in time, it must not stop.
#[test]
fn a_host_that_stops_for_a_while_stops_the_machine_where_its_lines_end() {
    const SPEED_MM_S: f64 = 20.0;
    let (mut rested, mut flowed) = (0, 0);
    let name = "a_host_that_stops_for_a_while_stops_the_machine_where_its_lines_end";
    let are_all = all_cases("chains", name, 60, |case| {
        let mut bench = Bench::new(case);
        bench.say("$11=0.05\n$904=0\n$120=50\n$920=0\n$930=500\n$900=0\n");
        bench.settle_settings();
        let accel_mm_s2 = 50.0;
        let lines = |from: i32| (from + 1..=from + 20).map(|mm| format!("G90 G1 X{mm} F1200\n")).collect::<String>();
        bench.stream(&lines(0));
        // The first 20 mm take some 3 s with the slowest speed profile.
        bench.wait(4.0);
        let came_ns = bench.sim.now_ns();
        bench.stream(&lines(20));
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        check(&outcome, case);
        assert_eq!((outcome.counted_steps, outcome.moves.len()), ([2_000, 0, 0], 40), "case {case}");
        let ratios = bench.ratios(&outcome, |_| Some(60.0 * SPEED_MM_S));
        assert!(ratios.are_within(), "case {case}: {ratios:?}");
        let is_rest = |index: usize| {
            let record = &outcome.moves[index];
            limits::are_rests(record, outcome.config_of(record))[1]
        };
        let rests: Vec<_> = (0..40).filter(|index| is_rest(*index)).collect();
        let [before, after] = [&outcome.moves[19], &outcome.moves[20]];
        // The latest time at which braking can begin: for the trapezoid, which begins later than any other speed profile, plus
        // the time that is committed ahead.
        let braking_s = SPEED_MM_S / accel_mm_s2;
        if before.run == after.run {
            flowed += 1;
            assert!(rests == [39] || rests == [19, 39], "case {case}: {rests:?}");
        } else {
            rested += 1;
            assert_eq!(rests, [19, 39], "case {case}: it comes to rest at the end of what is known alone");
            let begun_ns = after.begin_ns() - before.end_ns.max(came_ns);
            assert!(begun_ns < 10_000_000, "case {case}: it begins {begun_ns} ns after the lines came");
        }
        if came_ns as f64 * 1e-9 < before.end_ns as f64 * 1e-9 - 2.0 * braking_s - 0.1 {
            assert_eq!(rests, [39], "case {case}: it had not begun to brake");
        }
    });
    if !are_all {
        return;
    }
    println!("{rested} times it rested, {flowed} times it flowed");
    assert!(rested > 5 && flowed > 20, "{rested}, {flowed}");
}

/// The time from the last edge before the end of each move to the next edge, s.
fn corner_gaps_s(lines: &str) -> Vec<f64> {
    let mut bench = Bench::new(0);
    bench.say("$900=0\n$910=0\n$911=0\n$912=0\n$940=0\n$121=50\n$920=0\n$921=0\n$922=0\n");
    bench.settle_settings();
    bench.stream(lines);
    bench.sim.run_until_idle().unwrap();
    let outcome = bench.outcome();
    check(&outcome, 0);
    let gap_s = |pair: &[MoveRecord]| {
        let (last, next) = (&outcome.edges[pair[0].edges.end - 1], &outcome.edges[pair[1].edges.start]);
        (next.t_ns - last.t_ns) as f64 * 1e-9
    };
    outcome.moves.windows(2).map(gap_s).collect()
}

/// From the edges: from rest at 2,500 steps/s² half a step takes 20 ms, and stopping takes as long.
#[test]
fn exact_stops_and_no_deviation_stop_at_corners() {
    const STOP_S: f64 = 0.04;
    let stops = |gap_s: &f64| *gap_s > STOP_S - 1e-6;
    // In order: a right angle, straight on, a corner of 45 degrees, and back.
    let path = |word: &str| format!("G91 {word} G1 F1200 X4\nY4\nY4\nX4 Y4\nX-4 Y-4\n");
    let flowing = corner_gaps_s(&path("G61"));
    assert!(!flowing[..3].iter().any(stops) && stops(&flowing[3]), "{flowing:?}");
    // The corner is taken on a circle that deviates by 0.01 mm, at 50 mm/s² across for each axis. That gives 1.307
    // mm/s, at steps of 0.02 mm.
    assert!((flowing[0] - 0.0137).abs() < 0.0005, "{flowing:?}");
    assert!(flowing[1] < 0.002, "straight on it is no slower than by the way to brake: {flowing:?}");
    let exact = corner_gaps_s(&path("G61.1"));
    assert!(exact.iter().all(stops), "{exact:?}");
    let without = corner_gaps_s(&format!("$11=0\n{}", path("G61")));
    let at_corners: Vec<_> = without.iter().map(stops).collect();
    assert_eq!(at_corners, [true, false, true, true], "straight on there is no corner: {without:?}");
    // Exact stops apply only to the moves from G61.1 to G61.
    let some = corner_gaps_s("G91 G1 F1200 X4\nG61.1 Y4\nG61 Y4\nY4\n");
    assert_eq!(some.iter().map(stops).collect::<Vec<_>>(), [false, true, false], "{some:?}");
}
