//! Spindle and coolant, row by row of the table of the tool in docs/console.md.

use embassy_time::Duration;
use isostep_motion::{Level, Outputs, Spindle};
use isostep_sim::tool::{ToolChange, ToolOutput};
use isostep_sim::{Config, Port, Sim};

use crate::talk::{begin, bytes, homed, powered_up, report, say, state};

const OFF: [u16; 5] = [0; 5];

/// The accessories in a report, which come after the overrides.
fn accessories(sim: &mut Sim) -> Option<String> {
    let reported = (0..40).map(|_| report(sim)).find(|report| report.contains("|Ov:")).expect("overrides");
    Some(reported.split("|A:").nth(1)?.trim_end_matches('>').to_owned())
}

/// The words for spindle and coolant in `$G`.
fn modes(sim: &mut Sim) -> String {
    let heard = say(sim, "$G");
    let words = heard[0].split(' ').filter(|word| word.starts_with('M'));
    words.collect::<Vec<_>>().join(" ")
}

/// After a start, and after a reversal, nothing moves, dwells or jogs until the time has passed. A change of speed
/// takes no time.
#[test]
fn setting_394_gives_the_spindle_time() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$394=1.5\nF600"), ["ok", "ok"]);
    let mut x_mm = 0;
    let mut waits_ms = |sim: &mut Sim, line: &str| {
        assert_eq!(begin(sim, line, Duration::from_millis(1)), ["ok"], "{line}: answered at once");
        x_mm += 1;
        let asked_ns = sim.now_ns();
        assert_eq!(say(sim, &format!("G1 X{x_mm}")), ["ok"]);
        let outcome = sim.outcome();
        let first = outcome.edges.iter().find(|edge| edge.t_ns >= asked_ns).unwrap();
        (first.t_ns - asked_ns) / 1_000_000
    };
    let at_once_ms = waits_ms(&mut sim, "G4 P0");
    assert!(at_once_ms < 100, "{at_once_ms} ms");
    for (line, spins_up) in [
        ("M3 S1000", true),
        ("S500", false),
        ("M3 S400", false),
        ("M4", true),
        ("M8", false),
        ("M5", false),
        ("S100", false),
        ("M3", true),
    ] {
        let wait_ms = waits_ms(&mut sim, line);
        // The move was requested a millisecond after the spindle.
        let expected_ms = at_once_ms + if spins_up { 1_499 } else { 0 };
        assert!(wait_ms.abs_diff(expected_ms) <= 1, "{line}: {wait_ms} ms, not {expected_ms}");
    }
    assert_eq!(say(&mut sim, "M5"), ["ok"]);
    let before = sim.now();
    assert_eq!(say(&mut sim, "M3 G4 P0.5"), ["ok"]);
    let took = sim.now() - before;
    assert!((2_000..2_005).contains(&took.as_millis()), "{took:?}");
    // M5 before the spindle has its speed: the move does not wait.
    assert_eq!(begin(&mut sim, "M4\nM5\nG1 X0", Duration::from_millis(200)), ["ok"; 3]);
    assert!(sim.machine().position_steps()[0] < 50 * x_mm, "it moves");
}

/// A spindle with S0 stands, whatever its direction: enable is off, because a VFD runs by it. It begins to turn with the
/// next S, and nothing moves before it has its speed.
#[test]
fn a_spindle_that_starts_from_s0_is_waited_for() {
    for port in Port::ALL {
        for (stands, modes_reported) in
            [("M4 S0\nG4 P0.1", "M4 M9"), ("M3 S900\nG4 P0\nS0\nG0 X1\nG4 P3", "M3 M9"), ("M3\nM4", "M4 M9")]
        {
            for goes in ["G1 X2 F300", "G0 X2", "$J=X2 F300"] {
                let mut sim = powered_up(&Config { port, ..Config::default() });
                assert_eq!(say(&mut sim, "$394=2.5").last_line(), "ok");
                assert_eq!(say(&mut sim, stands).last_line(), "ok");
                assert_eq!((sim.tool(), accessories(&mut sim)), (OFF, None), "{port}, {stands:?}");
                assert_eq!(modes(&mut sim), modes_reported, "{stands:?}");
                assert_eq!(say(&mut sim, &format!("S900\n{goes}")), ["ok", "ok"], "{stands:?}");
                let outcome = sim.outcome();
                let is_rise = |change: &&ToolChange| change.output == ToolOutput::Pwm && change.duty > 0;
                let rose_ns = outcome.tool.iter().rfind(is_rise).unwrap().t_ns;
                let first = outcome.edges.iter().find(|edge| edge.t_ns > rose_ns).unwrap();
                let waits_ms = (first.t_ns - rose_ns) / 1_000_000;
                assert!((2_500..2_700).contains(&waits_ms), "{port}, {stands:?}, {goes}: {waits_ms} ms");
            }
        }
    }
}

/// The outputs stay off even if they are requested.
#[test]
fn outputs_stay_off_while_a_reset_brakes() {
    let mut sim = homed();
    begin(&mut sim, "M3 S1000\nG1 X50 F1200", Duration::from_secs(1));
    bytes(&mut sim, b"\x18");
    assert_eq!(state(&mut sim), "Hold:1");
    let on = Outputs { spindle: Spindle::Clockwise, level: Level::FULL, ..Outputs::OFF };
    assert!(sim.machine().set_outputs(on).is_err() && sim.machine().set_coolant(true, false).is_err());
    assert_eq!(sim.machine().set_outputs(Outputs::OFF), Ok(()));
    sim.run_until_idle().unwrap();
    assert_eq!((state(&mut sim).as_str(), sim.tool()), ("Idle", OFF));
    assert_eq!(sim.machine().set_outputs(on), Ok(()));
}
