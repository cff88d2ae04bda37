//! Random chains of moves, interfered with at random instants, in virtual time with both step ports. The lines have
//! reversals and single steps, arcs, rapids and feeds, and come in any number of bursts. Every edge must match the
//! closed form, counts must be exact, moves straight, and each axis within its limits, corners included. A failure
//! prints the command that repeats it.

use embassy_time::Duration;
use isostep_motion::{Alarm, Axis, Finish, State};
use isostep_sim::measure::kept;
use isostep_sim::{MoveRecord, Outcome, SwitchFault};
use isostep_tests::bench::{Bench, Highest, Kind, Moves, all_cases, check};
use isostep_trials::cases;

/// Number of interferences of each kind.
fn instants() -> u64 {
    cases(200, 1_000).into()
}
const PER_CASE: u64 = 10;

/// The machine of a case, with any acceleration and any corner deviation.
fn bench(case: u64) -> Bench {
    let mut bench = Bench::new(case);
    let deviation_mm = bench.one_of(&[0.0, 0.01, 0.05, 0.2]);
    let times = bench.one_of(&[1, 4, 20]);
    let axes = [0, 1, 2].map(|axis| {
        let accel = if axis == 1 { 40 * times } else { 50 * times };
        format!("$12{axis}={accel}\n$93{axis}={}\n", 500 * times)
    });
    // Most cases run as fast as possible.
    let thirds = u32::from(case.is_multiple_of(10));
    // Half of them go round corners by blends.
    let blend_mm = if case.is_multiple_of(2) { 0.0 } else { 0.03 };
    bench.say(&format!("$11={deviation_mm}\n$900={thirds}\n$904={blend_mm}\n{}", axes.concat()));
    bench.settle_settings();
    bench
}

/// Checks everything seen since `first` moves had been made. They must be `moves` in order, and those that should stop
/// must stop.
fn check_chain(bench: &mut Bench, outcome: &Outcome, first: usize, moves: &Moves, highest: &mut Highest, case: u64) {
    let records = &outcome.moves[first..];
    let found = moves.of(records);
    for (pair, index) in records.windows(2).zip(&found) {
        if moves.asked[*index].stops && pair[0].end_steps == moves.asked[*index].end_steps && pair[0].run == pair[1].run
        {
            let config = outcome.config_of(&pair[0]);
            let [_, exit_mm_s] = kept::speeds_mm_s(&pair[0], config);
            assert!(kept::are_rests(&pair[0], config)[1], "case {case}: {exit_mm_s} mm/s at an exact stop");
        }
    }
    let mut since = outcome.clone();
    since.moves = records.to_vec();
    let at = |record: &MoveRecord| records.iter().position(|each| each == record).expect("one of them");
    highest.add(bench.ratios(&since, |record| moves.asked[found[at(record)]].feed_mm_min), case);
}

fn ends_at(outcome: &Outcome, moves: &Moves, case: u64) {
    assert_eq!(outcome.counted_steps, moves.end_steps(), "case {case}: where the chain ends");
}

#[test]
fn holds_at_any_instant_lose_nothing() {
    let (mut held, mut highest) = (0, Highest::default());
    let are_all = all_cases("chains", "holds_at_any_instant_lose_nothing", instants() / PER_CASE, |case| {
        let mut bench = bench(case);
        let mut moves = Moves::default();
        for _ in 0..PER_CASE {
            let count = bench.random.rand_range(1..10);
            let lines = moves.more(count, Kind::Program, &mut bench.random);
            bench.stream(&lines);
            bench.wait(0.6);
            bench.say("!");
            if bench.one_of(&[true, false]) {
                let line = moves.more(1, Kind::Program, &mut bench.random);
                bench.say(&line);
            }
            bench.at_rest();
            bench.stays(0.3);
            bench.say("~");
        }
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        check(&outcome, case);
        ends_at(&outcome, &moves, case);
        check_chain(&mut bench, &outcome, 0, &moves, &mut highest, case);
        held += outcome.moves.iter().filter(|record| record.finish == Finish::Held).count() as u64;
    });
    if !are_all {
        return;
    }
    println!("of {} holds {held} fell into moves", instants());
    highest.print();
    assert!(held > instants() / 2, "{held}");
}

