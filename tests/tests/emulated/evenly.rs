//! Moves that are over sooner than a curved speed profile can be compiled for them, were they made at their feed. Every speed
//! profile must make them, slowly and evenly.

use std::fmt::Write as _;
use std::fs;

use isostep_profile::SpeedProfile;
use isostep_report::compare;
use isostep_sim::world::Edge;
use isostep_sim::{AXES, Config, Port, run};
use isostep_tests::emulated::{self, Board};
use isostep_tests::root;
use isostep_trials::stride;

/// The settings of the first axis, which all have: F6000 is reached within 2 mm. The speed profiles over displacement cannot
/// start from standstill.
const MACHINE: [(u32, u32); 4] = [(100, 80), (110, 24_000), (120, 10_000), (930, 300_000)];
const START: (u32, u32) = (910, 60);
const STEPS_PER_MM: f64 = 80.0;
/// Moves of a kind in a row.
const MOVES: usize = 60;
/// The time over which a speed is measured.
const WINDOW_NS: u64 = 50_000_000;

fn settings(number: usize, speed_profile: SpeedProfile) -> Vec<String> {
    let start = speed_profile.is_over_displacement().then_some(START);
    let each = MACHINE
        .into_iter()
        .chain(start)
        .flat_map(|(first, value)| (0..AXES as u32).map(move |axis| (first + axis, value)));
    each.map(|(number, value)| format!("${number}={value}"))
        .chain([format!("$940={number}"), "G61 G91".into()])
        .collect()
}

/// Moves of `mm`, in a line or in a zigzag.
fn short(mm: f64, is_straight: bool) -> impl Iterator<Item = String> {
    (0..MOVES).map(move |index| {
        let side = if is_straight || index % 2 == 0 { 0.6 } else { -0.6 };
        format!("X{:.4}Y{:.4}Z{:.4}", 0.7 * mm, side * mm, 0.3 * mm)
    })
}

/// The lowest and the highest speed over a window along the path, mm/s.
fn speeds_mm_s(edges: &[Edge]) -> [f64; 2] {
    let begin_ns = edges[0].t_ns;
    let mut windows: Vec<[i32; 3]> = Vec::new();
    for edge in edges {
        let window = ((edge.t_ns - begin_ns) / WINDOW_NS) as usize;
        windows.resize(windows.len().max(window + 1), [0; 3]);
        windows[window][edge.axis] += 1;
    }
    // The last window is not whole.
    let speeds = windows[..windows.len() - 1].iter().map(|steps| {
        let square: i32 = steps.iter().map(|steps| steps * steps).sum();
        f64::from(square).sqrt() / STEPS_PER_MM / (WINDOW_NS as f64 * 1e-9)
    });
    speeds.fold([f64::INFINITY, 0.0], |[low, high], speed| [low.min(speed), high.max(speed)])
}

