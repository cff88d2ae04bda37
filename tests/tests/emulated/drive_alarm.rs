//! The alarm of all drives on one wire: it stops the axes and the tool as soon as a limit switch does.

use isostep_sim::{AXES, Port};
use isostep_tests::emulated::Board;
use isostep_trials::cases;
use oorandom::Rand32;

/// Three axes at 240,000 steps/s, with the tool on. The contact closes at random instants, for good or for a microsecond.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn an_alarm_stops_as_soon_as_a_switch() {
    let mut random = Rand32::new(9);
    let mut script = "expect Grbl\nsend $0=0\nexpect ok\nsend $745=1\nexpect ok\nsend $744=1\nexpect ok\n".to_owned();
    for axis in 0..AXES as u32 {
        let settings = [(110, 288_000), (120, 100_000)];
        script.extend(settings.map(|(number, value)| format!("send ${}={value}\nexpect ok\n", number + axis)));
    }
    let count = cases(12, 60) as usize;
    for index in 0..count {
        let target_mm = if index % 2 == 0 { 900 } else { 0 };
        let lasts = if index % 4 < 2 { "wait-ms 20" } else { "wait-us 1" };
        script += &format!("send M3S500M8\nexpect ok\nsend G0X{target_mm}Y{target_mm}Z{target_mm}\nexpect ok\n");
        script += &format!("wait-us {}.3\nalarm pressed\n{lasts}\n", random.rand_range(60_000..80_000));
        script += "alarm released\nexpect ALARM:17\nwait-ms 20\nsend $X\nexpect ok\ncheck-position\n";
    }
    // A carriage that moves beyond its switch presses it. So the carriages start far from their switches.
    let run = Board::stepped_by(Port::Pio, "drive-alarm").with(&["--start", "900,900,900"]).script(&script);
    assert!(run.ok, "{}", run.printed);
    let stops = run.figures["stops"].as_array().unwrap();
    assert_eq!(stops.len(), count);
    for stop in stops {
        let [latency_ns, off_ns] = ["latency_ns", "outputs_off_ns"].map(|name| stop[name].as_f64().expect(name));
        assert!(latency_ns <= 1_500.0 && off_ns <= 2_500.0, "{stop}");
    }
}
