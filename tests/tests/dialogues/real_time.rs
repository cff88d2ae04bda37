//! Each real-time byte of the table in docs/console.md.

use embassy_time::Duration;
use isostep_motion::Axis;
use isostep_sim::{Config, Port, Sim, SwitchFault};

use crate::talk::{begin, bytes, field, homed, powered_up, report, say, state, status, switched_on};

/// The overrides of a fresh machine after these bytes. The bytes must not be answered.
fn overrides_after(sent: &[u8]) -> String {
    let mut sim = homed();
    assert_eq!(bytes(&mut sim, sent), [""; 0]);
    field(&mut sim, "Ov")
}

/// Sends the bytes in the middle of a line. The line must stay whole.
fn within_a_line(sent: &[u8]) -> Sim {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G0 X2"), ["ok"]);
    sim.send(&[b"G0 X1", sent, b"5\n"].concat());
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:15.000,0.000,0.000");
    sim
}

#[test]
fn byte_3f_reports_the_status() {
    let mut sim = homed();
    sim.send(b"G0 X1?0\n");
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    assert!(heard[0].starts_with("<Idle|MPos:0.000,0.000,0.000|FS:0,0|"), "{heard:?}");
    assert_eq!(heard[1..], ["ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:10.000,0.000,0.000");
}

#[test]
fn byte_18_resets() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G91 G20"), ["ok"]);
    bytes(&mut sim, b"\x91");
    sim.send(b"G0 X1\x18G0 X");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]"]);
    assert_eq!(say(&mut sim, "2"), ["ok"], "what came behind it is a new line");
    assert_eq!(status(&mut sim), "<Idle|MPos:2.000,0.000,0.000");
    assert_eq!(field(&mut sim, "Ov"), "100,100,100");
    begin(&mut sim, "G90 G0 X50\nG0 X0", Duration::from_millis(500));
    sim.send(b"\x18");
    sim.run_for(Duration::from_millis(100)).unwrap();
    assert_eq!(state(&mut sim), "Hold:1", "it brakes");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]"]);
    assert_eq!(state(&mut sim), "Idle");
    assert_eq!(sim.machine().status().homed, [true; 3]);
}

/// However much of a report has been sent, and however full the console's output is.
#[test]
fn byte_18_cuts_no_line() {
    const BYTE: Duration = Duration::from_micros(87);
    let mut sim = switched_on(&Config { baud: Some(115_200), ..Config::default() });
    sim.replies();
    let settings = say(&mut sim, "$$");
    let whole = |line: &String| line.starts_with("<Idle|MPos:0.000,0.000,0.000|") && line.ends_with('>');
    for bytes in 0..90 {
        for asked in ["?", "$$\n$$\n?", "$$\n$$\n$$\n"] {
            sim.send(asked.as_bytes());
            sim.run_for(BYTE * (bytes * asked.len() as u32)).unwrap();
            sim.send(b"\x18");
            sim.run_until_idle().unwrap();
            let mut heard = sim.replies();
            assert_eq!(heard.pop().unwrap(), "Grbl 1.1h ['$' for help]", "{heard:?}");
            for line in &heard {
                assert!(line.is_empty() || settings.contains(line) || whole(line), "{asked:?} after {bytes}: {line:?}");
            }
        }
    }
}

/// The byte comes in the middle of a line, which is carried out after the resume.
#[test]
fn byte_21_holds_the_move_under_way() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G0 X2"), ["ok"]);
    sim.send(b"G0 X4!0\n");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok"], "the line is taken; its move waits");
    assert_eq!(status(&mut sim), "<Hold:0|MPos:2.000,0.000,0.000");
    assert_eq!(bytes(&mut sim, b"~"), [""; 0]);
    sim.run_until_idle().unwrap();
    assert_eq!(status(&mut sim), "<Idle|MPos:40.000,0.000,0.000");
    begin(&mut sim, "G0 X0", Duration::from_millis(500));
    assert_eq!(bytes(&mut sim, b"!"), [""; 0]);
    assert_eq!(state(&mut sim), "Hold:1");
    sim.run_until_idle().unwrap();
    let held = status(&mut sim);
    assert!(
        held.starts_with("<Hold:0|MPos:") && !held.contains("MPos:40.000") && !held.contains("MPos:0.000"),
        "{held}"
    );
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(status(&mut sim), "<Idle|MPos:0.000,0.000,0.000");
}

