//! Random rasters of a laser, whose lines go straight on and become blocks with marks: each step is made with the power
//! of its line, whatever interferes, and nothing is later than by blocks of their own.

use std::fmt::Write as _;

use embassy_time::Duration;
use isostep_motion::{Axis, State};
use isostep_sim::tool::ToolOutput;
use isostep_sim::{Outcome, SwitchFault};
use isostep_tests::bench::{Bench, all_cases, check};
use isostep_trials::cases_that_count;

/// A line of the program: how many steps it makes in all, and the power of each, of 65,535.
#[derive(Clone, Copy)]
struct Line {
    steps: usize,
    duty: u16,
}

/// The place where rasters begin: 60 mm.
const CENTRE_STEPS: i32 = 3_000;

/// Rows of pixels.
#[derive(Default)]
struct Raster {
    /// The lines as a laser gets them, and without their power.
    lit: String,
    plain: String,
    lines: Vec<Line>,
}

impl Raster {
    fn random(bench: &mut Bench) -> Self {
        let mut raster = Self::default();
        let rows = bench.random.rand_range(1..4);
        let feed = bench.one_of(&[600, 1_500, 2_400]);
        let _ = writeln!(raster.lit, "G21G90 M3 S0 F{feed}\nG0X60Y60\nG91");
        let _ = writeln!(raster.plain, "G21G90 F{feed}\nG0X60Y60\nG91");
        let [x, y, _] = bench.steps();
        raster.lines.push(Line { steps: (x.abs_diff(CENTRE_STEPS) + y.abs_diff(CENTRE_STEPS)) as usize, duty: 0 });
        for row in 0..rows {
            // Steps of 0.02 mm. Most rows are along X, and some exactly oblique.
            let unit = bench.one_of(&[[1, 0], [1, 0], [1, 0], [0, 1], [2, 1], [3, -2]]);
            let unit = if row % 2 == 0 { unit } else { unit.map(|steps: i32| -steps) };
            let width = bench.one_of(&[1, 2, 5, 5, 20]);
            let mut left = 1_000;
            for _ in 0..bench.one_of(&[3, 40, 150]) {
                let times = (width * bench.one_of(&[1, 1, 1, 2, 7])).min(left);
                if times == 0 {
                    break;
                }
                left -= times;
                let percent = bench.one_of(&[0, 0, 10, 50, 50, 100]);
                raster.line(unit.map(|steps| steps * times), percent, bench.random.rand_range(0..60) == 0);
            }
            raster.line([0, 10], 0, false);
        }
        raster
    }

    /// A pixel; `as_a_rapid` it is dark, and divides the block.
    fn line(&mut self, [x, y]: [i32; 2], percent: i32, as_a_rapid: bool) {
        let place = format!("X{:.2}Y{:.2}", f64::from(x) * 0.02, f64::from(y) * 0.02);
        let motion = if as_a_rapid { "G0" } else { "G1" };
        let _ = writeln!(self.lit, "{motion}{place}S{}", percent * 10);
        let _ = writeln!(self.plain, "{motion}{place}");
        let duty = if as_a_rapid { 0.0 } else { f64::from(percent) / 100.0 * 65_535.0 };
        self.lines.push(Line { steps: (x.abs() + y.abs()) as usize, duty: duty.round() as u16 });
    }
}

/// A bench with a laser; mostly with the speed profile and the port that marks are for.
fn bench(case: u64) -> Bench {
    let mut bench = Bench::new(if case % 5 == 4 { case } else { 2 * case });
    let speed_profile = if case % 5 == 3 { 1 } else { 0 };
    let accel = bench.one_of(&[100, 500, 2_000]);
    bench.say(&format!("$940={speed_profile}\n$900=0\n$904=0\n$32=1\n$120={accel}\n$121={accel}\n$920=0\n$921=0\n"));
    bench.settle_settings();
    bench
}

/// The duty from an instant on, ns since power-up.
fn duty_at(outcome: &Outcome, t_ns: u64) -> u16 {
    let changes = outcome.tool.iter().filter(|change| change.output == ToolOutput::Pwm);
    changes.take_while(|change| change.t_ns <= t_ns).last().map_or(0, |change| change.duty)
}

/// Checks that the edges from the `first` on have the power of their lines. They may end in the middle.
fn are_lit(outcome: &Outcome, first: usize, lines: &[Line], case: u64) {
    let mut duties = lines.iter().flat_map(|line| std::iter::repeat_n(line.duty, line.steps));
    let mut changes = outcome.tool.iter().filter(|change| change.output == ToolOutput::Pwm).peekable();
    let mut duty = 0;
    for (index, edge) in outcome.edges[first..].iter().enumerate() {
        while let Some(change) = changes.next_if(|change| change.t_ns <= edge.t_ns) {
            duty = change.duty;
        }
        let expected = duties.next().unwrap_or_else(|| panic!("case {case}: more than {index} edges"));
        assert!(duty.abs_diff(expected) <= 1, "case {case}: edge {index} has {duty}, not {expected}, of 65,535");
    }
}

fn marks(outcome: &Outcome) -> usize {
    outcome.moves.iter().map(|record| record.marks_steps.len()).sum()
}

