//! A Pico 2 of four axes has a fifth motor, the second one of an axis. `tests/dialogues/squared.txt` has what else there is about it.

use std::fs;

use isostep_motion::DriverTiming;
use isostep_report::compare;
use isostep_sim::drive::MotorData;
use isostep_sim::{Config, run};
use isostep_tests::emulated::{self, Board};
use isostep_tests::root;

/// Four axes and the second motor of one, each at 2,000,000 steps/s: every step of every axis stands where the plan has it, and the second
/// motor makes its own on the same cycles.
#[test]
#[ignore = "needs the firmware of a Pico 2: cargo xtask test --all"]
fn five_motors_make_2_000_000_steps_a_second() {
    const STEPS: usize = 180_000;
    let folder = root().join("target/emulated/five-motors");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("program.nc");
    let of_axes =
        |number: u32, value: u32| (0..4).map(move |axis| format!("${}={value}\n", number + axis)).collect::<String>();
    // 200 mm/s in 80 ms.
    let settings = "$0=0\n".to_owned()
        + &of_axes(100, 10_000)
        + &of_axes(110, 12_000)
        + &of_axes(120, 2_500)
        + "$133=1000\n$376=0\n$905=2\n";
    fs::write(&path, settings + "G91 G0 X18 Y18 Z18 A18\n").unwrap();
    let board = Board::of_firmware("ISOSTEP_TMC2209_ELF", "five-motors").with(&["--driver=tmc2209", "--second=Y,0"]);
    let emulated = board.program(&path);
    assert!(emulated.ok, "{}", emulated.printed);
    assert_eq!(emulated.figures["driver_timing"]["violations"], 0, "{}", emulated.printed);
    let config = Config { driver: DriverTiming::TMC2209, motor: MotorData::RIGID, ..emulated::config() };
    let compared = compare::compare(&run(&fs::read(&path).unwrap(), &config).unwrap(), &emulated.edges).unwrap();
    assert!(compared.all.steps == 4 * STEPS && compared.all.max_ns <= 50.0, "{compared:#?}");
    assert_eq!(emulated.figures["second"]["steps_together"], STEPS, "{}", emulated.printed);
    assert_eq!(emulated.figures["second"]["steps_alone"], 0, "{}", emulated.printed);
    for axis in ["X", "Y", "Z", "A"] {
        let highest = emulated.figures["axes"][axis]["highest_rate_steps_per_s"].as_f64().unwrap();
        assert!((highest - 2e6).abs() < 0.02 * 2e6, "{axis}: {highest} steps/s");
    }
    println!("five motors at 2,000,000 steps/s: every edge within {:.1} ns", compared.all.max_ns);
}
