//! A simulated machine homes and moves. Then somebody presses a limit switch in the middle of a move.
//!
//! Run it with `cargo run -p isostep-sim --example 1_machine_with_a_fault`.

use isostep_motion::{Alarm, Axis};
use isostep_sim::faults::Trouble;
use isostep_sim::{Config, Fault, RunError, Sim, State};

const NS_PER_S: u64 = 1_000_000_000;

/// Prints what the machine answers, and where it stopped.
pub fn main() -> Result<(), RunError> {
    let mut sim = Sim::new(&Config::default());
    // A limit switch stops a move only with hard limits on.
    say(&mut sim, "$21=1")?;
    say(&mut sim, "$H")?;
    // The move takes minutes. The switch is pressed in it, for a fifth of a second.
    let (at_ns, lasts_ns) = (sim.now_ns() + 5 * NS_PER_S, Some(NS_PER_S / 5));
    sim.suffer(Fault { trouble: Trouble::Limit(Axis::X.into()), at_ns, lasts_ns });
    say(&mut sim, "G1 X340 F60")?;

    let position_steps = sim.machine().position_steps();
    println!("the machine is in state {:?}, {} steps from its zero", sim.machine().state(), position_steps[0]);
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::HardLimit { motor: Axis::X.into() }));
    // The position is the count of the edges that left, whatever came in between.
    assert_eq!(position_steps, sim.counted_steps());
    assert!((200..=250).contains(&position_steps[0]), "5 s at 1 mm/s and 50 steps/mm");
    Ok(())
}

/// Sends a line, runs until the machine is at rest, and prints what it answers.
fn say(sim: &mut Sim, line: &str) -> Result<(), RunError> {
    println!("> {line}");
    sim.send(format!("{line}\n").as_bytes());
    sim.run_until_idle()?;
    sim.replies().iter().for_each(|reply| println!("{reply}"));
    Ok(())
}