#[test]
fn byte_7e_resumes_from_a_program_pause() {
    within_a_line(b"~");
    let mut sim = homed();
    sim.send(b"G0 X1 M0\nG0 X2\n");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), [""; 0], "neither the pause is answered nor what comes behind it");
    assert_eq!(status(&mut sim), "<Hold:0|MPos:1.000,0.000,0.000");
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok", "ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:2.000,0.000,0.000");
    say(&mut sim, "M0");
    bytes(&mut sim, b"\x18");
    assert_eq!(state(&mut sim), "Idle", "a reset ends a pause too, and is no alarm");
}

#[test]
fn byte_85_cancels_a_jog() {
    within_a_line(b"\x85");
    let mut sim = homed();
    begin(&mut sim, "$J=X100F1200", Duration::from_secs(1));
    assert_eq!(say(&mut sim, "$J=X120F1200"), ["ok"]);
    assert_eq!(bytes(&mut sim, b"\x85"), [""; 0]);
    sim.run_until_idle().unwrap();
    let stopped = status(&mut sim);
    assert!(stopped.starts_with("<Idle|MPos:") && !stopped.contains("MPos:100.000"), "{stopped}");
    // The next move counts from there.
    let x = |text: &str| text.split("MPos:").nth(1).unwrap().split(',').next().unwrap().parse::<f64>().unwrap();
    say(&mut sim, "G91 G0 X1");
    sim.run_until_idle().unwrap();
    assert!((x(&status(&mut sim)) - x(&stopped) - 1.0).abs() < 0.011);
}

/// It counts from where the cancelled jog has come to rest.
#[test]
fn a_jog_behind_a_cancelled_one_is_made() {
    for behind in ["$J=G91 X-5 F3000\n", "$J=G91 X-3 F3000\n$J=G91 X-2 F3000\n"] {
        let mut sim = homed();
        assert_eq!(begin(&mut sim, "$J=G91 X200 F3000", Duration::from_secs(1)), ["ok"]);
        sim.send(b"\x85");
        sim.send(behind.as_bytes());
        sim.run_for(Duration::from_millis(1)).unwrap();
        assert_eq!((sim.replies().len(), state(&mut sim)), (0, "Jog".to_owned()), "the first one brakes");
        sim.run_for(Duration::from_millis(80)).unwrap();
        while sim.machine().status().speed_mm_s > 0.0 {
            sim.run_for(Duration::from_micros(100)).unwrap();
        }
        let rest_steps = sim.places_steps()[0];
        sim.run_until_idle().unwrap();
        assert_eq!(sim.replies(), vec!["ok"; behind.lines().count()]);
        assert!((sim.places_steps()[0] - (rest_steps - 250)).abs() <= 1, "{behind:?}: from {rest_steps}");
    }
}

/// A host that jogs while a key is held down has lines on their way when the key is let go.
#[test]
fn jogs_sent_before_a_cancel_are_not_made_after_it() {
    let mut sim = homed();
    sim.send(b"$J=G91 X5 F3000\n\x85$J=G91 Y5 F3000\n");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok", "ok"]);
    assert_eq!(sim.counted_steps(), [0, 250, 0], "the first one had not begun");
    // More than the machine takes at once: they wait as lines.
    let jogs = "$J=G91 X1 F600\n".repeat(100);
    sim.send(jogs.as_bytes());
    sim.run_for(Duration::from_millis(500)).unwrap();
    sim.send(b"\x85");
    sim.run_until_idle().unwrap();
    let stopped = sim.counted_steps();
    assert!(stopped[0] < 1_000, "{stopped:?}");
    assert_eq!(sim.replies(), vec!["ok"; 100]);
    assert_eq!(say(&mut sim, "$J=G91 X1 F600"), ["ok"]);
    assert_eq!(sim.counted_steps(), [stopped[0] + 50, 250, 0]);
}

#[test]
fn byte_90_puts_the_feed_back() {
    assert_eq!(overrides_after(b"\x91\x93\x90"), "100,100,100");
}

#[test]
fn byte_91_raises_the_feed_by_ten() {
    assert_eq!(overrides_after(b"\x91"), "110,100,100");
    assert_eq!(overrides_after(&[0x91; 11]), "200,100,100");
}

#[test]
fn byte_92_lowers_the_feed_by_ten() {
    assert_eq!(overrides_after(b"\x92"), "90,100,100");
    assert_eq!(overrides_after(&[0x92; 11]), "10,100,100");
}

#[test]
fn byte_93_raises_the_feed_by_one() {
    assert_eq!(overrides_after(b"\x93\x93"), "102,100,100");
}

