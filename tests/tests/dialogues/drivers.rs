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

/// What has been said after a round.
fn later(sim: &mut Sim) -> Vec<String> {
    sim.run_for(ROUND).unwrap();
    sim.replies()
}

fn setup(sim: &Sim, driver: usize) -> DriverSetup {
    sim.driver_setup(driver).unwrap()
}

#[test]
fn drivers_are_set_before_the_welcome() {
    let sim = powered_up(&skr_pico());
    for driver in 0..3 {
        // The scale is a thirty-second, rounded down, of 1,768 mA or of 979 mA.
        let expected =
            DriverSetup { microsteps: 16, run_ma: 795, hold_ma: 398, is_spread_cycle: true, tells_stalls: false };
        assert_eq!(setup(&sim, driver), expected, "{driver}");
    }
    assert_eq!(setup(&sim, 3).microsteps, 16, "the pins': no axis has a second motor");
    assert!(!setup(&sim, 3).is_spread_cycle, "nobody has told it");
}

#[test]
fn settings_are_with_the_drivers_when_they_are_answered() {
    let mut sim = powered_up(&skr_pico());
    assert_eq!(say(&mut sim, "$141=1200"), ["ok"]);
    assert_eq!(say(&mut sim, "$211=30"), ["ok"]);
    assert_eq!(say(&mut sim, "$981=600"), ["ok"]);
    let of_y = DriverSetup { microsteps: 16, run_ma: 1160, hold_ma: 331, is_spread_cycle: false, tells_stalls: false };
    assert_eq!(setup(&sim, 1), of_y);
    assert_eq!(setup(&sim, 0).run_ma, 795);
    // At 600 mm/min StealthChop ends.
    sim.send(b"G91\nG1 Y20 F500\n");
    sim.run_for(Duration::from_millis(800)).unwrap();
    assert!(!setup(&sim, 1).is_spread_cycle);
    sim.run_until_idle().unwrap();
    begin(&mut sim, "G1 Y20 F700", Duration::from_millis(800));
    say(&mut sim, "M122");
    assert!(!setup(&sim, 1).is_spread_cycle, "it stands again");
}

