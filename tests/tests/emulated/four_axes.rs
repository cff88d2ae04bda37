//! The fourth axis on the emulated board, with each port: its pins, its switch, and what it shares them with.

use isostep_sim::Port;
use isostep_tests::emulated::Board;

fn board(test: &str, port: Port) -> Board {
    Board::stepped_by(port, &format!("four-axes-{test}-{port}"))
}

/// A homes to the switch on its own pin, and turns past it without an end. With an end the same switch stops all axes.
#[test]
#[ignore = "needs the firmware: cargo xtask test --all"]
fn a_homes_turns_and_stops_at_its_switch() {
    for port in Port::ALL {
        let mut script =
            "expect Grbl\nsend $901=3124\nexpect ok\nsend $HA\nexpect ok\nbytes 3f\nexpect <Idle\n".to_owned();
        script +=
            "switch A stuck-closed\nwait-ms 20\nbytes 3f\nexpect <Idle|MPos:0.000,0.000,0.000,0.000|FS:0,0|Pn:A\n";
        script += "send G0 A20 X3\nexpect ok\nwait-idle\nsend G0 A0 X0\nexpect ok\nwait-idle\ncheck-position\n";
        script += "switch A normal\nwait-ms 20\nsend $133=180\nexpect ok\nsend G0 A90 X20\nexpect ok\nwait-ms 500\n";
        script += "switch A stuck-closed\nexpect ALARM:1\nexpect [MSG:A\nstop-within 100\nwait-ms 300\ncheck-stopped\n";
        let run = board("homes", port).script(&script);
        assert!(run.ok, "{port}: {}", run.printed);
        assert_eq!(run.figures["driver_timing"]["violations"], 0, "{port}: {}", run.printed);
    }
}

/// All four motors start on one cycle, and make as many steps as they are asked for.
#[test]
#[ignore = "needs the firmware: cargo xtask test --all"]
fn four_axes_start_on_the_same_cycle() {
    let run =
        board("start", Port::Pio).script("expect Grbl\nsend G0 X8 Y8 Z8 A8\nexpect ok\nwait-idle\ncheck-position\n");
    assert!(run.ok, "{}", run.printed);
    let of_axis = |axis: usize| run.edges.iter().filter(move |edge| edge.axis == axis).map(|edge| edge.t_ns);
    let x: Vec<_> = of_axis(0).collect();
    assert_eq!(x.len(), 400);
    for axis in 1..4 {
        assert!(of_axis(axis).eq(x.iter().copied()), "axis {axis}");
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test --all"]
fn a_second_motor_is_refused_where_a_has_its_pins() {
    let run = board("second", Port::Pio).script(
        "expect Grbl\nsend $905=2\nexpect error:2\nexpect [MSG:this firmware has no outputs\nsend $905=0\nexpect ok\n",
    );
    assert!(run.ok, "{}", run.printed);
}
