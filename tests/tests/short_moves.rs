//! Moves of one step each, which at their feed would be over long before anything could plan them, on a straight line, where
//! no corner slows them down. They are made slower, and no port runs out of steps: neither that of the axis that moves nor
//! those of the axes that stand still. Behind a hold as many of them as the machine takes are known at once.

use embassy_time::Duration;
use isostep_motion::{STRAIGHT_S, State};
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
                    let edges = made(&machine(port, speed_profile), words, is_held);
                    let short = &edges[LONG_STEPS as usize..];
                    // A step comes in the middle of its move, so there is a move less between them.
                    let lasts_s = (short[MOVES - 1].t_ns - short[0].t_ns) as f64 * 1e-9;
                    let least_s = (MOVES - 1) as f64 * STRAIGHT_S;
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
