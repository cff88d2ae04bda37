//! Homing by stall: axes without switches, whose drivers say when their motors stall at the end.

use embassy_time::Duration;
use isostep_console::Settings;
use isostep_motion::{Alarm, Axis, Motor, State};
use isostep_sim::drivers::DriverFault;
use isostep_sim::{Board, Config, Sim};

use crate::talk::{begin, bytes, say, state, status};

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

/// Whether X's driver would tell a stall now.
fn looks(sim: &mut Sim) -> bool {
    sim.run_for(ROUND).unwrap();
    sim.driver_setup(0).unwrap().tells_stalls
}

/// What is wrong with a machine.
type Change = fn(&mut Config);

/// How far an axis is from where it should be after homing, steps.
fn off_steps(sim: &Sim, axis: usize) -> i32 {
    sim.places_steps()[axis] - (HOME_MM * STEPS_PER_MM) as i32
}

#[test]
fn an_axis_homes_by_a_stall() {
    let mut sim = powered_up(&config());
    let heard = say(&mut sim, "$H");
    let words = |axis: &str| format!("[MSG:{axis} has stalled twice, 0 steps apart]");
    assert_eq!(heard, [words("X"), words("Y"), words("Z"), "ok".into()]);
    for axis in 0..3 {
        // The field was ahead of the rotor when the driver reported, and comes back by as much.
        assert!((-2 * MICROSTEPS..=0).contains(&off_steps(&sim, axis)), "{axis}: {}", off_steps(&sim, axis));
    }
    assert_eq!(sim.machine().homed(), [true; 3]);
    assert_eq!(status(&mut sim), "<Idle|MPos:0.000,0.000,0.000");
    assert!(!looks(&mut sim), "it tells stalls while homing alone");
    // Against their ends, and not farther: the limit inputs stop nothing else.
    assert_eq!(say(&mut sim, "G0 X100 Y100 Z50"), ["ok"]);
    let before = off_steps(&sim, 0);
    assert_eq!(say(&mut sim, "$HX"), [words("X"), "ok".into()]);
    assert_eq!(off_steps(&sim, 0), before - 100 * STEPS_PER_MM as i32, "where it was");
    assert_eq!(sim.outcome().violations, []);
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

/// An axis with a switch needs none of this, beside one that homes by stall.
#[test]
fn some_axes_may_home_by_stall_and_others_by_switch() {
    let mut config = config();
    (config.settings.stall_homing_mask, config.diag) = (0b001, [true, false, false]);
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$H"), ["[MSG:X has stalled twice, 0 steps apart]", "ok"]);
    let places_steps = sim.places_steps();
    assert!((1..=2).all(|axis| places_steps[axis] > 0), "{places_steps:?}");
    assert_eq!(say(&mut sim, "$339=0"), ["ok"]);
    let heard = say(&mut sim, "$HX");
    assert!(heard.contains(&"ALARM:8".into()), "its switch is wired to nothing: {heard:?}");
}

#[test]
fn a_threshold_is_proposed() {
    let mut config = config();
    config.settings.stall_threshold = [0; 3];
    let mut sim = powered_up(&config);
    let start = sim.places_steps();
    let heard = say(&mut sim, "$STALL=X");
    assert_eq!((heard.len(), heard[1].as_str()), (2, "ok"));
    // A quarter of the load of a stall leaves 300 of 400, and noise takes 10 at most.
    let words = heard[0].strip_prefix("[MSG:X turns freely at SG_RESULT 29").unwrap_or_else(|| panic!("{heard:?}"));
    assert!(words.contains(" to 3") && words.contains(", mean 29"), "{words}");
    let proposed = words.split("try ").nth(1).unwrap().split(',').next().unwrap().to_owned();
    assert_eq!(proposed, "$200=72");
    assert_eq!(sim.places_steps(), start, "it ends where it began");
    assert_eq!(say(&mut sim, &proposed), ["ok"]);
    assert_eq!(say(&mut sim, "$HX"), ["[MSG:X has stalled twice, 0 steps apart]", "ok"]);
    // Homed, it stands where its travel begins. Feed override does not slow it, and a jog cancel ends it.
    bytes(&mut sim, b"\x92\x92\x92\x92\x92");
    assert!(say(&mut sim, "$STALL=X")[0].starts_with("[MSG:X turns freely"));
    sim.send(b"$STALL=X\n");
    sim.run_for(ROUND).unwrap();
    sim.send(b"\x85");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies().last().unwrap(), "ok");
    assert_ne!(sim.machine().position_steps()[0], 0, "it stands where it was cancelled");
    assert_eq!(state(&mut sim), "Idle");
    say(&mut sim, "G0 X340");
    let far = say(&mut sim, "$STALL=X");
    assert_eq!(far, ["[MSG:there is no room for X to move: jog it to the middle of its travel]", "error:20"]);
}

