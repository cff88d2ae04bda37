//! Spindle and coolant, row by row of the table of the tool in docs/console.md.

use embassy_time::Duration;
use isostep_motion::{Axis, Level, Outputs, Spindle};
use isostep_sim::tool::{ToolChange, ToolOutput};
use isostep_sim::{Config, Port, Sim, SwitchFault};

use crate::talk::{
    ON, assert_at, begin, bytes, duty, field, homed, powered_up, refused, report, say, state, status, watch,
};

const OFF: [u16; 5] = [0; 5];
/// Full speed clockwise.
const FULL: [u16; 5] = [ON, ON, 0, 0, 0];

/// The accessories in a report, which come after the overrides.
fn accessories(sim: &mut Sim) -> Option<String> {
    let reported = (0..40).map(|_| report(sim)).find(|report| report.contains("|Ov:")).expect("overrides");
    Some(reported.split("|A:").nth(1)?.trim_end_matches('>').to_owned())
}

/// The words for spindle and coolant in `$G`.
fn modes(sim: &mut Sim) -> String {
    let heard = say(sim, "$G");
    let words = heard[0].split(' ').filter(|word| word.starts_with('M'));
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn m3_m4_m5_turn_the_spindle() {
    let mut sim = homed();
    assert_eq!((sim.tool(), accessories(&mut sim)), (OFF, None));
    for (line, outputs, modes_reported, reported) in [
        ("M3 S1000", FULL, "M3 M9", Some("S")),
        ("M4", [ON, ON, ON, 0, 0], "M4 M9", Some("C")),
        ("M3 S500", [duty(0.5), ON, 0, 0, 0], "M3 M9", Some("S")),
        ("M5", OFF, "M5 M9", None),
        ("S250", OFF, "M5 M9", None),
        ("M4", [duty(0.25), ON, ON, 0, 0], "M4 M9", Some("C")),
        ("M5", OFF, "M5 M9", None),
    ] {
        assert_eq!(say(&mut sim, line), ["ok"], "{line}");
        assert_eq!((sim.tool(), modes(&mut sim).as_str()), (outputs, modes_reported), "{line}");
        assert_eq!(accessories(&mut sim).as_deref(), reported, "{line}");
    }
}

/// A spindle of 24,000 rpm. It turns from 6,000 rpm at a duty of 20 %, and reaches full speed at 90 %.
#[test]
fn s_is_linear_from_the_least_to_the_full_duty() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$30=24000\n$31=6000\n$36=90\n$35=20\n$33=20000\nM3"), ["ok"; 6]);
    assert_eq!((sim.tool(), field(&mut sim, "FS").as_str()), (OFF, "0,0"), "S0");
    for (speed, ratio, reported) in [
        ("0.001", 0.2, "0,6000"),
        ("1", 0.2, "0,6000"),
        ("6000", 0.2, "0,6000"),
        ("10500", 0.375, "0,10500"),
        ("15000", 0.55, "0,15000"),
        ("24000", 0.9, "0,24000"),
        ("30000", 0.9, "0,24000"),
        ("0", 0.0, "0,0"),
    ] {
        assert_eq!(say(&mut sim, &format!("S{speed}")), ["ok"]);
        assert!(sim.tool()[0].abs_diff(duty(ratio)) <= 1, "S{speed}: {:?}", sim.tool());
        let enable = if speed == "0" { 0 } else { ON };
        assert_eq!((sim.tool()[1], field(&mut sim, "FS").as_str()), (enable, reported), "S{speed}");
    }
    for (line, again) in [("$31=24000", "$31=6000"), ("$35=91", "$35=20")] {
        assert_eq!(say(&mut sim, line).last().unwrap(), "ok");
        assert_eq!(sim.tool(), [0; 5], "{line}: all is off while settings do not work together");
        refused(&mut sim, "M3 S1000", 9);
        assert_eq!(say(&mut sim, again), ["ok"]);
    }
}

