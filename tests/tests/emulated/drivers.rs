//! UART drivers: the emulated SKR Pico has four.

use isostep_tests::emulated::{Board, UartDriver};

/// What the firmware sets a driver to.
fn as_set(microsteps: u64) -> UartDriver {
    // 26 of 32 parts of 979 mA are 795, and 13 are half of that.
    UartDriver { microsteps, currents: [25, 12], chopper: "SpreadCycle".into(), datagrams: [0, 0, 0] }
}

fn found(run: &isostep_tests::emulated::Run, axis: char) -> Option<UartDriver> {
    let driver = run.driver(axis)?;
    assert_eq!(driver.datagrams[2], 0, "datagrams that a driver refused");
    Some(UartDriver { datagrams: [0, 0, 0], ..driver })
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn drivers_are_set_before_the_welcome() {
    let run = Board::of_skr_pico("drivers").script("expect Grbl\nsend G91 G1 X1 F600\nexpect ok\nwait-idle\n");
    assert!(run.ok, "{}", run.printed);
    for axis in ['X', 'Y', 'Z'] {
        assert_eq!(found(&run, axis), Some(as_set(16)), "{axis}");
    }
    // No axis has a second motor: nobody talks to its driver.
    let not_set = UartDriver { currents: [31, 16], chopper: "StealthChop".into(), ..as_set(16) };
    assert_eq!(run.driver('A'), Some(not_set));
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_setting_is_in_the_driver_when_it_is_answered() {
    let script = "expect Grbl\nsend $151=32\nexpect [MSG:$101=100.000 now\nexpect ok\nsend $142=1200\nexpect ok\nsend $980=600\nexpect ok\n\
                  send $905=2\nexpect ok\nsend M122\nexpect [MSG:Y driver: well, 32 microsteps\nexpect [MSG:Y2 driver: well\nexpect ok\n";
    let run = Board::of_skr_pico("drivers-set").script(script);
    assert!(run.ok, "{}", run.printed);
    let mut expected = [as_set(16), as_set(32), as_set(16), as_set(32)];
    expected[0].chopper = "StealthChop".into();
    expected[2].currents = [20, 9];
    assert_eq!(['X', 'Y', 'Z', 'A'].map(|axis| found(&run, axis)), expected.map(Some));
}

/// A setting that is changed back is written again.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_setting_that_is_changed_back_is_in_the_driver() {
    let set = |lines: &[&str]| lines.iter().map(|line| format!("send {line}\nexpect ok\n")).collect::<String>();
    let changed = ["$142=1200", "$152=8", "$982=600"];
    let back = ["$142=800", "$152=16", "$982=0"];
    for (lines, expected) in [
        ([changed, back].concat(), as_set(16)),
        (
            [changed, back, changed].concat(),
            UartDriver { currents: [20, 9], chopper: "StealthChop".into(), ..as_set(8) },
        ),
    ] {
        let run = Board::of_skr_pico("drivers-back").script(&format!("expect Grbl\n{}", set(&lines)));
        assert!(run.ok, "{}", run.printed);
        assert_eq!(found(&run, 'Z'), Some(expected), "{lines:?}");
    }
}

/// A driver that fails in mid-move stops the machine, and the count of the steps is that of the edges.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_driver_that_fails_stops_the_machine() {
    let faults = [
        ("off", "on", "does not answer"),
        ("shorted", "well", "has found a short"),
        ("overheated", "well", "was too hot"),
        // It is heard while the next driver is asked, or the next time.
        ("late", "well", "does not answer"),
    ];
    for (fault, mended, words) in faults {
        let script = format!(
            "expect Grbl\nsend G91 G1 X100 Y50 F2000\nexpect ok\nwait-ms 500\ndriver Y {fault}\n\
             expect [MSG:Y driver {words}\nexpect ALARM:17\nsend ?\nexpect <Alarm\ndriver Y {mended}\nwait-ms 300\nsend $X\nexpect ok\nwait-ms 300\n\
             send M122\nexpect [MSG:X driver: well\nexpect [MSG:Y driver: well\nexpect ok\n\
             send G91 G1 X1 F600\nexpect ok\nwait-idle\n"
        );
        let run = Board::of_skr_pico("drivers-fault").script(&script);
        assert!(run.ok, "{fault}: {}", run.printed);
        assert_eq!(found(&run, 'Y'), Some(as_set(16)), "{fault}");
    }
}

/// What a driver warns of stops nothing.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_hot_driver_and_disturbed_replies_stop_nothing() {
    let script = "expect Grbl\nsend G91 G1 X20 F600\nexpect ok\nwait-ms 200\ndriver X hot\nexpect [MSG:X driver is hot\ndriver X well\n\
                  expect [MSG:X driver is well\ndriver X garbled\nwait-idle\nsend M122\nexpect [MSG:X driver: well\nexpect ok\n";
    let run = Board::of_skr_pico("drivers-hot").script(script);
    assert!(run.ok, "{}", run.printed);
}
