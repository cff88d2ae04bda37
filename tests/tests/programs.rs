//! Whole programs in virtual time: those of the project as readable tables, and random ones.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;

use expect_test::{Expect, expect};
use isostep_console::Settings;
use isostep_report::Figures;
use isostep_sim::{Config, Outcome, Port, run};
use isostep_tests::{root, speed_profiles};
use isostep_trials::{cases, stride, window};
use oorandom::Rand32;

/// The smallest and largest positions of X, Y and Z on the arcs of arcs.nc.
const ARCS_REACH_STEPS: [(i32, i32); 3] = [(6_000, 9_500), (7_000, 12_396), (1_000, 2_000)];

fn kept(name: &str, outcome: &Outcome) {
    let broken: Vec<_> = Figures::new(name, outcome).broken().map(|verdict| format!("{verdict:?}")).collect();
    assert!(broken.is_empty(), "{name}: {}", broken.join("\n"));
}

fn check(name: &str, expected: &Expect) {
    let program = fs::read(root().join("programs").join(name)).unwrap();
    let outcomes = Port::ALL.map(|port| run(&program, &Config { port, ..Config::default() }).unwrap());
    outcomes.iter().for_each(|outcome| kept(name, outcome));
    let [outcome, _] = outcomes;
    let mut table = String::from("       X      Y      Z        blend   accelerate     cruise decelerate\n");
    for record in outcome.moves.iter().filter(|record| !record.homing) {
        let ([x, y, z], blend) = (record.plan.steps, record.line_begins_s());
        write!(table, "{x:>8} {y:>6} {z:>6} {blend:>10.6} s").unwrap();
        // The profile with which the line was made, although the move after it may have become known only during it.
        match record.profile() {
            Some(line) => {
                let (accel, cruise, decel) = (line.t_accel_s(), line.t_cruise_s(), line.t_decel_s());
                writeln!(table, " {accel:>10.6} s {cruise:>8.6} s {decel:>8.6} s").unwrap();
            }
            None => writeln!(table, " of blends alone").unwrap(),
        }
    }
    writeln!(table, "ends at {:?}", outcome.position_steps).unwrap();
    expected.assert_eq(&table);
}

