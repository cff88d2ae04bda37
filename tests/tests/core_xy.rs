//! Crossed belts (CoreXY) in virtual time: the carriage goes where a Cartesian machine's goes, and every promise holds for the motors,
//! by their edges, and for the axes. Programs of other people, which are not part of the project, are in the folder
//! `ISOSTEP_CORPUS`, in `lines/`.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use isostep_console::Settings;
use isostep_motion::{AXES, Kinematics, Move};
use isostep_report::Figures;
use isostep_sim::measure::across;
use isostep_sim::{Config, Outcome, Port, run};
use isostep_tests::root;
use isostep_trials::cases;
use oorandom::Rand32;

/// By what fraction the edges may show more than a limit that is kept.
const GRAIN: f64 = 0.02;

/// The same machine with each axis's own motors, and with crossed belts.
fn both(config: &Config) -> [Config; 2] {
    [0, 1].map(|kinematics| {
        let mut config = config.clone();
        config.settings.kinematics = kinematics;
        config
    })
}

fn kept(name: &str, outcome: &Outcome) {
    let broken: Vec<_> = Figures::new(name, outcome).broken().map(|verdict| format!("{verdict:?}")).collect();
    assert!(broken.is_empty(), "{name}: {}", broken.join("\n"));
}

/// The place where each line of the program ends that has a step, in steps of the axes. One that is shorter than a step may have one on
/// belts, and none otherwise.
fn asked(outcome: &Outcome) -> BTreeMap<u32, [i32; AXES]> {
    let ends = |asked: &Move| (asked.source, outcome.kinematics.axes(asked.target_steps));
    outcome.program_moves().flat_map(|record| record.asked.iter().map(ends)).collect()
}

/// The highest acceleration of a motor, and of an axis that both belts move, as fractions of their limits.
fn highest(outcome: &Outcome) -> [f64; 2] {
    let most =
        |windows: &mut dyn Iterator<Item = across::Window>| windows.map(|window| window.ratio).fold(0.0, f64::max);
    [most(&mut across::windows(outcome)), most(&mut across::windows_of_axes(outcome))]
}

/// Runs a program on both machines and compares them. Returns their times in motion, s, and the highest accelerations with belts.
fn compare(name: &str, config: &Config, program: &str) -> ([f64; 2], [f64; 2]) {
    let outcomes = both(config).map(|config| run(program.as_bytes(), &config).unwrap());
    outcomes.iter().for_each(|outcome| kept(name, outcome));
    let [cartesian, belts] = &outcomes;
    assert_eq!([cartesian.kinematics, belts.kinematics], [Kinematics::Cartesian, Kinematics::CoreXy]);
    let [should, are] = outcomes.each_ref().map(asked);
    for (line, should) in &should {
        let Some(is) = are.get(line) else { continue };
        assert!((0..AXES).all(|axis| should[axis].abs_diff(is[axis]) <= 1), "{name}, {line}: {is:?} for {should:?}");
    }
    for axis in 0..AXES {
        let [should, is] = outcomes.each_ref().map(|outcome| outcome.places_steps[axis]);
        assert!(should.abs_diff(is) <= 1, "{name}: the carriage is at {is}, not at {should}");
    }
    let most = highest(belts);
    assert!(most.iter().all(|most| *most <= 1.0 + GRAIN), "{name}: {most:?} of an acceleration");
    (outcomes.map(|outcome| outcome.motion_s), most)
}

/// Every program of the project, by its own feeds and as fast as the machine goes, with each port.
#[test]
fn the_carriage_goes_where_a_cartesian_one_goes() {
    let mut names: Vec<_> = fs::read_dir(root().join("programs")).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.retain(|path| path.extension().is_some_and(|extension| extension == "nc"));
    names.sort();
    assert!(names.len() >= 8, "{names:?}");
    for path in names {
        let (name, program) = (path.file_name().unwrap().to_string_lossy(), fs::read_to_string(&path).unwrap());
        for port in Port::ALL {
            let config = Config { port, ..Config::default() };
            let ([cartesian_s, belts_s], [motors, axes]) = compare(&name, &config, &program);
            println!(
                "{name}, {port}: {cartesian_s:.3} s Cartesian, {belts_s:.3} s CoreXY; {motors:.4} and {axes:.4} of a limit"
            );
        }
    }
}

