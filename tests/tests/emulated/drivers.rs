//! Drivers that talk: the emulated SKR Pico has four, and a Pico none.

use isostep_tests::emulated::{Board, TalkingDriver, is_skr_pico};

/// The firmware leaves them as they are at power-up: the pins of their addresses say the microsteps.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_drivers_are_as_at_power_up() {
    let run = Board::new("drivers").script("expect Grbl\nsend G91 G1 X1 F600\nexpect ok\nwait-idle\n");
    assert!(run.ok, "{}", run.printed);
    let at_power_up = |microsteps| TalkingDriver {
        microsteps,
        currents: [31, 16],
        chopper: "StealthChop".into(),
        datagrams: [0, 0, 0],
    };
    let found = ['X', 'Y', 'Z', 'A'].map(|axis| run.driver(axis));
    assert_eq!(found, [8, 64, 32, 16].map(|microsteps| is_skr_pico().then(|| at_power_up(microsteps))));
}