#[test]
fn parking() {
    check(
        "parking.nc",
        &expect![[r#"
                   X      Y      Z        blend   accelerate     cruise decelerate
                8750   2000      0   0.000000 s   0.960000 s 2.685819 s 0.927210 s
                   0      0   4500   0.033636 s   0.566364 s 2.400000 s 0.566364 s
                   0    500      0   0.033636 s   0.366364 s 0.100000 s 0.366364 s
                   0      0  -4500   0.033636 s   0.566364 s 2.400000 s 0.566364 s
                7500  14000      0   0.033636 s   0.675535 s 7.235838 s 0.675535 s
                   0      0   4500   0.033636 s   0.566364 s 2.400000 s 0.566364 s
                   0   -500      0   0.033636 s   0.366364 s 0.100000 s 0.366364 s
                   0      0  -4500   0.033636 s   0.566364 s 2.400000 s 0.566364 s
               -7500 -14000      0   0.033636 s   0.930351 s 4.873272 s 0.960000 s
            ends at [8750, 2000, 0]
        "#]],
    );
}

/// There are too many chords for a table. This test checks where each figure ends and the extent of the arcs.
#[test]
fn arcs() {
    let program = fs::read(root().join("programs/arcs.nc")).unwrap();
    for port in Port::ALL {
        let outcome = run(&program, &Config { port, ..Config::default() }).unwrap();
        kept("arcs.nc", &outcome);
        assert_eq!(outcome.position_mm, [150.0, 200.0, 20.0]);
        let moves: Vec<_> = outcome.moves.iter().filter(|record| !record.homing).collect();
        let home = moves.iter().filter(|record| record.next_corner_steps() == [7_500, 10_000, 1_000]).count();
        assert_eq!(home, 11, "{port}: times at the place where figures begin and end");
        let reach = |axis: usize| {
            let ends = moves[1..].iter().map(|record| record.next_corner_steps()[axis]);
            (ends.clone().min().unwrap(), ends.max().unwrap())
        };
        assert_eq!([0, 1, 2].map(reach), ARCS_REACH_STEPS, "{port}");
        assert!((1_000..3_000).contains(&moves.len()), "{port}: {} moves", moves.len());
    }
}

/// A hundred steps of 1/50 mm at 40 mm/min, which is the start speed, so each takes 30 ms. A file of short moves must
/// take as long as its feed says.
#[test]
fn short_moves_do_not_exceed_their_feed() {
    for port in Port::ALL {
        let lines = "$910=40\n".to_owned() + &"G91 G1 X0.02 F40\n".repeat(100);
        let outcome = run(lines.as_bytes(), &Config { port, ..Config::default() }).unwrap();
        kept("short moves", &outcome);
        let [first, .., last] = &outcome.moves[..] else { panic!("{port}: {} moves", outcome.moves.len()) };
        assert!(outcome.moves.len() == 100 && last.run <= first.run + 1, "{port}: they flow, once they are known");
        let took_s = (last.start_ns - first.begin_ns()) as f64 * 1e-9 + last.plan_s;
        assert!((2.9999..3.0001).contains(&took_s), "{port}: {took_s} s");
    }
}

#[test]
fn square() {
    check(
        "square.nc",
        &expect![[r#"
                   X      Y      Z        blend   accelerate     cruise decelerate
                5000      0      0   0.000000 s   0.800000 s 1.700000 s 0.766364 s
                   0   5000      0   0.033636 s   0.766364 s 1.700000 s 0.766364 s
               -5000      0      0   0.033636 s   0.766364 s 1.700000 s 0.766364 s
                   0  -5000      0   0.033636 s   0.766364 s 1.700000 s 0.800000 s
            ends at [0, 0, 0]
        "#]],
    );
}

#[test]
fn diagonal() {
    check(
        "diagonal.nc",
        &expect![[r#"
                   X      Y      Z        blend   accelerate     cruise decelerate
                5000   1850      0   0.000000 s   0.960000 s 1.123334 s 0.923753 s
                   1   3000      0   0.036234 s   0.921351 s 0.290049 s 0.926352 s
                2000      1      0   0.033637 s   0.860845 s 0.000000 s 0.866199 s
                   1      1      0   0.019993 s   0.000002 s 0.000000 s 0.003184 s
                   1      0      0   0.016818 s   0.000780 s 0.000000 s 0.020780 s
               -3501     -3      0   0.000000 s   0.600000 s 1.733613 s 0.573583 s
                   7    -11     13   0.036461 s   0.052418 s 0.000000 s 0.033845 s
                1499    165   1000   0.036307 s   0.453372 s 0.709268 s 0.477376 s
               -5008  -5003  -1013   0.036303 s   0.943369 s 1.126496 s 0.960000 s
            ends at [0, 0, 0]
        "#]],
    );
}

/// The holes of bolt_circle.nc as somebody writes them who has neither parameters nor subroutines.
fn bolt_circle_by_hand() -> String {
    let holes = [
        (215.0, 200.0),
        (195.0, 234.641_016),
        (155.0, 234.641_016),
        (135.0, 200.0),
        (155.0, 165.358_984),
        (195.0, 165.358_984),
    ];
    let hole = |(x, y): (f64, f64)| {
        let pecks = [25, 20, 18].map(|z| format!("G1 Z{z} F600\nG0 Z32\n"));
        format!("G0 X{x} Y{y}\n{}", pecks.concat())
    };
    format!("$H\nG21 G90 G17 G94\nG0 X175 Y200 Z32\n{}G0 X175 Y200\nM2\n", holes.map(hole).concat())
}

#[test]
fn bolt_circle() {
    let program = fs::read(root().join("programs/bolt_circle.nc")).unwrap();
    let [made, by_hand] =
        [&program, bolt_circle_by_hand().as_bytes()].map(|text: &[u8]| run(text, &Config::default()).unwrap());
    kept("bolt_circle.nc", &made);
    assert!(made.edges.len() > 10_000 && made.edges == by_hand.edges, "{} edges", made.edges.len());
}

/// Where the tool goes straight down to below `surface_steps`, and how deep at most: X and Y, and then Z, steps.
fn depths(outcome: &Outcome, surface_steps: i32) -> BTreeMap<[i32; 2], i32> {
    let mut depths = BTreeMap::new();
    for record in outcome.moves.iter().filter(|record| !record.homing) {
        let ([by_x, by_y, by_z], [x, y, z]) = (record.plan.steps, record.next_corner_steps());
        if [by_x, by_y] == [0, 0] && by_z < 0 && z < surface_steps {
            depths.entry([x, y]).and_modify(|deepest: &mut i32| *deepest = z.min(*deepest)).or_insert(z);
        }
    }
    depths
}

/// The drill makes four holes, two of them deeper, and the mill goes down beside the plate, each with its own length from
/// the table of tools.
#[test]
fn two_tools() {
    let program = fs::read_to_string(root().join("programs/two_tools.nc")).unwrap();
    for (table, drill_steps, mill_steps) in [("", 0, 0), ("G10 L1 P1 Z5\nG10 L1 P2 Z-3\n", 250, -150)] {
        for port in Port::ALL {
            let outcome = run(format!("{table}{program}").as_bytes(), &Config { port, ..Config::default() }).unwrap();
            kept("two_tools.nc", &outcome);
            assert_eq!(outcome.position_steps, [1_000, 1_000, 1_250 + mill_steps], "{port}");
            let holes = [([1_400, 1_400], 900), ([1_400, 2_100], 700), ([2_600, 1_400], 900), ([2_600, 2_100], 700)];
            let mut expected: BTreeMap<_, _> = holes.map(|(place, z)| (place, z + drill_steps)).into();
            expected.insert([600, 1_750], 740 + mill_steps);
            assert_eq!(depths(&outcome, 1_000 + drill_steps), expected, "{port}");
        }
    }
}

/// Checks that every move that is long enough has its intervals measured, whatever its speed profile.
fn kept_and_measured(name: &str, config: &Config, measured: usize) {
    let program = fs::read(root().join("programs").join(name)).unwrap();
    let outcome = run(&program, config).unwrap();
    let figures = Figures::new(name, &outcome);
    let broken: Vec<_> = figures.broken().collect();
    assert!(broken.is_empty(), "{broken:#?}\nreplay: {}", figures.replay);
    let compared = figures.moves.iter().filter(|one| one.apart_s.is_some()).count();
    assert!(compared >= measured, "{compared} moves of {name} compared\nreplay: {}", figures.replay);
}

/// Without all cases a few of the speed profiles, ports and intervals are tried together.
fn under_every_speed_profile(name: &str, measured: usize) {
    let intervals = || [false, true].into_iter().flat_map(|thirds| Port::ALL.map(|port| (thirds, port)));
    let worlds = speed_profiles::machines().flat_map(|machine| intervals().map(move |world| (machine, world)));
    for (machine, (interval_thirds, port)) in worlds.step_by(stride(3)) {
        let settings = Settings { interval_thirds, ..machine };
        kept_and_measured(name, &Config { settings, port, ..Config::default() }, measured);
    }
}

#[test]
fn parking_keeps_every_promise_under_every_speed_profile() {
    // There are three moves of X and Y together.
    under_every_speed_profile("parking.nc", 3);
}

#[test]
fn diagonals_keep_every_promise_under_every_speed_profile() {
    under_every_speed_profile("diagonal.nc", 2);
}

/// Ten moves anywhere in the travel after homing, with one to three axes, rapids and feeds, and either interval split.
fn random_program(seed: u64) -> String {
    let mut random = Rand32::new(seed);
    let mut program = format!("$H\n$900={}\nG21 G90 F{}\n", random.rand_range(0..2), random.rand_range(60..4_000));
    for _ in 0..10 {
        write!(program, "G{}", random.rand_range(0..2)).unwrap();
        let axes = random.rand_range(1..8);
        for (bit, letter, travel_mm) in [(1, 'X', 350), (2, 'Y', 400), (4, 'Z', 100)] {
            if axes & bit != 0 {
                write!(program, " {letter}{}.{:02}", random.rand_range(0..travel_mm), random.rand_range(0..100))
                    .unwrap();
            }
        }
        program.push('\n');
    }
    program
}

#[test]
fn random_programs_keep_every_promise() {
    for seed in window(cases(10, 100)) {
        let program = random_program(seed);
        let folder = root().join("target/random");
        let name = format!("target/random/seed-{seed}.nc");
        let port = Port::ALL[seed as usize % Port::ALL.len()];
        let config = Config { seed, port, ..Config::default() };
        let outcome = run(program.as_bytes(), &config);
        let broken = match &outcome {
            Ok(outcome) => Figures::new(&name, outcome).broken().count() > 0,
            Err(_) => true,
        };
        if broken {
            fs::create_dir_all(&folder).unwrap();
            fs::write(root().join(&name), &program).unwrap();
            panic!("SEED={seed}: {:?}\nreplay: {}", outcome.err(), config.replay(&name));
        }
    }
}
