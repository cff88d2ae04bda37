//! A stop may come like an interrupt, between any two critical sections of a task. It must never be lost. In virtual
//! time, each stop is tried at the end of every critical section while something happens.

use embassy_time::Duration;
use isostep_motion::{Alarm, Axis, Finish, State};
use isostep_sim::swarm::judge;
use isostep_sim::{Came, Config, Outcome, Port, Sim, Stimulus, SwitchFault};
use isostep_trials::stride;

/// The time after its stop at which a step may still come, ns. Where a task makes the steps, the pulse under way is finished.
const REACTION_NS: u64 = 10_000;

/// A sweep of stops over what happens to a machine.
struct Sweep {
    name: &'static str,
    /// The text sent before, and the time that passes then, us.
    before: (&'static str, u64),
    /// Texts sent one after the other, and the time that passes after each, us. Stops are tried during these.
    during: &'static [(&'static str, u64)],
}

const SWEEPS: [Sweep; 7] = [
    Sweep { name: "a move begins", before: ("", 10_000), during: &[("G1 X5 Y3 F1200\n", 30_000)] },
    Sweep { name: "moves flow", before: ("G1 X5 F1200\nY2\nX0\nY0\n", 200_000), during: &[("X5\nY2\n", 40_000)] },
    Sweep { name: "a hold", before: ("G1 X5 F1200\nY2\n", 100_000), during: &[("!", 120_000)] },
    Sweep { name: "a resume", before: ("G1 X5 F1200\nY2\n!", 600_000), during: &[("~", 40_000)] },
    Sweep { name: "an override", before: ("G1 X5 F1200\nY2\n", 100_000), during: &[("\u{91}\u{91}", 80_000)] },
    Sweep { name: "a jog", before: ("", 10_000), during: &[("$J=X5 F1200\n", 30_000), ("\u{85}", 60_000)] },
    Sweep { name: "a dwell ends", before: ("G4 P0.05\nG1 X5 F1200\n", 40_000), during: &[("", 40_000)] },
];

/// A case for the emergency stop alone: nothing moves in it, and with any other stop the second reset stays the cause.
const TWO_RESETS: Sweep =
    Sweep { name: "a dwell is reset twice", before: ("G4 P1\n", 40_000), during: &[("\u{18}\u{18}", 20_000)] };

/// A machine that is ready for `sweep`.
fn ready(sweep: &Sweep, port: Port) -> Sim {
    let mut config = Config { port, section_max_ns: Some(0), bounce_us: 0, keep_waves: false, ..Config::default() };
    (config.settings.hard_limits, config.settings.drive_alarm_mask) = (true, 1 << Axis::Z as u16);
    let mut sim = Sim::new(&config);
    send(&mut sim, sweep.before.0);
    sim.run_for(Duration::from_micros(sweep.before.1)).unwrap();
    sim
}

/// Sends text as Latin-1.
fn send(sim: &mut Sim, text: &str) {
    sim.send(&text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect::<Vec<_>>());
}

fn happen(sim: &mut Sim, sweep: &Sweep) {
    for (text, us) in sweep.during {
        send(sim, text);
        sim.run_for(Duration::from_micros(*us)).unwrap();
    }
}

/// Stops the machine when `section` more critical sections have ended. Returns the machine at rest and when the stop
/// came.
fn stopped(sweep: &Sweep, port: Port, section: u64, stop: &Stimulus) -> (Sim, Came) {
    let mut sim = ready(sweep, port);
    let came = sim.after_sections(section, stop.clone());
    happen(&mut sim, sweep);
    sim.run_until_idle().unwrap();
    (sim, came.get().expect("as many sections end as did without it"))
}

/// Tries a stop at every critical section of the sweep. Returns how many there are.
fn swept(
    sweep: &Sweep,
    port: Port,
    stop: &Stimulus,
    check: &mut dyn FnMut(&Outcome, Came) -> Result<(), String>,
) -> u64 {
    let mut sim = ready(sweep, port);
    let first = sim.sections();
    happen(&mut sim, sweep);
    let sections = sim.sections() - first;
    for section in (1..=sections).step_by(stride(3)) {
        let (sim, came) = stopped(sweep, port, section, stop);
        let outcome = sim.outcome();
        let steps = judge::steps(&outcome).map_err(|(promise, found)| format!("{promise}: {found}"));
        if let Err(error) = steps.and_then(|()| check(&outcome, came)) {
            panic!("{stop:?} at the end of section {section} of {sections} while {} ({port}): {error}", sweep.name);
        }
    }
    sections
}

/// Checks that no step comes after the pulse under way.
fn stands_still(outcome: &Outcome, came: Came) -> Result<(), String> {
    let late = outcome.edges.iter().find(|edge| edge.t_ns > came.at_ns + REACTION_NS);
    late.map_or(Ok(()), |edge| Err(format!("it was stopped at {} ns, and {edge:?}", came.at_ns)))
}

fn all(stop: Stimulus, check: fn(&Outcome, Came) -> Result<(), String>) {
    over(&SWEEPS, stop, check);
}

fn over(sweeps: &[Sweep], stop: Stimulus, check: fn(&Outcome, Came) -> Result<(), String>) {
    let swept = sweeps.iter().flat_map(|sweep| Port::ALL.map(|port| swept(sweep, port, &stop, &mut { check })));
    println!("{stop:?} came at the end of {} critical sections", swept.sum::<u64>());
}

fn is_locked(outcome: &Outcome, came: Came) -> Result<(), String> {
    is_locked_with(Alarm::EmergencyStop, outcome, came)
}