/// M3, S, M8 and M5 each wait for the moves before them, and take effect at the instant at which those end.
#[test]
fn a_spindle_waits_for_the_moves_before_it() {
    let mut sim = homed();
    sim.send(b"G1 X5 F600\nM3 S1000\nG1 X10\nS500\nX15\nM8\nX20\nM5 M9\n");
    let changes = watch(&mut sim, Duration::from_secs(4));
    let expected = [FULL, [duty(0.5), ON, 0, 0, 0], [duty(0.5), ON, 0, ON, 0], OFF];
    assert_eq!(changes.iter().map(|change| change.1).collect::<Vec<_>>(), expected);
    let outcome = sim.outcome();
    let moves = outcome.moves.iter().filter(|record| !record.homing);
    for (record, (at_us, outputs)) in moves.zip(changes) {
        assert_at(at_us, record.end_ns, &format!("{outputs:?}"));
    }
    assert_eq!(sim.replies(), ["ok"; 8]);
}

/// After a start, and after a reversal, nothing moves, dwells or jogs until the time has passed. A change of speed
/// takes no time.
#[test]
fn setting_394_gives_the_spindle_time() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$394=1.5\nF600"), ["ok", "ok"]);
    let mut x_mm = 0;
    let mut waits_ms = |sim: &mut Sim, line: &str| {
        assert_eq!(begin(sim, line, Duration::from_millis(1)), ["ok"], "{line}: answered at once");
        x_mm += 1;
        let asked_ns = sim.now_ns();
        assert_eq!(say(sim, &format!("G1 X{x_mm}")), ["ok"]);
        let outcome = sim.outcome();
        let first = outcome.edges.iter().find(|edge| edge.t_ns >= asked_ns).unwrap();
        (first.t_ns - asked_ns) / 1_000_000
    };
    let at_once_ms = waits_ms(&mut sim, "G4 P0");
    assert!(at_once_ms < 100, "{at_once_ms} ms");
    for (line, spins_up) in [
        ("M3 S1000", true),
        ("S500", false),
        ("M3 S400", false),
        ("M4", true),
        ("M8", false),
        ("M5", false),
        ("S100", false),
        ("M3", true),
    ] {
        let wait_ms = waits_ms(&mut sim, line);
        // The move was requested a millisecond after the spindle.
        let expected_ms = at_once_ms + if spins_up { 1_499 } else { 0 };
        assert!(wait_ms.abs_diff(expected_ms) <= 1, "{line}: {wait_ms} ms, not {expected_ms}");
    }
    assert_eq!(say(&mut sim, "M5"), ["ok"]);
    let before = sim.now();
    assert_eq!(say(&mut sim, "M3 G4 P0.5"), ["ok"]);
    let took = sim.now() - before;
    assert!((2_000..2_005).contains(&took.as_millis()), "{took:?}");
    // M5 before the spindle has its speed: the move does not wait.
    assert_eq!(begin(&mut sim, "M4\nM5\nG1 X0", Duration::from_millis(200)), ["ok"; 3]);
    assert!(sim.machine().position_steps()[0] < 50 * x_mm, "it moves");
}

/// A spindle with S0 stands, whatever its direction: enable is off, because a VFD runs by it. It begins to turn with the
/// next S, and nothing moves before it has its speed.
#[test]
fn a_spindle_that_starts_from_s0_is_waited_for() {
    for port in Port::ALL {
        for (stands, modes_reported) in
            [("M4 S0\nG4 P0.1", "M4 M9"), ("M3 S900\nG4 P0\nS0\nG0 X1\nG4 P3", "M3 M9"), ("M3\nM4", "M4 M9")]
        {
            for goes in ["G1 X2 F300", "G0 X2", "$J=X2 F300"] {
                let mut sim = powered_up(&Config { port, ..Config::default() });
                assert_eq!(say(&mut sim, "$394=2.5").last_line(), "ok");
                assert_eq!(say(&mut sim, stands).last_line(), "ok");
                assert_eq!((sim.tool(), accessories(&mut sim)), (OFF, None), "{port}, {stands:?}");
                assert_eq!(modes(&mut sim), modes_reported, "{stands:?}");
                assert_eq!(say(&mut sim, &format!("S900\n{goes}")), ["ok", "ok"], "{stands:?}");
                let outcome = sim.outcome();
                let is_rise = |change: &&ToolChange| change.output == ToolOutput::Pwm && change.duty > 0;
                let rose_ns = outcome.tool.iter().rfind(is_rise).unwrap().t_ns;
                let first = outcome.edges.iter().find(|edge| edge.t_ns > rose_ns).unwrap();
                let waits_ms = (first.t_ns - rose_ns) / 1_000_000;
                assert!((2_500..2_700).contains(&waits_ms), "{port}, {stands:?}, {goes}: {waits_ms} ms");
            }
        }
    }
}

