//! Each `$` command of the table in docs/console.md.

use embassy_time::Duration;
use isostep_console::Settings;
use isostep_motion::{Axis, Contact, Event};
use isostep_sim::world::Wire;
use isostep_sim::{Config, Flash, Sim};

use crate::talk::{begin, homed, powered_up, refused, say, state, status};

const WELCOME: &str = "Grbl 1.1h ['$' for help]";

fn jogs(sim: &mut Sim, line: &str, place: &str) {
    assert_eq!(say(sim, line), ["ok"], "{line}");
    assert_eq!(status(sim), format!("<Idle|MPos:{place}"), "{line}");
}

#[test]
fn command_help_lists_the_commands() {
    let heard = say(&mut powered_up(&Config::default()), "$");
    assert_eq!(heard[0], "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]");
    assert_eq!(
        heard[1..],
        [
            "[MSG:$En and $An explain a refusal or an alarm by its number n, $BUZZ=X moves X to and fro, $BOOT makes way for \
             new firmware]",
            "ok"
        ]
    );
}

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
fn command_set_changes_a_setting_or_says_why_not() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$ 130 = 250.5"), ["ok"]);
    assert!(say(&mut sim, "$$").contains(&"$130=250.500".to_owned()));
    assert_eq!(say(&mut sim, "$130=20000"), ["[MSG:$130=20000 is above the most, 10000 mm: lower it]", "error:2"]);
    assert!(say(&mut sim, "$$").contains(&"$130=250.500".to_owned()));
}

#[test]
fn command_parameters_lists_offsets_and_places() {
    let mut sim = homed();
    for line in ["G10 L2 P2 X1 Y2 Z3", "G0 X10 Y20 Z30", "G28.1", "G0 X11", "G30.1", "G92 Y19", "G43.1 Z-2"] {
        assert_eq!(say(&mut sim, line), ["ok"], "{line}");
    }
    let expected = [
        "[G54:0.000,0.000,0.000]",
        "[G55:1.000,2.000,3.000]",
        "[G56:0.000,0.000,0.000]",
        "[G57:0.000,0.000,0.000]",
        "[G58:0.000,0.000,0.000]",
        "[G59:0.000,0.000,0.000]",
        "[G28:10.000,20.000,30.000]",
        "[G30:11.000,20.000,30.000]",
        "[G92:0.000,1.000,0.000]",
        "[TLO:-2.000]",
        "[PRB:0.000,0.000,0.000:0]",
        "ok",
    ];
    assert_eq!(say(&mut sim, "$#"), expected);
    assert_eq!(say(&mut sim, "$13=1"), ["ok"]);
    assert_eq!(say(&mut sim, "$#")[6], "[G28:0.3937,0.7874,1.1811]");
}

#[test]
fn command_modal_lists_the_modal_state() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$G"), ["[GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0]", "ok"]);
    assert_eq!(say(&mut sim, "G80 G56 G18 G20 G91 M3 M8 T7 F10 S1000"), ["ok"]);
    assert_eq!(say(&mut sim, "$G"), ["[GC:G80 G56 G18 G20 G91 G94 G64 M3 M8 T7 F254 S1000]", "ok"]);
}

#[test]
fn command_build_names_grbl() {
    let heard = say(&mut powered_up(&Config::default()), "$I");
    assert!(heard[0].starts_with("[VER:1.1h.20190830:") && heard[0].contains("grbl"), "{heard:?}");
    // The number of blocks equals the Bf field of a status report at rest.
    assert_eq!(heard[1], format!("[OPT:VNMZHL,{},128]", isostep_motion::MOVES_AHEAD));
    assert_eq!(heard[2..], ["[MSG:Emergency stop: normally open]", "ok"]);
    let mut other = powered_up(&Config { emergency_contact: Contact::NormallyClosed, ..Config::default() });
    assert_eq!(say(&mut other, "$I")[2], "[MSG:Emergency stop: normally closed]");
}

