//! Each alarm of the table in docs/console.md: its messages, that G-code is refused afterwards, and how to continue.
//! The alarms of a step port that cannot keep up need a real port, so they are in tests/emulated.rs.

use embassy_time::Duration;
use isostep_motion::{AXES, Alarm, Axis, Contact, Motor, State};
use isostep_sim::{Config, Sim, SwitchFault};

use crate::talk::{begin, homed, powered_up, refused, say, state, switched_on};

/// Checks that the alarm and its words each came once, and that the machine is locked.
fn alarmed(sim: &mut Sim, heard: &[String], code: u8, words: &str) {
    let alarm = format!("ALARM:{code}");
    assert_eq!(heard.iter().filter(|line| **line == alarm).count(), 1, "{heard:?}");
    let words = format!("[MSG:{words}");
    assert_eq!(heard.iter().filter(|line| line.starts_with(&words)).count(), 1, "{heard:?}");
    assert_eq!(state(sim), "Alarm");
    refused(sim, "G0 X1", 9);
}

/// Unlocks the machine. If the position is trusted, a target beyond the travel is still recognised.
fn unlock(sim: &mut Sim, trusted: bool) {
    assert_eq!(say(sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
    assert_eq!(state(sim), "Idle");
    assert_eq!(sim.machine().status().homed, [trusted; 3]);
}

#[test]
fn alarm_1_hard_limit() {
    let mut sim = homed();
    begin(&mut sim, "G1 X100 F600", Duration::from_secs(1));
    sim.set_switch(Axis::X, SwitchFault::StuckClosed);
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    alarmed(&mut sim, &heard, 1, "X limit switch closed, steps may be lost: $X, move off it, then $H]");
    sim.set_switch(Axis::X, SwitchFault::None);
    sim.run_until_idle().unwrap();
    unlock(&mut sim, false);
}

#[test]
fn alarm_2_soft_limit() {
    let mut sim = homed();
    let heard = say(&mut sim, "G0 X5\nG0 Y401");
    alarmed(&mut sim, &heard, 2, "Y target outside the travel ($130-$132), nothing moved: ");
    assert!(
        heard.contains(
            &"[MSG:Y401.000 is outside the travel, 0.000 to 400.000 mm: correct the program, then $X]".into()
        )
    );
    assert_eq!(sim.counted_steps(), [250, 0, 0], "the move before it was good");
    unlock(&mut sim, true);
}

#[test]
fn alarm_3_reset_in_motion() {
    let mut sim = homed();
    begin(&mut sim, "G0 X100", Duration::from_secs(1));
    sim.send(b"\x18");
    sim.run_for(Duration::from_millis(100)).unwrap();
    assert_eq!(state(&mut sim), "Hold:1", "it brakes");
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    assert_eq!(heard.last().unwrap(), "[MSG:'$H'|'$X' to unlock]");
    alarmed(&mut sim, &heard, 3, "reset again while braking, steps may be lost: $X, then $H]");
    unlock(&mut sim, false);
}

#[test]
fn alarm_6_homing_reset() {
    let mut sim = powered_up(&Config::default());
    begin(&mut sim, "$H", Duration::from_secs(1));
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    alarmed(&mut sim, &heard, 6, "reset while homing, position unknown: home again with $H]");
    unlock(&mut sim, false);
}

#[test]
fn alarm_8_pull_off() {
    let switches = [SwitchFault::None, SwitchFault::StuckClosed, SwitchFault::None];
    let mut sim = switched_on(&Config { switches, ..Config::default() });
    let heard = say(&mut sim, "$H");
    alarmed(
        &mut sim,
        &heard,
        8,
        "Y limit switch still closed after pulling off: free a stuck switch, raise $27, check $5]",
    );
}

#[test]
fn alarm_9_switch_not_found() {
    let switches = [SwitchFault::StuckOpen, SwitchFault::None, SwitchFault::None];
    let mut sim = powered_up(&Config { switches, ..Config::default() });
    let heard = say(&mut sim, "$H");
    alarmed(
        &mut sim,
        &heard,
        9,
        "X limit switch never closed: check its wiring, the direction ($23) and the travel ($130-$132); by stall ($339) raise \
         $200-$202]",
    );
    unlock(&mut sim, false);
}

#[test]
fn alarm_10_emergency_stop() {
    let mut sim = homed();
    sim.set_emergency_stop(true);
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    alarmed(&mut sim, &heard, 10, "emergency stop pressed: release it, or mend its wire, then $X and $H]");
    refused(&mut sim, "$X", 9);
    refused(&mut sim, "$H", 9);
    sim.set_emergency_stop(false);
    sim.run_until_idle().unwrap();
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    assert_eq!(state(&mut sim), "Idle");
}

/// That is what it is wired so for.
#[test]
fn a_broken_wire_of_an_emergency_stop_that_opens_is_a_press() {
    let mut sim = powered_up(&Config { emergency_contact: Contact::NormallyClosed, ..Config::default() });
    for press in [Sim::cut_emergency_stop, Sim::set_emergency_stop] {
        begin(&mut sim, "G91 G1 X50 F1200", Duration::from_secs(1));
        let steps = sim.steps();
        press(&mut sim, true);
        sim.run_until_idle().unwrap();
        let heard = sim.replies();
        alarmed(&mut sim, &heard, 10, "emergency stop pressed: ");
        assert_eq!(sim.steps(), steps);
        refused(&mut sim, "$X", 9);
        refused(&mut sim, "$H", 9);
        press(&mut sim, false);
        sim.run_until_idle().unwrap();
        unlock(&mut sim, false);
    }
}

#[test]
fn a_broken_wire_of_an_emergency_stop_that_closes_disables_it() {
    let mut sim = homed();
    begin(&mut sim, "G1 X50 F1200", Duration::from_secs(1));
    sim.cut_emergency_stop(true);
    sim.set_emergency_stop(true);
    sim.run_for(Duration::from_secs(1)).unwrap();
    assert_eq!(state(&mut sim), "Run");
    sim.cut_emergency_stop(false);
    sim.run_until_idle().unwrap();
    assert_eq!(state(&mut sim), "Alarm", "it is pressed still");
}

#[test]
fn an_emergency_stop_that_is_open_at_power_up_keeps_the_machine_locked() {
    let faults = vec!["broken:e-stop@0".parse().unwrap()];
    let mut sim = Sim::new(&Config { emergency_contact: Contact::NormallyClosed, faults, ..Config::default() });
    sim.run_for(Duration::from_millis(100)).unwrap();
    let heard = sim.replies();
    alarmed(&mut sim, &heard, 10, "emergency stop pressed: ");
    refused(&mut sim, "$X", 9);
    refused(&mut sim, "$H", 9);
    assert_eq!(sim.steps(), [0; AXES]);
}

/// The board cuts the tool off when the processor was held up, and says so once it is back.
#[test]
fn alarm_23_tool_cut_off() {
    let mut sim = homed();
    sim.machine().tool_cut_off();
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    alarmed(&mut sim, &heard, 23, "the processor was held up, so the tool was cut off: $X, then $H, and report it]");
    assert_eq!(sim.machine().homed(), [true; AXES], "nothing has moved");
    say(&mut sim, "$X");
    sim.send(b"G1 X50 F1200\n");
    sim.run_for(Duration::from_millis(500)).unwrap();
    sim.machine().tool_cut_off();
    sim.run_until_idle().unwrap();
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::ToolCutOff));
    assert_eq!(sim.machine().homed(), [false; AXES]);
}

