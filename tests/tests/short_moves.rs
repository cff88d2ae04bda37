//! Moves of one step each, which at their feed would be over long before anything could plan them, on a straight line, where
//! no corner slows them down. They are made slower, and no port runs out of steps: neither that of the axis that moves nor
//! those of the axes that stand still. Behind a hold as many of them as the machine takes are known at once.

use embassy_time::Duration;
use isostep_motion::{LeastTimes, State};
use isostep_profile::SpeedProfile;
use isostep_sim::world::Edge;
use isostep_sim::{AXES, Config, Port, Sim};
use isostep_tests::axes::xyz_a;

const MOVES: usize = 200;
const STEPS_PER_MM: f32 = 400.0;
/// The steps of a move before them, which lasts until many of them are known.
const LONG_STEPS: i32 = 800;

/// A machine that could make a step every 12.5 us.
fn machine(port: Port, speed_profile: usize) -> Config {
    let mut config = Config { port, ..Config::default() };
    let settings = &mut config.settings;
    settings.speed_profile = speed_profile as u16;
    (settings.steps_per_mm, settings.max_rate_mm_min) = ([STEPS_PER_MM; AXES], [12_000.0; AXES]);
    (settings.accel_mm_s2, settings.jerk_or_0_mm_s3) = ([10_000.0; AXES], [300_000.0; AXES]);
    // The speed profiles over displacement cannot start from standstill.
    let start_mm_min = if SpeedProfile::ALL[speed_profile].is_over_displacement() { 60.0 } else { 0.0 };
    settings.start_rate_mm_min = [start_mm_min; AXES];
    config
}

/// The edges of the long move and the short ones, with corners as `words` says.
fn made(config: &Config, words: &str, is_held: bool) -> Vec<Edge> {
    let name = format!("{}, speed profile {}, {words}, held: {is_held}", config.port, config.settings.speed_profile);
    let mut sim = Sim::new(config);
    sim.run_until_idle().unwrap();
    let short: String = (1..=MOVES).map(|index| format!("X{:.4}\n", 2.0 + index as f32 / STEPS_PER_MM)).collect();
    sim.send(format!("{words}\nG90 G1 F600 X2\nF12000\n{short}").as_bytes());
    if is_held {
        sim.run_for(Duration::from_millis(100)).unwrap();
        sim.send(b"!");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.machine().state(), State::Hold { still: true }, "{name}");
        sim.send(b"~");
    }
    sim.run_until_idle().unwrap();
    assert_eq!(sim.machine().state(), State::Idle, "{name}: {:?}", sim.replies());
    let outcome = sim.outcome();
    assert_eq!(outcome.counted_steps, xyz_a([LONG_STEPS + MOVES as i32, 0, 0], 0), "{name}");
    assert!(outcome.violations.is_empty() && outcome.losses.is_empty(), "{name}");
    outcome.edges
}

#[test]
fn short_moves_straight_on_are_slower_and_never_an_alarm() {
    for port in Port::ALL {
        for speed_profile in 0..SpeedProfile::ALL.len() {
            for words in ["G61", "G64 P0.01 Q0", "$904=0", "$11=1\nG61"] {
                for is_held in [false, true] {
                    let config = machine(port, speed_profile);
                    let edges = made(&config, words, is_held);
                    let short = &edges[LONG_STEPS as usize..];
                    // A step comes in the middle of its move, so there is a move less between them.
                    let lasts_s = (short[MOVES - 1].t_ns - short[0].t_ns) as f64 * 1e-9;
                    let least_s = (MOVES - 1) as f64 * config.least_times.straight_s;
                    assert!(
                        lasts_s > 0.999 * least_s,
                        "{port}, speed profile {speed_profile}, {words}, held: {is_held}: {lasts_s} s"
                    );
                    let is_trapezoid = speed_profile == 0 && port == Port::Pio;
                    assert!(!is_trapezoid || lasts_s < 1.1 * least_s, "{words}, held: {is_held}: {lasts_s} s");
                }
            }
        }
    }
}