#[test]
fn a_threshold_is_not_proposed_where_none_can_be() {
    let mut spread =
        powered_up(&Config { settings: Settings { stealth_mm_min: [0.0; 3], ..config().settings }, ..config() });
    let words = "[MSG:a stall of X cannot be detected: it seeks by SpreadCycle, $980=0. Set $980=2250, or more]";
    assert_eq!(say(&mut spread, "$STALL=X"), [words, "error:20"]);
    // So much varies what it turns against that it seems stalled now and then.
    let mut noisy = powered_up(&Config { load_noise: 0.7, ..config() });
    let heard = say(&mut noisy, "$STALL=Y");
    assert!(heard[0].contains("too low for a threshold. Seek faster ($25), or mend what brakes it"), "{heard:?}");
    let mut pico = powered_up(&Config::default());
    assert_eq!(say(&mut pico, "$STALL=X"), ["error:3"]);
    let mut moving = powered_up(&config());
    moving.send(b"G91 G1 X20 F600\n");
    moving.run_for(ROUND).unwrap();
    moving.replies();
    assert_eq!(begin(&mut moving, "$STALL=X", ROUND), ["error:8"]);
    // A reset ends it, and the driver is not read any more.
    let mut reset = powered_up(&config());
    begin(&mut reset, "$STALL=X", ROUND);
    reset.send(b"\x18");
    reset.run_until_idle().unwrap();
    assert_eq!(reset.replies().last().unwrap(), "Grbl 1.1h ['$' for help]");
    assert_eq!(state(&mut reset), "Idle");
    assert_eq!(say(&mut reset, "$STALL=X").last().unwrap(), "ok", "it can be done again");
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

/// A threshold above what a free motor has is a stall wherever the axis is fast.
#[test]
fn alarm_24_stalls_apart() {
    let mut config = config();
    config.settings.stall_threshold = [160; 3];
    let mut sim = powered_up(&config);
    let heard = say(&mut sim, "$HX");
    let words = "[MSG:X has stalled at two places: lower $200-$202 ($STALL proposes it), free the axis, then $H]";
    assert_eq!(heard, ["ALARM:24", words, "error:9"]);
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::StallsApart { axis: Axis::X }));
    assert!(!sim.machine().homed()[0] && !looks(&mut sim));
    assert!(off_steps(&sim, 0) > 1_000, "it is far from its end");
    assert_eq!(say(&mut sim, "$200=70"), ["ok"]);
    assert_eq!(say(&mut sim, "$HX"), ["[MSG:X has stalled twice, 0 steps apart]", "ok"]);
}

