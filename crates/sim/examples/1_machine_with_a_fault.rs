//! A simulated machine homes and moves. Then somebody presses a limit switch in the middle of a move.
//!
//! Run it with `cargo run -p isostep-sim --example 1_machine_with_a_fault`.

use isostep_sim::{Config, Fault, RunError, Sim};

/// Half a second after the long move has begun, for a fifth of a second.
const TROUBLE: &str = "limit:X@30+0.2";

/// Prints what the machine answers, and where it stopped.
pub fn main() -> Result<(), RunError> {
    let fault: Fault = TROUBLE.parse().expect("this is how a fault is written");
    let mut sim = Sim::new(&Config { faults: vec![fault], ..Config::default() });
    for line in ["$H", "G1 X340 F60"] {
        println!("> {line}");
        sim.send(format!("{line}\n").as_bytes());
        sim.run_until_idle()?;
        sim.replies().iter().for_each(|reply| println!("{reply}"));
    }
    let told = sim.machine().position_steps();
    println!("the machine is in state {:?}, {} steps from its zero", sim.machine().state(), told[0]);
    // The position is the count of the edges that left, whatever came in between.
    assert_eq!(told, sim.counted_steps());
    Ok(())
}
