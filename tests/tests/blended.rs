//! Random programs whose corners are blends, held and overridden at random instants, in virtual time with both step
//! ports. Every edge must match the closed form, counts must be exact, and no axis may exceed its acceleration anywhere,
//! corners included, nor a speed that was asked for, as the edges alone say. A failure prints the command that repeats
//! it.

use isostep_motion::{AXES, Finish, State};
use isostep_sim::measure::across;
use isostep_sim::{MoveRecord, Outcome};
use isostep_tests::bench::{Bench, Highest, Kind, Moves, all_cases, check};
use isostep_trials::cases;

/// Number of interferences of each kind.
fn instants() -> u64 {
    cases(500, 5_000).into()
}
const PER_CASE: u64 = 10;
/// By what fraction the edges may show more than a limit that is kept.
const GRAIN: f64 = 0.02;

/// The machine of a case, which has blends: a trapezoid without a start speed, any acceleration and any deviation. Where a
/// block of G61.1 begins it stops (`$11`).
fn bench(case: u64) -> Bench {
    let mut bench = Bench::new(case);
    let deviation_mm = bench.one_of(&[0.01, 0.05, 0.3, 1.0]);
    let times = bench.one_of(&[1, 4, 20]);
    let axes = [0, 1, 2].map(|axis| {
        let accel = if axis == 1 { 40 * times } else { 50 * times };
        format!("$91{axis}=0\n$12{axis}={accel}\n")
    });
    bench.say(&format!("$11=0\n$900=0\n$940=0\n$904={deviation_mm}\n{}", axes.concat()));
    bench.settle_settings();
    bench
}

/// What has been seen of all cases.
#[derive(Default)]
struct Seen {
    blends: usize,
    held: usize,
    replanned: usize,
    accel_ratio: f64,
    lines: Highest,
}

impl Seen {
    /// Checks a case, in which all `moves` have been made.
    fn see(&mut self, bench: &mut Bench, moves: &Moves, case: u64) {
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        check(&outcome, case);
        assert_eq!(outcome.counted_steps, moves.end_steps(), "case {case}: where the program ends");
        let most = across::highest(&outcome).expect("moves");
        assert!(most.ratio < 1.0 + GRAIN, "case {case}: {most:?}");
        let found = moves.of(&outcome.moves);
        let feeds: Vec<_> = found.iter().map(|index| moves.asked[*index].feed_mm_min).collect();
        keeps_speeds(bench, &outcome, &feeds, case);
        let at = |record: &MoveRecord| outcome.moves.iter().position(|each| each == record).expect("one of them");
        self.lines.add(bench.ratios(&outcome, |record| feeds[at(record)]), case);
        self.accel_ratio = self.accel_ratio.max(most.ratio);
        self.blends += outcome.moves.iter().filter(|record| record.blend.is_some()).count();
        self.held += outcome.moves.iter().filter(|record| record.finish == Finish::Held).count();
        self.replanned += outcome.moves.iter().filter(|record| !record.parts.is_empty()).count();
    }

    fn print(&self) {
        let Self { blends, held, replanned, accel_ratio, .. } = self;
        println!(
            "{blends} blends, {held} moves held, {replanned} went on otherwise, accelerations {accel_ratio:.4} at most"
        );
        assert!(*accel_ratio > 0.98 && *blends as u64 > 2 * instants(), "{accel_ratio}, {blends} blends");
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

#[test]
fn holds_of_blended_programs_lose_nothing_and_keep_the_limits() {
    let name = "holds_of_blended_programs_lose_nothing_and_keep_the_limits";
    let mut seen = Seen::default();
    let are_all = all_cases("blended", name, instants() / PER_CASE, |case| {
        let (mut bench, mut moves) = (bench(case), Moves::default());
        for _ in 0..PER_CASE {
            let count = bench.random.rand_range(1..10);
            let lines = moves.more(count, Kind::Program, &mut bench.random);
            bench.stream(&lines);
            bench.wait(0.6);
            // A hold, the door's byte, or a hold while an override takes effect.
            match bench.random.rand_range(0..4) {
                0 => bench.sim.send(&[0x84]),
                1 => {
                    let byte = bench.one_of(&[0x90, 0x91, 0x92]);
                    bench.override_by(&[byte; 5]);
                    bench.wait(0.05);
                    bench.say("!");
                }
                _ => bench.say("!"),
            }
            bench.at_rest();
            bench.stays(0.3);
            bench.say("~");
            if bench.one_of(&[true, false]) {
                bench.wait(0.2);
                bench.say("!");
                bench.at_rest();
                bench.stays(0.1);
                bench.say("~");
            }
        }
        seen.see(&mut bench, &moves, case);
    });
    if are_all {
        seen.print();
        assert!(seen.held as u64 > instants() / 2, "{}", seen.held);
    }
}

#[test]
fn overrides_of_blended_programs_lose_nothing_and_keep_the_limits() {
    let name = "overrides_of_blended_programs_lose_nothing_and_keep_the_limits";
    let mut seen = Seen::default();
    let are_all = all_cases("blended", name, instants() / PER_CASE, |case| {
        let (mut bench, mut moves) = (bench(case), Moves::default());
        for _ in 0..PER_CASE {
            let count = bench.random.rand_range(1..8);
            let lines = moves.more(count, Kind::Program, &mut bench.random);
            bench.stream(&lines);
            bench.wait(0.4);
            let feed = bench.one_of(&[0x90, 0x91, 0x92, 0x91, 0x92]);
            let rapid = bench.one_of(&[0x95, 0x96, 0x97]);
            match bench.random.rand_range(0..3) {
                0 => bench.override_by(&[feed; 5]),
                1 => bench.override_by(&[rapid]),
                // Both at once.
                _ => bench.override_by(&[feed, feed, feed, rapid, feed]),
            }
        }
        seen.see(&mut bench, &moves, case);
    });
    if are_all {
        seen.print();
        assert!(seen.replanned as u64 > instants() / 5, "{}", seen.replanned);
    }
}

/// A reset brakes round blends too, and what follows begins where the machine stands.
#[test]
fn resets_of_blended_programs_keep_the_position_and_the_limits() {
    let name = "resets_of_blended_programs_keep_the_position_and_the_limits";
    let (mut braked, mut blends) = (0, 0);
    let are_all = all_cases("blended", name, instants() / PER_CASE, |case| {
        let mut bench = bench(case);
        for _ in 0..PER_CASE {
            let mut moves = Moves::from(bench.steps());
            let lines = moves.more(10, Kind::Program, &mut bench.random);
            bench.stream(&lines);
            bench.wait(1.0);
            bench.reset();
            bench.sim.run_for(embassy_time::Duration::from_micros(1)).unwrap();
            bench.at_rest();
            bench.stays(0.1);
            bench.sim.run_until_idle().unwrap();
            assert!(bench.hear(), "case {case}: no welcome");
            assert_eq!(bench.state(), State::Idle, "case {case}");
        }
        let outcome = bench.outcome();
        check(&outcome, case);
        let most = across::highest(&outcome).expect("moves");
        assert!(most.ratio < 1.0 + GRAIN, "case {case}: {most:?}");
        braked += outcome.moves.iter().filter(|record| record.finish == Finish::Held).count() as u64;
        blends += outcome.moves.iter().filter(|record| record.blend.is_some()).count() as u64;
    });
    if are_all {
        println!("{braked} of {} resets fell into moves, among {blends} blends", instants());
        assert!(braked > instants() / 3 && blends > instants(), "{braked}, {blends}");
    }
}