/// A path of moves of 0.05 mm at 100 mm/s, each of which lasts as long as the board takes for it: how long one is, s.
fn bound_s(config: &Config, words: &str) -> f64 {
    let mut sim = Sim::new(config);
    sim.run_until_idle().unwrap();
    let curve: String = (1..=300).map(|index| format!("X{:.2} Y{}\n", 0.05 * f64::from(index), index % 2)).collect();
    sim.send(format!("$904=1\nG90 {words}\nG1 F6000\n{curve}").replace("Y1", "Y0.0004").as_bytes());
    sim.run_until_idle().unwrap();
    let outcome = sim.outcome();
    assert_eq!(outcome.alarm_code, None, "{words}: {:?}", sim.replies());
    let moves: Vec<_> = outcome.program_moves().collect();
    assert_eq!(moves.len(), 300, "{words}: one for each line");
    (moves[250].begin_ns() - moves[50].begin_ns()) as f64 * 1e-9 / 200.0
}

/// The times of the board make these moves as long as they are, and nothing else does: a board that takes twice as long makes
/// them twice as long.
#[test]
fn a_board_with_twice_the_times_makes_short_moves_twice_as_long() {
    let mut config = Config { only_time: true, ..machine(Port::Pio, 0) };
    config.settings.soft_limits = false;
    let twice = |config: &Config| {
        let LeastTimes { straight_s, blend_s, shaped_s, box_s, .. } = config.least_times;
        let [straight_s, blend_s, shaped_s, box_s] = [straight_s, blend_s, shaped_s, box_s].map(|s| 2.0 * s);
        let least_times = LeastTimes { straight_s, blend_s, shaped_s, box_s, ..config.least_times };
        Config { least_times, ..config.clone() }
    };
    let zv = "$950=1\n$951=1\n$952=1\nG64 P0.05 Q0";
    let boxes = "$950=5\n$951=5\n$952=5\n$960=100\n$961=100\n$962=100\nG64 P0.05 Q0";
    let LeastTimes { straight_s, blend_s, shaped_s, box_s, .. } = config.least_times;
    for (words, least_s) in [("G61", straight_s), ("G64 P0.05 Q0", blend_s), (zv, shaped_s), (boxes, box_s)] {
        for (config, least_s) in [(config.clone(), least_s), (twice(&config), 2.0 * least_s)] {
            let lasts_s = bound_s(&config, words);
            assert!((lasts_s / least_s - 1.0).abs() < 1e-5, "{words}: {lasts_s} s for {least_s}");
        }
    }
}

/// The same for chords of 0.05 mm of a circle that are taken together.
#[test]
fn a_board_with_twice_the_times_takes_twice_as_long_for_moves_that_it_takes_together() {
    let lasts_s = |times: f64| {
        let mut config = Config { only_time: true, ..machine(Port::Pio, 0) };
        config.settings.soft_limits = false;
        let LeastTimes { blend_s, together_s, join_s, .. } = &mut config.least_times;
        [blend_s, together_s, join_s].into_iter().for_each(|s| *s *= times);
        let mut sim = Sim::new(&config);
        sim.run_until_idle().unwrap();
        let chord = |index: u32| {
            let (sin, cos) = (f64::from(index) * 0.05 / 5.0).sin_cos();
            format!("X{:.4} Y{:.4}\n", 5.0 * sin, 5.0 - 5.0 * cos)
        };
        sim.send(format!("$11=1\nG90 G64 P0.02\nG1 F12000\n{}", (1..=600).map(chord).collect::<String>()).as_bytes());
        sim.run_until_idle().unwrap();
        let outcome = sim.outcome();
        let moves: Vec<_> = outcome.program_moves().collect();
        assert!(moves.len() < 120, "{}: several chords are one move", moves.len());
        (moves[moves.len() - 1].begin_ns() - moves[0].begin_ns()) as f64 * 1e-9
    };
    // Such a board is slow enough for its times alone to count.
    let [twice_s, four_times_s] = [2.0, 4.0].map(lasts_s);
    assert!((four_times_s / twice_s / 2.0 - 1.0).abs() < 0.01, "{four_times_s} s for twice {twice_s} s");
}
