//! The fourth axis on the emulated board: its pins, its switch, its words, and what it shares with the others. With each
//! port where everything is compiled for four axes.

use isostep_sim::{AXES, Port};
use isostep_tests::emulated::{Board, Run};

use crate::inputs;

const PORTS: &[Port] = if AXES == 4 { &Port::ALL } else { &[Port::Pio] };

fn carried_out_with(test: &str, options: &[&str], script: &str) -> Vec<Run> {
    let run = |&port| {
        let board = Board::of_four_axes(port, &format!("four-axes-{test}-{port}")).with(options);
        let run = board.script(&format!("expect Grbl\n{script}"));
        assert!(run.ok, "{port}: {}", run.printed);
        assert_eq!(run.figures["driver_timing"]["violations"], 0, "{port}: {}", run.printed);
        run
    };
    PORTS.iter().map(run).collect()
}

fn carried_out(test: &str, script: &str) -> Vec<Run> {
    carried_out_with(test, &[], script)
}

/// A homes to the switch on its own pin, and turns past it without an end. With an end the same switch stops all axes.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_homes_turns_and_stops_at_its_switch() {
    let mut script = "send $901=3124\nexpect ok\nsend $HA\nexpect ok\nbytes 3f\nexpect <Idle\n".to_owned();
    script += "switch A stuck-closed\nwait-ms 20\nbytes 3f\nexpect <Idle|MPos:0.000,0.000,0.000,0.000|FS:0,0|Pn:A\n";
    script += "send G0 A20 X3\nexpect ok\nwait-idle\nsend G0 A0 X0\nexpect ok\nwait-idle\ncheck-position\n";
    script += "switch A normal\nwait-ms 20\nsend $133=180\nexpect ok\nsend G0 A90 X20\nexpect ok\nwait-ms 500\n";
    script += "switch A stuck-closed\nexpect ALARM:1\nexpect [MSG:A\nstop-within 100\nwait-ms 300\ncheck-stopped\n";
    carried_out("homes", &script);
}

/// `$H` leaves A where it is, unless the order names it. Then A has its zero at its own switch.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_is_homed_with_the_others_if_the_order_names_it() {
    let script = "send $24=200\nexpect ok\nsend $25=2880\nexpect ok\nsend $26=1\nexpect ok\nsend $HA\nexpect error:5\nsend $H\nexpect ok\n";
    let start = ["--start", "3,2.5,3.5,4"];
    for run in carried_out_with("not-homed", &start, script) {
        assert_eq!(run.steps()[3], 0);
        assert_eq!(run.figures["axes"]["X"]["place_mm"], 2.0);
    }
    for run in
        carried_out_with("homed", &start, &script.replace("send $HA\nexpect error:5", "send $901=4312\nexpect ok"))
    {
        for axis in ["X", "Y", "Z", "A"] {
            assert_eq!(run.figures["axes"][axis]["place_mm"], 2.0, "{axis}: {}", run.printed);
        }
    }
}

