//! Homing by stall: the emulated drivers' DIAG is wired to the limit inputs, and a hard end is where the switches close.

use isostep_tests::emulated::{Board, Run};

/// All that homing by stall needs but the threshold.
const SETTINGS: &str = "expect Grbl\nsend $339=7\nexpect ok\nsend $25=1800\nexpect ok\n\
    send $110=3000\nexpect ok\nsend $111=3000\nexpect ok\nsend $112=3000\nexpect ok\n\
    send $120=500\nexpect ok\nsend $121=500\nexpect ok\nsend $122=500\nexpect ok\n\
    send $980=3000\nexpect ok\nsend $981=3000\nexpect ok\nsend $982=3000\nexpect ok\n";
const THRESHOLDS: &str = "send $200=45\nexpect ok\nsend $201=45\nexpect ok\nsend $202=45\nexpect ok\n";
const WIRED: [&str; 4] = ["--diag", "X,Y,Z", "--hard-ends", "0"];

/// Where an axis stands, mm above its end.
fn place_mm(run: &Run, axis: &str) -> f64 {
    run.figures["axes"][axis]["place_mm"].as_f64().unwrap()
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_threshold_is_measured_and_three_axes_home_by_it() {
    // The emulated SG_RESULT of a free motor is 180 to 220, and that of a blocked one 4 at most.
    let script = format!(
        "{SETTINGS}send $HX\nexpect [MSG:a stall of X cannot be detected: $200=0\nexpect error:20\n\
         send $STALL=X\nexpect [MSG:X turns freely at SG_RESULT 180 to 220\nexpect ok\n{THRESHOLDS}\
         send $H\nexpect [MSG:X has stalled twice\nexpect [MSG:Y has stalled twice\nexpect [MSG:Z has stalled twice\nexpect ok\n\
         send ?\nexpect <Idle|MPos:0.000,0.000,0.000\n"
    );
    let run = Board::of_skr_pico("stall-homing").with(&WIRED).script(&script);
    assert!(run.ok, "{}", run.printed);
    assert!(run.printed.contains("readings: try $200=45,"), "{}", run.printed);
    for axis in ["X", "Y", "Z"] {
        assert_eq!(place_mm(&run, axis), 2.0, "{axis}: {}", run.printed);
        // Two full steps of 16, twice: those until a driver has measured, and no more.
        let lost = run.figures["axes"][axis]["lost_steps"].as_u64().unwrap();
        assert!((2..=64).contains(&lost), "{axis} lost {lost}");
    }
    assert_eq!(run.figures["driver_timing"]["violations"], 0, "{}", run.printed);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn without_a_jumper_nothing_moves() {
    let script = format!(
        "{SETTINGS}{THRESHOLDS}send $HX\nexpect [MSG:a stall of X cannot be detected: its limit input is high\nexpect error:20\n"
    );
    let run = Board::of_skr_pico("stall-unwired").script(&script);
    assert!(run.ok, "{}", run.printed);
    assert_eq!(run.edges.len(), 0);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_stall_that_is_never_reported_is_alarm_9() {
    // There is no end.
    let script = format!("{SETTINGS}{THRESHOLDS}send $130=30\nexpect ok\nsend $HX\nexpect ALARM:9\nexpect error:9\n");
    let run = Board::of_skr_pico("stall-endless").with(&["--diag", "X,Y,Z"]).script(&script);
    assert!(run.ok, "{}", run.printed);
    assert_eq!(run.edges.len(), 45 * 50);
}

/// A threshold above what a free motor has is a stall wherever the axis gets fast.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_threshold_that_is_too_high_is_noticed() {
    let script = format!("{SETTINGS}send $200=120\nexpect ok\nsend $HX\nexpect ALARM:24\nexpect error:9\n");
    let run = Board::of_skr_pico("stall-false").with(&WIRED).script(&script);
    assert!(run.ok, "{}", run.printed);
    assert!(place_mm(&run, "X") > 10.0, "{}", run.printed);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_stall_in_a_move_is_an_alarm_if_that_is_asked_for() {
    let script = format!(
        "{SETTINGS}{THRESHOLDS}send $20=0\nexpect ok\nsend $909=1\nexpect ok\nsend $J=G91 X-60 F1800\nexpect ok\n\
         expect ALARM:17\nexpect [MSG:X driver has reported a stall of its motor\nsend $X\nexpect [MSG:Caution: Unlocked\nwait-ms 300\n\
         send $HX\nexpect [MSG:X has stalled twice\nexpect ok\n"
    );
    let run = Board::of_skr_pico("stall-alarm").with(&WIRED).script(&script);
    assert!(run.ok, "{}", run.printed);
    assert_eq!(place_mm(&run, "X"), 2.0);
    // No step is made once the input is high.
    let stops = run.figures["stops"].as_array().unwrap();
    let stop = stops.iter().find(|stop| stop["input"] == "X_LIMIT").unwrap();
    assert_eq!(stop["edges_after"], 0, "{stop}");
}