/// With S0 nothing is waited for, and a hold has nothing to start again.
#[test]
fn a_spindle_with_s0_holds_nothing_up() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$394=2.5\nM3 S0"), ["ok", "ok"]);
    let before = sim.now();
    assert_eq!(say(&mut sim, "G1 X1 F600"), ["ok"]);
    assert!(sim.now() - before < Duration::from_secs(1));
    bytes(&mut sim, b"!");
    for byte in [0x9E, 0x9E, 0x9A] {
        bytes(&mut sim, &[byte]);
        assert_eq!(sim.tool(), OFF, "after 0x{byte:x}");
    }
    let before = sim.now();
    sim.send(b"~G1 X2\n");
    sim.run_until_idle().unwrap();
    assert!(sim.now() - before < Duration::from_secs(1));
}

/// The machine is held, jogged, reset, or stopped while the spindle gets its speed.
#[test]
fn a_spin_up_may_be_interfered_with() {
    let spinning = || {
        let mut sim = homed();
        assert_eq!(say(&mut sim, "$394=2"), ["ok"]);
        assert_eq!(begin(&mut sim, "M3 S1000\nG1 X5 F600", Duration::from_millis(500)), ["ok", "ok"]);
        assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Run", FULL));
        sim
    };
    // A hold is at rest at once. The remaining time passes during it or after it.
    for hold_ms in [500, 5_000] {
        let mut sim = spinning();
        bytes(&mut sim, b"!");
        assert_eq!(state(&mut sim), "Hold:0");
        sim.run_for(Duration::from_millis(hold_ms)).unwrap();
        assert_eq!((sim.counted_steps(), sim.tool()), ([0; 3], FULL));
        sim.send(b"~");
        sim.run_for(Duration::from_millis(400)).unwrap();
        assert_eq!(sim.counted_steps() != [0; 3], hold_ms > 2_000);
        sim.run_until_idle().unwrap();
        assert_eq!(status(&mut sim), "<Idle|MPos:5.000,0.000,0.000");
    }
    let mut sim = spinning();
    sim.send(b"\x18");
    sim.run_for(Duration::from_millis(1)).unwrap();
    assert_eq!((sim.replies(), sim.tool()), (vec!["Grbl 1.1h ['$' for help]".to_owned()], OFF));
    assert_eq!(say(&mut sim, "G1 X1 F600"), ["ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:1.000,0.000,0.000");
    let mut sim = spinning();
    sim.set_emergency_stop(true);
    sim.run_for(Duration::from_millis(10)).unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool(), sim.counted_steps()), ("Alarm", OFF, [0; 3]));
    // A jog waits too, and can be cancelled.
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$394=2"), ["ok"]);
    assert_eq!(begin(&mut sim, "M3 S1000\n$J=X5 F600", Duration::from_millis(500)), ["ok", "ok"]);
    assert_eq!((state(&mut sim).as_str(), sim.counted_steps()), ("Jog", [0; 3]));
    bytes(&mut sim, b"\x85");
    assert_eq!((state(&mut sim).as_str(), sim.tool(), sim.counted_steps()), ("Idle", FULL, [0; 3]));
}

