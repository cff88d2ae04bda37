//! UART drivers: how they are set, what M122 says, and what a machine does whose drivers fail.

use embassy_time::Duration;
use isostep_motion::{Alarm, Axis, Motor, State};
use isostep_sim::drivers::{DriverFault, DriverSetup};
use isostep_sim::world::{Loss, LossCause};
use isostep_sim::{Board, Config, Sim};
use isostep_trials::stride;

use crate::talk::{begin, say, state};

/// Longer than a driver is left alone, with its datagrams.
const ROUND: Duration = Duration::from_millis(300);

pub fn skr_pico() -> Config {
    Config { board: Board::SkrPico, driver: Board::SkrPico.driver(), ..Config::default() }
}

fn switched_on(config: &Config) -> Sim {
    let mut sim = Sim::new(config);
    sim.run_for(ROUND).unwrap();
    sim
}

/// A machine that has just sent its welcome.
pub fn powered_up(config: &Config) -> Sim {
    let mut sim = switched_on(config);
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]"]);
    sim
}

/// Runs a round, and returns what has been said.
fn later(sim: &mut Sim) -> Vec<String> {
    sim.run_for(ROUND).unwrap();
    sim.replies()
}

fn setup(sim: &Sim, driver: usize) -> DriverSetup {
    sim.driver_setup(driver).unwrap()
}

#[test]
fn steps_per_millimetre_follow_the_microsteps() {
    let mut sim = powered_up(&skr_pico());
    let heard = say(&mut sim, "$150=32");
    assert_eq!(heard, ["[MSG:$100=100.000 now, as the microsteps ask for]", "ok"]);
    assert_eq!(setup(&sim, 0).microsteps, 32);
    let listed = say(&mut sim, "$$");
    assert!(listed.contains(&"$150=32".into()) && listed.contains(&"$100=100.000".into()), "{listed:?}");
    say(&mut sim, "$100=50");
    for line in listed.iter().filter(|line| line.starts_with('$')) {
        assert_eq!(say(&mut sim, line).last().unwrap(), "ok", "{line}");
    }
    assert_eq!(say(&mut sim, "$$"), listed, "a listing that is sent back ends where it began");
    let refused = say(&mut sim, "$150=24");
    let words = "[MSG:$150=24 is not a power of two: give 1, 2, 4, 8, 16, 32, 64, 128 or 256]";
    assert_eq!(refused, [words, "error:2"]);
    assert_eq!(setup(&sim, 0).microsteps, 32);
}

#[test]
fn a_board_without_uart_drivers_has_none_of_this() {
    let mut sim = powered_up(&Config::default());
    let listed = say(&mut sim, "$$");
    assert!(!listed.iter().any(|line| line.starts_with("$140=") || line.starts_with("$980=")), "{listed:?}");
    let words = "[MSG:$150 is about UART drivers, which this board does not have: set them by their jumpers]";
    assert_eq!(say(&mut sim, "$150=32"), [words, "error:3"]);
    assert_eq!(say(&mut sim, "M122"), ["[MSG:M122: unknown here: remove it]", "error:20"]);
}

/// The report of a driver's fault, if it stops the machine.
fn reported(fault: DriverFault) -> Option<&'static str> {
    match fault {
        DriverFault::Off | DriverFault::Late => Some("does not answer"),
        DriverFault::Overheated => Some("was too hot, its motor was off"),
        DriverFault::Shorted => Some("has found a short, its motor is off"),
        _ => None,
    }
}