#[test]
fn byte_94_lowers_the_feed_by_one() {
    assert_eq!(overrides_after(b"\x94"), "99,100,100");
}

#[test]
fn byte_95_puts_the_rapids_back() {
    assert_eq!(overrides_after(b"\x97\x95"), "100,100,100");
}

#[test]
fn byte_96_halves_the_rapids() {
    assert_eq!(overrides_after(b"\x96"), "100,50,100");
    assert_eq!(overrides_after(b"\xC2\x96"), "100,50,100", "as UTF-8");
}

#[test]
fn byte_97_quarters_the_rapids() {
    assert_eq!(overrides_after(b"\x97"), "100,25,100");
}

#[test]
fn byte_99_puts_the_spindle_back() {
    assert_eq!(overrides_after(b"\x9A\x99"), "100,100,100");
}

#[test]
fn byte_9a_raises_the_spindle_by_ten() {
    assert_eq!(overrides_after(b"\x9A"), "100,100,110");
}

#[test]
fn byte_9b_lowers_the_spindle_by_ten() {
    assert_eq!(overrides_after(b"\x9B"), "100,100,90");
}

#[test]
fn byte_9c_raises_the_spindle_by_one() {
    assert_eq!(overrides_after(b"\x9C"), "100,100,101");
}

#[test]
fn byte_9d_lowers_the_spindle_by_one() {
    assert_eq!(overrides_after(b"\x9D"), "100,100,99");
}

/// The bytes come in the middle of a line and must leave it whole.
#[test]
fn bytes_without_a_meaning_are_dropped() {
    let meaning = |byte: u8| matches!(byte, 0x84 | 0x85 | 0x90..=0x97 | 0x99..=0x9E | 0xA0 | 0xA1);
    let dropped: Vec<u8> = (0x80..=0xFF).filter(|&byte| !meaning(byte)).collect();
    let mut sim = within_a_line(&dropped);
    assert_eq!(field(&mut sim, "Ov"), "100,100,100");
}

#[test]
fn the_feed_override_counts_for_moves_and_not_for_jogs() {
    let mut sim = homed();
    let speed = |sim: &mut Sim, line: &str| {
        begin(sim, line, Duration::from_secs(1));
        let speed = report(sim).split("FS:").nth(1).unwrap().split(',').next().unwrap().to_owned();
        sim.run_until_idle().unwrap();
        sim.replies();
        speed
    };
    assert_eq!(speed(&mut sim, "G1 X50 F600"), "600");
    bytes(&mut sim, &[0x91; 5]);
    assert_eq!(speed(&mut sim, "G1 X0"), "900");
    // The same during a move.
    begin(&mut sim, "G1 X100", Duration::from_secs(1));
    bytes(&mut sim, &[0x90]);
    sim.run_for(Duration::from_secs(1)).unwrap();
    assert_eq!(report(&mut sim).split("FS:").nth(1).unwrap().split(',').next(), Some("600"));
    sim.run_until_idle().unwrap();
    sim.replies();
    assert_eq!(speed(&mut sim, "G1 X0"), "600");
    bytes(&mut sim, &[0x94; 3]);
    assert_eq!(speed(&mut sim, "G1 X50"), "582");
    assert_eq!(speed(&mut sim, "G1 X0"), "582");
    bytes(&mut sim, &[0x90, 0x92]);
    assert_eq!(speed(&mut sim, "G1 X50"), "540");
    assert_eq!(speed(&mut sim, "$J=X0 F600"), "600");
    assert_eq!(speed(&mut sim, "G93 G1 X50 F12"), "540", "12 a minute is 600 mm/min");
    assert_eq!(say(&mut sim, "M2"), ["[MSG:Pgm End]", "ok"]);
    assert_eq!(field(&mut sim, "Ov"), "100,100,100");
}

/// A move that began at 100 % and then braked would be too fast at first.
#[test]
fn an_override_counts_from_the_first_step() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$120=2000"), ["ok"]);
    bytes(&mut sim, &[0x92; 9]);
    begin(&mut sim, "G1 X50 F600", Duration::from_millis(100));
    let [made_steps, ..] = sim.counted_steps();
    // A tenth of 10 mm/s is 50 steps/s. Without the override the machine would reach 10 mm/s in 5 ms.
    assert!((1..=5).contains(&made_steps), "{made_steps} steps in 0.1 s at 50 steps/s");
}

