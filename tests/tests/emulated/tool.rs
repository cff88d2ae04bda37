//! The tool on the emulated board, tested by its pins and by the steps at which something happens.

use std::fmt::Write as _;
use std::fs;

use isostep_report::compare;
use isostep_sim::world::Edge;
use isostep_sim::{Config, Port};
use isostep_tests::emulated::{self, Board, Run};
use isostep_tests::root;
use isostep_trials::cases;
use oorandom::Rand32;

/// Resolution of X in these programs, steps/mm.
const STEPS_PER_MM: u32 = 80;
/// Length of a pixel, steps.
const PIXEL_STEPS: i32 = 8;
/// Distance before and after the pixels, steps.
const RUN_UP_STEPS: i32 = 400;
/// The levels of consecutive pixels, percent.
const LEVELS_PERCENT: [u32; 5] = [20, 80, 50, 100, 10];

/// Settings for a laser, and for an X axis that reaches 100 mm/s within 2 mm.
fn laser_settings() -> String {
    format!("$32=1\n$30=1000\n$100={STEPS_PER_MM}\n$110=20000\n$120=5000\n")
}

/// A line of pixels of 0.1 mm at 100 mm/s, which is a thousand moves per second.
fn pixels(count: usize) -> String {
    laser_settings() + "G21 G91\nM3 S0\nG1 F6000 X5\n" + &only_pixels(count) + "X5S0\nM5\nM2\n"
}

fn only_pixels(count: usize) -> String {
    LEVELS_PERCENT.iter().cycle().take(count).map(|percent| format!("X0.1S{}\n", percent * 10)).collect()
}

fn streamed(test: &str, port: Port, program: &str) -> Run {
    let path = root().join("target/emulated").join(format!("{test}.nc"));
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, program).unwrap();
    let run = Board::stepped_by(port, test).with(&["--stream", "counting"]).program(&path);
    assert!(run.ok, "{}", run.printed);
    run
}

/// The changes of the PWM output: when, ns, and the new duty.
fn levels(run: &Run) -> Vec<(f64, f64)> {
    run.outputs.iter().filter(|change| change.output == "pwm").map(|change| (change.t_ns, change.value)).collect()
}

