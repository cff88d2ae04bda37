//! What is stored: what was answered `ok` is there after a power cycle, however soon the power fails.

use embassy_time::Duration;
use isostep_sim::{Config, Flash, Sim};

use crate::talk::say;

/// The replies that list all that is stored.
const LISTINGS: [&str; 4] = ["$$", "$#", "$N", "$I"];

fn listed(sim: &mut Sim) -> Vec<Vec<String>> {
    LISTINGS.map(|line| say(sim, line).into_iter().collect()).into()
}

fn powered(flash: &Flash) -> Sim {
    let mut sim = Sim::with_flash(&Config::default(), flash.clone());
    sim.run_until_idle().unwrap();
    sim.replies();
    sim
}

#[test]
fn what_was_answered_ok_is_there_after_a_power_cycle() {
    const BEFORE: [&str; 8] =
        ["$110=1234", "$13=0", "$I=MILL", "$N0=G55", "G10 L2 P1 X1 Y2 Z3", "G10 L2 P3 X4", "G0 X2 Y1", "G28.1"];
    for line in [
        "$130=250.5",
        "$22=0",
        "$110=2000",
        "$13=1",
        "$I=LATHE",
        "$I=",
        "$N0=",
        "$N1=G21",
        "$N0=G91",
        "G10 L2 P1 X7",
        "G10 L2 P0 Y7",
        "G10 L2 P6 Z-7",
        "G10 L20 P2 X5 Y5",
        "G10 L20 P0 Z5",
        "G28.1",
        "G30.1",
        "$RST=$",
        "$RST=#",
        "$RST=*",
    ] {
        let flash = Flash::blank();
        let mut sim = powered(&flash);
        for line in BEFORE {
            assert_eq!(say(&mut sim, line), ["ok"], "{line}");
        }
        let mut sim = powered(&flash);
        say(&mut sim, "G0 X5 Y6 Z7");
        say(&mut sim, line);
        // G54 to G59, G28 and G30 of `$#` are stored. The others are not.
        let stored = |mut listed: Vec<Vec<String>>| {
            listed[1].truncate(8);
            listed
        };
        let expected = stored(listed(&mut sim));
        let found = stored(listed(&mut powered(&flash)));
        assert_eq!(found, expected, "{line}");
    }
}

/// The power fails in the instant in which `ok` comes.
#[test]
fn what_is_answered_ok_is_stored_by_then() {
    for (line, listing, expected) in [
        ("$130=250.5", "$$", "$130=250.500"),
        ("$N1=G21", "$N", "$N1=G21"),
        ("$I=LATHE", "$I", "[VER:1.1h.20190830:LATHE]"),
        ("G10 L2 P2 X7", "$#", "[G55:7.000,0.000,0.000]"),
        ("G10 L20 P2 X7", "$#", "[G55:-7.000,0.000,0.000]"),
        ("G0 X1\nG28.1", "$#", "[G28:1.000,0.000,0.000]"),
        ("G0 X1\nG30.1", "$#", "[G30:1.000,0.000,0.000]"),
        ("G10 L2 P1 X9\n$RST=#", "$#", "[G54:0.000,0.000,0.000]"),
        ("$130=200\n$RST=$", "$$", "$130=350.000"),
        ("$130=200\n$RST=*", "$$", "$130=350.000"),
    ] {
        let flash = Flash::blank();
        let mut sim = powered(&flash);
        sim.send(format!("{line}\n").as_bytes());
        let mut left = line.lines().count();
        while left > 0 {
            sim.run_for(Duration::from_micros(20)).unwrap();
            left -= sim.replies().iter().filter(|heard| *heard == "ok").count();
        }
        let heard = say(&mut powered(&flash), listing);
        assert!(heard.iter().any(|heard| heard == expected), "{line}: {heard:?}, {expected} expected");
    }
}