/// Each fault of each driver, at rest and in a move, at different times of a round: reported within a round, on the axis that it
/// is of.
#[test]
fn each_fault_of_each_driver_is_reported() {
    let stopping = DriverFault::ALL.into_iter().filter_map(|fault| Some((fault, reported(fault)?)));
    let motors = Axis::ALL.map(Motor::first).into_iter().chain([Motor::second(Axis::Y)]);
    let mut tried = 0;
    for (fault, words) in stopping {
        for motor in motors.clone() {
            for wait_ms in [0, 17, 61, 97] {
                let moves = wait_ms % 2 == 1;
                let mut config = skr_pico();
                config.settings.second_motor_axis = 2;
                let mut sim = powered_up(&config);
                assert_eq!(say(&mut sim, "$H"), ["ok"]);
                if moves {
                    sim.send(b"G0 X200 Y200 Z50\n");
                }
                sim.run_for(Duration::from_millis(500 + wait_ms)).unwrap();
                sim.replies();
                sim.set_driver(motor, Some(fault));
                let heard = later(&mut sim);
                let said = format!("[MSG:{motor} driver {words}: ");
                let whole = format!("{fault} of {motor} after {wait_ms} ms: {heard:?}");
                assert_eq!(heard.iter().filter(|line| line.starts_with(&said)).count(), 1, "{whole}");
                assert_eq!(heard.iter().filter(|line| *line == "ALARM:17").count(), 1, "{whole}");
                assert_eq!(sim.machine().state(), State::Alarm(Alarm::DriverFailed { motor }), "{whole}");
                assert_eq!(sim.machine().homed(), [false; 3], "{whole}");
                let is_lost = |loss: &Loss| loss.axis == motor.axis as usize && loss.cause == LossCause::DriverOff;
                let lost = sim.outcome().losses.iter().any(is_lost);
                assert_eq!(lost, moves && fault != DriverFault::Late, "its motor was off: {whole}");
                tried += 1;
            }
        }
    }
    assert_eq!(tried, 64);
}

/// A reply that comes too late disturbs the next one too, and is no reason to stop, however often that happens.
#[test]
fn a_reply_that_is_late_now_and_then_is_asked_for_again() {
    let mut sim = powered_up(&skr_pico());
    for wait_ms in 0..100 {
        sim.set_driver(Axis::Y, Some(DriverFault::Late));
        sim.run_for(Duration::from_millis(2)).unwrap();
        sim.set_driver(Axis::Y, None);
        sim.run_for(Duration::from_millis(50 + wait_ms)).unwrap();
    }
    assert_eq!(sim.replies(), [""; 0]);
    assert_eq!(state(&mut sim), "Idle");
}

/// The faults that stop the machine also if they are over before anybody asks: the driver keeps that they were.
const KEPT: [DriverFault; 3] = [DriverFault::Off, DriverFault::Overheated, DriverFault::Shorted];

/// A fault that is over at once.
fn blink(sim: &mut Sim, motor: impl Into<Motor>, fault: DriverFault) {
    let motor = motor.into();
    sim.set_driver(motor, Some(fault));
    sim.set_driver(motor, None);
}

/// A driver's failure is reported whenever it comes in the exchange that sets it anew, also where the settings have been read
/// back already. Afterwards the driver is as the settings say.
#[test]
fn a_failure_while_the_settings_change_is_reported() {
    for fault in KEPT {
        for wait_us in (0..60_000).step_by(stride(500)) {
            let mut sim = powered_up(&skr_pico());
            sim.send(b"$141=1200\n");
            sim.run_for(Duration::from_micros(wait_us as u64)).unwrap();
            blink(&mut sim, Axis::Y, fault);
            let heard = later(&mut sim);
            assert!(heard.contains(&"ALARM:17".into()), "{fault} after {wait_us} us: {heard:?}");
            assert_eq!((setup(&sim, 1).run_ma, setup(&sim, 1).is_spread_cycle), (1160, true), "{fault}, {wait_us} us");
        }
    }
}

/// A fault that comes and goes is reported each time, also when it comes again as soon as the machine is unlocked. (The motor of
/// a driver that has found a short is off until then; what else would switch it off meanwhile, nobody can tell.)
#[test]
fn a_fault_that_comes_again_is_reported_again() {
    let pairs = KEPT.into_iter().flat_map(|first| KEPT.map(|second| (first, second)));
    for (first, second) in pairs.filter(|pair| pair.0 != DriverFault::Shorted || pair.1 == DriverFault::Off) {
        for wait_ms in [0, 20, 60, 110, 250, 500] {
            let mut sim = powered_up(&skr_pico());
            blink(&mut sim, Axis::X, first);
            sim.run_until_state(|state| matches!(state, State::Alarm(_))).unwrap();
            sim.run_for(Duration::from_millis(wait_ms)).unwrap();
            assert_eq!(begin(&mut sim, "$X", Duration::from_millis(1)).last().unwrap(), "ok");
            assert_eq!(sim.machine().state(), State::Idle);
            blink(&mut sim, Axis::X, second);
            let heard = later(&mut sim);
            let whole = format!("{first}, then {second} {wait_ms} ms later: {heard:?}");
            assert!(heard.contains(&"ALARM:17".into()), "{whole}");
            assert!(begin(&mut sim, "$X", ROUND).contains(&"ok".into()), "{whole}");
            assert_eq!(state(&mut sim), "Idle", "it is over: {whole}");
        }
    }
}