fn is_locked_with(alarm: Alarm, outcome: &Outcome, came: Came) -> Result<(), String> {
    stands_still(outcome, came)?;
    if !came.inhibits {
        return Err("an interrupt would not have inhibited for it".into());
    }
    if outcome.state == State::Alarm(alarm) { Ok(()) } else { Err(format!("the machine is in {:?}", outcome.state)) }
}

#[test]
fn no_emergency_stop_is_lost() {
    all(Stimulus::EmergencyStop, is_locked);
    over(&[TWO_RESETS], Stimulus::EmergencyStop, is_locked);
}

/// Also at rest and while it homes.
#[test]
fn no_alarm_of_a_drive_is_lost() {
    const HOMING: Sweep = Sweep { name: "it homes", before: ("", 10_000), during: &[("$H\n", 40_000)] };
    let check = |outcome: &Outcome, came| is_locked_with(Alarm::DriverFailed { motor: Axis::Z.into() }, outcome, came);
    all(Stimulus::Drive(Axis::Z), check);
    over(&[TWO_RESETS, HOMING], Stimulus::Drive(Axis::Z), check);
}

const Z_CLOSES: Stimulus = Stimulus::Switch(Axis::Z, SwitchFault::StuckClosed);

/// A switch stops what is under way, and nothing else. A board inhibits for it before that is decided, and must be right: an
/// inhibit without a stop would hold the axes for ever.
fn stops_as_inhibited(outcome: &Outcome, came: Came) -> Result<(), String> {
    let is_stopped = outcome.state == State::Alarm(Alarm::HardLimit { motor: Axis::Z.into() });
    if came.inhibits != is_stopped {
        return Err(format!(
            "inhibited: {}, in {:?}, and the machine is in {:?}",
            came.inhibits, came.state, outcome.state
        ));
    }
    if is_stopped { stands_still(outcome, came) } else { Ok(()) }
}

#[test]
fn no_limit_switch_is_lost() {
    all(Z_CLOSES, |outcome, came| {
        let is_due = came.state != State::Idle;
        if is_due == came.inhibits {
            stops_as_inhibited(outcome, came)
        } else {
            Err(format!("inhibited in {:?}", came.state))
        }
    });
}

/// Homing looks for the switch: from its first critical section to its last a press is none, and before and after it is.
#[test]
fn a_switch_that_closes_as_homing_begins_or_ends_stops_only_what_is_not_homing() {
    let begins =
        Sweep { name: "homing begins after a move", before: ("G1 X1 F1200\n", 30_000), during: &[("$HZ\n", 150_000)] };
    let mut sim = ready(&Sweep { before: ("", 10_000), ..begins }, Port::Pio);
    let begun_ns = sim.now_ns();
    send(&mut sim, "$HZ\n");
    sim.run_until_idle().unwrap();
    let homed_us = (sim.now_ns() - begun_ns) / 1_000;
    let ends = Sweep {
        name: "homing ends before a move",
        before: ("$HZ\n", homed_us - 80_000),
        during: &[("G1 X1 F1200\n", 30_000)],
    };
    let mut seen = [0; 2];
    for sweep in [&begins, &ends] {
        swept(sweep, Port::Pio, &Z_CLOSES, &mut |outcome, came| {
            seen[usize::from(came.inhibits)] += 1;
            let is_due = matches!(came.state, State::Run);
            if is_due == came.inhibits {
                stops_as_inhibited(outcome, came)
            } else {
                Err(format!("inhibited in {:?}", came.state))
            }
        });
    }
    assert!(seen.iter().all(|&times| times >= 20), "{seen:?}");
}

/// The first reset brakes on the path. Then the machine must be ready.
#[test]
fn no_reset_is_lost() {
    all(Stimulus::Bytes(vec![0x18]), |outcome, _| match outcome.state {
        State::Idle if outcome.losses.is_empty() => Ok(()),
        state => Err(format!("the machine is in {state:?}, and lost {:?}", outcome.losses)),
    });
}

/// The second reset stops at once, unless the machine stands still by then.
#[test]
fn no_second_reset_is_lost() {
    all(Stimulus::Bytes(vec![0x18, 0x18]), |outcome, came| {
        stands_still(outcome, came)?;
        match outcome.state {
            State::Alarm(Alarm::ResetInMotion) | State::Idle => Ok(()),
            state => Err(format!("the machine is in {state:?}")),
        }
    });
}

/// A stop may find axes armed for a run that never starts, or segments that are never made. None of that is to show in
/// the next run.
#[test]
fn the_move_after_a_stop_is_as_planned() {
    for port in Port::ALL {
        let sweep = &SWEEPS[0];
        let mut sim = ready(sweep, port);
        let first = sim.sections();
        happen(&mut sim, sweep);
        for section in 1..=sim.sections() - first {
            let (mut sim, _) = stopped(sweep, port, section, &Stimulus::EmergencyStop);
            sim.set_emergency_stop(false);
            sim.run_for(Duration::from_millis(100)).unwrap();
            let before = sim.outcome().moves.len();
            send(&mut sim, "$X\nG91 G1 X3 Y2 Z1 F1200\n");
            sim.run_until_idle().unwrap();
            let outcome = sim.outcome();
            assert_eq!(judge::steps(&outcome), Ok(()), "section {section} ({port})");
            let finishes: Vec<_> = outcome.moves[before..].iter().map(|record| record.finish).collect();
            assert_eq!(finishes, [Finish::Done], "section {section} ({port})");
        }
    }
}
