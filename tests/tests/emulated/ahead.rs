//! Lines that wait on the emulated board, and real-time bytes behind them, on both cables.

use std::fmt::Write as _;

use isostep_sim::Port;
use isostep_tests::emulated::Board;

/// More than 512 bytes of lines behind M0, at once: a report, the resume and a reset are heard.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn real_time_bytes_are_heard_behind_more_lines_than_a_console_keeps() {
    for cable in ["usb", "uart"] {
        let mut script = "expect Grbl\nsend M0\nwait-ms 50\n".to_owned();
        for _ in 0..100 {
            writeln!(script, "send G91 G1 X0.1 F3000").unwrap();
        }
        script += "wait-ms 500\nbytes 3f\nexpect <Hold:0|MPos:0.000\n";
        // 512 bytes are 28 lines of 18 bytes, and the beginning of another.
        script += "bytes 7e\n";
        script += &"expect ok\n".repeat(29);
        script += &"expect [MSG:This line is lost\nexpect error:11\n".repeat(72);
        script += "wait-idle\nbytes 3f\nexpect <Idle|MPos:2.800,\n";
        script +=
            "bytes 18\nexpect Grbl\nsend G91 G1 X1 F3000\nexpect ok\nwait-idle\nbytes 3f\nexpect <Idle|MPos:3.800,\n";
        let run = Board::stepped_by(Port::Pio, "ahead").with(&["--console", cable]).script(&script);
        assert!(run.ok, "{cable}: {}", run.printed);
    }
}