/// A setting that is changed again, and back to what the driver had at power-up, is written each time.
#[test]
fn each_change_of_a_setting_is_with_the_driver_when_it_is_answered() {
    let mut sim = powered_up(&skr_pico());
    for (line, run_ma) in [("$141=1200", 1160), ("$141=800", 795), ("$141=1000", 994), ("$141=800", 795)] {
        assert_eq!(say(&mut sim, line), ["ok"]);
        assert_eq!(setup(&sim, 1).run_ma, run_ma, "{line}");
        // The rounds after it leave it as it is.
        assert_eq!((later(&mut sim), setup(&sim, 1).run_ma), (Vec::new(), run_ma), "{line}");
    }
    for (microsteps, line) in [(8, "$150=8"), (16, "$150=16"), (32, "$150=32")] {
        assert_eq!(say(&mut sim, line).last().unwrap(), "ok");
        assert_eq!((setup(&sim, 0).microsteps, setup(&sim, 0).run_ma), (microsteps, 795), "{line}");
    }
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
fn the_second_motor_is_set_as_its_axis() {
    let mut sim = powered_up(&skr_pico());
    say(&mut sim, "$151=8");
    assert_eq!(say(&mut sim, "$905=2"), ["ok"]);
    assert_eq!((setup(&sim, 3).microsteps, setup(&sim, 3).run_ma), (8, 795));
    let heard = say(&mut sim, "M122");
    let names: Vec<_> = heard.iter().filter_map(|line| line.strip_prefix("[MSG:")?.split(' ').next()).collect();
    assert_eq!(names, ["X", "Y", "Z", "Y2"], "{heard:?}");
}

#[test]
fn m122_tells_how_each_driver_is() {
    let mut config = skr_pico();
    config.settings.trinamic_mask = 0b011;
    let mut sim = powered_up(&config);
    let heard = say(&mut sim, "m122");
    let well = "driver: well, 16 microsteps, 795 mA, 397 mA at standstill, SpreadCycle]";
    let expected =
        [format!("[MSG:X {well}"), format!("[MSG:Y {well}"), "[MSG:Z driver: left out by $338]".into(), "ok".into()];
    assert_eq!(heard, expected);
    sim.set_driver(Axis::X, Some(DriverFault::Hot));
    assert_eq!(later(&mut sim), ["[MSG:X driver is hot: cool it, or lower its current ($140-$142)]"]);
    assert!(say(&mut sim, "M122")[0].starts_with("[MSG:X driver: hot, 16 microsteps"));
    say(&mut sim, "$980=2000");
    begin(&mut sim, "G91 G1 X40 F1200", Duration::from_secs(1));
    let moving = begin(&mut sim, "M122", ROUND);
    let sg_result = moving.iter().find_map(|line| line.split("StealthChop, SG_RESULT ").nth(1)?.strip_suffix(']'));
    // A quarter of the load of a stall, of 400 without any, and noise.
    assert!(sg_result.is_some_and(|value| (290..=310).contains(&value.parse().unwrap())), "{moving:?}");
    sim.run_until_idle().unwrap();
    sim.replies();
    assert_eq!(state(&mut sim), "Idle");
    sim.set_driver(Axis::X, None);
    assert_eq!(later(&mut sim), ["[MSG:X driver is well]"]);
    sim.set_driver(Axis::Z, Some(DriverFault::Off));
    assert_eq!(later(&mut sim), [""; 0], "it is left out");
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

/// What a driver's fault is reported as, if it stops the machine.
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

/// `$X` does not leave an alarm for long whose cause is still there, and does once it is mended. A driver that has found a
/// short is switched off and on then: until that it tells of it.
#[test]
fn an_unlocked_machine_is_locked_again_until_the_driver_is_mended() {
    for fault in [DriverFault::Off, DriverFault::Shorted] {
        let mut sim = powered_up(&skr_pico());
        sim.set_driver(Axis::Y, Some(fault));
        assert!(later(&mut sim).contains(&"ALARM:17".into()));
        assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
        let heard = later(&mut sim);
        assert!(heard.contains(&"ALARM:17".into()), "{heard:?}");
        sim.set_driver(Axis::Y, None);
        let well = ["[MSG:Y driver is well]"];
        let [before, after] = if fault == DriverFault::Off { [&well[..], &[]] } else { [&[], &well[..]] };
        assert_eq!(later(&mut sim), before);
        assert_eq!(state(&mut sim), "Alarm");
        assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
        assert_eq!(later(&mut sim), after);
        assert_eq!(state(&mut sim), "Idle");
        assert!(setup(&sim, 1).is_spread_cycle, "it is set again");
    }
}

/// A driver whose supply fails for an instant has forgotten all: also where no round saw it silent.
#[test]
fn a_driver_that_lost_its_supply_for_an_instant_is_reported_and_set_again() {
    let mut sim = powered_up(&skr_pico());
    sim.run_for(Duration::from_millis(250)).unwrap();
    sim.set_driver(Axis::X, Some(DriverFault::Off));
    sim.set_driver(Axis::X, None);
    assert!(!setup(&sim, 0).is_spread_cycle);
    let heard = later(&mut sim);
    let words = "[MSG:X driver had lost its supply, and was set again: check the motors' supply]";
    assert!(heard.contains(&words.into()) && heard.contains(&"ALARM:17".into()), "{heard:?}");
    assert!(setup(&sim, 0).is_spread_cycle);
}

#[test]
fn a_motor_whose_supply_is_off_at_power_up_locks_the_machine_and_settings_can_be_set() {
    let mut config = skr_pico();
    config.faults = ["X", "Y", "Z"].map(|axis| format!("driver-off:{axis}@0+2").parse().unwrap()).into();
    let mut sim = switched_on(&config);
    let heard = sim.replies();
    assert!(heard.contains(&"[MSG:'$H'|'$X' to unlock]".into()), "{heard:?}");
    assert!(begin(&mut sim, "M122", ROUND)[0].contains("driver: does not answer"));
    assert_eq!(begin(&mut sim, "$140=900", ROUND), ["ok"]);
    sim.run_for(Duration::from_secs(2)).unwrap();
    let mut well = ["X", "Y", "Z"].map(|axis| format!("[MSG:{axis} driver is well]"));
    well.sort();
    assert_eq!(sim.replies(), well);
    assert_eq!(setup(&sim, 0).run_ma, 887);
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
}

/// A reply that is disturbed now and then is asked for again.
#[test]
fn every_second_reply_may_be_disturbed() {
    let mut sim = powered_up(&skr_pico());
    Axis::ALL.into_iter().for_each(|axis| sim.set_driver(axis, Some(DriverFault::Garbled)));
    sim.run_for(Duration::from_secs(20)).unwrap();
    assert_eq!(sim.replies(), [""; 0]);
    assert_eq!(say(&mut sim, "$140=1000"), ["ok"]);
    assert_eq!(setup(&sim, 0).run_ma, 994);
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

/// An open coil is reported of a motor that turns, and stops nothing.
#[test]
fn an_open_coil_is_reported_while_the_motor_turns() {
    let mut sim = powered_up(&skr_pico());
    sim.set_driver(Axis::Z, Some(DriverFault::OpenCoil));
    sim.run_for(Duration::from_secs(2)).unwrap();
    assert_eq!(sim.replies(), [""; 0], "it stands");
    let heard = begin(&mut sim, "G1 Z20 F600", Duration::from_secs(2));
    let words = "[MSG:Z driver sees an open coil: switch the supply off, check the motor's plug and cable]";
    assert!(heard.contains(&words.into()), "{heard:?}");
    assert_eq!(state(&mut sim), "Run");
}

/// Two consoles hear the same, and a reset between a setting and its answer leaves the drivers as the setting says.
#[test]
fn both_consoles_hear_of_a_fault_and_a_reset_leaves_a_setting_half_way_to_no_driver() {
    let mut config = skr_pico();
    config.second_console = true;
    let mut sim = powered_up(&config);
    sim.replies_of(1);
    sim.send(b"$140=1200\n");
    sim.run_for(Duration::from_millis(3)).unwrap();
    sim.send(b"\x18");
    sim.run_for(ROUND).unwrap();
    let listed = say(&mut sim, "$$");
    assert!(listed.contains(&"$140=1200".into()), "{listed:?}");
    assert_eq!(setup(&sim, 0).run_ma, 1160);
    sim.replies_of(1);
    sim.set_driver(Axis::X, Some(DriverFault::Overheated));
    let heard = [later(&mut sim), sim.replies_of(1)];
    assert_eq!(heard[0], heard[1]);
    assert!(heard[0].contains(&"ALARM:17".into()), "{heard:?}");
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

/// The machine is unlocked while the motor is still off. Whether it was off once or twice since then, nobody can tell. (A short
/// is kept by the driver until the motor is switched off after `$X`, so it is once.)
#[test]
fn a_fault_that_lasts_until_the_machine_is_unlocked_is_reported_again() {
    for fault in [DriverFault::Off, DriverFault::Overheated] {
        let mut sim = powered_up(&skr_pico());
        sim.set_driver(Axis::X, Some(fault));
        sim.run_until_state(|state| matches!(state, State::Alarm(_))).unwrap();
        assert_eq!(begin(&mut sim, "$X", Duration::from_millis(1)).last().unwrap(), "ok");
        sim.set_driver(Axis::X, None);
        blink(&mut sim, Axis::X, fault);
        let heard = later(&mut sim);
        assert!(heard.contains(&"ALARM:17".into()), "{fault}: {heard:?}");
        assert_eq!(begin(&mut sim, "$X", ROUND).last().unwrap(), "ok");
        assert_eq!(state(&mut sim), "Idle", "{fault}: it is over");
    }
}

/// A driver that warns now and then is reported each time, and stops nothing.
#[test]
fn a_driver_that_is_hot_again_is_reported_again() {
    let mut sim = powered_up(&skr_pico());
    for _ in 0..3 {
        sim.set_driver(Axis::Z, Some(DriverFault::Hot));
        assert_eq!(later(&mut sim), ["[MSG:Z driver is hot: cool it, or lower its current ($140-$142)]"]);
        sim.set_driver(Axis::Z, None);
        assert_eq!(later(&mut sim), ["[MSG:Z driver is well]"]);
    }
    assert_eq!(state(&mut sim), "Idle");
}

/// A coil has to seem open in five rounds in a row. A round in which it does not, and a driver that is left out for a while, begin
/// the count anew.
#[test]
fn a_coil_that_seems_open_now_and_then_is_not_reported() {
    let open = |sim: &mut Sim, millis: u64| {
        sim.set_driver(Axis::Z, Some(DriverFault::OpenCoil));
        sim.run_for(Duration::from_millis(millis)).unwrap();
        sim.set_driver(Axis::Z, None);
    };
    let mut sim = powered_up(&skr_pico());
    say(&mut sim, "G91");
    sim.send(b"G1 Z50 F300\n");
    sim.run_for(ROUND).unwrap();
    sim.replies();
    // A round is 100 ms and 20 ms of datagrams.
    for _ in 0..5 {
        open(&mut sim, 430);
        assert_eq!(later(&mut sim), [""; 0]);
    }
    open(&mut sim, 800);
    let words = "[MSG:Z driver sees an open coil: switch the supply off, check the motor's plug and cable]";
    assert_eq!(later(&mut sim), [words, "[MSG:Z driver is well]"]);
    sim.run_until_idle().unwrap();
    sim.send(b"G1 Z-5 F300\n");
    sim.run_for(ROUND).unwrap();
    // The move ends, and with it the rounds that could show the coil as well again.
    sim.set_driver(Axis::Z, Some(DriverFault::OpenCoil));
    sim.run_until_idle().unwrap();
    assert!(later(&mut sim).contains(&words.into()));
    sim.set_driver(Axis::Z, None);
    assert_eq!(later(&mut sim), [""; 0], "it stands, so nobody knows");
    assert_eq!(say(&mut sim, "$338=3"), ["ok"]);
    assert_eq!(say(&mut sim, "$338=7"), ["ok"]);
    assert_eq!(later(&mut sim), [""; 0]);
    assert!(say(&mut sim, "M122")[2].starts_with("[MSG:Z driver: well, "));
}

/// What has been set once can be set again, to what it was before too.
#[test]
fn settings_that_change_again_are_with_the_drivers() {
    let mut sim = powered_up(&skr_pico());
    for (microsteps, ma, is_ma) in [(32, 1200, 1160), (16, 800, 795), (8, 1200, 1160), (16, 800, 795)] {
        assert_eq!(say(&mut sim, &format!("$150={microsteps}")).last().unwrap(), "ok");
        assert_eq!(say(&mut sim, &format!("$140={ma}\n$980=600")), ["ok", "ok"]);
        assert_eq!((setup(&sim, 0).microsteps, setup(&sim, 0).run_ma), (microsteps, is_ma));
        assert!(!setup(&sim, 0).is_spread_cycle);
        assert_eq!(say(&mut sim, "$980=0"), ["ok"]);
        assert!(setup(&sim, 0).is_spread_cycle);
        sim.run_for(Duration::from_secs(3)).unwrap();
        assert_eq!(sim.replies(), [""; 0], "read back, they are as they were set");
    }
}

/// An alarm of a probe leaves the position trusted, and a driver that fails meanwhile does not.
#[test]
fn a_driver_that_fails_in_another_alarm_takes_the_position() {
    for fault in KEPT {
        let mut sim = powered_up(&skr_pico());
        assert_eq!(say(&mut sim, "$H"), ["ok"]);
        assert!(say(&mut sim, "G38.2 Z5 F300").contains(&"ALARM:5".into()));
        assert_eq!(sim.machine().homed(), [true; 3]);
        blink(&mut sim, Axis::X, fault);
        let heard = later(&mut sim);
        assert!(heard.iter().any(|line| line.starts_with("[MSG:X driver ")), "{fault}: {heard:?}");
        assert_eq!(sim.machine().homed(), [false; 3], "{fault}");
        assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
    }
}