/// The same program without a laser has a block for each line.
#[test]
fn a_raster_loses_no_time_by_marks_and_makes_the_same_steps() {
    let mut found = 0;
    let name = "a_raster_loses_no_time_by_marks_and_makes_the_same_steps";
    let are_all = all_cases("rasters", name, cases_that_count(20, 200).into(), |case| {
        let mut lit = bench(case);
        let raster = Raster::random(&mut lit);
        let mut plain = bench(case);
        plain.say("$32=0\n");
        plain.settle_settings();
        let [lit, plain] = [(lit, &raster.lit), (plain, &raster.plain)].map(|(mut bench, lines)| {
            bench.stream(lines);
            bench.sim.run_until_idle().unwrap();
            let outcome = bench.outcome();
            check(&outcome, case);
            outcome
        });
        assert_eq!(marks(&plain), 0);
        found += marks(&lit);
        assert_eq!(lit.edges.len(), plain.edges.len(), "case {case}");
        let [lit_ns, plain_ns] = [&lit, &plain].map(|outcome| outcome.edges[0].t_ns);
        for (index, (made, other)) in lit.edges.iter().zip(&plain.edges).enumerate() {
            assert_eq!((made.axis, made.direction), (other.axis, other.direction), "case {case}: edge {index}");
            let [made_ns, other_ns] = [made.t_ns - lit_ns, other.t_ns - plain_ns];
            assert!(
                made_ns <= other_ns + 2_000,
                "case {case}: edge {index} at {made_ns} ns, and {other_ns} without marks"
            );
        }
        are_lit(&lit, 0, &raster.lines, case);
    });
    assert!(!are_all || found > 1_000, "{found} marks");
}

/// Holds and overrides in the middle of blocks with marks.
#[test]
fn a_raster_that_is_held_or_overridden_goes_on_with_the_power_of_its_lines() {
    let (mut found, mut held) = (0, 0);
    let name = "a_raster_that_is_held_or_overridden_goes_on_with_the_power_of_its_lines";
    let are_all = all_cases("rasters", name, cases_that_count(100, 300).into(), |case| {
        let mut bench = bench(case);
        let raster = Raster::random(&mut bench);
        for (number, line) in raster.lit.split_inclusive('\n').enumerate() {
            bench.stream(line);
            if number % 20 != 19 {
                continue;
            }
            bench.wait(0.3);
            match bench.random.rand_range(0..4) {
                0 => {
                    let byte = bench.one_of(&[0x90, 0x91, 0x92, 0x91, 0x92]);
                    bench.override_by(&[byte; 4]);
                }
                _ => bench.hold(b'!', "", 0.2),
            }
        }
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        check(&outcome, case);
        are_lit(&outcome, 0, &raster.lines, case);
        assert_eq!(outcome.edges.len(), raster.lines.iter().map(|line| line.steps).sum::<usize>(), "case {case}");
        found += marks(&outcome);
        let is_within = |record: &&isostep_sim::MoveRecord| {
            record.finish == isostep_motion::Finish::Held
                && record.held_at_steps > 0.0
                && !record.marks_steps.is_empty()
        };
        held += outcome.moves.iter().filter(is_within).count();
    });
    assert!(!are_all || found > 2_000 && held > 20, "{found} marks, {held} holds among them");
}

/// What was stopped is dark, and the marks of what was forgotten are no marks of what follows.
#[test]
fn a_raster_after_a_reset_or_a_stop_has_the_power_of_its_own_lines() {
    let mut found = 0;
    let name = "a_raster_after_a_reset_or_a_stop_has_the_power_of_its_own_lines";
    let are_all = all_cases("rasters", name, cases_that_count(20, 200).into(), |case| {
        let mut bench = bench(case);
        for round in 0..4 {
            let raster = Raster::random(&mut bench);
            let begun = bench.sim.outcome().edges.len();
            bench.stream(&raster.lit);
            bench.wait(1.0);
            let (last, outcome) = (round == 3, bench.sim.outcome());
            // At the instant of a stop the light goes out before the last step.
            are_lit(&outcome, begun, &raster.lines, case);
            found += marks(&outcome);
            if last {
                break;
            }
            if bench.one_of(&[true, false]) {
                bench.sim.set_switch(Axis::Z, SwitchFault::StuckClosed);
                bench.sim.run_for(Duration::from_millis(20)).unwrap();
                bench.sim.set_switch(Axis::Z, SwitchFault::None);
            }
            bench.sim.send(b"\x18");
            bench.sim.run_for(Duration::from_secs(2)).unwrap();
            let outcome = bench.sim.outcome();
            assert_eq!(duty_at(&outcome, u64::MAX), 0, "case {case}");
            bench.forget_answers();
            bench.say("$X\n");
            bench.sim.run_for(Duration::from_millis(100)).unwrap();
            bench.forget_answers();
        }
        bench.sim.run_until_idle().unwrap();
        let outcome = bench.outcome();
        assert_eq!((outcome.counted_steps, bench.state()), (outcome.position_steps, State::Idle), "case {case}");
    });
    assert!(!are_all || found > 1_000, "{found} marks");
}