/// The distance of each change of the level from the middle between its two steps, us.
fn distances_us(run: &Run, count: usize) -> Vec<f64> {
    let levels = levels(run);
    let between = |edges: &[Edge]| (edges[0].t_ns + edges[1].t_ns) as f64 / 2.0;
    let mut distances = Vec::new();
    for pixel in 0..=count {
        let last_step = (RUN_UP_STEPS + PIXEL_STEPS * pixel as i32) as usize;
        let at_ns = between(&run.edges[last_step - 1..=last_step]);
        let percent = if pixel < count { LEVELS_PERCENT[pixel % LEVELS_PERCENT.len()] } else { 0 };
        let belongs = |level: &&(f64, f64)| (level.1 * 100.0 - f64::from(percent)).abs() < 0.1;
        let distance_ns = |level: &(f64, f64)| level.0 - at_ns;
        let nearest = levels.iter().filter(belongs).map(distance_ns).min_by(|a, b| a.abs().total_cmp(&b.abs()));
        distances.push(nearest.expect("such a level") * 1e-3);
    }
    distances
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn levels_begin_between_the_steps_they_belong_to() {
    let run = streamed("pixels", Port::Pio, &pixels(1_000));
    let distances_us = distances_us(&run, 1_000);
    let most_us = distances_us.iter().fold(0.0_f64, |most, distance| most.max(distance.abs()));
    // Half a step is 62 us.
    assert!(most_us < 15.0, "{most_us} us");
    // X moves at full speed throughout, so each pixel takes a millisecond.
    let steps = |pixel: usize| run.edges[RUN_UP_STEPS as usize + pixel * PIXEL_STEPS as usize].t_ns;
    assert!((steps(1_000) - steps(0)).abs_diff(1_000_000_000) < 1_000, "{} ns", steps(1_000) - steps(0));
    assert_eq!(run.figures["tool"]["on_at_standstill_s"], 0.0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn levels_begin_between_the_steps_of_the_timer_port_too() {
    let run = streamed("pixels-timer", Port::Timer, &pixels(300).replace("F6000", "F3000"));
    let distances_us = distances_us(&run, 300);
    let most_us = distances_us.iter().fold(0.0_f64, |most, distance| most.max(distance.abs()));
    // Half a step is 125 us.
    assert!(most_us < 60.0, "{most_us} us");
}

/// Pixels as fast as the processor makes them, and ramps as fast as it makes their steps, on which the level follows the speed: a step
/// that is due while a level is prepared does not wait for that.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn levels_delay_no_step_of_the_timer_port() {
    for mode in ["M3", "M4"] {
        let settings = laser_settings() + "$110=60000\n$120=10000\n$130=900\n";
        let long = "X30S900\nX-30S100\n".repeat(3);
        let program = format!("{settings}G21 G91\n{mode} S0\nG1 F60000 X20\n{}{long}M5\n", only_pixels(300));
        let run = streamed(&format!("pixels-hasty-{mode}"), Port::Timer, &program);
        let config = Config { port: Port::Timer, ..emulated::config() };
        let simulated = isostep_sim::run(program.as_bytes(), &config).unwrap();
        let most_ns = compare::compare(&simulated, &run.edges).unwrap().all.max_ns;
        println!("{mode}: at most {most_ns:.0} ns off (emulated)");
        assert!(most_ns < 10_000.0, "{mode}: {most_ns} ns");
    }
}

/// Nothing moves before a spindle that starts from S0 has its speed.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_spindle_that_starts_from_s0_is_waited_for() {
    let program = "$394=0.5\nM4 S0\nG4 P0.1\nS900\nG91 G1 Z-1 F300\nM5\n";
    let run = streamed("spindle-from-s0", Port::Pio, program);
    let [(rose_ns, _), (_, 0.0)] = levels(&run)[..] else { panic!("{:?}", levels(&run)) };
    let waits_ms = (run.edges[0].t_ns as f64 - rose_ns) * 1e-6;
    assert!((500.0..600.0).contains(&waits_ms), "{waits_ms} ms");
    let enabled = run.outputs.iter().filter(|change| change.output == "enable");
    let enabled: Vec<_> = enabled.map(|change| (change.t_ns >= rose_ns - 1e6, change.value)).collect();
    assert_eq!(enabled, [(true, 1.0), (true, 0.0)], "not before it turns");
}

/// With M4 the level must be proportional to the speed.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_level_by_speed_follows_the_steps() {
    let program = laser_settings() + "$120=1000\nG21 G91\nM4 S1000\nG1 F6000 X20\nM5\n";
    let run = streamed("by-speed", Port::Pio, &program);
    let levels = levels(&run);
    let full_steps_s = 100.0 * f64::from(STEPS_PER_MM);
    let mut compared = 0;
    for pair in run.edges.windows(2) {
        let (from_ns, to_ns) = (pair[0].t_ns as f64, pair[1].t_ns as f64);
        let ratio = 1e9 / (to_ns - from_ns) / full_steps_s;
        // Near rest, a step takes longer than a level lasts.
        if ratio < 0.1 {
            continue;
        }
        let at = levels.partition_point(|level| level.0 <= (from_ns + to_ns) / 2.0);
        let level = levels[at - 1].1;
        assert!((level - ratio).abs() < 0.01, "at {from_ns} ns: {level} for {ratio}");
        compared += 1;
    }
    assert!(compared > 1_500, "{compared}");
}

/// The steps of X and Y in a report of the probe.
fn probed_steps(line: &str) -> [i32; 2] {
    let mm = line.split("[PRB:").nth(1).unwrap().split(',').take(2);
    let steps: Vec<_> = mm.map(|mm| (mm.parse::<f64>().unwrap() * 50.0).round() as i32).collect();
    [steps[0], steps[1]]
}

/// Probing moves in many directions and at many speeds. The reported place must be that of the step at which the
/// contact closed.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn places_of_contact_are_exact_to_the_step() {
    let count = cases(20, 200) as usize;
    let mut random = Rand32::new(15);
    let mut script =
        "expect Grbl\nsend $120=1000\nexpect ok\nsend $121=1000\nexpect ok\nsend G90\nexpect ok\n".to_owned();
    for _ in 0..count {
        // The machine's zero is 35 mm above the switch.
        let plate_mm = 36.0 + random.rand_float() * 3.0;
        let (aside_mm, feed_mm_min) = (random.rand_float() * 20.0 - 10.0, random.rand_range(200..2_880));
        writeln!(script, "probe-plate X {plate_mm:.3} above").unwrap();
        writeln!(script, "send G38.2 X12 Y{aside_mm:.3} F{feed_mm_min}\nexpect [PRB:\nexpect ok").unwrap();
        writeln!(script, "send G0 X0 Y0\nexpect ok\nwait-idle").unwrap();
    }
    let run = Board::new("probe").script(&script);
    assert!(run.ok, "{}", run.printed);
    let contacts = run.figures["probe"]["contacts"].as_array().unwrap();
    let reported: Vec<_> = run.printed.lines().filter(|line| line.contains("< [PRB:")).map(probed_steps).collect();
    assert_eq!([contacts.len(), reported.len()], [count; 2]);
    for (contact, reported) in contacts.iter().zip(&reported) {
        let seen = [0, 1].map(|axis| contact["position_steps"][axis].as_i64().unwrap() as i32);
        let off = [0, 1].map(|axis| seen[axis].abs_diff(reported[axis]));
        assert!(off.iter().all(|&steps| steps <= 1), "{contact}: {reported:?}");
    }
}