/// All four motors start on one cycle, and make as many steps as they are asked for.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn four_axes_start_on_the_same_cycle() {
    let script = "send G0 X8 Y8 Z8 A8\nexpect ok\nwait-idle\ncheck-position\n";
    // The timer port sets the pins of one axis after the other.
    let run = carried_out("start", script).swap_remove(0);
    let of_axis = |axis: usize| run.edges.iter().filter(move |edge| edge.axis == axis).map(|edge| edge.t_ns);
    let x: Vec<_> = of_axis(0).collect();
    assert_eq!(x.len(), 400);
    for axis in 1..4 {
        assert!(of_axis(axis).eq(x.iter().copied()), "axis {axis}");
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn each_of_four_axes_has_its_own_pins_and_direction() {
    let script = "send G91 G0 X1 Y-2 Z3 A-4\nexpect ok\nsend G0 X1 Y2 Z-3 A-4\nexpect ok\nwait-idle\ncheck-position\n\
                  send $3=8\nexpect ok\nsend G0 A-1\nexpect ok\nwait-idle\n";
    for run in carried_out("pins", script) {
        // $3 inverts the DIR of A alone.
        let expected = [vec![100], vec![-100, 100], vec![150, -150], vec![-400, 50]];
        assert_eq!(run.turns(), expected);
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn the_motors_of_four_axes_are_enabled_for_a_move_of_a_alone() {
    let script = "motors off\nsend $1=50\nexpect ok\nsend G91 G0 A5\nexpect ok\nwait-ms 20\nmotors on\nwait-idle\nwait-ms 100\nmotors off\n\
                  send $1=255\nexpect ok\nsend G0 A1\nexpect ok\nwait-idle\nwait-ms 100\nmotors on\nsend $SLP\nexpect ok\nwait-ms 20\nmotors off\n";
    carried_out("enable", script);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn each_input_stops_all_four_axes_within_10_us() {
    let a = ("A_LIMIT", "switch A stuck-closed", "ALARM:1\nexpect [MSG:A limit switch", "switch A normal");
    let stops = [inputs::X, inputs::Y, inputs::Z, a, inputs::ESTOP];
    inputs::each_stops_all_axes(Board::of_four_axes(Port::Pio, "four-axes-stops"), "XYZA", &stops);
}

/// Words, reports, settings and places have four values, and A's are degrees whatever the unit of the others.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_has_its_words_reports_and_settings() {
    let script = "send $I\nexpect [AXS:4:XYZA]\nexpect ok\nsend $$\nexpect $103=50.000\nexpect $113=\nexpect $123=\nexpect $133=0.000\nexpect $376=1\nexpect $701=0\nexpect ok\n\
                  send B1\nexpect error:20\nsend G20 G0 X1 A10\nexpect ok\nwait-idle\nbytes 3f\nexpect <Idle|MPos:25.400,0.000,0.000,10.000\n\
                  send G10 L20 P0 A0\nexpect ok\nsend G0 A-30\nexpect ok\nwait-idle\nbytes 3f\nexpect <Idle|MPos:25.400,0.000,0.000,-20.000\n\
                  send $#\nexpect [G54:0.000,0.000,0.000,10.000]\nexpect ok\n";
    for run in carried_out("words", script) {
        assert_eq!(run.steps(), [1_270, 0, 0, 2_000]);
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn what_is_set_of_a_outlives_a_power_cycle() {
    let script = "send $103=100\nexpect ok\nsend $133=90\nexpect ok\nsend $376=0\nexpect ok\nsend G10 L2 P2 A4\nexpect ok\n\
                  power-cycle\nexpect Grbl\nsend $$\nexpect $103=100.000\nexpect $133=90.000\nexpect $376=0\nexpect ok\n\
                  send $#\nexpect [G55:0.000,0.000,0.000,4.000]\nexpect ok\nsend G91 G0 A1\nexpect ok\nwait-idle\n";
    for run in carried_out("stored", script) {
        assert_eq!(run.steps(), [0, 0, 0, 100]);
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_rotary_axis_without_an_end_has_no_soft_limit_and_one_with_an_end_has() {
    let script = "send $24=200\nexpect ok\nsend $25=2880\nexpect ok\nsend $901=3124\nexpect ok\nsend $HA\nexpect ok\nsend $113=36000\nexpect ok\nsend $123=1000\nexpect ok\n\
                  send G0 A400\nexpect ok\nsend G0 A0\nexpect ok\nwait-idle\ncheck-position\nsend $133=180\nexpect ok\nsend $HA\nexpect ok\nsend G0 A179\nexpect ok\nwait-idle\n\
                  send G0 A181\nexpect [MSG:A181.000 is outside the travel, 0.000 to 180.000 degrees\nexpect error:9\nexpect ALARM:2\n";
    carried_out("travel", script);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_jog_of_a_is_cancelled_and_a_move_of_four_axes_held_and_resumed() {
    let script = "send $J=G91 A200 F2400\nexpect ok\nwait-ms 500\nbytes 85\nwait-idle\ncheck-position\nsend $J=G90 A0 F2400\nexpect ok\nwait-idle\n\
                  send G1 X20 Y15 Z10 A25 F2400\nexpect ok\nwait-ms 400\nbytes 21\nwait-ms 600\nbytes 3f\nexpect <Hold:0\ncheck-position\nbytes 7e\nwait-idle\n\
                  bytes 3f\nexpect <Idle|MPos:20.000,15.000,10.000,25.000\nsend G0 X0 Y0 Z0 A0\nexpect ok\nwait-ms 400\nbytes 18\nexpect Grbl\n\
                  bytes 3f\nexpect <Idle\ncheck-position\n";
    for run in carried_out("hold", script) {
        assert!(run.steps().iter().all(|&steps| steps > 500), "{:?}", run.steps());
    }
}

/// A move of four axes ends for all at once, however different their lengths are, and an arc carries A along.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn an_arc_carries_a_along_evenly() {
    for run in carried_out("arc", "send G2 X20 I10 A36 F1200\nexpect ok\nwait-idle\ncheck-position\n") {
        assert_eq!(run.steps()[3], 1_800);
        let (first, last) = (run.edges[0].t_ns, run.edges.last().unwrap().t_ns);
        let of_a = |share: usize| run.edges.iter().filter(|edge| edge.axis == 3).nth(18 * share).unwrap().t_ns;
        let half = (of_a(50) - first) as f64 / (last - first) as f64;
        assert!((half - 0.5).abs() < 0.01, "{half}");
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_second_motor_is_refused_where_a_has_its_pins() {
    carried_out(
        "second",
        "send $905=2\nexpect error:2\nexpect [MSG:this firmware has no outputs\nsend $905=0\nexpect ok\n",
    );
}