#[test]
fn command_set_build_keeps_a_text() {
    let (config, flash) = (Config::default(), Flash::blank());
    let mut sim = Sim::with_flash(&config, flash.clone());
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), [WELCOME]);
    let own = say(&mut sim, "$I");
    assert_eq!(say(&mut sim, "$I = Mill 3, new belt (2026)"), ["ok"]);
    let name = own[0].rsplit(':').next().unwrap();
    let reported = ["[VER:1.1h.20190830:MILL3,NEWBELT]", &own[1], &format!("[MSG:{name}"), &own[2], "ok"];
    assert_eq!(say(&mut sim, "$I"), reported, "stripped as every line; senders still find grbl");
    let mut again = Sim::with_flash(&config, flash);
    again.run_until_idle().unwrap();
    assert_eq!(again.replies(), [WELCOME]);
    assert_eq!(say(&mut again, "$I"), reported, "a power cycle keeps it");
    assert_eq!(say(&mut again, "$RST=#"), ["[MSG:Restoring defaults]", "ok", WELCOME]);
    assert_eq!(say(&mut again, "$I"), reported);
    assert_eq!(say(&mut again, "$RST=*"), ["[MSG:Restoring defaults]", "ok", WELCOME]);
    assert_eq!(say(&mut again, "$I"), own);
    let longest = "A".repeat(76);
    assert_eq!(say(&mut sim, &format!("$I={longest}")), ["ok"]);
    assert_eq!(say(&mut sim, "$I")[0], format!("[VER:1.1h.20190830:{longest}]"));
    refused(&mut sim, &format!("$I={longest}A"), 11);
    assert_eq!(say(&mut sim, "$I=\n$I").split_off(1), *own);
    refused(&mut sim, "$IX", 3);
}

#[test]
fn command_startup_lists_the_lines() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$N"), ["$N0=", "$N1=", "ok"]);
    assert_eq!(say(&mut sim, "$N1=G20 (inches)"), ["ok"]);
    assert_eq!(say(&mut sim, "$N"), ["$N0=", "$N1=G20", "ok"]);
}

#[test]
fn command_set_startup_runs_a_line_and_keeps_it() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$N0=G91 G0 X5"), ["ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:5.000,0.000,0.000", "it is carried out at once");
    refused(&mut sim, "$N1=G0 Q1", 20);
    let longest = format!("F1{}", "0".repeat(73));
    assert_eq!(say(&mut sim, &format!("$N1={longest}")), ["error:2"]);
    assert_eq!(say(&mut sim, "$N1=G20"), ["ok"]);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), [WELCOME, ">G91G0X5:ok", ">G20:ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:10.000,0.000,0.000");
    assert_eq!(say(&mut sim, "$G")[0], "[GC:G0 G54 G17 G20 G91 G94 G64 M5 M9 T0 F0 S0]");
    assert_eq!(say(&mut sim, "G21\n$N1=G21"), ["ok"; 2]);
    assert_eq!(say(&mut sim, "$H"), [">G91G0X5:ok", ">G21:ok", "ok"], "after homing too");
    assert_eq!(status(&mut sim), "<Idle|MPos:5.000,0.000,0.000");
    // A line that cannot be carried out reports an error. A target outside the travel also locks the machine.
    assert_eq!(say(&mut sim, "$130=9"), ["ok"]);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    assert!(heard.contains(&">G91G0X5:error:9".to_owned()) && heard.contains(&">G21:error:9".to_owned()), "{heard:?}");
    assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"], "not after unlocking");
    assert_eq!(say(&mut sim, "$N0=\n$N1="), ["ok", "ok"]);
    assert_eq!(say(&mut sim, "$N"), ["$N0=", "$N1=", "ok"]);
}

#[test]
fn command_check_moves_nothing() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$C"), ["[MSG:Enabled]", "ok"]);
    assert_eq!(say(&mut sim, "G91 G1 X10 F600\nX10\nG4 P10\nM0\nG10 L2 P1 X1"), ["ok"; 5]);
    refused(&mut sim, "G1 X1 X1", 25);
    assert_eq!(say(&mut sim, "M30"), ["[MSG:Pgm End]", "ok"]);
    let before = sim.now();
    assert_eq!(say(&mut sim, "$C"), ["[MSG:Disabled]", "ok", WELCOME]);
    assert!(sim.now() - before < Duration::from_millis(1), "nothing was waited for");
    assert_eq!(sim.counted_steps(), [0; 3]);
    assert_eq!(status(&mut sim), "<Idle|MPos:0.000,0.000,0.000");
    assert_eq!(say(&mut sim, "$G")[0], "[GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0]", "a reset");
    // Targets are checked too.
    say(&mut sim, "$C");
    assert!(say(&mut sim, "G53 G0 X-1").contains(&"ALARM:2".to_owned()));
    assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn command_unlock_leaves_alarm() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$X"), ["ok"], "nothing to unlock");
    say(&mut sim, "G0 X-1");
    assert_eq!(state(&mut sim), "Alarm");
    assert_eq!(say(&mut sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
    assert_eq!(state(&mut sim), "Idle");
}

#[test]
fn command_home_homes_and_runs_the_startup_lines() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$N0=G55"), ["ok"]);
    assert_eq!(begin(&mut sim, "$H", Duration::from_secs(1)), [""; 0]);
    assert_eq!(state(&mut sim), "Home");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), [">G55:ok", "ok"]);
    let homed = sim.outcome().events.iter().filter(|(_, event)| matches!(event, Event::Homed { .. })).count();
    assert_eq!(homed, 3);
}

