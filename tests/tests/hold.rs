//! Feed hold and resume, jog cancel and overrides at random instants of random moves, in virtual time. Every edge must
//! match the closed form, counts must be exact, paths straight, and each axis within its limits as computed from its
//! edges alone. Every run is the same; a failure names its case.

use embassy_time::Duration;
use isostep_motion::{Alarm, Finish, State};
use isostep_sim::MoveRecord;
use isostep_tests::bench::{Bench, Highest, check, steps_of};
use isostep_trials::cases;

fn holds() -> u64 {
    cases(60, 500).into()
}

#[test]
fn holds_at_any_instant_lose_nothing() {
    let (mut held, mut highest) = (0, Highest::default());
    for case in 0..holds() {
        let mut bench = Bench::new(case);
        let place = bench.place();
        let [x, y, z] = place;
        let feed = (100.0 + bench.random.rand_float() * 4_000.0).round();
        bench.say(&format!("G90\nG1 X{x} Y{y} Z{z} F{feed}\nG0 X0 Y0 Z0\n"));
        for _ in 0..bench.random.rand_range(1..4) {
            bench.wait(2.5);
            // An override makes the move slower or faster, and the hold comes before the override has taken effect.
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
        highest.add(bench.ratios(&outcome, |record| is_feed(record).then_some(feed)), case);
        held += outcome.moves.iter().filter(|record| record.finish == Finish::Held).count();
    }
    println!("{} random programs were held in mid-move {held} times", holds());
    highest.print();
    assert!(held as u64 > holds() / 2, "only {held} holds fell into a move");
}

#[test]
fn overrides_at_any_instant_lose_nothing() {
    let (mut changed, mut highest) = (0, Highest::default());
    for case in 0..holds() {
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
        highest.add(bench.ratios(&outcome, |_| feed), case);
        changed += outcome.moves.iter().filter(|record| !record.parts.is_empty()).count();
    }
    println!("of {} random moves {changed} went on at another speed", holds());
    highest.print();
    assert!(changed as u64 > holds() / 4, "only {changed} moves went on at another speed");
}

/// Overrides come faster than they take effect. Then the move is held while the last one takes effect.
#[test]
fn overrides_in_quick_succession_lose_nothing() {
    let mut highest = Highest::default();
    for case in 0..holds() / 5 {
        let mut bench = Bench::new(case);
        // At this acceleration a full queue is a few milliseconds of motion.
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
        highest.add(bench.ratios(&outcome, |_| Some(1_500.0)), case);
    }
    highest.print();
}

#[test]
fn jogs_are_cancelled_at_any_instant() {
    let mut highest = Highest::default();
    for case in 0..holds() / 5 {
        let mut bench = Bench::new(case);
        let [x, y, z] = bench.place();
        bench.say(&format!("$J=G90 X{x} Y{y} Z{z} F1500\n$J=G91 X5 F1500\n"));
        bench.wait(2.0);
        bench.sim.send(&[0x85]);
        bench.at_rest();
        let still = bench.steps();
        bench.wait(0.5);
        assert_eq!((bench.steps(), bench.sim.machine().state()), (still, State::Idle), "case {case}");
        // The next move is relative to where the machine stands.
        bench.say("G91\nG0 X1\n");
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        assert_eq!(outcome.counted_steps, [still[0] + 50, still[1], still[2]], "case {case}");
        check(&outcome, case);
        let is_rapid = |record: &MoveRecord| record.plan.steps == [50, 0, 0];
        highest.add(bench.ratios(&outcome, |record| (!is_rapid(record)).then_some(1_500.0)), case);
    }
    highest.print();
}

/// Resets in the middle of moves, dwells and jogs, some of them during or just before a hold. There must be no alarm,
/// and the welcome must come once the machine stands still.
#[test]
fn resets_at_any_instant_keep_the_position() {
    let (mut braked, mut highest) = (0, Highest::default());
    for case in 0..holds() / 2 {
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
        // The next move is relative to where the machine stands.
        bench.say("G91\nG0 X1\n");
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        assert_eq!(outcome.counted_steps, [still[0] + 50, still[1], still[2]], "case {case}");
        check(&outcome, case);
        let is_feed = |record: &MoveRecord| [steps_of(place), [-250, 0, 0]].contains(&record.plan.steps);
        highest.add(bench.ratios(&outcome, |record| is_feed(record).then_some(feed)), case);
        braked += u64::from(outcome.moves.iter().any(|record| record.finish == Finish::Held));
    }
    println!("of {} resets {braked} had a move brake", holds() / 2);
    highest.print();
    assert!(braked > holds() / 8, "only {braked} resets fell into a move");
}

#[test]
fn a_second_reset_stops_what_brakes_at_once() {
    for case in 0..holds() / 5 {
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
