//! Words of programs that are in the G-code table of docs/console.md.

use embassy_time::Duration;
use isostep_sim::Config;

use crate::talk::{begin, bytes, homed, powered_up, refused, say, state, status};

#[test]
fn a_percent_sign_alone_does_nothing_in_any_state() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "%"), ["ok"]);
    assert_eq!(begin(&mut sim, "$H", Duration::from_millis(500)), [""; 0]);
    assert_eq!(state(&mut sim), "Home");
    assert_eq!(say(&mut sim, "%"), ["ok", "ok"], "answered in its turn");
    assert_eq!(say(&mut sim, "% (begin)\nG0 X5\n %"), ["ok"; 3]);
    assert_eq!(begin(&mut sim, "$J=X100 F600", Duration::from_millis(500)), ["ok"]);
    assert_eq!(state(&mut sim), "Jog");
    assert_eq!(begin(&mut sim, "%", Duration::from_millis(1)), ["ok"]);
    assert_eq!(state(&mut sim), "Jog");
    sim.run_until_idle().unwrap();
    assert!(say(&mut sim, "G0 X-1").contains(&"ALARM:2".to_owned()));
    assert_eq!(say(&mut sim, "%"), ["ok"]);
    refused(&mut sim, "G21", 9);
    say(&mut sim, "$X");
    refused(&mut sim, "%1", 1);
}

#[test]
fn g64_ends_exact_stops() {
    let mut sim = homed();
    let mut took_ms = |mode: &str| {
        assert!(say(&mut sim, &format!("{mode}\nG0 X0")).iter().all(|answer| answer == "ok"), "{mode}");
        let before = sim.now();
        assert_eq!(say(&mut sim, "G1 X10 F2400\nX20"), ["ok", "ok"]);
        (sim.now() - before).as_millis()
    };
    let [exact, g61, g64] = ["G61.1", "G61", "G61.1\nG64 P0.05"].map(&mut took_ms);
    assert_eq!(g64, g61);
    assert!(exact > g64 + 100, "{exact} ms with stops, {g64} ms without");
    assert_eq!(status(&mut sim), "<Idle|MPos:20.000,0.000,0.000");
}

#[test]
fn m6_says_which_tool_to_put_in_and_waits() {
    let mut sim = homed();
    sim.send(b"G1 X10 F600\nT3 M6 G0 X20\nG0 X30\n");
    sim.run_for(Duration::from_millis(500)).unwrap();
    assert_eq!(sim.replies(), ["ok"]);
    assert_eq!(state(&mut sim), "Run", "the moves before it end first");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["[MSG:M6: put in tool 3, then resume with ~]"], "it is reported while it waits");
    assert_eq!(status(&mut sim), "<Hold:0|MPos:10.000,0.000,0.000", "its own move is behind it");
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok", "ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:30.000,0.000,0.000");
}

/// In the order of the program: before its line is carried out, and so before M0 and M6 wait.
#[test]
fn a_message_to_the_operator_comes_before_its_line_waits() {
    let mut sim = homed();
    assert_eq!(
        say(&mut sim, "G1 X5 F600 (MSG, one)\n(MSG, turn the work)\nM0 (MSG, then resume)\n(MSG, two)"),
        ["[MSG:one]", "ok", "[MSG:turn the work]", "ok", "[MSG:then resume]",]
    );
    assert_eq!(status(&mut sim), "<Hold:0|MPos:5.000,0.000,0.000");
    assert_eq!(bytes(&mut sim, b"~"), ["ok", "[MSG:two]", "ok"]);
    let heard = say(&mut sim, "T2 M6 (MSG, the book says 3 mm)");
    assert_eq!(heard, ["[MSG:the boOK says 3 mm]", "[MSG:M6: put in tool 2, then resume with ~]"]);
    assert_eq!(bytes(&mut sim, b"~"), ["ok"]);
    assert_eq!(say(&mut sim, "G0 Q5 (MSG, refused)").len(), 3, "the message, the reason, the error");
    let longest = "m".repeat(100);
    let heard = say(&mut sim, &format!("(MSG, {longest})"));
    assert_eq!(heard, [format!("[MSG:{}...]", "m".repeat(76)).as_str(), "ok"], "cut where it can be seen");
}

#[test]
fn m6_without_a_tool_waits_too_and_with_m0_it_waits_once() {
    let mut sim = homed();
    for (line, reported) in [
        ("M6", "M6: change the tool, then resume with ~"),
        ("T0 M6 M0", "M6: change the tool, then resume with ~"),
        ("T7\nM0 M6", "M6: put in tool 7, then resume with ~"),
        ("M6", "M6: put in tool 7, then resume with ~"),
    ] {
        let heard = say(&mut sim, line);
        assert_eq!(heard.last().unwrap(), &format!("[MSG:{reported}]"), "{line}");
        assert_eq!(state(&mut sim), "Hold:0", "{line}");
        assert_eq!(bytes(&mut sim, b"~"), ["ok"], "{line}");
        assert_eq!(state(&mut sim), "Idle", "{line}");
    }
    assert_eq!(say(&mut sim, "M6 M0 G0 X5").len(), 1);
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(status(&mut sim), "<Hold:0|MPos:5.000,0.000,0.000", "M0 stands behind the move");
    assert_eq!(bytes(&mut sim, b"~"), ["ok"]);
}

#[test]
fn a_reset_ends_m6() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G1 X5 F600\nT2 M6\nG0 X9").len(), 2);
    assert_eq!(state(&mut sim), "Hold:0");
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:5.000,0.000,0.000");
}

#[test]
fn m6_passes_in_check_mode() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$C"), ["[MSG:Enabled]", "ok"]);
    assert_eq!(say(&mut sim, "T1 M6\nM6 M0\nG0 X1"), ["ok"; 3]);
    assert_eq!(state(&mut sim), "Check");
}

#[test]
fn a_startup_line_waits_at_m6_after_telling() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$N0=T1 M6"), ["[MSG:M6: put in tool 1, then resume with ~]"]);
    assert_eq!(bytes(&mut sim, b"~"), ["ok"]);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", "[MSG:M6: put in tool 1, then resume with ~]"]);
    assert_eq!(bytes(&mut sim, b"~"), [">T1M6:ok"]);
}

/// Every line counts, however short: as typed, then in ten-thousandths of an inch, and by jogs.
#[test]
fn thousands_of_increments_end_where_they_should() {
    let mut sim = homed();
    let mut go = |first: &str, line: &str, times: usize| {
        let lines = vec![line; times].join("\n");
        let heard = say(&mut sim, &format!("{first}\n{lines}"));
        assert!(heard.iter().all(|answer| answer == "ok"), "{first}, {line}");
        status(&mut sim)
    };
    assert_eq!(go("G90 G0 X257\nG91", "X0.001", 10_000), "<Idle|MPos:267.000,0.000,0.000");
    assert_eq!(go("G20 G1 F100", "X-0.0001", 10_000), "<Idle|MPos:241.600,0.000,0.000");
    // A hold in between, from where the machine stands; 0.001 mm is a twentieth of a step.
    assert_eq!(go("G21 G92 X0.3 Y0.1\nG4 P0", "$J=G91 X0.001 Y0.01 F1000", 1_000), "<Idle|MPos:242.600,10.000,0.000");
}