#[test]
fn command_home_axis_homes_it_alone() {
    let homed = |sim: &Sim| {
        let events = sim.outcome().events;
        events
            .iter()
            .filter_map(|(_, event)| if let Event::Homed { axis } = event { Some(*axis) } else { None })
            .collect::<Vec<_>>()
    };
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$N0=G55"), ["ok"]);
    assert_eq!(begin(&mut sim, "$HY", Duration::from_secs(1)), [""; 0]);
    assert_eq!(state(&mut sim), "Home");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["ok"], "the start-up lines are for $H");
    assert_eq!(homed(&sim), [Axis::Y]);
    assert_eq!(sim.machine().status().homed, [false, true, false]);
    // The travel of X is known, that of the others is not.
    assert_eq!(say(&mut sim, "G0 X-1 Z-1"), ["ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:-1.000,0.000,-1.000");
    assert!(say(&mut sim, "G0 Y-1").contains(&"ALARM:2".to_owned()));
    // This alarm does not cost the zero: Y keeps its own.
    assert_eq!(say(&mut sim, "$HX"), ["ok"]);
    assert_eq!(status(&mut sim), "<Idle|MPos:0.000,0.000,-1.000");
    assert_eq!(sim.machine().status().homed, [true, true, false]);
    assert_eq!(say(&mut sim, "$HZ"), ["ok"]);
    assert_eq!(homed(&sim), [Axis::Y, Axis::X, Axis::Z]);
    assert_eq!(sim.machine().status().homed, [true; 3]);
    refused(&mut sim, "$HA", 3);
    assert_eq!(say(&mut sim, "$22=0"), ["ok"]);
    refused(&mut sim, "$HX", 5);
}

#[test]
fn command_jog_moves_and_leaves_the_modes() {
    let mut sim = homed();
    let modal = say(&mut sim, "$G");
    jogs(&mut sim, "$J=X10.0 Y5 F1000", "10.000,5.000,0.000");
    jogs(&mut sim, "$J=G91 X-2.5 F1000", "7.500,5.000,0.000");
    jogs(&mut sim, "$J=G91 G20 X1 F50", "32.900,5.000,0.000");
    assert_eq!(say(&mut sim, "G10 L2 P1 X100"), ["ok"]);
    jogs(&mut sim, "$J=X-60 F1000", "40.000,5.000,0.000");
    jogs(&mut sim, "$J=G53 X10 F1000", "10.000,5.000,0.000");
    assert_eq!(say(&mut sim, "$G"), modal);
    // Jogs come one directly after another, as from a key that is held down.
    sim.send(b"$J=G91X1F600\n$J=G91X1F600\n$J=G91X1F600\n");
    sim.run_for(Duration::from_millis(50)).unwrap();
    assert_eq!(sim.replies(), ["ok"; 3], "taken, not done");
    assert_eq!(state(&mut sim), "Jog");
    sim.run_until_idle().unwrap();
    assert_eq!(status(&mut sim), "<Idle|MPos:13.000,5.000,0.000");
    // A refused jog neither moves nor locks the machine. The next jog counts from where the last one ended.
    refused(&mut sim, "$J=G91 X400 F600", 15);
    jogs(&mut sim, "$J=G91 X1 F600", "14.000,5.000,0.000");
}