#[test]
fn m7_m8_m9_switch_the_coolant() {
    let mut sim = homed();
    for (line, outputs, modes_reported, reported) in [
        ("M7", [0, 0, 0, 0, ON], "M5 M7", Some("M")),
        ("M8", [0, 0, 0, ON, ON], "M5 M7 M8", Some("FM")),
        ("M3 S1000", [ON, ON, 0, ON, ON], "M3 M7 M8", Some("SFM")),
        ("M9", FULL, "M3 M9", Some("S")),
        ("M8 M5", [0, 0, 0, ON, 0], "M5 M8", Some("F")),
        ("M9", OFF, "M5 M9", None),
    ] {
        assert_eq!(say(&mut sim, line), ["ok"], "{line}");
        assert_eq!((sim.tool(), modes(&mut sim).as_str()), (outputs, modes_reported), "{line}");
        assert_eq!(accessories(&mut sim).as_deref(), reported, "{line}");
    }
    refused(&mut sim, "M7 M8", 21);
}

#[test]
fn m2_and_m30_put_all_off() {
    for line in ["M2", "M30"] {
        let mut sim = homed();
        assert_eq!(say(&mut sim, "M4 S1000 M8\nM7"), ["ok", "ok"]);
        assert_eq!(sim.tool(), [ON; 5]);
        sim.send(format!("G1 X5 F600\nX10 {line}\n").as_bytes());
        let changes = watch(&mut sim, Duration::from_secs(2));
        let [(at_us, OFF)] = changes[..] else { panic!("{changes:?}") };
        assert_at(at_us, sim.outcome().moves.last().unwrap().end_ns, line);
        assert_eq!(sim.replies(), ["ok", "[MSG:Pgm End]", "ok"]);
        assert_eq!(modes(&mut sim), "M5 M9");
    }
}

/// The overrides act at once, in motion and at rest. The report gives the current speed of the spindle.
#[test]
fn spindle_overrides_act_at_once() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "M3 S400"), ["ok"]);
    begin(&mut sim, "G1 X50 F600", Duration::from_secs(1));
    for (byte, percent) in [(0x9A, 110), (0x9C, 111), (0x9D, 110), (0x9B, 100), (0x9B, 90), (0x99, 100)] {
        let before_ns = sim.now_ns();
        sim.send(&[byte]);
        let changes = watch(&mut sim, Duration::from_millis(1));
        let [(at_us, outputs)] = changes[..] else { panic!("{changes:?}") };
        assert_at(at_us, before_ns, "at once");
        assert!(outputs[0].abs_diff(duty(f64::from(percent) * 0.004)) <= 1, "{percent} %: {outputs:?}");
        assert_eq!(field(&mut sim, "FS"), format!("600,{}", percent * 4));
        assert_eq!(field(&mut sim, "Ov"), format!("100,100,{percent}"));
    }
    bytes(&mut sim, &[0x9A; 10]);
    assert_eq!(sim.tool()[0], duty(0.8), "200 %");
    assert_eq!(say(&mut sim, "S900"), ["ok"]);
    assert_eq!((sim.tool(), field(&mut sim, "FS").as_str()), (FULL, "0,1000"), "no faster than $30");
    assert_eq!(say(&mut sim, "M2"), ["[MSG:Pgm End]", "ok"]);
    assert_eq!(say(&mut sim, "M3 S400"), ["ok"]);
    assert_eq!(sim.tool()[0], duty(0.4), "the program's end puts it back");
}

