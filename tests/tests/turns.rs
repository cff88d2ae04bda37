//! Where an axis turns in a blend just beyond an edge, and passes the edge again on the line after it, the two steps are
//! made as far apart as the driver needs. With usual drivers this takes an edge within some 1e-7 steps of where an axis
//! turns; here the driver is slow, so that a program is soon found in which it happens.

use isostep_motion::{AXES, DriverTiming, State};
use isostep_sim::{Config, Port, Sim};

const PERIOD_NS: u64 = 950_000;
const SLOW: DriverTiming = DriverTiming { period_ns: PERIOD_NS as u32, ..DriverTiming::DRV8825 };
const ZIGZAG: &str = "G64 P0.02\nG1 F664\nX0.828 Y2\nX0.426 Y2.439\nX0.134 Y2.753\nX0.555 Y3.406\nX0.898 Y3.834\n\
    X0.538 Y4.172\nX0.202 Y4.718\nX0.504 Y5.211\nX0.938 Y5.551\nX0.429 Y5.658\nX0.927 Y6.072\nX1.457 Y6.365\n\
    X1.456 Y6.479\nX1.744 Y7.048\nX1.297 Y7.661\nX1.269 Y7.979\nX1.770 Y8.479\nX1.704 Y8.787\nX1.578 Y8.889\n\
    X1.833 Y8.989\nX1.373 Y9.491\n";

#[test]
fn a_step_back_follows_no_sooner_than_a_driver_takes_it() {
    for port in Port::ALL {
        let mut config = Config { port, driver: SLOW, ..Config::default() };
        let settings = &mut config.settings;
        (settings.steps_per_mm, settings.max_rate_mm_min) = ([80.0; AXES], [750.0; AXES]);
        (settings.accel_mm_s2, settings.start_rate_mm_min) = ([1_500.0; AXES], [0.0; AXES]);
        let mut sim = Sim::new(&config);
        sim.run_until_idle().unwrap();
        sim.send(ZIGZAG.as_bytes());
        sim.run_until_idle().unwrap();
        assert_eq!(
            (sim.machine().state(), sim.counted_steps()[..2].to_vec()),
            (State::Idle, vec![110, 759]),
            "{port:?}"
        );
        let outcome = sim.outcome();
        let rises = |axis| outcome.edges.iter().filter(move |edge| edge.axis == axis);
        let pairs = (0..AXES).flat_map(|axis| rises(axis).zip(rises(axis).skip(1)));
        let turns = pairs.filter(|(one, next)| one.direction != next.direction);
        let nearest_ns = turns.map(|(one, next)| next.t_ns - one.t_ns).min().expect("it turns");
        assert!((PERIOD_NS..PERIOD_NS + 10_000).contains(&nearest_ns), "{port:?}: {nearest_ns} ns");
    }
}