/// A machine whose Y is slower in everything than X.
fn unlike() -> Config {
    let mut config = Config { start_mm: [150.0, 150.0, 40.0], ..Config::default() };
    let settings = &mut config.settings;
    (settings.steps_per_mm, settings.soft_limits) = ([80.0; AXES], false);
    (settings.max_rate_mm_min, settings.accel_mm_s2) = ([12_000.0; AXES], [2_000.0; AXES]);
    (settings.max_rate_mm_min[1], settings.accel_mm_s2[1]) = (6_000.0, 500.0);
    settings.decel_or_0_mm_s2[1] = 300.0;
    config
}

/// Where X alone and Y alone reach their own limits, a diagonal turns one motor only, which has to be as fast as both axes together.
#[test]
fn both_axes_and_both_motors_keep_their_own_limits() {
    let outcome = |program: &str| {
        let outcome = run(program.as_bytes(), &both(&unlike())[1]).unwrap();
        kept(program, &outcome);
        outcome
    };
    // The line, and how long it should take from rest to rest: by hand, from the limit that is reached.
    let by_accel = |mm: f64, up_mm_s2: f64, down_mm_s2: f64| {
        let top_mm_s = (2.0 * mm / (1.0 / up_mm_s2 + 1.0 / down_mm_s2)).sqrt();
        top_mm_s / up_mm_s2 + top_mm_s / down_mm_s2
    };
    for (line, expected_s) in [
        // X alone: 2,000 mm/s² both ways.
        ("G0 X10", by_accel(10.0, 2_000.0, 2_000.0)),
        // Y alone: 500 and 300.
        ("G0 Y10", by_accel(10.0, 500.0, 300.0)),
        // The same on both: Y's limits, as the motor of X makes 1,000 and 600 of 2,000.
        ("G0 X10 Y10", by_accel(10.0, 500.0, 300.0)),
        // The motor of X makes 1.1 of what X makes, and may make 2,000.
        ("G0 X10 Y1", by_accel(10.0, 2_000.0 / 1.1, 2_000.0 / 1.1)),
        // The same for the motor of Y.
        ("G0 X10 Y-1", by_accel(10.0, 2_000.0 / 1.1, 2_000.0 / 1.1)),
    ] {
        let took_s = outcome(&format!("G91\n{line}\n")).motion_s;
        assert!((took_s / expected_s - 1.0).abs() < 1e-6, "{line}: {took_s} s for {expected_s}");
    }
    // As fast as belts go: a motor goes as fast as both axes together.
    let long = outcome("G91\nG0 X200 Y200\n");
    let [x, y, _] = long.moves[0].plan.steps.map(|steps| f64::from(steps) / 160.0);
    assert_eq!([x, y], [200.0, 0.0]);
    // Y's 100 mm/s hold: 200 mm of Y take 2 s and the ramps half as long as they last.
    let expected_s = 2.0 + 0.5 * (100.0 / 500.0 + 100.0 / 300.0);
    assert!((long.motion_s - expected_s).abs() < 1e-3, "{} for {expected_s}", long.motion_s);
}

/// A path of lines in all directions, long and short.
fn wander(random: &mut Rand32, moves: usize) -> String {
    let mut program = "G91\nG64\n".to_owned();
    let (mut x, mut y) = (0.0_f64, 0.0_f64);
    for _ in 0..moves {
        let reach = [0.05, 0.5, 5.0, 30.0][random.rand_range(0..4) as usize];
        let mut step = |at: &mut f64| {
            let by = (2.0 * f64::from(random.rand_float()) - 1.0) * reach;
            let by = if (*at + by).abs() > 60.0 { -by } else { by };
            let by = (by * 1e3).round() / 1e3;
            *at += by;
            by
        };
        let (dx, dy) = (step(&mut x), step(&mut y));
        let rapid = if random.rand_range(0..5) == 0 { "G0" } else { "G1" };
        program += &format!("{rapid} X{dx:.3} Y{dy:.3} F{}\n", 600 + random.rand_range(0..11_400));
    }
    program
}

