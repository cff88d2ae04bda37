//! The pins of an SKR Pico: other ones than a Pico's, and an ENABLE for each driver.

use isostep_tests::emulated::{Board, Run};

use crate::inputs;

fn carried_out(test: &str, options: &[&str], script: &str) -> Run {
    let run = Board::of_skr_pico(&format!("skr-pico-{test}")).with(options).script(&format!("expect Grbl\n{script}"));
    assert!(run.ok, "{}", run.printed);
    assert_eq!(run.figures["driver_timing"]["violations"], 0, "{}", run.printed);
    run
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn each_axis_of_an_skr_pico_has_its_own_pins() {
    let script = "send G91 G0 X1 Y-2 Z3\nexpect ok\nsend G0 X1 Y2 Z-3\nexpect ok\nwait-idle\ncheck-position\n\
                  send $I\nexpect [BOARD:BTT SKR Pico V1.0]\nexpect ok\n";
    let run = carried_out("pins", &[], script);
    assert_eq!(run.turns(), [vec![100], vec![-100, 100], vec![150, -150], vec![]]);
}

/// ENABLE is four pins, which are switched together. The fourth driver's motor is not free while the others hold.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn all_drivers_of_an_skr_pico_are_enabled_and_freed() {
    let script = "motors off\nsend $1=50\nexpect ok\nsend G91 G0 X1\nexpect ok\nwait-ms 20\nmotors on\nwait-idle\nwait-ms 100\nmotors off\n\
                  send $1=255\nexpect ok\nsend G0 Z1\nexpect ok\nwait-idle\nwait-ms 100\nmotors on\nsend $SLP\nexpect ok\nwait-ms 20\nmotors off\n";
    carried_out("enable", &[], script);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn each_input_of_an_skr_pico_stops_all_axes_within_10_us() {
    let stops = [inputs::X, inputs::Y, inputs::Z, inputs::ESTOP];
    inputs::each_stops_all_axes(Board::of_skr_pico("skr-pico-stops"), "XYZ", &stops);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn an_skr_pico_homes_to_its_switches() {
    let script = "send $24=200\nexpect ok\nsend $25=2880\nexpect ok\nsend $H\nexpect ok\nbytes 3f\nexpect <Idle|MPos:0.000,0.000,0.000\n";
    let run = carried_out("homing", &["--start", "3,2.5,3.5", "--bounce-us", "800"], script);
    for axis in ["X", "Y", "Z"] {
        assert_eq!(run.figures["axes"][axis]["place_mm"], 2.0, "{axis}: {}", run.printed);
    }
}

/// The second motor is the board's fourth, and its switch is at THB.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_fourth_motor_of_an_skr_pico_is_a_second_one() {
    let script = "send $905=2\nexpect ok\nsend $20=0\nexpect ok\ncount-together\nsend G91 G0 Y5\nexpect ok\nwait-idle\ncheck-together\n\
                  send G0 Y20\nexpect ok\nwait-ms 300\nswitch 2 stuck-closed\nexpect ALARM:1\nexpect [MSG:Y2 limit switch closed\n\
                  wait-ms 20\ncheck-together\ncheck-position\n";
    carried_out("second", &["--second", "Y,0"], script);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_outputs_of_an_skr_pico_are_switched() {
    let script = "send M3 S250\nexpect ok\nwait-output pwm on\nwait-output enable on\nsend M4\nexpect ok\nwait-output direction on\n\
                  send M8\nexpect ok\nwait-output flood on\nsend M7\nexpect ok\nwait-output mist on\n\
                  send M5\nexpect ok\nwait-output enable off\nsend M9\nexpect ok\nwait-output mist off\nwait-output flood off\n";
    let run = carried_out("outputs", &[], script);
    let changes = |output: &str| {
        run.outputs.iter().filter(|change| change.output == output).map(|change| change.value).collect::<Vec<_>>()
    };
    assert_eq!(changes("flood"), [1.0, 0.0]);
    assert_eq!(changes("mist"), [1.0, 0.0]);
    let duty = changes("pwm")[0];
    assert!((duty - 0.25).abs() < 0.001, "{duty}");
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_buttons_and_the_probe_of_an_skr_pico_are_heard() {
    let script = "send G91 G1 X10 F600\nexpect ok\nwait-ms 300\nhold pressed\nwait-ms 300\nbytes 3f\nexpect <Hold:0\nhold released\nwait-ms 20\n\
                  start pressed\nwait-ms 20\nstart released\nwait-idle\nbytes 3f\nexpect <Idle|MPos:10.000,0.000,0.000\n\
                  send G38.2 Z-10 F300\nwait-ms 500\nprobe pressed\nexpect [PRB:10.000,0.000,-2\nexpect ok\n";
    carried_out("contacts", &[], script);
}
