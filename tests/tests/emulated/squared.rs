//! An axis with two motors on the emulated board, with each port: homed apart, stepped on the same cycles, stopped by
//! either switch.

use isostep_sim::Port;
use isostep_tests::emulated::Board;

/// A second motor on Y, and quick homing.
const SETTINGS: &str = "expect Grbl\nsend $905=2\nexpect ok\nsend $24=600\nexpect ok\nsend $25=2880\nexpect ok\n\
                        send $26=1\nexpect ok\nsend $121=500\nexpect ok\nsend $120=500\nexpect ok\n";

/// Runs a script on a gantry that is skewed by so many mm at power-up, near its switches.
fn carry_out(port: Port, test: &str, skew_mm: f64, script: &str) {
    let second = format!("Y,{skew_mm}");
    let options = ["--second", &second, "--start", "10,6,10", "--bounce-us", "300"];
    let run = Board::stepped_by(port, &format!("{test}-{port}")).with(&options).script(&format!("{SETTINGS}{script}"));
    assert!(run.ok, "{port}, {skew_mm} mm: {}", run.printed);
    assert_eq!(run.figures["driver_timing"]["violations"], 0, "{port}: {}", run.printed);
    assert_eq!(run.figures["floating_input_pins"], serde_json::json!([]), "{port}");
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_squared_axis_is_homed_apart_and_steps_on_the_same_cycles() {
    for port in Port::ALL {
        for (skew_mm, offset_mm) in [(2.5, 0.5), (-2.5, -0.5), (0.0, 0.0)] {
            let offset_steps = 50.0 * offset_mm;
            let script = format!(
                "send $171={offset_mm}\nexpect ok\nsend $HY\nexpect ok\ncheck-square {offset_steps}\ncount-together\n\
                 send G53 G0 X3 Y20\nexpect ok\nsend G53 G1 X0 Y5 F2000\nexpect ok\nsend G53 G1 Y5.5\nexpect ok\n\
                 wait-idle\ncheck-together\ncheck-square {offset_steps}\ncheck-position\n"
            );
            carry_out(port, "squared", skew_mm, &script);
        }
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_limit_of_either_motor_stops_the_board_at_once() {
    for (port, within_us) in [(Port::Pio, 1.5), (Port::Timer, 10.0)] {
        for (switch, name) in [("Y", "Y"), ("2", "Y2")] {
            let script = format!(
                "send $HY\nexpect ok\ncount-together\nsend G53 G1 X20 Y30 F2000\nexpect ok\nwait-ms 400\n\
                 switch {switch} stuck-closed\nstop-within {within_us}\nexpect ALARM:1\nexpect [MSG:{name} limit switch closed\n\
                 wait-ms 20\ncheck-stopped\ncheck-together\ncheck-position\nbytes 3f\nexpect <Alarm\n\
                 switch {switch} normal\nwait-ms 5\nsend $X\nexpect ok\nsend G91 G0 Y2\nexpect ok\nwait-idle\n\
                 check-together\ncheck-square 0\ncheck-position\n"
            );
            carry_out(port, &format!("squared-limit-{switch}"), 0.0, &script);
        }
    }
}

/// As fast as the drivers go: 240,000 steps/s of every motor, at which a step rises every 4 us.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_limit_of_either_motor_stops_a_fast_move_within_1_5_us() {
    let mut script = "send $0=0\nexpect ok\n".to_owned();
    for axis in 0..3 {
        let settings = [(110, 288_000), (120, 100_000)];
        script.extend(settings.map(|(number, value)| format!("send ${}={value}\nexpect ok\n", number + axis)));
    }
    for index in 0..16 {
        let (switch, mm, us) = (["Y", "2"][index % 2], 900 * (1 - index % 2), 60_000 + 997 * index);
        script += &format!(
            "send G0X{mm}Y{mm}Z{mm}\nexpect ok\nwait-us {us}.3\nswitch {switch} stuck-closed\nexpect ALARM:1\n"
        );
        script += &format!("switch {switch} normal\nwait-ms 20\nsend $X\nexpect ok\ncheck-position\n");
    }
    let options = ["--second", "Y,0", "--start", "900,900,900"];
    let run = Board::new("squared-fast").with(&options).script(&format!("{SETTINGS}{script}"));
    assert!(run.ok, "{}", run.printed);
    let stops = run.figures["stops"].as_array().unwrap();
    assert_eq!(stops.len(), 16);
    for stop in stops {
        assert!(stop["latency_ns"].as_f64().unwrap() <= 1_500.0, "{stop}");
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_motor_without_its_switch_is_an_alarm_that_names_it() {
    for port in Port::ALL {
        for (switch, name, skewed_steps) in [("Y", "Y", 75), ("2", "Y2", -75)] {
            let script = format!(
                "send $349=1.5\nexpect ok\nswitch {switch} stuck-open\nsend $HY\nexpect error:9\n\
                 expect [MSG:{name} did not reach its switch\ncheck-square {skewed_steps}\n\
                 switch {switch} normal\nsend $X\nexpect ok\nsend $349=5\nexpect ok\nsend $HY\nexpect ok\ncheck-square 0\n"
            );
            carry_out(port, &format!("squared-blind-{switch}"), 0.0, &script);
        }
    }
}

/// A second motor that is mounted the other way round turns by `$8`. Without a setting it makes no step, and another axis may
/// have it.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_direction_of_the_second_motor_is_its_own() {
    for port in Port::ALL {
        let script = "count-together\nsend $8=2\nexpect ok\nsend G91 G0 Y1\nexpect ok\nwait-idle\ncheck-together\n\
                      check-square -100\nsend $8=0\nexpect ok\nsend G0 Y1\nexpect ok\nwait-idle\ncheck-together\n\
                      check-square -100\nsend $905=0\nexpect ok\nsend G0 Y1\nexpect ok\nwait-idle\ncheck-square -150\n\
                      send $905=1\nexpect ok\nsend G0 X1\nexpect ok\nwait-idle\ncheck-square -100\ncheck-position\n";
        carry_out(port, "squared-direction", 0.0, script);
    }
}

/// At the end of a run the counts of both motors have to agree: otherwise the frame may be skewed, and that is an alarm.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn motors_that_count_differently_are_an_alarm() {
    let begin = "count-together\nsend G91 G0 Y5\nexpect ok\nwait-ms 50\n";
    carry_out(Port::Pio, "squared-count", 0.0, &format!("{begin}wait-idle\ncheck-together\n"));
    let script = format!("{begin}miscount-second\nexpect ALARM:22\ncheck-together\ncheck-position\n");
    carry_out(Port::Pio, "squared-miscount", 0.0, &script);
}

/// The guard inhibits for a press before anything is decided, but not while a gantry is squared. The switches of the axis are
/// pressed before a ganged motor can have met its own; after that a press would have its level debounced anew.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn presses_while_a_gantry_is_squared_inhibit_nothing() {
    let press = |switch: &str, us: u32| {
        format!("wait-us {us}\nswitch {switch} stuck-closed\nwait-us 0.1\nswitch {switch} normal\n")
    };
    for port in Port::ALL {
        for skew_mm in [2.5, -2.5] {
            let first: String = (0..12).map(|index| press(["2", "Y", "X"][index % 3], 150)).collect();
            let later: String = (0..60).map(|index| press(["X", "Z"][index % 2], 7_300)).collect();
            let script =
                format!("send $HY\n{first}{later}expect ok\ncheck-square 0\ncheck-position\nbytes 3f\nexpect <Idle\n");
            carry_out(port, "squared-presses", skew_mm, &script);
        }
    }
}

/// The guard sees the second motor's switch as it sees the others, on a state machine of its own.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_press_of_the_second_switch_counts_however_short_it_is() {
    for port in Port::ALL {
        let press = "switch 2 stuck-closed\nwait-us 0.1\nswitch 2 normal\n";
        let script = format!(
            "count-together\nsend G91 G0 X5 Y5\nexpect ok\nwait-ms 100\n{press}expect ALARM:1\nwait-ms 20\ncheck-position\n\
             check-together\nsend $X\nexpect ok\nsend $905=0\nexpect ok\nsend G91 G0 X5\nexpect ok\nwait-ms 100\n{press}\
             wait-idle\nbytes 3f\nexpect <Idle\n"
        );
        carry_out(port, "squared-press", 0.0, &script);
    }
}