/// A long move, then short ones: every edge is where the simulation has it, so that none was late. The speed of the short
/// ones is even: it is limited by the time that each of them takes to compile, and this is the same for all. A quarter is
/// for the beginning, where the S-curve takes several moves to speed up.
fn are_even(port: Port, feed_mm_min: u32, jitter_max_ns: f64) {
    for (number, speed_profile) in SpeedProfile::ALL.into_iter().enumerate().step_by(stride(4)) {
        let mut text = settings(number, speed_profile).join("\n");
        writeln!(text, "\nG1 F{feed_mm_min} X20").unwrap();
        let kinds = [(0.2, false), (0.2, true), (0.05, false)];
        for line in kinds.into_iter().flat_map(|(mm, is_straight)| short(mm, is_straight)).chain(["X10".into()]) {
            writeln!(text, "{line}").unwrap();
        }
        let test = format!("evenly-{port}-{speed_profile}");
        let path = root().join("target/emulated").join(format!("{test}.nc"));
        fs::create_dir_all(path.parent().expect("a folder")).unwrap();
        fs::write(&path, &text).unwrap();
        let board = Board::stepped_by(port, &test).with(&["--start", "300,300,300", "--stream", "counting"]);
        let emulated = board.program(&path);
        assert!(emulated.ok, "{speed_profile}: {}", emulated.printed);

        let simulated = run(text.as_bytes(), &Config { port, ..emulated::config() }).unwrap();
        let comparison = compare::compare(&simulated, &emulated.edges).unwrap();
        assert!(comparison.all.max_ns <= jitter_max_ns, "{speed_profile}: {:?}", comparison.all);
        // Where X is, in steps, when moves of another kind begin. The first of them may be faster, or slower.
        let places = [20.7, 28.4, 36.8].map(|mm| (mm * STEPS_PER_MM) as i32);
        let [first, second, end] = places.map(|place| {
            let is_there = |edge: &Edge| edge.axis == 0 && edge.position_steps == place;
            emulated.edges.iter().position(is_there).expect("X comes by")
        });
        for edges in [&emulated.edges[first..second], &emulated.edges[second..end]] {
            let [low, high] = speeds_mm_s(edges);
            println!(
                "{speed_profile}: {low:.1} to {high:.1} mm/s; at most {:.0} ns off (emulated)",
                comparison.all.max_ns
            );
            assert!(low >= 0.75 * high, "{speed_profile}: {low} to {high} mm/s");
        }
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn short_moves_of_every_speed_profile_slow_down_evenly() {
    are_even(Port::Pio, 6_000, 50.0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn short_moves_of_every_speed_profile_by_the_timer_port_slow_down_evenly() {
    are_even(Port::Timer, 24_000, 20_000.0);
}

/// Long moves of one axis, of two and of three, at feeds that no processor makes the steps of: by every speed profile they are as
/// slow as it takes, and no step is late. The cruise is longer than the queues are.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn long_moves_of_the_timer_port_are_as_slow_as_their_steps_in_every_speed_profile() {
    for (number, speed_profile) in SpeedProfile::ALL.into_iter().enumerate().step_by(stride(4)) {
        let accel_mm_s2 = [3_000, 1_500, 700, 10_000][number % 4];
        let mut text =
            settings(number, speed_profile).join("\n").replace("=24000", "=60000\n$130=900\n$131=900\n$132=900");
        (0..3).for_each(|axis| write!(text, "\n${}={accel_mm_s2}", 120 + axis).unwrap());
        let lines = [(2, "X550"), (2, "X-140Y140"), (2, "X90Y-90Z90"), (2, "X-50Y-40Z-90"), (5, "X-100Y-10")];
        for (pulse_us, line) in lines {
            write!(text, "\n$0={pulse_us}\nG1 F60000 {line}\nG4 P0").unwrap();
        }
        let test = format!("long-{speed_profile}");
        let path = root().join("target/emulated").join(format!("{test}.nc"));
        fs::create_dir_all(path.parent().expect("a folder")).unwrap();
        fs::write(&path, text + "\n").unwrap();
        let board = Board::stepped_by(Port::Timer, &test).with(&["--start", "300,300,300"]);
        let emulated = board.program(&path);
        assert!(emulated.ok, "{speed_profile}: {}", emulated.printed);
        let mut config = Config { port: Port::Timer, start_mm: [300.0; AXES], ..emulated::config() };
        config.settings.travel_mm = [900.0; AXES];
        let simulated = run(&fs::read(&path).unwrap(), &config).unwrap();
        let comparison = compare::compare(&simulated, &emulated.edges).unwrap();
        println!("{speed_profile}: at most {:.0} ns off (emulated)", comparison.all.max_ns);
        assert!(comparison.all.max_ns <= 20_000.0, "{speed_profile}: {:?}", comparison.all);
    }
}

/// Overrides up to 200 %, a hold in the middle of short moves, and a resume: no alarm, and no step lost.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn short_moves_of_every_speed_profile_are_overridden_and_held() {
    for (port, (number, speed_profile)) in
        Port::ALL.into_iter().cycle().zip(SpeedProfile::ALL.into_iter().enumerate()).step_by(stride(4))
    {
        let begin = settings(number, speed_profile).into_iter().chain(["G1 F3000 X5".into()]);
        let mut script = "expect Grbl\n".to_owned();
        let changes = ["91 91 91 91 91 91 91 91 91 91", "21\nwait-ms 500\nbytes 7e", "90", "92 92 92 92 92", "90"];
        let mut changes = changes.into_iter().cycle();
        for (index, line) in begin.chain(short(0.2, false)).chain(short(0.2, true)).chain(["X5".into()]).enumerate() {
            writeln!(script, "send {line}\nexpect ok").unwrap();
            if index % 15 == 14 {
                writeln!(script, "bytes {}", changes.next().unwrap()).unwrap();
            }
        }
        script += "wait-idle\nbytes 3f\nexpect <Idle|MPos:26.800,7.200,7.200\n";
        let run = Board::stepped_by(port, &format!("evenly-changed-{speed_profile}")).script(&script);
        assert!(run.ok, "{speed_profile} {port}: {}", run.printed);
    }
}