#[test]
fn jogs_are_cancelled_at_any_instant() {
    let (mut held, mut highest) = (0, Highest::default());
    let are_all = all_cases("chains", "jogs_are_cancelled_at_any_instant", instants() / PER_CASE, |case| {
        let mut bench = bench(case);
        for _ in 0..PER_CASE {
            let first = bench.sim.outcome().moves.len();
            let mut moves = Moves::from(bench.steps());
            let lines = moves.more(10, Kind::Jog, &mut bench.random);
            bench.stream(&lines);
            bench.wait(1.0);
            bench.sim.send(&[0x85]);
            bench.at_rest();
            bench.stays(0.1);
            assert_eq!(bench.state(), State::Idle, "case {case}");
            let outcome = bench.outcome();
            held += outcome.moves[first..].iter().filter(|record| record.finish == Finish::Held).count() as u64;
            check_chain(&mut bench, &outcome, first, &moves, &mut highest, case);
        }
        check(&bench.outcome(), case);
    });
    if !are_all {
        return;
    }
    println!("of {} jog cancels {held} fell into moves", instants());
    highest.print();
    assert!(held > instants() / 3, "{held}");
}

#[test]
fn overrides_at_any_instant_lose_nothing() {
    let (mut changed, mut highest) = (0, Highest::default());
    let are_all = all_cases("chains", "overrides_at_any_instant_lose_nothing", instants() / PER_CASE, |case| {
        let mut bench = bench(case);
        let mut moves = Moves::default();
        for _ in 0..PER_CASE {
            let count = bench.random.rand_range(1..8);
            let lines = moves.more(count, Kind::Program, &mut bench.random);
            bench.stream(&lines);
            bench.wait(0.4);
            let byte = bench.one_of(&[0x90, 0x91, 0x92, 0x91, 0x92, 0x91, 0x95, 0x96, 0x97]);
            bench.override_by(&[byte; 5]);
        }
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        check(&outcome, case);
        ends_at(&outcome, &moves, case);
        check_chain(&mut bench, &outcome, 0, &moves, &mut highest, case);
        changed += outcome.moves.iter().filter(|record| !record.parts.is_empty()).count() as u64;
    });
    if !are_all {
        return;
    }
    println!("{changed} moves went on otherwise");
    highest.print();
    assert!(changed > instants() / 5, "{changed}");
}

