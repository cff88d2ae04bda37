//! Inputs that stop the machine, on boards whose pins are others than those of a Pico with three axes.

use std::fmt::Write as _;

use isostep_tests::emulated::Board;

/// An input that stops the machine: its name in the emulator's figures, how it is pressed, what is reported, and how it is
/// released.
pub type Stop = (&'static str, &'static str, &'static str, &'static str);

pub const X: Stop = ("X_LIMIT", "switch X stuck-closed", "ALARM:1\nexpect [MSG:X limit switch", "switch X normal");
pub const Y: Stop = ("Y_LIMIT", "switch Y stuck-closed", "ALARM:1\nexpect [MSG:Y limit switch", "switch Y normal");
pub const Z: Stop = ("Z_LIMIT", "switch Z stuck-closed", "ALARM:1\nexpect [MSG:Z limit switch", "switch Z normal");
pub const ESTOP: Stop = ("ESTOP", "estop pressed", "ALARM:10", "estop released");

/// Each of these inputs stops all axes within 10 us in a move of all at 40,000 steps/s, with outputs off, and the count is
/// that of the edges.
pub fn each_stops_all_axes(board: Board, axes: &str, stops: &[Stop]) {
    let mut script = "expect Grbl\nsend $0=0\nexpect ok\nsend $133=1000\nwait-reply\n".to_owned();
    for number in 0..axes.len() {
        let settings = [(110, 48_000), (120, 20_000)];
        script.extend(settings.map(|(first, value)| format!("send ${}={value}\nexpect ok\n", first + number)));
    }
    for (index, (_, press, reported, release)) in stops.iter().enumerate() {
        let target = if index % 2 == 0 { 400 } else { 0 };
        let words: String = axes.chars().map(|axis| format!("{axis}{target}")).collect();
        write!(script, "send M3S500M8\nexpect ok\nsend G0{words}\nexpect ok\nwait-us {}.3\n", 150_000 + 997 * index)
            .unwrap();
        write!(script, "{press}\nexpect {reported}\n{release}\nwait-ms 20\nsend $X\nexpect ok\ncheck-position\n")
            .unwrap();
    }
    // A carriage that moves beyond its switch presses it. So the carriages start far from their switches.
    let start = vec!["500"; axes.len()].join(",");
    let run = board.with(&["--start", &start]).script(&script);
    assert!(run.ok, "{}", run.printed);
    assert_eq!(run.figures["driver_timing"]["violations"], 0, "{}", run.printed);
    assert!(run.steps()[..axes.len()].iter().all(|&steps| steps > 5_000), "{:?}", run.steps());
    let reported = run.figures["stops"].as_array().unwrap();
    let names: Vec<_> = reported.iter().map(|stop| stop["input"].as_str().unwrap()).collect();
    assert_eq!(names, stops.iter().map(|stop| stop.0).collect::<Vec<_>>());
    for stop in reported {
        let [latency_ns, off_ns] = ["latency_ns", "outputs_off_ns"].map(|name| stop[name].as_f64().expect(name));
        assert!(latency_ns <= 10_000.0 && off_ns <= 20_000.0, "{stop}");
    }
}
