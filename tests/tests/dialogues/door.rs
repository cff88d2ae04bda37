//! Buttons and the safety door, row by row of their table in docs/console.md.

use embassy_time::Duration;
use isostep_sim::world::Wire;
use isostep_sim::{Config, Flash, Sim};

use crate::talk::{
    ON, assert_at, begin, bytes, duty, field, homed, powered_up, refused, report, say, state, status, watch,
};

const OFF: [u16; 5] = [0; 5];
const FULL: [u16; 5] = [ON, ON, 0, 0, 0];

/// A homed machine with a door switch on the input of the feed hold button.
fn with_door() -> Sim {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$902=1"), ["ok"]);
    sim
}

/// Presses or releases a button whose contacts bounce for 2 ms. Then the input is steady for longer than the debounce
/// time.
fn bounce(sim: &mut Sim, wire: Wire, pressed: bool) {
    for flips in 0..4 {
        sim.set_hand_input(wire, pressed == (flips % 2 == 0));
        sim.run_for(Duration::from_micros(500)).unwrap();
    }
    sim.set_hand_input(wire, pressed);
    sim.run_for(Duration::from_millis(20)).unwrap();
}

fn pins(sim: &mut Sim) -> Option<String> {
    Some(report(sim).split("|Pn:").nth(1)?.split(['|', '>']).next()?.to_owned())
}

#[test]
fn the_feed_hold_button_holds() {
    let mut sim = homed();
    begin(&mut sim, "G1 X20 F600", Duration::from_secs(1));
    let before = sim.now();
    sim.set_hand_input(Wire::Hold, true);
    sim.run_for(Duration::from_micros(1)).unwrap();
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref()), ("Hold:1", Some("H")), "its first edge");
    assert!(sim.now() - before < Duration::from_millis(3));
    bounce(&mut sim, Wire::Hold, true);
    sim.run_until_idle().unwrap();
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref()), ("Hold:0", Some("H")));
    // It acts only when pressed: the hold can be resumed while it is still pressed.
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(status(&mut sim), "<Idle|MPos:20.000,0.000,0.000");
    begin(&mut sim, "G1 X0", Duration::from_secs(1));
    bounce(&mut sim, Wire::Hold, false);
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim)), ("Run", None), "letting it go holds nothing");
    bounce(&mut sim, Wire::Hold, true);
    assert_eq!(state(&mut sim), "Hold:1", "pressed once more");
    // It cancels a jog.
    let mut sim = homed();
    begin(&mut sim, "$J=X20 F600", Duration::from_secs(1));
    bounce(&mut sim, Wire::Hold, true);
    sim.run_until_idle().unwrap();
    assert!(state(&mut sim) == "Idle" && sim.counted_steps()[0] < 1_000);
}

#[test]
fn the_cycle_start_button_resumes() {
    let mut sim = homed();
    bounce(&mut sim, Wire::Start, true);
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref()), ("Idle", Some("S")), "nothing to resume");
    bounce(&mut sim, Wire::Start, false);
    assert_eq!(pins(&mut sim), None);
    assert_eq!(say(&mut sim, "G1 X5 F600 M0\nX10"), [""; 0]);
    // A press shorter than the debounce time has no effect.
    sim.set_hand_input(Wire::Start, true);
    sim.run_for(Duration::from_millis(2)).unwrap();
    sim.set_hand_input(Wire::Start, false);
    sim.run_until_idle().unwrap();
    assert_eq!(state(&mut sim), "Hold:0");
    bounce(&mut sim, Wire::Start, true);
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies().iter().filter(|line| *line == "ok").count(), 2);
    assert_eq!(status(&mut sim), "<Idle|MPos:10.000,0.000,0.000");
    // It has no effect while the machine brakes, and no second effect while it stays pressed.
    begin(&mut sim, "G1 X0", Duration::from_millis(500));
    bytes(&mut sim, b"!");
    sim.run_until_idle().unwrap();
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref()), ("Hold:0", Some("S")));
    bounce(&mut sim, Wire::Hold, true);
    assert_eq!(pins(&mut sim).as_deref(), Some("HS"));
}