/// They are reported as 100 % and applied as 100 %.
#[test]
fn a_reset_puts_the_overrides_back() {
    let mut sim = homed();
    bytes(&mut sim, &[0x91, 0x91, 0x97]);
    assert_eq!(field(&mut sim, "Ov"), "120,25,100");
    assert_eq!(bytes(&mut sim, b"\x18"), ["Grbl 1.1h ['$' for help]"]);
    assert_eq!(field(&mut sim, "Ov"), "100,100,100");
    for (line, speed) in [("G1 X50 F600", "600"), ("G0 X0", "2880")] {
        begin(&mut sim, line, Duration::from_millis(1_000));
        assert_eq!(report(&mut sim).split("FS:").nth(1).unwrap().split(',').next(), Some(speed), "{line}");
        sim.run_until_idle().unwrap();
        sim.replies();
    }
}

/// Lines sent during the hold count from where the jog has ended, as do lines after it.
#[test]
fn a_hold_after_a_cancelled_jog_knows_where_it_stands() {
    let mut sim = homed();
    assert_eq!(begin(&mut sim, "$J=X100 F1200", Duration::from_secs(1)), ["ok"]);
    bytes(&mut sim, b"!");
    sim.run_until_idle().unwrap();
    let stopped = sim.counted_steps();
    bytes(&mut sim, b"!");
    assert_eq!(state(&mut sim), "Hold:0");
    assert_eq!(say(&mut sim, "G91 G0 X1"), ["ok"]);
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.counted_steps(), [stopped[0] + 50, 0, 0]);
}

/// The start-up line is being carried out when the next line comes. The next line counts from the end of the start-up
/// line.
#[test]
fn a_reset_after_a_jog_knows_where_it_stands() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$N0=G91 G0 X1"), ["ok"]);
    assert_eq!(say(&mut sim, "$J=G90 X10 F1200"), ["ok"]);
    assert_eq!(bytes(&mut sim, b"\x18"), ["Grbl 1.1h ['$' for help]", ">G91G0X1:ok"]);
    assert_eq!(state(&mut sim), "Run");
    assert_eq!(say(&mut sim, "G91 G0 X1"), ["ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:12.000,0.000,0.000");
}

/// The console restarts, and the start-up line waits in the hold. When there is nothing to resume, changes are stored.
#[test]
fn a_hold_behind_a_reset_holds_up_no_answer() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$N0=G0 X1"), ["ok"]);
    sim.run_until_idle().unwrap();
    assert_eq!(bytes(&mut sim, b"\x18!"), ["Grbl 1.1h ['$' for help]", ">G0X1:ok"]);
    assert_eq!(state(&mut sim), "Hold:0");
    assert_eq!(say(&mut sim, "$G").last().map(String::as_str), Some("ok"));
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(status(&mut sim), "<Idle|MPos:1.000,0.000,0.000");
    assert_eq!(say(&mut sim, "$N0="), ["ok"]);
    assert_eq!(bytes(&mut sim, b"\x18!"), ["Grbl 1.1h ['$' for help]"]);
    assert_eq!(say(&mut sim, "G10 L2 P2 X5"), ["ok"]);
    assert_eq!(state(&mut sim), "Hold:0");
}

/// At 0.1 steps/mm, 1 mm/min can be planned in any direction, but half of it could not.
#[test]
fn an_override_makes_no_feed_too_slow() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$100=0.1").last_line(), "ok");
    assert_eq!(bytes(&mut sim, &[0x92; 5]), [""; 0]);
    assert_eq!(begin(&mut sim, "G1 X100 F1", Duration::from_secs(1)), ["ok"]);
    assert_eq!(state(&mut sim), "Run");
}

/// During braking, at standstill with a move to continue, and at standstill without one.
#[test]
fn an_emergency_stop_ends_a_hold() {
    for (line, hold_ms) in [("G0 X100", 100), ("G0 X100", 3_000), ("G4 P0", 3_000)] {
        let mut sim = homed();
        begin(&mut sim, line, Duration::from_millis(800));
        sim.send(b"!");
        sim.run_for(Duration::from_millis(hold_ms)).unwrap();
        assert!(state(&mut sim).starts_with("Hold"), "{line}, {hold_ms} ms");
        sim.set_emergency_stop(true);
        sim.run_for(Duration::from_millis(100)).unwrap();
        assert_eq!(state(&mut sim), "Alarm", "{line}, {hold_ms} ms");
        sim.replies();
        let stopped = sim.counted_steps();
        sim.set_emergency_stop(false);
        sim.run_for(Duration::from_millis(100)).unwrap();
        assert_eq!(bytes(&mut sim, b"~"), [""; 0]);
        assert_eq!(say(&mut sim, "$X").last().map(String::as_str), Some("ok"));
        assert_eq!((state(&mut sim).as_str(), sim.counted_steps()), ("Idle", stopped), "what was held is forgotten");
    }
}

