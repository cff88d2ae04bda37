//! The output watchdog on the emulated board: a core that hangs drops the tool, and nothing else does.

use std::fmt::Write as _;

use isostep_sim::Port;
use isostep_tests::emulated::{Board, Run};
use isostep_trials::cases;
use oorandom::Rand32;

/// The output watchdog is fed every 5 ms and is patient for 20 ms. The core may have hung at any time between two feeds.
const OFF_AFTER_MS: [f64; 2] = [14.9, 20.001];

fn went_through(run: Run) -> Run {
    assert!(run.ok, "{}", run.printed);
    run
}

/// The time that outputs were on after each time the core hung, ms.
fn off_after_ms(run: &Run) -> Vec<f64> {
    let stops = run.figures["tool"]["stops"].as_array().unwrap();
    let hangs = stops.iter().filter(|stop| stop["input"] == "HANG");
    hangs.map(|stop| stop["outputs_off_ns"].as_f64().expect("off") * 1e-6).collect()
}

/// A laser in a slow move, then a spindle and coolant at rest. Each time the core hangs at another instant, and comes
/// back after the output watchdog has run out.
fn a_core_that_hangs_drops_the_tool(port: Port, test: &str) {
    let count = cases(6, 30) as usize;
    let mut random = Rand32::new(6);
    let mut script = "expect Grbl\nsend $30=1000\nexpect ok\nsend G91\nexpect ok\n".to_owned();
    for laser in [1, 0] {
        writeln!(script, "send $32={laser}\nexpect ok").unwrap();
        for _ in 0..count {
            let lines = ["M3S500M8", "M3S500M8G1X5F300"][laser];
            writeln!(script, "send {lines}\nexpect ok\nwait-output pwm on").unwrap();
            writeln!(script, "wait-us {}.3\nhang 30\nexpect ALARM:", random.rand_range(20_000..25_000)).unwrap();
            writeln!(script, "wait-output flood off\nsend $X\nexpect ok\nwait-ms 5").unwrap();
        }
    }
    let run = went_through(Board::stepped_by(port, test).script(&script));
    let off_after_ms = off_after_ms(&run);
    assert_eq!(off_after_ms.len(), 2 * count);
    let [least, most] = OFF_AFTER_MS;
    assert!(off_after_ms.iter().all(|&ms| (least..most).contains(&ms)), "{off_after_ms:?}");
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_core_that_hangs_drops_the_tool_within_20_ms() {
    a_core_that_hangs_drops_the_tool(Port::Pio, "output-watchdog");
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_core_that_hangs_drops_the_tool_by_the_timer_port_too() {
    a_core_that_hangs_drops_the_tool(Port::Timer, "output-watchdog-timer");
}

/// The first setting that is stored has a sector erased. Nothing is fed meanwhile.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn storing_does_not_drop_the_tool() {
    let script = "expect Grbl\nsend M3S500M8\nexpect ok\nwait-output flood on\nwait-ms 10\n\
                  send $110=3000\nexpect ok\nwait-ms 100\nbytes 3f\nexpect <Idle\nsend $111=3000\nexpect ok\nwait-ms 100\n\
                  hang 30\nexpect ALARM:23\n";
    let run = went_through(Board::new("output-watchdog-store").script(script));
    let sent =
        |line: &str| run.figures["replies"].as_array().unwrap().iter().find(|reply| reply["text"] == line).cloned();
    let reply = sent("$110=3000").expect("its reply");
    let stored_ns = reply["replied_ns"].as_f64().unwrap() - reply["arrived_ns"].as_f64().unwrap();
    assert!(stored_ns > 45e6, "no sector was erased: {reply}");
    let floods = run.outputs.iter().filter(|change| change.output == "flood").count();
    assert_eq!(floods, 2, "on, and off when the core hangs: {:?}", run.outputs);
    let [least, most] = OFF_AFTER_MS;
    assert!((least..most).contains(&off_after_ms(&run)[0]), "as patient as before: {:?}", off_after_ms(&run));
}
