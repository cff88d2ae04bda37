//! `$` commands of the table in docs/console.md, and lines that are too long.

use isostep_sim::{Config, Sim};

use crate::talk::{homed, powered_up, refused, say, status};

#[test]
fn command_settings_lists_them_all() {
    let heard = say(&mut powered_up(&Config::default()), "$$");
    let rows = isostep_console::SETTING_TABLE.iter().filter(|row| !row.is_trinamic()).flat_map(|row| row.numbers());
    let numbers: Vec<_> = rows.map(|number| format!("${number}=")).collect();
    assert_eq!(heard.len(), numbers.len() + 1);
    assert!(heard.iter().zip(&numbers).all(|(line, number)| line.starts_with(number)), "{heard:?}");
    assert_eq!(heard.last().unwrap(), "ok");
}

#[test]
fn command_explain_says_what_an_error_means() {
    let mut sim = powered_up(&Config::default());
    for error in isostep_console::Error::ALL {
        assert_eq!(say(&mut sim, &format!("$E{}", error.code())), [format!("[MSG:{error}]"), "ok".into()]);
    }
    for nonsense in ["$E", "$E0", "$E99", "$E1.5", "$E-1", "$E99999"] {
        refused(&mut sim, nonsense, 3);
    }
}

#[test]
fn command_explain_says_what_an_alarm_means() {
    let mut sim = powered_up(&Config::default());
    for alarm in isostep_console::AlarmCode::ALL {
        assert_eq!(say(&mut sim, &format!("$a{}", alarm.code())), [format!("[MSG:{alarm}]"), "ok".into()]);
    }
    refused(&mut sim, "$A11", 3);
}

#[test]
fn command_buzz_moves_an_axis_to_and_fro() {
    let mut sim = homed();
    say(&mut sim, "G0 X2 Y400");
    sim.run_until_idle().unwrap();
    let before = sim.outcome().edges.len();
    sim.send(b"$BUZZ=Y\n");
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    assert_eq!(heard.last().map(String::as_str), Some("ok"));
    assert!(
        heard.iter().any(|line| line.starts_with("[MSG:Y should have moved 1 mm to and fro 10 times")),
        "{heard:?}"
    );
    // At the end of its travel the axis first moves inwards.
    let edges = &sim.outcome().edges[before..];
    assert_eq!(edges.len(), 2 * 10 * 50);
    assert!(edges.iter().all(|edge| edge.axis == 1) && edges[0].direction == -1);
    assert_eq!(status(&mut sim), "<Idle|MPos:2.000,400.000,0.000");
    assert_eq!(say(&mut sim, "$BUZZ=A"), ["error:3"]);
}

/// Each line must be refused with the error. Modal state, offsets, settings and position must be as before.
fn refused_and_unchanged(lines: &[&str], code: u8) {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G55 G91 G1 X1 F600"), ["ok"]);
    let before = everything(&mut sim);
    for line in lines {
        refused(&mut sim, line, code);
        assert_eq!(everything(&mut sim), before, "{line}");
    }
}

fn everything(sim: &mut Sim) -> Vec<String> {
    let mut heard: Vec<_> = ["$G", "$#", "$$", "$N"].iter().flat_map(|line| say(sim, line)).collect();
    heard.push(status(sim));
    heard
}

#[test]
fn error_11_line_too_long() {
    let longest = format!("X1{}", "Y".repeat(77));
    refused_and_unchanged(&[&longest], 2);
    refused_and_unchanged(&[&format!("{longest}Y"), &"X".repeat(10_000)], 11);
}