/// From the lowest frequency that `$33` accepts to the highest, including values at which the ticks of a period might
/// overflow. The setting must survive a power cycle.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_frequency_has_its_duty() {
    let mut script = "expect Grbl\nsend M3 S500\nexpect ok\nwait-ms 250\n".to_owned();
    for hz in [10, 1_000, 65_537, 65_538, 100_000] {
        writeln!(script, "send M5\nexpect ok\nsend $33={hz}\nexpect ok\nsend M3 S500\nexpect ok\nwait-ms 250").unwrap();
    }
    script += "power-cycle\nexpect Grbl\nsend M3 S500\nexpect ok\nwait-ms 250\n";
    let run = Board::new("frequencies").script(&script);
    assert!(run.ok, "{}", run.printed);
    let on: Vec<_> = levels(&run).into_iter().map(|level| level.1).filter(|&duty| duty > 0.0).collect();
    assert!(on.len() == 7 && on.iter().all(|duty| (duty - 0.5).abs() < 1e-3), "{on:?}");
}

/// Scripts that stop the machine and make it ready again.
const STOPS: [&str; 5] = [
    "switch X stuck-closed\nexpect ALARM:1\nswitch X normal\nwait-ms 12\nsend $X\nexpect ok",
    "estop pressed\nexpect ALARM:10\nestop released\nwait-ms 12\nsend $X\nexpect ok",
    "bytes 18\nexpect Grbl",
    "bytes 18\nwait-ms 2\nbytes 18\nexpect ALARM:3\nexpect Grbl\nsend $X\nexpect ok",
    "crash\nwait-reset\nexpect [MSG:Restarted after a hard fault\nexpect Grbl",
];
/// One stop in this many is a crash, after which the chip takes a second to restart.
const CRASH_EVERY: usize = 25;

fn stops(count: usize, seed: u64) -> String {
    let mut random = Rand32::new(seed);
    let mut script = "expect Grbl\n".to_owned();
    for line in laser_settings().lines() {
        writeln!(script, "send {line}\nexpect ok").unwrap();
    }
    for number in 0..count {
        let (mode, distance_mm) = (if number % 2 == 0 { "M3" } else { "M4" }, if number % 4 < 2 { 40 } else { -40 });
        let stop = if number % CRASH_EVERY == 0 { STOPS[4] } else { STOPS[random.rand_range(0..4) as usize] };
        writeln!(script, "send {mode}S800M8G91G1F6000X{distance_mm}\nexpect ok").unwrap();
        writeln!(script, "wait-output pwm on\nwait-us {}.7\n{stop}", random.rand_range(0..60_000)).unwrap();
    }
    script
}

/// Every stop must switch the tool off, and the tool must stay off.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_stop_puts_the_tool_off_at_once() {
    let count = cases(16, 500) as usize;
    let run = Board::new("tool-stops").with(&["--start", "150,40,15"]).script(&stops(count, 7));
    assert!(run.ok, "{}", run.printed);
    let stops = run.figures["tool"]["stops"].as_array().unwrap();
    // The guard puts the inhibit on before it takes a lock. USB waits for the task that prepares a level.
    let most_us = [("X_LIMIT", 3.0), ("ESTOP", 3.0), ("RESET", 20.0), ("CRASH", 20.0)];
    let of = |input: &str| stops.iter().filter(|stop| stop["input"] == *input).collect::<Vec<_>>();
    assert!(most_us.iter().map(|(input, _)| of(input).len()).sum::<usize>() >= count, "{stops:?}");
    for (input, most_us) in most_us {
        let most_ns = of(input).iter().map(|stop| stop["outputs_off_ns"].as_f64().expect("off")).fold(0.0, f64::max);
        assert!(most_ns < 1_000.0 * most_us, "{input}: {most_ns} ns");
    }
}
