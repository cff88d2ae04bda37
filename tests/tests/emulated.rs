//! Compares the firmware on the emulated board with the simulation and the closed form.
//!
//! A plain `cargo test` ignores these tests: `cargo xtask test` builds the firmware and then runs them. Every figure
//! here is emulated, at 125 MHz.

#[path = "emulated/blends.rs"]
mod blends;
#[path = "emulated/board_words.rs"]
mod board_words;
#[path = "emulated/boxes.rs"]
mod boxes;
#[path = "emulated/cached.rs"]
mod cached;
#[path = "emulated/contract.rs"]
mod contract;
#[path = "emulated/core_xy.rs"]
mod core_xy;
/// The dialogues of `tests/dialogues` that are for the emulated board.
mod dialogues {
    include!(concat!(env!("OUT_DIR"), "/emulated.rs"));
}
#[path = "emulated/drive_alarm.rs"]
mod drive_alarm;
#[path = "emulated/estop.rs"]
mod estop;
#[path = "emulated/evenly.rs"]
mod evenly;
#[cfg(feature = "four-axes")]
#[path = "emulated/five_motors.rs"]
mod five_motors;
#[path = "emulated/flowing.rs"]
mod flowing;
#[path = "emulated/four_axes.rs"]
mod four_axes;
#[path = "emulated/linked.rs"]
mod linked;
#[path = "emulated/output_watchdog.rs"]
mod output_watchdog;
// Its image has three axes.
#[cfg(all(unix, not(feature = "four-axes")))]
#[path = "emulated/prove.rs"]
mod prove;
#[path = "emulated/shaped.rs"]
mod shaped;
#[path = "emulated/short_moves.rs"]
mod short_moves;
#[path = "emulated/sweep.rs"]
mod sweep;
#[path = "emulated/tool.rs"]
mod tool;

use std::fs;
use std::path::{Path, PathBuf};

use isostep::chip::Chip;
use isostep_console::AXIS_NAMES;
use isostep_profile::SpeedProfile;
use isostep_report::compare::{self, Comparison};
use isostep_sim::{AXES, Port, run};
use isostep_tests::emulated::{self, Board, Run};
use isostep_tests::rig::{Emulated, Pace};
use isostep_tests::{cases, root};
use oorandom::Rand32;

const CLOCK_CYCLE_NS: f64 = 8.0;

fn program(name: &str) -> PathBuf {
    root().join("programs").join(name)
}

/// Runs a program on the board and in simulation. Panics if the steps differ.
fn held_against_simulation(board: Board, program: &Path) -> (Run, Comparison) {
    let emulated = board.program(program);
    assert!(emulated.ok, "{}", emulated.printed);
    assert_eq!(emulated.figures["driver_timing"]["violations"], 0, "{}", emulated.printed);
    let simulated = run(&fs::read(program).unwrap(), &emulated::config()).unwrap();
    for (axis, position) in AXIS_NAMES.into_iter().zip(simulated.position_steps) {
        assert_eq!(emulated.figures["axes"][axis]["position_steps"], position, "{axis}");
    }
    let comparison = compare::compare(&simulated, &emulated.edges).unwrap();
    (emulated, comparison)
}

/// Without all cases it is the beginning, in which the car is fetched.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn parking_is_the_simulations_and_within_50_ns() {
    let (all, beginning) = (program("parking.nc"), root().join("target/emulated/parking-beginning.nc"));
    let text = fs::read_to_string(&all).unwrap();
    fs::create_dir_all(beginning.parent().expect("a folder")).unwrap();
    fs::write(&beginning, text.split("; Store it").next().expect("the beginning")).unwrap();
    let (path, steps, moves) = [(beginning, 20_250, 1), (all, 72_750, 3)][isostep_trials::cases(0, 1) as usize].clone();
    let (run, comparison) = held_against_simulation(Board::new("parking"), &path);
    assert!(comparison.all.max_ns <= 50.0, "{comparison:#?}");
    assert_eq!(comparison.all.steps, steps, "{}", run.printed);
    let apart_ns: Vec<_> = comparison.moves.iter().filter_map(|each| each.apart_ns).collect();
    assert_eq!(apart_ns.len(), moves, "moves of X and Y together");
    assert!(apart_ns.iter().all(|&ns| ns < CLOCK_CYCLE_NS), "{comparison:#?}");
}