/// The byte acts only in a hold at rest. The resume switches the spindle on again, and the moves wait until it has its
/// speed.
#[test]
fn byte_9e_stops_the_spindle_while_held() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$394=1\nM3 S1000 M8"), ["ok", "ok"]);
    let on = [ON, ON, 0, ON, 0];
    bytes(&mut sim, b"\x9E");
    assert_eq!(sim.tool(), on, "in Idle");
    begin(&mut sim, "G1 X50 F600", Duration::from_secs(3));
    bytes(&mut sim, b"\x9E");
    assert_eq!(sim.tool(), on, "in motion");
    bytes(&mut sim, b"!");
    bytes(&mut sim, b"\x9E");
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Hold:1", on), "while it brakes");
    sim.run_until_idle().unwrap();
    bytes(&mut sim, b"\x9E");
    assert_eq!((sim.tool(), accessories(&mut sim).as_deref()), ([0, 0, 0, ON, 0], Some("F")));
    assert_eq!(field(&mut sim, "FS"), "0,0");
    bytes(&mut sim, b"\x9E");
    assert_eq!((sim.tool(), accessories(&mut sim).as_deref()), (on, Some("SF")));
    bytes(&mut sim, b"\x9E");
    assert_eq!((sim.tool(), modes(&mut sim).as_str()), ([0, 0, 0, ON, 0], "M3 M8"), "what was asked for stays");
    let (stands, resumed) = (sim.counted_steps(), sim.now_ns());
    bytes(&mut sim, b"~");
    assert_eq!((sim.tool(), state(&mut sim).as_str()), (on, "Run"));
    sim.run_until_idle().unwrap();
    let outcome = sim.outcome();
    let first = outcome.edges.iter().find(|edge| edge.t_ns > resumed).unwrap();
    assert!((1_000..1_100).contains(&((first.t_ns - resumed) / 1_000_000)), "{first:?} from {stands:?}");
}

/// The spindle must be off, because a person reaches in.
#[test]
fn the_spindle_stands_for_a_tool_change() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$394=1\nM3 S1000 M8\nG1 X1 F600"), ["ok"; 3]);
    assert_eq!(say(&mut sim, "T2 M6"), ["[MSG:M6: put in tool 2, then resume with ~]"]);
    assert_eq!(sim.tool(), [0, 0, 0, ON, 0]);
    let asked_ns = sim.now_ns();
    sim.send(b"~G1 X2\n");
    sim.run_for(Duration::from_millis(1)).unwrap();
    assert_eq!(sim.tool(), [ON, ON, 0, ON, 0]);
    sim.run_until_idle().unwrap();
    let first = sim.outcome().edges.into_iter().find(|edge| edge.t_ns >= asked_ns).unwrap();
    assert!(first.t_ns - asked_ns >= 1_000_000_000, "{} ns", first.t_ns - asked_ns);
}

/// Somebody reaches for the tool: neither 0x9E nor an override of the speed turns the spindle on.
#[test]
fn nothing_starts_the_spindle_in_a_change_of_the_tool() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "M3 S500"), ["ok"]);
    assert_eq!(say(&mut sim, "M6 T1"), ["[MSG:M6: put in tool 1, then resume with ~]"]);
    for byte in [0x9E, 0x9E, 0x9A, 0x99, 0x9E] {
        assert_eq!(bytes(&mut sim, &[byte]), [""; 0]);
        assert_eq!(sim.tool(), OFF, "after 0x{byte:x}");
    }
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!((sim.replies(), sim.tool()[1]), (vec!["ok".to_owned()], ON));
    // The next hold is an ordinary one.
    assert_eq!(say(&mut sim, "M0"), [""; 0]);
    for on in [0, ON] {
        bytes(&mut sim, b"\x9e");
        assert_eq!(sim.tool()[1], on);
    }
}

fn toggles(byte: u8, output: usize, word: &str) {
    let mut sim = homed();
    let all = |on: bool| std::array::from_fn(|index| if on && index == output { ON } else { 0 });
    for line in ["G4 P0", "G1 X50 F600", "!"] {
        sim.send(line.as_bytes());
        sim.send(b"\n");
        sim.run_for(Duration::from_millis(500)).unwrap();
        sim.replies();
        for on in [true, false] {
            assert_eq!(bytes(&mut sim, &[byte]), [""; 0]);
            assert_eq!(sim.tool(), all(on), "{line}");
            let heard = begin(&mut sim, "$G", Duration::from_millis(1));
            assert_eq!(heard.iter().any(|line| line.contains(word)), on, "{line}: {heard:?}");
        }
    }
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    sim.replies();
    // A program can switch an output that was switched by hand.
    bytes(&mut sim, &[byte]);
    assert_eq!(say(&mut sim, "M9"), ["ok"]);
    assert_eq!(sim.tool(), OFF);
    // The byte has no effect while jogging, in Alarm, or in check mode.
    begin(&mut sim, "$J=X10 F600", Duration::from_millis(100));
    bytes(&mut sim, &[byte]);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Jog", OFF));
    sim.run_until_idle().unwrap();
    assert_eq!(say(&mut sim, "$C").last().unwrap(), "ok");
    bytes(&mut sim, &[byte]);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Check", OFF));
    say(&mut sim, "$C");
    say(&mut sim, "G0 X-1");
    bytes(&mut sim, &[byte]);
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Alarm", OFF));
}