#[test]
fn a_stall_in_a_move_is_an_alarm_if_asked_for() {
    for is_asked in [true, false] {
        let mut config = config();
        config.settings.stall_alarm_mask = u16::from(is_asked);
        let mut sim = powered_up(&config);
        assert_eq!(say(&mut sim, "$H").last().unwrap(), "ok");
        assert_eq!(looks(&mut sim), is_asked);
        say(&mut sim, "$20=0");
        sim.replies();
        // 100 mm further than the end, and after it was homed again once more.
        for time in 0..2 {
            let heard = say(&mut sim, "G1 X-100 F1800");
            if !is_asked {
                assert_eq!(heard, ["ok"]);
                assert_eq!(state(&mut sim), "Idle");
                break;
            }
            sim.run_for(ROUND).unwrap();
            let later = sim.replies();
            let all: Vec<_> = heard.iter().chain(&later).cloned().collect();
            let is_there = |words: &str| all.iter().any(|line| line.starts_with(words));
            let is_reported =
                is_there("ALARM:17") && is_there("[MSG:X driver has reported a stall of its motor: free it");
            assert!(is_reported, "{time}: {all:?}");
            assert_eq!(sim.machine().state(), State::Alarm(Alarm::DriverFailed { motor: Motor::first(Axis::X) }));
            let report = say(&mut sim, "M122");
            assert!(
                report[0].starts_with("[MSG:X driver: has reported a stall of its motor, 16 microsteps"),
                "{report:?}"
            );
            assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
            assert_eq!(say(&mut sim, "$HX").last().unwrap(), "ok");
            assert!(say(&mut sim, "M122")[0].starts_with("[MSG:X driver: well"), "{time}");
        }
    }
}

/// The task that asks the drivers would notice after a tenth of a second.
#[test]
fn the_diag_of_a_driver_that_fails_stops_at_once() {
    let mut sim = powered_up(&config());
    assert_eq!(say(&mut sim, "$H").last().unwrap(), "ok");
    begin(&mut sim, "G1 X100 F1800", ROUND);
    sim.set_driver(Axis::X, Some(DriverFault::Shorted));
    sim.run_for(Duration::from_millis(1)).unwrap();
    assert!(sim.replies().contains(&"ALARM:17".into()));
    let edges = sim.steps();
    sim.run_for(ROUND).unwrap();
    assert_eq!(sim.steps(), edges);
    let heard = sim.replies();
    assert!(heard.iter().any(|line| line.starts_with("[MSG:X driver has found a short")), "{heard:?}");
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

/// Each stall is reported as what it is, not the first alone.
#[test]
fn a_motor_that_stalls_again_is_reported_again() {
    let mut config = config();
    config.settings.stall_alarm_mask = 1;
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$H").last().unwrap(), "ok");
    say(&mut sim, "$20=0");
    for _ in 0..3 {
        sim.send(b"G1 X-100 F1800\n");
        sim.run_for(Duration::from_secs(5)).unwrap();
        let heard = sim.replies();
        let words = "[MSG:X driver has reported a stall of its motor: free it";
        assert_eq!(heard.iter().filter(|line| line.starts_with(words)).count(), 1, "{heard:?}");
        assert_eq!(say(&mut sim, "$X").last().unwrap(), "ok");
        assert_eq!(say(&mut sim, "$HX").last().unwrap(), "ok");
    }
}

/// The emergency stop is pressed in the same instant, and another console has asked for homing already, which leaves that alarm
/// while the motor is off: so the machine is locked again.
#[test]
fn a_driver_that_fails_in_an_emergency_stop_in_homing_is_reported() {
    let mut sim = powered_up(&Config { second_console: true, ..config() });
    sim.send(b"$H\n");
    sim.run_for(ROUND).unwrap();
    sim.send_to(1, b"$HZ\n");
    sim.run_for(ROUND).unwrap();
    sim.set_emergency_stop(true);
    sim.set_driver(Axis::Y, Some(DriverFault::Overheated));
    sim.run_for(Duration::from_millis(28)).unwrap();
    sim.set_emergency_stop(false);
    sim.run_for(Duration::from_millis(66)).unwrap();
    sim.set_driver(Axis::Y, None);
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    let is_reported = |words: &str| heard.iter().any(|line| line.starts_with(words));
    assert!(is_reported("ALARM:10") && is_reported("[MSG:Y driver was too hot, its motor was off"), "{heard:?}");
    assert!(is_reported("ALARM:17"), "{heard:?}");
    assert_eq!(sim.machine().homed(), [false; 3], "{heard:?}");
    assert_eq!(say(&mut sim, "$HZ").last().unwrap(), "ok");
    assert_eq!(sim.machine().homed(), [false, false, true]);
}