/// Door:2 while the machine brakes, with the spindle on; Door:1 while the door is open, with all outputs off; Door:0
/// when it is closed; Door:3 while the spindle gets its speed.
#[test]
fn the_door_holds_and_puts_all_off() {
    let mut sim = with_door();
    assert_eq!(say(&mut sim, "$394=1\nM4 S500 M8"), ["ok", "ok"]);
    let on = [duty(0.5), ON, ON, ON, 0];
    begin(&mut sim, "G1 X30 F1200", Duration::from_secs(2));
    sim.set_hand_input(Wire::Hold, true);
    sim.run_for(Duration::from_micros(1)).unwrap();
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref(), sim.tool()), ("Door:2", Some("D"), on));
    let changes = watch(&mut sim, Duration::from_secs(1));
    assert_eq!(changes.iter().map(|change| change.1).collect::<Vec<_>>(), [OFF], "at standstill");
    let (held_us, last_ns) = (changes[0].0, sim.outcome().edges.last().unwrap().t_ns);
    assert!((0..25_000).contains(&(held_us as i64 - last_ns as i64 / 1_000)), "{held_us} us after {last_ns} ns");
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref()), ("Door:1", Some("D")));
    let stands = sim.counted_steps();
    for ignored in [b"~".as_slice(), b"!", b"\x84", b"\x9E", b"\xA0"] {
        bytes(&mut sim, ignored);
        assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:1", OFF), "{ignored:?}");
    }
    bounce(&mut sim, Wire::Start, true);
    bounce(&mut sim, Wire::Start, false);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:1", OFF), "the start button neither");
    bounce(&mut sim, Wire::Hold, false);
    assert_eq!(
        (state(&mut sim).as_str(), pins(&mut sim), sim.tool()),
        ("Door:0", None, OFF),
        "closing resumes nothing"
    );
    assert_eq!(sim.counted_steps(), stands);
    sim.send(b"~");
    sim.run_for(Duration::from_millis(900)).unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool(), sim.counted_steps()), ("Door:3", on, stands));
    sim.run_for(Duration::from_millis(200)).unwrap();
    assert_eq!(state(&mut sim), "Run");
    sim.run_until_idle().unwrap();
    assert_eq!((status(&mut sim).as_str(), sim.tool()), ("<Idle|MPos:30.000,0.000,0.000", on));
}

#[test]
fn the_door_puts_a_laser_off_at_once() {
    let mut sim = with_door();
    assert_eq!(say(&mut sim, "$32=1\nM3 S1000 M8"), ["ok", "ok"]);
    begin(&mut sim, "G1 X30 F1200", Duration::from_secs(1));
    assert_eq!(sim.tool(), [ON, ON, 0, ON, 0]);
    let before_ns = sim.now_ns();
    sim.set_hand_input(Wire::Hold, true);
    let changes = watch(&mut sim, Duration::from_secs(1));
    let [(at_us, OFF)] = changes[..] else { panic!("{changes:?}") };
    assert_at(at_us, before_ns, "at once");
    bounce(&mut sim, Wire::Hold, false);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:0", OFF));
    sim.send(b"~");
    sim.run_for(Duration::from_millis(500)).unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Run", [ON, ON, 0, ON, 0]));
}