#[test]
fn byte_a0_toggles_flood() {
    toggles(0xA0, 3, "M8");
}

#[test]
fn byte_a1_toggles_mist() {
    toggles(0xA1, 4, "M7");
}

/// Every output must be off within 10 us of the stop, and must stay off until it is requested again.
fn all_off(stop: impl Fn(&mut Sim), alarms: bool, why: &str) {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "M4 S1000 M8\nM7"), ["ok", "ok"]);
    begin(&mut sim, "G1 X50 F1200", Duration::from_secs(1));
    assert_eq!(sim.tool(), [ON; 5], "{why}");
    let before_ns = sim.now_ns();
    stop(&mut sim);
    let changes = watch(&mut sim, Duration::from_millis(200));
    let [(at_us, OFF)] = changes[..] else { panic!("{why}: {changes:?}") };
    assert_at(at_us, before_ns, why);
    sim.set_switch(Axis::Y, SwitchFault::None);
    sim.set_emergency_stop(false);
    sim.run_until_idle().unwrap();
    if alarms {
        assert_eq!(state(&mut sim), "Alarm", "{why}");
        refused(&mut sim, "M3", 9);
        sim.replies();
        assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"], "{why}");
    }
    sim.replies();
    assert_eq!((state(&mut sim).as_str(), modes(&mut sim).as_str(), sim.tool()), ("Idle", "M5 M9", OFF), "{why}");
    assert_eq!(say(&mut sim, "G91 G1 X1 F600\nG90"), ["ok", "ok"], "{why}");
    assert_eq!((sim.tool(), accessories(&mut sim)), (OFF, None), "{why}");
    assert_eq!(say(&mut sim, "M3 S1000"), ["ok"], "{why}");
    assert_eq!(sim.tool(), FULL, "{why}");
}

#[test]
fn a_stop_puts_all_outputs_off_at_once() {
    all_off(|sim| sim.set_emergency_stop(true), true, "emergency stop");
    all_off(|sim| sim.set_switch(Axis::Y, SwitchFault::StuckClosed), true, "limit switch");
    all_off(|sim| sim.machine().tool_cut_off(), true, "tool cut off");
    all_off(|sim| sim.send(b"\x18"), false, "reset");
    all_off(|sim| sim.send(b"\x18\x18"), true, "two resets");
}

/// The outputs stay off even if they are requested.
#[test]
fn outputs_stay_off_while_a_reset_brakes() {
    let mut sim = homed();
    begin(&mut sim, "M3 S1000\nG1 X50 F1200", Duration::from_secs(1));
    bytes(&mut sim, b"\x18");
    assert_eq!(state(&mut sim), "Hold:1");
    let on = Outputs { spindle: Spindle::Clockwise, level: Level::FULL, ..Outputs::OFF };
    assert!(sim.machine().set_outputs(on).is_err() && sim.machine().set_coolant(true, false).is_err());
    assert_eq!(sim.machine().set_outputs(Outputs::OFF), Ok(()));
    sim.run_until_idle().unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Idle", OFF));
    assert_eq!(sim.machine().set_outputs(on), Ok(()));
}

