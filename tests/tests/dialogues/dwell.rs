//! Dwells, and what interferes with them. As in Grbl, the time of a dwell stands still during a hold.

use embassy_time::Duration;
use isostep_sim::world::Wire;
use isostep_sim::{Config, Sim};

use crate::talk::{begin, bytes, homed, powered_up, say, state, status};

/// Runs until `wanted` is received. Returns how long that took, in milliseconds.
fn until_heard(sim: &mut Sim, wanted: &[&str]) -> u64 {
    for ms in 0..20_000 {
        let heard = sim.replies();
        if !heard.is_empty() {
            assert_eq!(heard, wanted);
            return ms;
        }
        sim.run_for(Duration::from_millis(1)).unwrap();
    }
    panic!("silence in {}", state(sim));
}

/// The machine is already at rest, so the hold is immediate.
#[test]
fn a_dwell_is_held_at_once() {
    let mut sim = homed();
    assert_eq!(begin(&mut sim, "G4 P1\nG0 X1", Duration::from_millis(100)), [""; 0]);
    for _ in 0..3 {
        assert_eq!(bytes(&mut sim, b"!"), [""; 0]);
        assert_eq!(state(&mut sim), "Hold:0");
        assert_eq!(bytes(&mut sim, b"~"), [""; 0]);
        assert_eq!(state(&mut sim), "Run");
    }
    assert_eq!(bytes(&mut sim, b"!"), [""; 0]);
    sim.run_until_idle().unwrap();
    assert_eq!((sim.replies(), state(&mut sim).as_str()), (vec![], "Hold:0"));
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok", "ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:1.000,0.000,0.000");
}

#[test]
fn a_held_dwell_has_its_rest_after_the_resume() {
    for hold_ms in [1, 600, 10_000] {
        let mut sim = homed();
        begin(&mut sim, "G4 P1", Duration::from_millis(400));
        bytes(&mut sim, b"!");
        sim.run_for(Duration::from_millis(hold_ms)).unwrap();
        assert_eq!((sim.replies(), state(&mut sim).as_str()), (vec![], "Hold:0"), "{hold_ms} ms");
        sim.send(b"~");
        let left_ms = until_heard(&mut sim, &["ok"]);
        assert!((599..=601).contains(&left_ms), "{left_ms} ms after a hold of {hold_ms} ms");
    }
}

/// The dwell lasts three years. A hold, a resume and a reset must not wait for it.
#[test]
fn a_dwell_of_years_is_held_resumed_and_reset() {
    let mut sim = homed();
    begin(&mut sim, "G0 X1\nG4 P99999999\nG0 X2", Duration::from_secs(3_600));
    for (byte, word) in [(b"!", "Hold:0"), (b"~", "Run"), (b"!", "Hold:0"), (b"~", "Run"), (b"!", "Hold:0")] {
        bytes(&mut sim, byte);
        assert_eq!(state(&mut sim), word);
        sim.run_for(Duration::from_secs(60)).unwrap();
        assert_eq!(state(&mut sim), word);
    }
    sim.replies();
    assert_eq!(bytes(&mut sim, b"\x18"), ["Grbl 1.1h ['$' for help]"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:1.000,0.000,0.000", "what waited is forgotten");
    assert_eq!(sim.machine().homed(), [true; 3]);
    assert_eq!(say(&mut sim, "G4 P0.1\nG0 X3"), ["ok", "ok"]);
}

/// The line of the dwell is forgotten because the console is opened again. Commands that wait for moves to end must
/// also wait for the dwell.
#[test]
fn what_waits_for_a_held_dwell_waits_for_its_rest() {
    let mut sim = homed();
    begin(&mut sim, "G4 P1", Duration::from_millis(100));
    sim.open_console();
    assert_eq!(bytes(&mut sim, b""), ["Grbl 1.1h ['$' for help]"]);
    assert_eq!(begin(&mut sim, "G10 L2 P2 X5", Duration::from_millis(100)), [""; 0]);
    assert_eq!(bytes(&mut sim, b"!"), [""; 0]);
    assert_eq!(state(&mut sim), "Hold:0");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), [""; 0]);
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok"]);
}

#[test]
fn an_emergency_stop_ends_a_dwell_held_or_not() {
    for hold in ["", "!"] {
        let mut sim = homed();
        begin(&mut sim, "G4 P10\nG0 X5", Duration::from_millis(100));
        bytes(&mut sim, hold.as_bytes());
        sim.set_emergency_stop(true);
        sim.run_for(Duration::from_millis(20)).unwrap();
        let heard = sim.replies();
        assert_eq!(state(&mut sim), "Alarm", "{hold:?}");
        assert!(heard.contains(&"ALARM:10".to_owned()), "{hold:?}: {heard:?}");
        sim.set_emergency_stop(false);
        sim.run_until_idle().unwrap();
        assert_eq!(sim.counted_steps(), [0; 3], "{hold:?}");
    }
}

/// A dwell behind a spindle that gets its speed must still last its full time.
#[test]
fn the_door_holds_a_dwell_whose_rest_comes_after_the_spindle_has_its_speed() {
    let mut config = Config::default();
    (config.settings.hold_input_is_door, config.settings.spin_up_s) = (true, 1.0);
    let mut sim = powered_up(&config);
    assert_eq!(say(&mut sim, "M3 S1000\nG4 P0"), ["ok", "ok"]);
    begin(&mut sim, "G4 P2", Duration::from_millis(500));
    sim.set_hand_input(Wire::Hold, true);
    sim.run_for(Duration::from_secs(5)).unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool()[1]), ("Door:1", 0));
    assert_eq!(bytes(&mut sim, b"~"), [""; 0]);
    assert_eq!(state(&mut sim), "Door:1", "it is open still");
    sim.set_hand_input(Wire::Hold, false);
    sim.run_for(Duration::from_millis(50)).unwrap();
    assert_eq!(state(&mut sim), "Door:0");
    sim.send(b"~");
    sim.run_for(Duration::from_millis(500)).unwrap();
    assert_eq!(state(&mut sim), "Door:3");
    let left_ms = 500 + until_heard(&mut sim, &["ok"]);
    // 1 s for the spindle and 1.5 s for the dwell, minus the debounce time of an input.
    assert!((2_490..=2_510).contains(&left_ms), "{left_ms} ms");
}