/// During braking, at standstill with a move to continue, and while accelerating again. The machine must lock at once,
/// make no further step, keep an exact count, and discard the held move.
#[test]
fn a_limit_switch_ends_a_hold() {
    for (port, law) in Port::ALL.into_iter().flat_map(|port| [0, 1, 2].map(|law| (port, law))) {
        for (hold_ms, resume_ms) in
            [(60, None), (100, None), (500, None), (3_000, None), (3_000, Some(10)), (3_000, Some(400))]
        {
            let mut sim = powered_up(&Config { port, ..Config::default() });
            assert_eq!(say(&mut sim, &format!("$940={law}\n$H")), ["ok", "ok"]);
            begin(&mut sim, "G0 X100 Y80 Z20", Duration::from_millis(1_200));
            sim.send(b"!");
            sim.run_for(Duration::from_millis(hold_ms)).unwrap();
            assert_eq!(state(&mut sim), if hold_ms < 3_000 { "Hold:1" } else { "Hold:0" });
            if let Some(resume_ms) = resume_ms {
                sim.send(b"~");
                sim.run_for(Duration::from_millis(resume_ms)).unwrap();
                assert_eq!(state(&mut sim), "Run");
            }
            sim.replies();
            sim.set_switch(Axis::Y, SwitchFault::StuckClosed);
            let stopped = (sim.counted_steps(), sim.steps());
            sim.run_until_idle().unwrap();
            let case = format!("{port}, law {law}, {hold_ms} ms, then {resume_ms:?} ms");
            assert_eq!(sim.replies().first().map(String::as_str), Some("ALARM:1"), "{case}");
            assert_eq!((sim.counted_steps(), sim.steps()), stopped, "{case}");
            assert_eq!(sim.machine().position_steps(), sim.counted_steps(), "{case}");
            assert!(sim.outcome().violations.is_empty(), "{case}");
            sim.set_switch(Axis::Y, SwitchFault::None);
            sim.run_until_idle().unwrap();
            assert_eq!(bytes(&mut sim, b"~"), [""; 0], "{case}");
            assert_eq!(say(&mut sim, "$X").last().map(String::as_str), Some("ok"), "{case}");
            assert_eq!((state(&mut sim).as_str(), sim.counted_steps()), ("Idle", stopped.0), "{case}");
        }
    }
}

/// A limit switch is also watched while a cancelled jog brakes.
#[test]
fn a_limit_switch_stops_a_jog_that_is_cancelled() {
    for port in Port::ALL {
        let mut sim = powered_up(&Config { port, ..Config::default() });
        assert_eq!(say(&mut sim, "$H"), ["ok"]);
        begin(&mut sim, "$J=X100F2400", Duration::from_millis(1_000));
        assert_eq!(bytes(&mut sim, b"\x85"), [""; 0]);
        sim.run_for(Duration::from_millis(300)).unwrap();
        assert_eq!(state(&mut sim), "Jog");
        sim.replies();
        sim.set_switch(Axis::X, SwitchFault::StuckClosed);
        let stopped = sim.counted_steps();
        sim.run_until_idle().unwrap();
        assert_eq!(sim.replies().first().map(String::as_str), Some("ALARM:1"), "{port}");
        assert_eq!((sim.counted_steps(), sim.machine().position_steps()), (stopped, stopped));
    }
}

/// Nothing moves and nothing waits. As in Idle, a switch raises no alarm, and the report shows it.
#[test]
fn a_limit_switch_is_no_alarm_in_a_hold_of_nothing() {
    let mut sim = homed();
    assert_eq!(bytes(&mut sim, b"!"), [""; 0]);
    assert_eq!(state(&mut sim), "Hold:0");
    sim.set_switch(Axis::X, SwitchFault::StuckClosed);
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), [""; 0]);
    assert_eq!((state(&mut sim).as_str(), field(&mut sim, "Pn").as_str()), ("Hold:0", "X"));
    assert_eq!(bytes(&mut sim, b"~"), [""; 0]);
    assert_eq!((state(&mut sim).as_str(), sim.machine().status().homed), ("Idle", [true; 3]));
}