/// The same at rest.
#[test]
fn alarms_and_resets_at_rest_put_all_outputs_off() {
    for (stop, answers) in [("G0 X-1\n", 4), ("$SLP\n", 2), ("\x18", 1), ("$C\n$C\n", 5), ("$RST=#\n", 3)] {
        let mut sim = homed();
        assert_eq!(say(&mut sim, "M3 S1000 M8"), ["ok"]);
        sim.send(stop.as_bytes());
        sim.run_until_idle().unwrap();
        assert_eq!((sim.tool(), sim.replies().len()), (OFF, answers), "{stop:?}");
        assert_eq!(accessories(&mut sim), None, "{stop:?}");
        sim.send(b"\x18");
        sim.run_until_idle().unwrap();
        sim.replies();
        say(&mut sim, "$X");
        assert_eq!((modes(&mut sim).as_str(), sim.tool()), ("M5 M9", OFF), "{stop:?}");
        assert_eq!(say(&mut sim, "M3 S1000"), ["ok"], "{stop:?}");
        assert_eq!(sim.tool(), FULL, "{stop:?}");
    }
    let mut sim = homed();
    assert_eq!(say(&mut sim, "M3 S1000 M8"), ["ok"]);
    sim.set_emergency_stop(true);
    sim.run_for(Duration::from_millis(1)).unwrap();
    assert_eq!(sim.tool(), OFF);
}

#[test]
fn homing_leaves_the_spindle_on() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "M3 S1000 M8"), ["ok"]);
    begin(&mut sim, "$H", Duration::from_secs(1));
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Home", [ON, ON, 0, ON, 0]));
    sim.run_until_idle().unwrap();
    assert_eq!((sim.replies(), sim.tool()), (vec!["ok".to_owned()], [ON, ON, 0, ON, 0]));
    assert_eq!(modes(&mut sim), "M3 M8");
    // Homing from an alarm is different: the outputs were switched off by the alarm.
    say(&mut sim, "G0 X-1");
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    assert_eq!((modes(&mut sim).as_str(), sim.tool()), ("M5 M9", OFF));
}

#[test]
fn check_mode_switches_nothing() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$C\nM3 S1000 M8\nG1 X5 F600\nM4"), ["[MSG:Enabled]", "ok", "ok", "ok", "ok"]);
    assert_eq!((sim.tool(), modes(&mut sim).as_str()), (OFF, "M4 M8"));
    assert_eq!(say(&mut sim, "M30\n$C").len(), 5);
    assert_eq!(say(&mut sim, "M3 S1000\n$C\nM5\nM30").len(), 6);
    assert_eq!(sim.tool(), FULL, "nothing is done in check mode");
    assert_eq!(say(&mut sim, "$C").len(), 3);
    assert_eq!((sim.tool(), modes(&mut sim).as_str()), (OFF, "M5 M9"), "its end is a reset");
}

#[test]
fn a_startup_line_may_switch_the_spindle() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$N0=M3 S1000"), ["ok"]);
    assert_eq!(sim.tool(), FULL);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", ">M3S1000:ok"]);
    assert_eq!(sim.tool(), FULL);
}

/// S and coolant in one line: neither hides the other.
#[test]
fn a_line_may_change_the_speed_and_the_coolant() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "M3 S1000\nS500 M8"), ["ok", "ok"]);
    assert_eq!(sim.tool(), [duty(0.5), ON, 0, ON, 0]);
    assert_eq!(say(&mut sim, "S1000 M9"), ["ok"]);
    assert_eq!(sim.tool(), FULL);
}

/// An alarm switches the outputs off, but not the override, which the report still shows.
#[test]
fn the_override_of_the_spindle_outlives_an_alarm() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "M3 S500"), ["ok"]);
    bytes(&mut sim, b"\x9A");
    let raised = sim.tool();
    assert!(raised[0] > duty(0.54) && raised[0] < duty(0.56), "{raised:?}");
    assert!(say(&mut sim, "G0 X-5").contains(&"ALARM:2".to_owned()));
    assert_eq!(sim.tool(), OFF);
    assert_eq!(say(&mut sim, "$X\nM3 S500")[1..], ["ok", "ok"]);
    assert_eq!(sim.tool(), raised);
}
