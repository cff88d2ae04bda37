//! The edges of the fourth axis on the emulated board; `tests/dialogues/four_axes.txt` has what else there is about it. With each port
//! where everything is compiled for four axes.

use isostep_sim::{AXES, Port};
use isostep_tests::emulated::{Board, Run};

const PORTS: &[Port] = if AXES == 4 { &Port::ALL } else { &[Port::Pio] };

fn carried_out(test: &str, script: &str) -> Vec<Run> {
    let run = |&port| {
        let board = Board::of_four_axes(port, &format!("four-axes-{test}-{port}"));
        let run = board.script(&format!("expect Grbl\n{script}"));
        assert!(run.ok, "{port}: {}", run.printed);
        run
    };
    PORTS.iter().map(run).collect()
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
