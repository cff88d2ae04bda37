//! Homing by stall: axes without switches, whose drivers say when their motors stall at the end.

use embassy_time::Duration;
use isostep_console::Settings;
use isostep_motion::Axis;
use isostep_sim::{Board, Config, Sim};

use crate::talk::{begin, bytes, say, state};

/// Longer than a driver is left alone, with its datagrams.
const ROUND: Duration = Duration::from_millis(300);
/// The ends are 3 mm below where the switches would close, and an axis pulls off by 2 mm.
const HOME_MM: f64 = -1.0;
const STEPS_PER_MM: f64 = 50.0;
const MICROSTEPS: i32 = 16;

/// Three axes that home by stall, at 30 mm/s, which is half a turn a second.
fn config() -> Config {
    let settings = Settings {
        stall_homing_mask: 0b111,
        stall_threshold: [70; 3],
        homing_seek_mm_min: 1_800.0,
        stealth_mm_min: [3_000.0; 3],
        accel_mm_s2: [500.0; 3],
        ..Settings::DEFAULT
    };
    Config { settings, board: Board::SkrPico, driver: Board::SkrPico.driver(), diag: [true; 3], ..Config::default() }
}

fn powered_up(config: &Config) -> Sim {
    let mut sim = Sim::new(config);
    sim.run_for(ROUND).unwrap();
    assert_eq!(sim.replies()[0], "Grbl 1.1h ['$' for help]");
    sim
}

/// True if X's driver would report a stall now.
fn looks(sim: &mut Sim) -> bool {
    sim.run_for(ROUND).unwrap();
    sim.driver_setup(0).unwrap().reports_stalls
}

/// The fault of a machine.
type Change = fn(&mut Config);

/// The distance of an axis from where it should be after homing, steps.
fn off_steps(sim: &Sim, axis: usize) -> i32 {
    sim.places_steps()[axis] - (HOME_MM * STEPS_PER_MM) as i32
}

#[test]
fn homing_by_stall_is_refused_where_no_stall_could_be_detected() {
    let reported = |change: Change| {
        let mut config = config();
        change(&mut config);
        let mut sim = powered_up(&config);
        let heard = say(&mut sim, "$H");
        assert_eq!(sim.steps(), [0; 3], "{heard:?}");
        assert_eq!((heard.len(), heard[1].as_str(), state(&mut sim).as_str()), (2, "error:20", "Idle"), "{heard:?}");
        assert!(!looks(&mut sim));
        heard[0].strip_prefix("[MSG:a stall of ").unwrap().to_owned()
    };
    let cases: [(Change, &str); 10] = [
        (
            |config| config.settings.trinamic_mask = 0b110,
            "X cannot be detected: $338 leaves its driver out. Take it in, or out of $339]",
        ),
        (
            |config| config.settings.second_motor_axis = 2,
            "Y cannot be detected: only X, Y and Z with one motor each have a driver whose DIAG can be wired. Take it out of $339]",
        ),
        (
            |config| config.settings.stealth_mm_min[2] = 2_200.0,
            "Z cannot be detected: it seeks by SpreadCycle, $982=2200. Set $982=2250, or more]",
        ),
        (
            |config| config.settings.homing_seek_mm_min = 900.0,
            "X cannot be detected: it seeks at 900 mm/min, which is too slow. Set $25=1280, or more, and $110]",
        ),
        (
            |config| config.settings.max_rate_mm_min[1] = 900.0,
            "Y cannot be detected: it seeks at 900 mm/min, which is too slow. Set $25=1280, or more, and $111]",
        ),
        (
            |config| (config.settings.accel_mm_s2[2], config.settings.travel_mm[2]) = (50.0, 20.0),
            "Z cannot be detected: its run-up is 20 mm long, its travel 20. Raise $122, or lower $25]",
        ),
        (
            |config| config.settings.homing_pull_off_mm = 0.6,
            "X cannot be detected: it pulls off by less than two full steps, $27=0.600. Set $27=0.640, or more]",
        ),
        (
            |config| config.settings.stall_threshold[1] = 0,
            "Y cannot be detected: $201=0. With Y in the middle of its travel send $STALL=Y]",
        ),
        (
            |config| config.diag[0] = false,
            "X cannot be detected: its limit input is high while the motor stands. Set the jumper from its driver's DIAG, unplug the \
             switch]",
        ),
        (
            |config| (config.diag[0], config.settings.stall_threshold[1]) = (false, 0),
            "Y cannot be detected: $201=0. With Y in the middle of its travel send $STALL=Y]",
        ),
    ];
    for (change, words) in cases {
        assert_eq!(reported(change), words);
    }
    // What the message says is enough.
    let mut sim =
        powered_up(&Config { settings: Settings { homing_seek_mm_min: 900.0, ..config().settings }, ..config() });
    assert_eq!(say(&mut sim, "$25=1280"), ["ok"]);
    assert_eq!(say(&mut sim, "$HX").last().unwrap(), "ok");
}