/// The settings of a random machine, shaped or not.
fn settings(random: &mut Rand32) -> Settings {
    let mut settings = unlike().settings;
    for axis in 0..2 {
        settings.accel_mm_s2[axis] = 100.0 + 3_000.0 * random.rand_float().round() + 400.0 * random.rand_float();
        settings.decel_or_0_mm_s2[axis] = [0.0, 800.0][random.rand_range(0..2) as usize];
        settings.max_rate_mm_min[axis] = 3_000.0 + 9_000.0 * random.rand_float();
        settings.shaper_kind[axis] = [0, random.rand_range(1..6) as u16][random.rand_range(0..2) as usize];
        settings.shaper_hz[axis] = 15.0 + 100.0 * random.rand_float();
        settings.shaper_damping_ratio[axis] = 0.1 * random.rand_float();
    }
    settings
}

/// Random paths on random machines, whose axes are unlike and have shapers of their own.
#[test]
fn random_machines_keep_their_limits_round_every_corner() {
    let mut most = [0.0_f64; 2];
    for seed in 0..cases(8, 120) {
        let mut random = Rand32::new(u64::from(seed) + 907);
        let config = Config { settings: settings(&mut random), ..unlike() };
        let program = wander(&mut random, 60);
        let (_, found) = compare(&format!("seed {seed}"), &config, &program);
        most = [0, 1].map(|which| most[which].max(found[which]));
    }
    println!("at most {most:?} of an acceleration, of motors and of axes");
}

/// Homing of one axis after the other, from anywhere, with switches that close at scattered places.
#[test]
fn homing_finds_the_same_place_every_time() {
    let mut random = Rand32::new(56);
    for time in 0..cases(20, 200) {
        let mut config = both(&Config::default())[1].clone();
        config.settings.homing_direction_mask = random.rand_range(0..8) as u16;
        config.settings.homing_order_digits = [123, 132, 213, 231, 312, 321][random.rand_range(0..6) as usize];
        config.start_mm = std::array::from_fn(|_| f64::from(random.rand_float()) * 90.0);
        config.seed = random.rand_u32().into();
        let outcome = run(b"$H\nG90 G0 X0 Y0\n", &config).unwrap();
        kept("homing", &outcome);
        let pull_off = outcome.places_steps.map(|steps| f64::from(steps) / 50.0);
        assert!(pull_off.iter().all(|mm| (mm - 2.0).abs() <= 0.03), "time {time}: {pull_off:?} mm off their switches");
        assert_eq!(outcome.position_steps, [0; AXES]);
    }
}

/// Programs of other people, as they are and as fast as the machine goes.
#[test]
fn programs_of_others_end_where_they_end_on_a_cartesian_machine() {
    let Some(folder) = std::env::var_os("ISOSTEP_CORPUS").map(PathBuf::from) else { return };
    let mut programs: Vec<_> = fs::read_dir(folder.join("lines")).unwrap().map(|entry| entry.unwrap().path()).collect();
    programs.sort();
    for path in programs {
        let (name, program) =
            (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read_to_string(&path).unwrap());
        let machine = fs::read_to_string(root().join("programs/machines/c.txt")).unwrap();
        let middle = Config { start_mm: [3_000.0; AXES], ..Config::default() };
        let config =
            Config { settings: isostep_sim::settings::read_for_any_port("c", machine.as_bytes()).unwrap(), ..middle };
        let ([cartesian_s, belts_s], [motors, axes]) = compare(&name, &config, &program);
        println!("{name}: {cartesian_s:.3} s Cartesian, {belts_s:.3} s CoreXY; {motors:.4} and {axes:.4} of a limit");
    }
}