/// The door is opened, closed and opened again while the machine brakes, resumes, or stands still.
#[test]
fn the_door_may_be_opened_at_any_time() {
    let mut sim = with_door();
    assert_eq!(say(&mut sim, "$394=1\nM3 S1000"), ["ok", "ok"]);
    begin(&mut sim, "G1 X30 F1200", Duration::from_secs(2));
    bounce(&mut sim, Wire::Hold, true);
    bounce(&mut sim, Wire::Hold, false);
    assert_eq!(state(&mut sim), "Door:2", "it brakes still");
    bytes(&mut sim, b"~");
    sim.run_until_idle().unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:0", OFF));
    bytes(&mut sim, b"~");
    sim.run_for(Duration::from_millis(500)).unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:3", FULL));
    bounce(&mut sim, Wire::Hold, true);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:1", OFF), "while the spindle gets its speed");
    bounce(&mut sim, Wire::Hold, false);
    bytes(&mut sim, b"~");
    sim.run_until_idle().unwrap();
    assert_eq!((status(&mut sim).as_str(), sim.tool()), ("<Idle|MPos:30.000,0.000,0.000", FULL));
    // In a hold, at rest and while the machine brakes.
    for hold_ms in [20, 2_000] {
        begin(&mut sim, "G91 G1 X-10 F1200", Duration::from_secs(1));
        bytes(&mut sim, b"!");
        sim.run_for(Duration::from_millis(hold_ms)).unwrap();
        assert!(state(&mut sim).starts_with("Hold"));
        bounce(&mut sim, Wire::Hold, true);
        sim.run_until_idle().unwrap();
        assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:1", OFF));
        bounce(&mut sim, Wire::Hold, false);
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Idle", FULL));
        sim.replies();
    }
    assert_eq!(sim.counted_steps(), [500, 0, 0]);
    // In a dwell, whose time stands still meanwhile.
    begin(&mut sim, "G4 P2", Duration::from_millis(100));
    bounce(&mut sim, Wire::Hold, true);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:1", OFF));
    bounce(&mut sim, Wire::Hold, false);
    bytes(&mut sim, b"~");
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:3", FULL));
    sim.run_for(Duration::from_millis(1_100)).unwrap();
    assert_eq!(state(&mut sim), "Run");
}

/// The door also counts at rest: motions requested while it is open wait until it is closed and the machine is resumed.
#[test]
fn what_is_asked_for_while_the_door_is_open_waits() {
    let mut sim = with_door();
    assert_eq!(say(&mut sim, "M3 S1000"), ["ok"]);
    bounce(&mut sim, Wire::Hold, true);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:1", OFF));
    assert_eq!(say(&mut sim, "G1 X5 F600\nG4 P0.1"), ["ok"], "the dwell is answered when it is over");
    assert_eq!((status(&mut sim).as_str(), sim.tool()), ("<Door:1|MPos:0.000,0.000,0.000", OFF));
    bounce(&mut sim, Wire::Hold, false);
    sim.run_until_idle().unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:0", OFF));
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok"]);
    assert_eq!((status(&mut sim).as_str(), sim.tool()), ("<Idle|MPos:5.000,0.000,0.000", FULL));
    bounce(&mut sim, Wire::Hold, true);
    for (line, code) in [("$J=X1 F100", 8), ("$H", 8), ("$$", 8), ("$C", 8)] {
        refused(&mut sim, line, code);
    }
}

/// A reset ends the hold although the door is still open. This allows a machine without a door to have its setting
/// changed.
#[test]
fn a_reset_with_the_door_open_moves_nothing() {
    let mut sim = with_door();
    begin(&mut sim, "M3 S1000\nG1 X30 F1200", Duration::from_secs(1));
    bounce(&mut sim, Wire::Hold, true);
    sim.run_until_idle().unwrap();
    let stands = sim.counted_steps();
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", "[MSG:Check Door]"]);
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref(), sim.tool()), ("Idle", Some("D"), OFF));
    refused(&mut sim, "$H", 13);
    refused(&mut sim, "$J=X1 F100", 13);
    // The spindle waits too: closing the door does not switch it on.
    assert_eq!(say(&mut sim, "M3 S1000"), ["ok"]);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:1", OFF));
    bounce(&mut sim, Wire::Hold, false);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:0", OFF));
    bytes(&mut sim, b"~");
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Idle", FULL));
    bounce(&mut sim, Wire::Hold, true);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    sim.replies();
    assert_eq!(say(&mut sim, "G91 G1 X1 F600"), ["ok"]);
    assert_eq!((state(&mut sim).as_str(), sim.counted_steps()), ("Door:1", stands));
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    sim.replies();
    assert_eq!(say(&mut sim, "$902=0"), ["ok"]);
    assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref()), ("Hold:0", Some("H")), "a button, pressed");
    assert_eq!(sim.counted_steps(), stands);
}