#[test]
fn command_sleep_frees_the_motors_until_a_reset() {
    let mut sim = homed();
    let energised = |sim: &Sim| {
        let outcome = sim.outcome();
        outcome.waves.iter().rfind(|wave| wave.wire == Wire::Enable).is_some_and(|wave| !wave.high)
    };
    assert!(energised(&sim), "$1=255");
    assert_eq!(say(&mut sim, "$SLP"), ["ok", "[MSG:Sleeping]"]);
    assert!(!energised(&sim));
    assert_eq!(say(&mut sim, "G0 X1"), [""; 0]);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), [WELCOME, "[MSG:'$H'|'$X' to unlock]"], "what was sent to a sleeper is forgotten");
    assert_eq!(say(&mut sim, "$X\nG0 X1"), ["[MSG:Caution: Unlocked]", "ok", "ok"]);
    assert_eq!(sim.counted_steps(), [50, 0, 0]);
    assert!(energised(&sim), "the idle delay is $1 again");
    // From Alarm, and once more while the motors are not energised.
    sim.set_emergency_stop(true);
    sim.run_until_idle().unwrap();
    sim.set_emergency_stop(false);
    sim.run_until_idle().unwrap();
    for _ in 0..2 {
        sim.replies();
        assert_eq!(say(&mut sim, "$SLP"), ["ok", "[MSG:Sleeping]"]);
        assert!(!energised(&sim));
        sim.send(b"\x18");
        sim.run_until_idle().unwrap();
    }
    sim.replies();
    assert_eq!(say(&mut sim, "$X\nG0 X2"), ["[MSG:Caution: Unlocked]", "ok", "ok"]);
    assert!(energised(&sim), "and so it stays");
}

/// Whoever frees the motors may push the axes, and nothing counts that. After an idle delay they are trusted to stay.
#[test]
fn the_position_is_not_trusted_after_a_sleep() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$1=25\nG0 X1\nG4 P1"), ["ok"; 3]);
    assert_eq!(sim.machine().homed(), [true; 3], "freed by $1");
    assert_eq!(say(&mut sim, "$SLP"), ["ok", "[MSG:Sleeping]"]);
    assert_eq!(sim.machine().homed(), [false; 3]);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(say(&mut sim, "$X").last().unwrap(), "ok");
    assert_eq!(sim.machine().homed(), [false; 3], "unlocked");
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    assert_eq!(sim.machine().homed(), [true; 3]);
}

#[test]
fn command_boot_is_refused_without_a_boot_loader() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$BOOT"), ["[MSG:There is no boot loader here: $BOOT is for a board]", "error:3"]);
    assert_eq!(say(&mut sim, "G0 X1"), ["ok"], "all is as before");
    assert_eq!(begin(&mut sim, "G0 X100", Duration::from_secs(1)), ["ok"]);
    refused(&mut sim, "$BOOT", 8);
}

#[test]
fn command_restore_settings() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$130=100\n$N0=G55\nG10 L2 P1 X1"), ["ok"; 3]);
    assert_eq!(say(&mut sim, "$RST=$"), ["[MSG:Restoring defaults]", "ok", WELCOME, ">G55:ok"]);
    assert!(say(&mut sim, "$$").contains(&"$130=350.000".to_owned()));
    assert_eq!(say(&mut sim, "$#")[0], "[G54:1.000,0.000,0.000]");
    assert_eq!(say(&mut sim, "$N")[0], "$N0=G55");
}

#[test]
fn command_restore_parameters() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$130=100\n$N0=G55\nG10 L2 P1 X1\nG28.1"), ["ok"; 4]);
    assert_eq!(say(&mut sim, "$RST=#"), ["[MSG:Restoring defaults]", "ok", WELCOME]);
    assert!(say(&mut sim, "$$").contains(&"$130=100.000".to_owned()));
    assert_eq!(say(&mut sim, "$#")[0], "[G54:0.000,0.000,0.000]");
    assert_eq!(say(&mut sim, "$N")[0], "$N0=");
}

#[test]
fn command_restore_everything() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$130=100\n$N0=G55\nG10 L2 P1 X1"), ["ok"; 3]);
    assert_eq!(say(&mut sim, "$RST=*"), ["[MSG:Restoring defaults]", "ok", WELCOME]);
    assert_eq!(say(&mut sim, "$#")[0], "[G54:0.000,0.000,0.000]");
    let fresh = say(&mut powered_up(&Config { settings: Settings::DEFAULT, ..Config::default() }), "$$");
    assert_eq!(say(&mut sim, "$$"), fresh);
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
    for alarm in isostep_console::Alarm::ALL {
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
