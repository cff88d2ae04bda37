//! A machine of X and Y alone in the simulator.

use isostep_report::{Figures, pictures};
use isostep_sim::{Config, Port, swarm};
use isostep_tests::talk::{machine, say};

#[test]
fn both_axes_share_the_intervals_of_a_move() {
    for port in Port::ALL {
        let mut sim = machine(&Config { port, ..Config::default() });
        for line in ["$H", "G1 X20 Y10 F2000", "G2 X30 Y20 I10", "G3 X20 Y10 R20", "$J=G91 Y5 F500", "G0 X0 Y0"] {
            assert_eq!(say(&mut sim, line), ["ok"], "{line}");
        }
        assert_eq!(sim.counted_steps(), [0; 2]);
        let figures = Figures::new("two axes", &sim.outcome());
        let broken: Vec<_> = figures.broken().collect();
        assert!(broken.is_empty() && figures.losses_total == 0, "{broken:?}");
    }
}

/// Senders read three coordinates, so the third is 0.
#[test]
fn what_is_said_of_z() {
    let mut sim = machine(&Config::default());
    let z = "[MSG:Z: two axes only, X Y: remove it]";
    for (line, said) in [
        ("G1 X1 Z2 F600", vec![z, "error:20"]),
        ("G18", vec!["[MSG:G18: no plane with Z here: remove it]", "error:20"]),
        ("G19", vec!["[MSG:G19: no plane with Z here: remove it]", "error:20"]),
        ("G17", vec!["ok"]),
        ("G43.1 X1", vec!["[MSG:G43.1: no tools without Z here: remove G43 and its H]", "error:20"]),
        ("G81 X1", vec!["[MSG:G81: no canned cycles without Z: let the post-processor expand them]", "error:20"]),
        ("G49", vec!["ok"]),
        ("G1 X1.5 F600", vec!["ok"]),
        ("G2 X1 Y1 K1", vec!["error:35"]),
        ("$102=50", vec!["[MSG:there is no $102: $$ lists the settings]", "error:3"]),
        ("$901=312", vec!["[MSG:$901=312 is above the most, 21: lower it]", "error:2"]),
        ("$901=11", vec!["[MSG:$901=11 is below the least, 12: raise it]", "error:2"]),
        ("$901=13", vec!["[MSG:$901=13 is no order: give each of 1 (X) and 2 (Y) once, as in 12]", "error:2"]),
        ("$901=21", vec!["ok"]),
        ("$905=3", vec!["[MSG:$905=3 is above the most, 2: lower it]", "error:2"]),
        ("$HZ", vec!["error:3"]),
    ] {
        assert_eq!(say(&mut sim, line), said, "{line}");
    }
    assert!(say(&mut sim, "$I").contains(&"[AXS:2:XY]".to_owned()));
    assert!(say(&mut sim, "$#").contains(&"[G54:0.000,0.000,0.000]".to_owned()));
    assert!(say(&mut sim, "?")[0].starts_with("<Idle|MPos:1.500,0.000,0.000|"));
}

#[test]
fn the_report_has_two_axes() {
    let outcome = isostep_sim::run(b"G1 X20 Y10 F1200\nG2 X30 I5\n", &Config::default()).unwrap();
    let page =
        pictures::page(&outcome, &pictures::BothRules::of(&outcome, None), &Figures::new("two axes", &outcome)).html();
    assert!(page.contains("X 30.00, Y 10.00") && !page.contains("Z 0.00"));
}

#[test]
fn random_worlds_keep_their_promises() {
    for seed in 0..40 {
        let world = swarm::run(&swarm::Scenario::new(seed));
        assert!(world.is_ok(), "{seed}: {world:?}");
    }
}
