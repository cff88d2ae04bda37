//! Crossed belts on the chip: every edge is where the simulation has it, on both ports, shaped or not, and the carriage ends where it does.

use std::fmt::Write as _;
use std::fs;

use isostep_report::compare;
use isostep_sim::{Outcome, Port, run};
use isostep_tests::emulated::{self, Board, Run};
use isostep_tests::root;
use isostep_trials::cases;
use oorandom::Rand32;

use super::shaped::off_at_most_ns;

/// Far enough from the switches, mm.
const START_MM: [f64; 3] = [200.0, 200.0, 50.0];
const CARRIAGE_STEPS_PER_MM: f64 = 50.0;
const SETTINGS: &str = "$907=1\n$100=80\n$101=80\n$110=12000\n$111=9000\n$120=1500\n$121=800\n";
/// ZV and MZV, so that an axis is late by another time than the other.
const UNLIKE_SHAPERS: &str = "$950=1\n$951=5\n$960=40\n$961=30\n$970=0.1\n$971=0.05\n";

/// The lines of a path.
fn lines() -> usize {
    cases(25, 80) as usize
}

/// A path of short and long lines in all directions, with blends, that stays near its start; then the axes alone.
fn wander(seed: u64, lines: usize) -> String {
    let mut random = Rand32::new(seed);
    let mut program = "G90\nG64 P0.05\n".to_owned();
    for _ in 0..lines {
        let reach = [0.3, 3.0, 12.0][random.rand_range(0..3) as usize];
        let [x, y] = [(); 2].map(|()| f64::from(random.rand_float()) * reach);
        let feed = 1_200 + random.rand_range(0..8_000);
        writeln!(program, "{} X{x:.3} Y{y:.3} F{feed}", ["G1", "G1", "G0"][random.rand_range(0..3) as usize]).unwrap();
    }
    program + "G61\nG1 X3 Y3 F3000\nX8\nY8\nX3 Y3\nX8 Y-2\nG4 P0.2\nG0 X7 Y-3\n"
}

/// Streams a program to the board with belts, and simulates it.
fn both(name: &str, port: Port, program: &str) -> (Run, Outcome) {
    let test = format!("core-xy-{name}-{port}");
    let path = root().join("target/emulated").join(format!("{test}.nc"));
    fs::create_dir_all(path.parent().expect("a folder")).unwrap();
    fs::write(&path, program).unwrap();
    let start = format!("--start={},{},{}", START_MM[0], START_MM[1], START_MM[2]);
    let emulated = Board::stepped_by(port, &test)
        .with(&["--belts", &start, "--stream=counting", "--timeout-s=900"])
        .program(&path);
    assert!(emulated.ok, "{test}: {}", emulated.printed);
    let mut config = isostep_sim::Config { port, ..emulated::config() };
    config.settings.kinematics = 1;
    config.start_mm[..3].copy_from_slice(&START_MM);
    let simulated = run(program.as_bytes(), &config).unwrap();
    for (axis, letter) in ["X", "Y"].into_iter().enumerate() {
        let figures = &emulated.figures["axes"][letter];
        assert_eq!(figures["position_steps"], simulated.motor_steps[axis], "{test}: the motor of {letter}");
        assert_eq!(figures["lost_steps"], 0, "{test}: {letter}");
        let place_mm = figures["place_mm"].as_f64().unwrap();
        // The emulated carriages have their own steps.
        let steps = (place_mm - START_MM[axis]) * CARRIAGE_STEPS_PER_MM;
        assert!(
            (steps - f64::from(simulated.position_steps[axis])).abs() < 0.6,
            "{test}: {letter} is at {place_mm} mm"
        );
    }
    (emulated, simulated)
}

/// Random paths, and where all cases are tried a program of the project.
fn are_exact(port: Port, jitter_max_ns: f64) {
    for seed in 0..cases(1, 6) {
        let program = format!("{SETTINGS}{}", wander(u64::from(seed) + 907, lines()));
        let simulated = path_is_exact(&format!("path-{seed}"), port, &program, jitter_max_ns);
        let blends = simulated.moves.iter().filter(|record| record.blend.is_some()).count();
        assert!(blends > lines() / 2, "{blends} blends");
    }
    if cases(0, 1) == 1 {
        let diagonal = fs::read_to_string(root().join("programs/diagonal.nc")).unwrap();
        path_is_exact("diagonal", port, &format!("$907=1\n{diagonal}"), jitter_max_ns);
    }
}

fn path_is_exact(name: &str, port: Port, program: &str, jitter_max_ns: f64) -> Outcome {
    let (emulated, simulated) = both(name, port, program);
    let all = compare::compare(&simulated, &emulated.edges).unwrap().all;
    println!("{port}, {name}: {} edges at most {:.0} ns off (emulated)", all.steps, all.max_ns);
    assert!(all.max_ns <= jitter_max_ns, "{port}, {name}: {all:?}");
    assert!(all.steps > 5_000, "{name}: {all:?}");
    simulated
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn edges_with_crossed_belts_are_where_the_simulation_has_them() {
    are_exact(Port::Pio, 50.0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn edges_with_crossed_belts_by_the_timer_port_are_where_the_simulation_has_them() {
    are_exact(Port::Timer, 20_000.0);
}

fn unlike_shapers_are_exact(port: Port, off_max_ns: u64) {
    for seed in 0..cases(1, 4) {
        let program = format!("{SETTINGS}{UNLIKE_SHAPERS}{}", wander(u64::from(seed) + 950, lines()));
        let (emulated, simulated) = both(&format!("shaped-{seed}"), port, &program);
        let off_ns = off_at_most_ns(&emulated.edges, &simulated.edges);
        println!(
            "{port}, seed {seed}: {} edges of shaped runs at most {off_ns} ns off (emulated)",
            emulated.edges.len()
        );
        assert!(off_ns <= off_max_ns, "{port}, seed {seed}: {off_ns} ns");
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn axes_of_crossed_belts_with_unlike_shapers_are_where_the_simulation_has_them() {
    unlike_shapers_are_exact(Port::Pio, 50);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn axes_of_crossed_belts_with_unlike_shapers_by_the_timer_port_are_where_the_simulation_has_them() {
    unlike_shapers_are_exact(Port::Timer, 20_000);
}