/// The door is opened while a reset brakes. The motion is discarded, and afterwards the door counts as at rest.
#[test]
fn the_door_opened_while_a_reset_brakes_counts() {
    let mut sim = with_door();
    begin(&mut sim, "M3 S1000\nG1 X30 F1200", Duration::from_secs(1));
    sim.send(b"\x18");
    sim.run_for(Duration::from_millis(50)).unwrap();
    sim.set_hand_input(Wire::Hold, true);
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", "[MSG:Check Door]"]);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:1", OFF));
    bounce(&mut sim, Wire::Hold, false);
    bytes(&mut sim, b"~");
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Idle", OFF));
    assert_eq!(sim.machine().status().homed, [true; 3]);
}

/// The setting is loaded from flash after the input was first read.
#[test]
fn a_door_open_at_power_up_is_one() {
    let (config, flash) = (Config::default(), Flash::blank());
    let mut sim = Sim::with_flash(&config, flash.clone());
    sim.run_until_idle().unwrap();
    sim.replies();
    assert_eq!(say(&mut sim, "$902=1\n$N0=G1 X5 F600"), ["ok", "ok"]);
    for is_open in [false, true] {
        let mut sim = Sim::with_flash(&config, flash.clone());
        sim.set_hand_input(Wire::Hold, is_open);
        sim.run_until_idle().unwrap();
        let heard = sim.replies();
        if !is_open {
            assert_eq!(heard, ["Grbl 1.1h ['$' for help]", ">G1X5F600:ok"]);
            continue;
        }
        assert_eq!(heard, ["Grbl 1.1h ['$' for help]", "[MSG:Check Door]", ">G1X5F600:ok"]);
        assert_eq!((state(&mut sim).as_str(), pins(&mut sim).as_deref()), ("Door:1", Some("D")));
        bytes(&mut sim, b"~");
        assert_eq!(sim.counted_steps(), [0; 3]);
        bounce(&mut sim, Wire::Hold, false);
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        assert_eq!(status(&mut sim), "<Idle|MPos:5.000,0.000,0.000");
    }
}

/// The byte acts like the door, but without a switch: nothing has to be closed before the resume.
#[test]
fn byte_84_is_the_door() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "M3 S1000"), ["ok"]);
    bytes(&mut sim, b"\x84");
    assert_eq!((state(&mut sim).as_str(), sim.tool(), pins(&mut sim)), ("Door:0", OFF, None), "at rest");
    bytes(&mut sim, b"~");
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Idle", FULL));
    sim.send(b"G1 X3\x840 F600\n");
    sim.run_for(Duration::from_millis(100)).unwrap();
    assert_eq!(sim.replies(), ["ok"], "in the middle of a line, which waits");
    assert_eq!(status(&mut sim), "<Door:0|MPos:0.000,0.000,0.000");
    bytes(&mut sim, b"~");
    sim.run_for(Duration::from_secs(1)).unwrap();
    bytes(&mut sim, b"\x84");
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:2", FULL));
    sim.run_until_idle().unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Door:0", OFF));
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!((status(&mut sim).as_str(), sim.tool()), ("<Idle|MPos:30.000,0.000,0.000", FULL));
}

/// The door cancels the jog and then acts as usual. Waiting jogs are discarded.
#[test]
fn the_door_cancels_a_jog() {
    for by_byte in [false, true] {
        let mut sim = with_door();
        begin(&mut sim, "M3 S1000\n$J=X30 F1200\n$J=X0 F1200\n$J=X30 F1200", Duration::from_secs(1));
        if by_byte {
            sim.send(b"\x84");
        } else {
            sim.set_hand_input(Wire::Hold, true);
        }
        sim.run_for(Duration::from_millis(10)).unwrap();
        assert_eq!(state(&mut sim), "Jog");
        sim.run_until_idle().unwrap();
        assert_eq!((state(&mut sim).as_str(), sim.tool()), (if by_byte { "Door:0" } else { "Door:1" }, OFF));
        let stands = sim.counted_steps();
        assert!(stands[0] < 1_500, "{stands:?}");
        bounce(&mut sim, Wire::Hold, false);
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        assert_eq!((state(&mut sim).as_str(), sim.counted_steps(), sim.tool()), ("Idle", stands, FULL));
        sim.replies();
        assert_eq!(say(&mut sim, "G91 G0 X1"), ["ok"]);
        assert_eq!(sim.counted_steps()[0], stands[0] + 50);
    }
}

