//! Each real-time byte of the table in docs/console.md.

use embassy_time::Duration;
use isostep_motion::Axis;
use isostep_sim::{Config, Port, Sim, SwitchFault};

use crate::talk::{begin, bytes, field, homed, powered_up, say, state, status, switched_on};

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

/// The bytes come in the middle of a line and must leave it whole.
#[test]
fn bytes_without_a_meaning_are_dropped() {
    let meaning = |byte: u8| matches!(byte, 0x80..=0x85 | 0x87 | 0x90..=0x97 | 0x99..=0x9E | 0xA0 | 0xA1);
    let dropped: Vec<u8> = (0x80..=0xFF).filter(|&byte| !meaning(byte)).collect();
    let mut sim = within_a_line(&dropped);
    assert_eq!(field(&mut sim, "Ov"), "100,100,100");
}

/// During braking, at standstill with a move to continue, and while accelerating again. The machine must lock at once,
/// make no further step, keep an exact count, and discard the held move.
#[test]
fn a_limit_switch_ends_a_hold() {
    for (port, speed_profile) in
        Port::ALL.into_iter().flat_map(|port| [0, 1, 2].map(|speed_profile| (port, speed_profile)))
    {
        for (hold_ms, resume_ms) in
            [(60, None), (100, None), (500, None), (3_000, None), (3_000, Some(10)), (3_000, Some(400))]
        {
            let mut sim = powered_up(&Config { port, ..Config::default() });
            assert_eq!(say(&mut sim, &format!("$940={speed_profile}\n$H")), ["ok", "ok"]);
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
            let case = format!("{port}, speed profile {speed_profile}, {hold_ms} ms, then {resume_ms:?} ms");
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