#[test]
fn resets_at_any_instant_keep_the_position() {
    let (mut braked, mut highest) = (0, Highest::default());
    let are_all = all_cases("chains", "resets_at_any_instant_keep_the_position", instants() / PER_CASE, |case| {
        let mut bench = bench(case);
        for _ in 0..PER_CASE {
            let first = bench.sim.outcome().moves.len();
            let mut moves = Moves::from(bench.steps());
            let lines = moves.more(10, Kind::Program, &mut bench.random);
            bench.stream(&lines);
            bench.wait(1.0);
            bench.reset();
            bench.sim.run_for(Duration::from_micros(1)).unwrap();
            bench.at_rest();
            bench.stays(0.1);
            bench.sim.run_until_idle().unwrap();
            assert!(bench.hear(), "case {case}: no welcome");
            assert_eq!(bench.state(), State::Idle, "case {case}");
            let outcome = bench.outcome();
            braked += outcome.moves[first..].iter().filter(|record| record.finish == Finish::Held).count() as u64;
            check_chain(&mut bench, &outcome, first, &moves, &mut highest, case);
        }
        check(&bench.outcome(), case);
    });
    if !are_all {
        return;
    }
    println!("of {} resets {braked} fell into moves", instants());
    highest.print();
    assert!(braked > instants() / 3, "{braked}");
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stop {
    Limit(Axis),
    Emergency,
    Resets,
}

#[test]
fn stops_at_any_instant_leave_the_exact_count() {
    let (mut stopped, mut highest) = (0, Highest::default());
    let are_all = all_cases("chains", "stops_at_any_instant_leave_the_exact_count", instants() / PER_CASE, |case| {
        let mut bench = bench(case);
        for round in 0..PER_CASE {
            let first = bench.sim.outcome().moves.len();
            let mut moves = Moves::from(bench.steps());
            let lines = moves.more(10, Kind::Program, &mut bench.random);
            bench.stream(&lines);
            bench.wait(1.0);
            let was = bench.state();
            let axis = bench.one_of(&Axis::ALL);
            let stop = [Stop::Limit(axis), Stop::Emergency, Stop::Resets][(round % 3) as usize];
            match stop {
                Stop::Limit(axis) => bench.sim.set_switch(axis, SwitchFault::StuckClosed),
                Stop::Emergency => bench.sim.set_emergency_stop(true),
                Stop::Resets => bench.sim.send(b"\x18\x18"),
            }
            bench.sim.run_for(Duration::from_micros(20)).unwrap();
            bench.stays(0.1);
            let expected = match (stop, was) {
                (Stop::Emergency, _) => State::Alarm(Alarm::EmergencyStop),
                (_, State::Idle) => State::Idle,
                (Stop::Limit(axis), _) => State::Alarm(Alarm::HardLimit { motor: axis.into() }),
                (Stop::Resets, _) => State::Alarm(Alarm::ResetInMotion),
            };
            assert_eq!(bench.state(), expected, "case {case}: {stop:?} in {was:?}");
            match stop {
                Stop::Limit(axis) => bench.sim.set_switch(axis, SwitchFault::None),
                Stop::Emergency => bench.sim.set_emergency_stop(false),
                Stop::Resets => {}
            }
            bench.sim.run_for(Duration::from_millis(50)).unwrap();
            bench.sim.send(b"$X\n");
            bench.sim.run_until_idle().unwrap();
            bench.forget_answers();
            assert_eq!(bench.state(), State::Idle, "case {case}");
            let outcome = bench.sim.outcome();
            assert_eq!(outcome.counted_steps, outcome.position_steps, "case {case}: {stop:?}");
            stopped += outcome.moves[first..].iter().filter(|record| record.finish == Finish::Stopped).count() as u64;
            check_chain(&mut bench, &outcome, first, &moves, &mut highest, case);
            // The machine moves to where the random moves have room.
            bench.say("G90 G0 X0 Y0 Z0\n");
            bench.sim.run_until_idle().unwrap();
            assert_eq!(bench.outcome().counted_steps, [0; 3], "case {case}");
        }
        check(&bench.outcome(), case);
    });
    if !are_all {
        return;
    }
    println!("of {} stops {stopped} fell into moves", instants());
    highest.print();
    assert!(stopped > instants() / 3, "{stopped}");
}

/// The host stops sending in the middle of a line. The machine must brake to rest at the end of the known moves and
/// continue when more lines come; if they come in time, it must not stop.
#[test]
fn a_host_that_stops_for_a_while_stops_the_machine_where_its_lines_end() {
    const SPEED_MM_S: f64 = 20.0;
    let (mut rested, mut flowed) = (0, 0);
    let name = "a_host_that_stops_for_a_while_stops_the_machine_where_its_lines_end";
    let are_all = all_cases("chains", name, 60, |case| {
        let mut bench = bench(case);
        bench.say("$120=50\n$920=0\n$930=500\n$900=0\n");
        bench.settle_settings();
        let accel_mm_s2 = 50.0;
        let lines = |from: i32| (from + 1..=from + 20).map(|mm| format!("G90 G1 X{mm} F1200\n")).collect::<String>();
        bench.stream(&lines(0));
        // The first 20 mm take some 3 s with the slowest law.
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
            kept::are_rests(record, outcome.config_of(record))[1]
        };
        let rests: Vec<_> = (0..40).filter(|index| is_rest(*index)).collect();
        let [before, after] = [&outcome.moves[19], &outcome.moves[20]];
        // The latest time at which braking can begin: for the trapezoid, which begins later than any other law, plus
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