/// An axis is no faster than its top speed, whatever `$25` is, and its run-up no longer.
#[test]
fn a_run_up_is_to_the_speed_that_an_axis_may_have() {
    let mut config = config();
    (config.settings.homing_seek_mm_min, config.settings.max_rate_mm_min) = (9_000.0, [1_800.0; 3]);
    // To 150 mm/s it would be 225 mm, to 30 mm/s 9 mm.
    config.settings.accel_mm_s2 = [100.0; 3];
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$HZ"), ["[MSG:Z has stalled twice, 0 steps apart]", "ok"]);
    // It seeks, backs off, latches and pulls off: from the first of these places on the next is the farthest.
    let edges = sim.outcome().edges;
    let turns = edges.windows(2).filter(|pair| pair[0].direction != pair[1].direction);
    let places_steps: Vec<_> = turns.map(|pair| pair[0].position_steps).collect();
    assert_eq!(places_steps.len(), 3, "{places_steps:?}");
    assert_eq!(places_steps[1] - places_steps[0], 50 * (9 + 2), "the run-up and the pull-off");
}

/// The field is two full steps ahead at most when a stall is reported. Pulled off by so much, it is where the motor is, wherever
/// it began.
#[test]
fn an_axis_that_has_homed_by_a_stall_is_where_it_says() {
    for phase in 0..4 * MICROSTEPS {
        let mut config = config();
        (config.settings.homing_pull_off_mm, config.start_mm[0]) = (0.64, 10.0 + f64::from(phase) / STEPS_PER_MM);
        let mut sim = powered_up(&config);
        assert_eq!(say(&mut sim, "$HX").last().unwrap(), "ok", "{phase}");
        assert_eq!(say(&mut sim, "G53 G0 X5"), ["ok"]);
        assert_eq!(sim.outcome().drift_steps[0], 0, "{phase}");
    }
}

/// Each axis stalls at either end, with every value of `$23`; and a threshold that is too high is found out at either.
#[test]
fn axes_home_by_stall_at_either_end() {
    for negative in 0..8 {
        let mut config = config();
        config.settings.homing_direction_mask = negative;
        let mut sim = powered_up(&config);
        let words = |axis: &str| format!("[MSG:{axis} has stalled twice, 0 steps apart]");
        assert_eq!(say(&mut sim, "$H"), [words("X"), words("Y"), words("Z"), "ok".into()], "$23={negative}");
        for axis in 0..3 {
            let off_steps = off_steps(&sim, axis);
            assert!((-2 * MICROSTEPS..=0).contains(&off_steps), "$23={negative}, {axis}: {off_steps}");
        }
        config.settings.stall_threshold = [160; 3];
        for axis in Axis::ALL {
            let mut sim = powered_up(&config);
            assert!(say(&mut sim, &format!("$H{axis}")).contains(&"ALARM:24".into()), "$23={negative}: {axis}");
        }
    }
}

#[test]
fn a_reset_ends_the_look_for_stalls() {
    // In each phase, and in the exchange with the driver before them.
    for wait_ms in [5, 40, 300, 1_200, 1_500, 1_700] {
        let mut sim = powered_up(&config());
        begin(&mut sim, "$HX", Duration::from_millis(wait_ms));
        let was_moving = sim.steps()[0] > 0;
        bytes(&mut sim, b"\x18");
        assert!(!looks(&mut sim), "after {wait_ms} ms");
        sim.run_until_idle().unwrap();
        let heard = sim.replies();
        let is_home = sim.machine().homed()[0];
        if was_moving && !is_home {
            assert_eq!(state(&mut sim), "Alarm", "after {wait_ms} ms: {heard:?}");
            assert_eq!(say(&mut sim, "$X").last().unwrap(), "ok");
        }
        assert_eq!(say(&mut sim, "$HX"), ["[MSG:X has stalled twice, 0 steps apart]", "ok"], "after {wait_ms} ms");
    }
}