/// The board sees a press that is over before the task that watches the input looks. It counts, and does not last.
#[test]
fn alarm_15_skewed() {
    let mut config = Config::default();
    config.settings.second_motor_axis = 2;
    let mut sim = powered_up(&config);
    sim.set_switch(Motor::second(Axis::Y), SwitchFault::StuckOpen);
    let heard = say(&mut sim, "$HY");
    let reason = "Y2 did not reach its switch within $349 of the other motor: \
                  free what is jammed, check motor and switch, square it by hand, then $H]";
    alarmed(&mut sim, &heard, 15, reason);
    unlock(&mut sim, false);
}

#[test]
fn an_emergency_stop_that_only_the_board_sees_locks_until_it_is_debounced() {
    let mut sim = homed();
    for _ in 0..3 {
        sim.machine().emergency_stop_edge(true);
        sim.machine().emergency_stop_edge(false);
        assert_eq!(sim.machine().state(), State::Alarm(Alarm::EmergencyStop));
        sim.run_for(Duration::from_millis(20)).unwrap();
        assert!(sim.replies().contains(&"ALARM:10".to_owned()));
        unlock(&mut sim, true);
    }
}

/// 17 m along the diagonal at 1 mm/min take 12 days, which is longer than can be planned. Nothing has moved, so the
/// axes stay homed.
#[test]
fn alarm_21_unplannable() {
    let mut config = Config::default();
    config.settings.travel_mm = [10_000.0; 3];
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "$H\nG0 X1"), ["ok", "ok"]);
    let heard = say(&mut sim, "G1 X10000 Y10000 Z10000 F1");
    let words = "nothing moved: the move would last longer than 1,000,000 s - raise F, or make it shorter, then $X]";
    alarmed(&mut sim, &heard, 21, words);
    assert_eq!((sim.counted_steps(), sim.machine().homed()), ([50, 0, 0], [true; 3]));
    unlock(&mut sim, true);
    assert!(say(&mut sim, "G0 X-1").contains(&"ALARM:2".to_owned()), "soft limits are where they were");
}

/// The line that clears the alarm is already waiting when the alarm is raised.
#[test]
fn an_alarm_is_reported_before_it_is_left() {
    for (leaves, words) in [("$X", "[MSG:Caution: Unlocked]"), ("$H", "ok")] {
        let mut sim = homed();
        let heard = say(&mut sim, &format!("G0 X-1\n{leaves}\nG0 X1"));
        let place = |wanted: &str| heard.iter().position(|line| line.starts_with(wanted)).expect(wanted);
        assert!(place("error:9") < place("ALARM:2") && place("ALARM:2") < place(words), "{heard:?}");
        assert_eq!((heard.last().map(String::as_str), state(&mut sim).as_str()), (Some("ok"), "Idle"));

        let mut sim = homed();
        sim.send(format!("G0 X40\nG4 P0\n{leaves}\n").as_bytes());
        sim.run_for(Duration::from_millis(500)).unwrap();
        sim.set_switch(Axis::Y, SwitchFault::StuckClosed);
        sim.run_for(Duration::from_millis(100)).unwrap();
        assert!(sim.replies().contains(&"ALARM:1".to_owned()), "{leaves}");
    }
}