/// The largest distance of the steps of `TimerPort` from the closed form, p99. What is promised is promised for three axes; a
/// fourth takes some of the processor's time even where it rests.
const TIMER_PORT_P99_NS: f64 = if AXES == 3 { 2_000.0 } else { 3_000.0 };

/// Without all cases it is a shorter program.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_program_of_the_timer_port_is_the_simulations_and_within_2_us() {
    let name = ["square.nc", "parking.nc"][isostep_trials::cases(0, 1) as usize];
    let (run, comparison) = held_against_simulation(Board::stepped_by(Port::Timer, "program-timer"), &program(name));
    assert!(comparison.all.p99_ns <= TIMER_PORT_P99_NS, "{comparison:#?}");
    assert!(comparison.all.steps > 10_000, "{}", run.printed);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn diagonal_by_uart_with_a_full_window_is_the_simulations() {
    let board = Board::new("diagonal").with(&["--console", "uart", "--stream", "counting"]);
    held_against_simulation(board, &program("diagonal.nc"));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_same_program_gives_the_same_bytes() {
    let (first, _) = held_against_simulation(Board::new("square-1"), &program("square.nc"));
    let (second, _) = held_against_simulation(Board::new("square-2"), &program("square.nc"));
    assert_eq!(first.figures, second.figures);
    assert_eq!(first.edges, second.edges);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_stop_leaves_the_exact_count_of_the_edges_that_left() {
    cases::stops_leave_the_exact_count(Emulated(Port::Pio));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_stop_of_the_timer_port_leaves_the_exact_count_of_the_edges_that_left() {
    cases::stops_leave_the_exact_count(Emulated(Port::Timer));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn moves_there_and_back_are_exact() {
    cases::moves_there_and_back_are_exact(Emulated(Port::Pio));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn moves_there_and_back_by_the_timer_port_are_exact() {
    cases::moves_there_and_back_are_exact(Emulated(Port::Timer));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_speed_profile_is_exact() {
    cases::every_speed_profile_is_exact(Emulated(Port::Pio), Pace::GANTRY, 2);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn single_steps_take_as_long_as_planned() {
    cases::single_steps_take_as_long_as_planned(Emulated(Port::Pio), 200.0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn single_steps_by_the_timer_port_take_as_long_as_planned() {
    cases::single_steps_take_as_long_as_planned(Emulated(Port::Timer), 200.0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_speed_profile_by_the_timer_port_is_exact() {
    cases::every_speed_profile_is_exact(Emulated(Port::Timer), Pace::GANTRY, 4);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn cold_starts_are_in_time_and_within_50_ns() {
    cases::cold_starts_are_exact(Emulated(Port::Pio), 50.0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn cold_starts_by_the_timer_port_are_in_time_and_within_20_us() {
    // A step may wait for two steps of the other axes and for code that masks interrupts while lines are read and
    // answered. A step period is 50 us.
    cases::cold_starts_are_exact(Emulated(Port::Timer), 20_000.0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_highest_rate_the_port_takes_is_made() {
    cases::the_highest_rate_is_made(Emulated(Port::Pio), 297_618);
}

/// The emulated board's chip.
fn chip() -> Chip {
    if emulated::is_pico_2() { Chip::Rp2350 } else { Chip::Rp2040 }
}

/// As the tools call it that look for the drive.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn boot_names_the_drive_of_the_boards_chip() {
    let script = format!(
        "expect Grbl\nsend $BOOT\nexpect [MSG:The board becomes the USB drive {}: copy\nexpect ok\nexpect-bootsel\n",
        chip().drive()
    );
    let run = Board::new("boot-drive").script(&script);
    assert!(run.ok, "{}", run.printed);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_host_that_stops_reading_does_not_stop_the_machine() {
    let mut script = "expect Grbl\nsend G0 X20\nexpect ok\nreading off\n".to_owned();
    // Many more status reports than the firmware has room for.
    script += &"bytes 3f 3f 3f 3f 3f 3f 3f 3f\nwait-ms 20\n".repeat(60);
    script += "reading on\nwait-ms 500\nsend $X\nexpect ok\nwait-idle\nbytes 3f\nexpect <Idle|MPos:20.000\n";
    let run = Board::new("deaf-host").script(&script);
    assert!(run.ok, "{}", run.printed);
    assert_eq!(run.edges.len(), 1_000);
    // The report of which the host received half is ended once, and the reports after it are whole and on lines of
    // their own.
    let heard: Vec<_> = run.printed.lines().filter_map(|line| line.split_once(" < ")).map(|(_, heard)| heard).collect();
    let is_half = |line: &&&str| line.starts_with('<') && !(line.ends_with('>') && line.matches('<').count() == 1);
    let halves: Vec<_> = heard.iter().filter(is_half).collect();
    assert!(halves.len() == 1 && !halves[0][1..].contains('<'), "half a line: {halves:?}");
    assert_eq!(heard.iter().filter(|line| **line == "ok").count(), 2, "the answers to G0 and $X");
    assert!(heard.iter().all(|line| !line.is_empty()), "an empty line");
}

/// The tasks of the axes get no time for a while. The state machine that runs dry must halt and not stretch an interval, and
/// must stop the other axes itself: within an interval, not when a task hears of it.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_port_that_runs_out_of_steps_locks_the_machine() {
    let mut script = "expect Grbl\nsend $0=0\nexpect ok\n".to_owned();
    for axis in 0..AXES as u32 {
        let settings = [(110, 14_880), (100, 1_000), (120, 100_000)];
        script.extend(settings.map(|(number, value)| format!("send ${}={value}\nexpect ok\n", number + axis)));
    }
    script += "send G0 X100 Y100 Z100\nexpect ok\nwait-ms 200\nmask-irq 28\nwait-ms 12\nunmask-irq 28\nexpect ALARM:22\nexpect [MSG:the step port of\n";
    script += "send $I\nexpect [MSG:step ports faulted\nexpect ok\nbytes 3f\nexpect <Alarm\n";
    let run = Board::new("underrun").script(&script);
    assert!(run.ok, "{}", run.printed);
    let report = run.printed.lines().rfind(|line| line.contains("< <Alarm|")).unwrap();
    // With 1,000 steps/mm the three decimals of the report are steps.
    let reported: Vec<i32> =
        report.split(['|', ':', ',']).skip(2).take(3).map(|mm| mm.replace('.', "").parse().unwrap()).collect();
    let seen = [0, 1, 2].map(|axis| run.edges.iter().filter(|edge| edge.axis == axis).count() as i32);
    assert_eq!(reported, seen, "{report}");
    assert!(seen.iter().all(|&steps| (1..100_000).contains(&steps)), "{seen:?}");
    let last_ns = [0, 1, 2].map(|axis| run.edges.iter().rfind(|edge| edge.axis == axis).unwrap().t_ns);
    let spread_ns = last_ns.iter().max().unwrap() - last_ns.iter().min().unwrap();
    assert!(spread_ns <= 4_000, "last edges at {last_ns:?} ns");
}

/// Offsets that change in the middle of a program are stored when the moves before them have ended. Every edge of those
/// moves must be at the same instant as in a run without the change; erasing a sector would delay an edge by 45 ms.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn nothing_is_stored_while_steps_are_made() {
    let moves = |test, between: &str, offset_mm: u8| {
        let script = format!(
            "expect Grbl\nsend G0 X20 Y15\nexpect ok\n{between}send G0 X0 Y0\nexpect ok\nwait-idle\ncheck-position\n\
             send $#\nexpect [G55:{offset_mm}.000\nexpect ok\npower-cycle\nexpect Grbl\n\
             send $#\nexpect [G55:{offset_mm}.000\nexpect ok\n",
        );
        let run = Board::new(test).script(&script);
        assert!(run.ok, "{}", run.printed);
        run.edges
    };
    // Without the dwell, both moves would be in one run, on one clock.
    let rest = "send G4 P0\nexpect ok\n";
    let (plain, stored) = (moves("store-plain", rest, 0), moves("store-moving", "send G10 L2 P2 X5\nexpect ok\n", 5));
    assert_eq!(plain.len(), stored.len());
    // The edges of each move are compared relative to its first edge.
    for half in [0..plain.len() / 2, plain.len() / 2..plain.len()] {
        let from_first = |edges: &[isostep_sim::world::Edge]| -> Vec<_> {
            let first_ns = edges[half.start].t_ns;
            edges[half.clone()].iter().map(|edge| (emulated::cycles(edge.t_ns - first_ns), edge.axis)).collect()
        };
        assert_eq!(from_first(&plain), from_first(&stored));
    }
}

/// Three axes with the same distance must make each step on the same clock cycle, from the first step on.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn all_axes_start_on_the_same_cycle() {
    let run = Board::new("same-cycle").script("expect Grbl\nsend G0 X10 Y10 Z10\nexpect ok\nwait-idle\n");
    assert!(run.ok, "{}", run.printed);
    assert_eq!(run.edges.len(), 3 * 500);
    assert!(run.edges.chunks(3).all(|step| step.iter().all(|edge| edge.t_ns == step[0].t_ns)));
}

/// Three axes at 240,000 steps/s. Whatever stops them, the last edge may come at most 1.5 us later: the guard inhibits before
/// it takes a lock, and what masks interrupts in a move takes less than the rest. Without the inhibit it would take tens of
/// microseconds, until the tasks of the axes run, and 5 us if it were put on when the stop is decided.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn every_stop_takes_less_than_1_5_us() {
    let mut script = "expect Grbl\nsend $0=0\nexpect ok\n".to_owned();
    for axis in 0..AXES as u32 {
        let settings = [(110, 288_000), (120, 100_000)];
        script.extend(settings.map(|(number, value)| format!("send ${}={value}\nexpect ok\n", number + axis)));
    }
    let stops = [
        "switch X stuck-closed\nexpect ALARM:1\nswitch X normal",
        "switch Y stuck-closed\nexpect ALARM:1\nswitch Y normal",
        "switch Z stuck-closed\nexpect ALARM:1\nswitch Z normal",
        "estop pressed\nexpect ALARM:10\nestop released",
        "bytes 18\nwait-ms 5\nbytes 18\nexpect ALARM:3\nexpect Grbl",
        // The reset byte follows another byte in the same packet.
        "bytes 18\nwait-ms 5\nbytes 3f 18\nexpect ALARM:3\nexpect Grbl",
    ];
    let stops_made = isostep_trials::cases(12, 90) as usize;
    for (index, stop) in stops.iter().cycle().take(stops_made).enumerate() {
        let (target_mm, wait_us) = (if index % 2 == 0 { 900 } else { 0 }, 60_000 + 997 * index);
        script += &format!("send G0 X{target_mm} Y{target_mm} Z{target_mm}\nexpect ok\nwait-us {wait_us}.3\n");
        script += &format!("{stop}\nwait-ms 20\nsend $X\nexpect ok\ncheck-position\n");
    }
    // A carriage that moves beyond its switch presses it. So the carriages start far from their switches.
    let run = Board::new("stop-latency").with(&["--start", "900,900,900"]).script(&script);
    assert!(run.ok, "{}", run.printed);
    let stops = run.figures["stops"].as_array().unwrap();
    assert!(stops.len() >= stops_made, "{stops:?}");
    for stop in stops {
        assert!(stop["latency_ns"].as_f64().unwrap() <= 1_500.0, "{stop}");
    }
}

/// The guard inhibits for a press before anything is decided, but not in homing, which looks for the switches: presses that are
/// over before any code runs, while it begins and moves, change nothing. Where it ends and a move begins, each either stops
/// the machine with an alarm or does nothing: an inhibit without an alarm would hold the axes for ever.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn presses_while_homing_begins_lasts_and_ends_inhibit_nothing() {
    let begin = "expect Grbl\nsend $24=600\nexpect ok\nsend $25=2880\nexpect ok\nsend $26=1\nexpect ok\n";
    let press = |axis: char, wait_us: f64| {
        format!("wait-us {wait_us:.3}\nswitch {axis} stuck-closed\nwait-us 0.1\nswitch {axis} normal\n")
    };
    let mut random = Rand32::new(4);
    // With both levels of DIR: the emulator counts with that of the default.
    for (test, directions, check) in
        [("homing-presses-low", "$3=0\n$23=7", "check-position\n"), ("homing-presses-high", "$3=7\n$23=0", "")]
    {
        let set = directions.lines().map(|line| format!("send {line}\nexpect ok\n")).collect::<String>();
        let board = || Board::new(test).with(&["--start", "10,6,10", "--bounce-us", "300"]);
        let plain = board().script(&format!("{begin}{set}send $HZ\nexpect ok\nsend $HZ\nexpect ok\nwait-idle\n"));
        assert!(plain.ok, "{}", plain.printed);
        let mut script = format!("{begin}{set}send $HZ\n");
        // Z is pressed before it can have met its switch; after that a press would have its level debounced anew.
        script.extend((0..20).map(|index| press(['Z', 'X', 'Y'][index % 3], 100.0 * f64::from(random.rand_float()))));
        script.extend((0..60).map(|index| press(['X', 'Y'][index % 2], 9_000.0 * f64::from(random.rand_float()))));
        script += "expect ok\nsend $HZ\nexpect ok\nwait-idle\nbytes 3f\nexpect <Idle\n";
        let pressed = board().script(&script);
        assert!(pressed.ok, "{}", pressed.printed);
        let steps = |run: &Run| run.edges.iter().map(|edge| (edge.axis, edge.direction)).collect::<Vec<_>>();
        assert_eq!(steps(&pressed), steps(&plain), "{test}");

        let reported_s = |run: &Run, what: &str| -> Vec<f64> {
            let reported = run.printed.lines().filter(|line| line.ends_with(what));
            reported.map(|line| line.trim_start().split(' ').next().unwrap().parse().unwrap()).collect()
        };
        let lasts_us = 1e6 * (reported_s(&plain, "< ok").last().unwrap() - reported_s(&plain, "> $HZ").last().unwrap());
        let mut script = format!("{begin}{set}send $HZ\nexpect ok\n");
        for _ in 0..isostep_trials::cases_that_count(8, 40) {
            let wait_us = lasts_us - 1_500.0 + 6_000.0 * f64::from(random.rand_float());
            script += &format!("send $HZ\nsend G91G0X1F600\n{}wait-ms 300\nsend $X\n", press('X', wait_us));
            script += &format!("wait-ms 20\n{check}send G0X-0.5\nwait-ms 300\nbytes 3f\nexpect <Idle\n");
        }
        let ended = board().script(&script);
        assert!(ended.ok, "{}", ended.printed);
        let alarms = ended.printed.matches("< ALARM:1").count();
        assert!((2..8).contains(&alarms) || isostep_trials::cases_that_count(8, 40) > 8, "{alarms}: {}", ended.printed);
    }
}

/// Moves of three axes are held, resumed and slowed down at some thirty instants. No step may be lost or off the path.
fn holds_and_overrides_lose_nothing(board: Board, speed_profile: u32) {
    let mut script = format!("expect Grbl\nsend $940={speed_profile}\nexpect ok\nsend G90\nexpect ok\n");
    // Each second one leads back to the start.
    let rounds = isostep_trials::cases_that_count(2, 10);
    for index in 0..rounds {
        let wait_ms = 150 + 83 * index;
        let target = if index % 2 == 0 { "X40 Y23 Z3" } else { "X0 Y0 Z0" };
        script += &format!("send G1 {target} F2400\nexpect ok\nwait-ms {wait_ms}\nbytes 92 92 92\nwait-ms 130\n");
        script += "bytes 21\nwait-ms 1500\nbytes 3f\nexpect <Hold:0\ncheck-position\nwait-ms 50\ncheck-position\n";
        script +=
            "bytes 90\nbytes 7e\nwait-ms 200\nbytes 21\nwait-ms 1500\nbytes 3f\nexpect <Hold:0\nbytes 7e\nwait-idle\n";
    }
    let run = board.script(&(script + "bytes 3f\nexpect <Idle|MPos:0.000,0.000,0.000\n"));
    assert!(run.ok, "{}", run.printed);
    // The distances there and back, in steps.
    let totals = [2_000.0, 1_150.0, 150.0];
    let mut made = [0_i64; 3];
    for together in run.edges.chunk_by(|one, next| next.t_ns - one.t_ns < 20_000) {
        for edge in together {
            made[edge.axis] += i64::from(edge.direction);
        }
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let apart = (made[i] as f64 / totals[i] - made[j] as f64 / totals[j]).abs();
            // The bound is half a step of each axis, plus what a step's duration adds where edges coincide.
            let bound = 0.5 / totals[i] + 0.5 / totals[j] + 0.1 / totals[0];
            assert!(apart <= bound, "{made:?} after {} ns: {apart} is more than {bound}", together[0].t_ns);
        }
    }
    assert_eq!(run.edges.len(), rounds as usize * (2_000 + 1_150 + 150));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn holds_and_overrides_lose_no_step() {
    holds_and_overrides_lose_nothing(Board::new("hold"), 0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn holds_and_overrides_of_an_s_curve_lose_no_step() {
    holds_and_overrides_lose_nothing(Board::new("hold-s-curve"), 1);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn holds_and_overrides_by_the_timer_port_lose_no_step() {
    holds_and_overrides_lose_nothing(Board::stepped_by(Port::Timer, "hold-timer"), 0);
}

/// Three axes up to 200 mm/s at 4,000 mm/s2, the logarithmic speed profile at 1,000. On these ramps segments take longer to
/// compile than they last. The ramps begin at standstill for the speed profiles that can.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn steep_ramps_of_every_speed_profile_are_compiled_in_time() {
    let tops = &[12_000, 2_880][..isostep_trials::cases(1, 2) as usize];
    for (number, speed_profile) in SpeedProfile::ALL.into_iter().enumerate().step_by(isostep_trials::stride(4)) {
        let accel = if speed_profile == SpeedProfile::Logarithmic { 1_000 } else { 4_000 };
        let start = if speed_profile.is_over_displacement() { 120 } else { 0 };
        let mut script = "expect Grbl\nsend G91\nexpect ok\n".to_owned();
        for (top, axis) in tops.iter().flat_map(|&top| (0..AXES).map(move |axis| (top, axis))) {
            let settings = [(910, start), (110, top), (120, accel), (930, 80_000)];
            script.extend(settings.map(|(number, value)| format!("send ${}={value}\nexpect ok\n", number + axis)));
            if axis == AXES - 1 {
                script += &format!("send $940={number}\nexpect ok\n");
                script += "send G0 X60 Y55 Z50\nexpect ok\nsend G0 X-60 Y-55 Z-50\nexpect ok\nwait-idle\n";
            }
        }
        let run = Board::new(&format!("steep-{speed_profile}"))
            .script(&(script + "bytes 3f\nexpect <Idle|MPos:0.000,0.000,0.000\n"));
        assert!(run.ok, "{speed_profile}: {}", run.printed);
        assert_eq!(run.edges.len(), 2 * tops.len() * (3_000 + 2_750 + 2_500), "{speed_profile}");
    }
}

/// At 4,000 mm/s2, where a full queue is a few milliseconds of motion. Overrides come faster than they take effect, and
/// a hold comes before the last of them has.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn changes_in_quick_succession_lose_no_step() {
    let mut script = "expect Grbl\nsend G90\nexpect ok\n".to_owned();
    for axis in 0..AXES as u32 {
        let settings = [(110, 12_000), (120, 4_000)];
        script.extend(settings.map(|(number, value)| format!("send ${}={value}\nexpect ok\n", number + axis)));
    }
    let rounds = isostep_trials::cases_that_count(6, 10);
    for index in 0..rounds {
        let target = if index % 2 == 0 { "X60 Y55 Z50" } else { "X0 Y0 Z0" };
        script += &format!("send G1 {target} F12000\nexpect ok\nwait-edge\nwait-ms {}\n", 1 + 13 * index);
        script +=
            &["92", "91", "94", "93", "92"].map(|byte| format!("bytes {byte}\nwait-us 1700\n")).concat().repeat(2);
        script += "bytes 21\nwait-ms 900\nbytes 3f\nexpect <Hold:0\ncheck-position\nbytes 90\nbytes 7e\nwait-idle\n";
    }
    let run = Board::new("quick-succession").script(&(script + "bytes 3f\nexpect <Idle|MPos:0.000,0.000,0.000\n"));
    assert!(run.ok, "{}", run.printed);
    assert_eq!(run.edges.len(), rounds as usize * (3_000 + 2_750 + 2_500));
}
