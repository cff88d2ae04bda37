//! The ways into the boot loader: the machine must be at rest, settings must be stored, and new firmware must start
//! normally.

use isostep_sim::Port;
use isostep_tests::emulated::{Board, Run};

/// What a flashing tool does to start the boot loader: the 1200-baud touch.
const TOUCH: &str = "usb-line-coding 1200\ndtr off\n";
/// How long before the restart the motors must have been still.
const REST_NS: u64 = 240_000_000;

/// When the boot loader took over, ns.
fn left_ns(run: &Run) -> u64 {
    let line = run.printed.lines().find_map(|line| line.strip_prefix("BOOTSEL      from ")).expect("a line on BOOTSEL");
    (line.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e9) as u64
}

/// A touch in the middle of a move of three axes must stop them with whole pulses, free the motors, and enter the boot
/// loader.
fn a_touch_stops_the_move(port: Port, test: &str) {
    let run = Board::stepped_by(port, test).script(&format!(
        "expect Grbl\nsend G0 X50 Y50 Z50\nexpect ok\nwait-ms 700\nmotors on\n{TOUCH}expect-bootsel\nmotors off\n"
    ));
    assert!(run.ok, "{}", run.printed);
    let steps = [0, 1, 2].map(|axis| run.edges.iter().filter(|edge| edge.axis == axis).count());
    assert!(steps.iter().all(|steps| (300..1_500).contains(steps)), "{steps:?}");
    let last_ns = run.edges.last().unwrap().t_ns;
    assert!(left_ns(&run) - last_ns > REST_NS, "stepping until {last_ns} ns: {}", run.printed);
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_touch_in_mid_move_stops_it_and_leads_to_the_boot_loader() {
    a_touch_stops_the_move(Port::Pio, "touch");
}

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_touch_by_the_timer_port_stops_the_move_and_leads_to_the_boot_loader() {
    a_touch_stops_the_move(Port::Timer, "touch-timer");
}

/// Spindle, laser and coolant must be off before the boot loader takes over.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_touch_puts_the_tool_off() {
    let run = Board::new("touch-tool").script(&format!(
        "expect Grbl\nsend $32=1\nexpect ok\nsend M3S800M8G91G1F600X40\nexpect ok\nwait-output pwm on\nwait-ms 100\n\
         {TOUCH}expect-bootsel\n"
    ));
    assert!(run.ok, "{}", run.printed);
    for output in ["pwm", "enable", "flood"] {
        let last = run.outputs.iter().rfind(|change| change.output == output).expect("it was on");
        assert_eq!(last.value, 0.0, "{output}");
        assert!((last.t_ns as u64) < left_ns(&run) - REST_NS, "{output}: {last:?}");
    }
}

/// The rate alone is not a touch, and a closed port alone is not either. Both together are, in either order.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn only_1200_baud_with_dtr_down_is_a_touch() {
    let run = Board::new("touch-only").script(
        "expect Grbl\nsend G0 X10\nexpect ok\nusb-line-coding 1200\nwait-ms 400\nusb-line-coding 9600\ndtr off\n\
         wait-ms 400\ndtr on\nexpect Grbl\nwait-idle\nbytes 3f\nexpect <Idle|MPos:10.000,0.000,0.000\n\
         dtr off\nwait-ms 400\nusb-line-coding 1200\nexpect-bootsel\nmotors off\n",
    );
    assert!(run.ok, "{}", run.printed);
    assert_eq!(run.edges.len(), 500);
}

/// The touch must work in every state: asleep, in alarm, with inverted ENABLE, in a pause of the program. A flashing
/// tool does not know the state.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_touch_works_in_every_state() {
    let states = [
        "send $SLP\nexpect ok\n",
        "estop pressed\nexpect ALARM:10\n",
        "send G0 X5\nexpect ok\nsend M0\nwait-ms 1500\nbytes 3f\nexpect <Hold:0\n",
        "send $H\nwait-ms 300\nbytes 3f\nexpect <Home\n",
        "send G4 P100\nwait-ms 300\n",
        "send $4=1\nexpect ok\n",
    ];
    for (index, state) in states.into_iter().enumerate() {
        // The drivers of this gantry are enabled by a low ENABLE. If it is inverted, the script's "on" means off.
        let freed = if state.contains("$4") { "on" } else { "off" };
        let run = Board::new(&format!("touch-state-{index}"))
            .script(&format!("expect Grbl\n{state}{TOUCH}expect-bootsel\nmotors {freed}\n"));
        assert!(run.ok, "{state}: {}", run.printed);
    }
}

/// An offset is stored when its move has ended. It must also be stored when a touch has ended that move.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn a_touch_loses_no_setting() {
    let run = Board::new("touch-store").script(&format!(
        "expect Grbl\nsend G0 X50\nexpect ok\nsend G10 L2 P2 X5\nwait-ms 500\n{TOUCH}expect-bootsel\nmotors off\n\
         leave-bootsel\nexpect Grbl\nsend $#\nexpect [G55:5.000\nexpect ok\n"
    ));
    assert!(run.ok, "{}", run.printed);
}

/// `$BOOT` is refused in motion. At rest its answer must be complete before the board leaves, on either console. New
/// firmware must not report a watchdog restart, although the boot loader uses the watchdog to restart the chip.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn boot_answers_and_leads_to_the_boot_loader() {
    for console in ["usb", "uart"] {
        let run = Board::new(&format!("boot-{console}")).with(&["--console", console]).script(
            "expect Grbl\nsend $110=1234\nexpect ok\nsend G0 X5\nexpect ok\nsend $BOOT\nexpect error:8\nwait-idle\nmotors on\n\
             send $BOOT\nexpect [MSG:The board becomes the USB drive RPI-RP2\nexpect ok\nsend G0 X1\nexpect error:8\nexpect-bootsel\nmotors off\n\
             leave-bootsel\nexpect Grbl\nsend $$\nexpect $110=1234.000\nexpect ok\n",
        );
        assert!(run.ok, "{}", run.printed);
        assert!(!run.printed.contains("Restarted"), "{}", run.printed);
        assert_eq!(run.edges.len(), 250, "no line is taken after it");
    }
}