#[test]
fn alarm_7_homing_door() {
    for by_byte in [false, true] {
        let mut sim = with_door();
        assert_eq!(say(&mut sim, "M3 S1000"), ["ok"]);
        begin(&mut sim, "$H", Duration::from_secs(1));
        if by_byte {
            sim.send(b"\x84");
        } else {
            sim.set_hand_input(Wire::Hold, true);
        }
        sim.run_until_idle().unwrap();
        let heard = sim.replies();
        assert!(heard.contains(&"ALARM:7".to_owned()) && heard.contains(&"error:9".to_owned()), "{heard:?}");
        let words = "[MSG:the safety door opened while homing, position unknown: close it, home again with $H]";
        assert!(heard.contains(&words.to_owned()), "{heard:?}");
        assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Alarm", OFF));
        assert_eq!(sim.machine().status().homed, [false; 3]);
        bounce(&mut sim, Wire::Hold, false);
        assert_eq!(say(&mut sim, "$H"), ["ok"]);
        assert_eq!(state(&mut sim), "Idle");
    }
}

/// In Alarm, `$X` and homing are refused while the door is open.
#[test]
fn error_13_door_open() {
    let mut sim = with_door();
    say(&mut sim, "G0 X-1");
    bounce(&mut sim, Wire::Hold, true);
    assert_eq!((state(&mut sim).as_str(), field(&mut sim, "Pn").as_str()), ("Alarm", "D"));
    for line in ["$X", "$H", "$HX"] {
        refused(&mut sim, line, 13);
        assert_eq!(state(&mut sim), "Alarm", "{line}");
    }
    bounce(&mut sim, Wire::Hold, false);
    assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
    assert_eq!(state(&mut sim), "Idle");
    // The same in Sleep, and after it.
    assert_eq!(say(&mut sim, "$SLP").last().unwrap(), "[MSG:Sleeping]");
    bounce(&mut sim, Wire::Hold, true);
    assert_eq!(state(&mut sim), "Sleep");
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    sim.replies();
    for line in ["$X", "$H"] {
        refused(&mut sim, line, 13);
        assert_eq!(state(&mut sim), "Alarm", "{line}");
    }
}

/// A hold of nothing must not unlock the machine.
#[test]
fn a_hold_after_a_sleep_does_not_unlock() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$SLP"), ["ok", "[MSG:Sleeping]"]);
    for byte in [b'!', 0x84] {
        bytes(&mut sim, &[byte]);
        assert_eq!(state(&mut sim), "Sleep");
    }
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    sim.replies();
    bytes(&mut sim, b"!");
    assert_eq!(state(&mut sim), "Alarm");
    refused(&mut sim, "G0 X1", 9);
}

#[test]
fn a_limit_or_an_emergency_stop_ends_the_door() {
    let mut sim = with_door();
    begin(&mut sim, "M3 S1000\nG1 X30 F1200", Duration::from_secs(1));
    bounce(&mut sim, Wire::Hold, true);
    sim.run_until_idle().unwrap();
    sim.set_emergency_stop(true);
    sim.run_for(Duration::from_millis(10)).unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool(), pins(&mut sim).as_deref()), ("Alarm", OFF, Some("DR")));
    sim.set_emergency_stop(false);
    bounce(&mut sim, Wire::Hold, false);
    sim.replies();
    assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
    bytes(&mut sim, b"~");
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Idle", OFF), "neither is resumed");
}
