//! Every life that can be reached is tried, and the table in `docs/states.md` is compared with what happens.

extern crate std;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::format;
use std::string::String;
use std::vec::Vec;

use super::*;
use crate::axes::Axis;
use crate::event::SpindleFault;

/// The number of motions that are pending at most: one under way, and others that wait.
const MOTIONS: usize = 3;
const AXIS: Axis = Axis::X;
const JUDGED: Alarm = Alarm::LateStep { axis: AXIS };
const HARMLESS: Alarm = Alarm::ProbeContact;

/// The events that may happen to a machine in this life. The tasks of this crate keep to it: a run belongs to a motion, and a
/// motion ends only after its run.
fn triggers(life: &Life) -> Vec<Trigger> {
    let mut all = std::vec![
        Trigger::OutputAsked,
        Trigger::Hold,
        Trigger::Resume,
        Trigger::GoesOn,
        Trigger::CancelJog,
        Trigger::OpenDoor,
        Trigger::Door(!life.door.is_open),
        Trigger::ResetHeard,
        Trigger::Reset,
        Trigger::Limit(Motor::first(AXIS)),
        Trigger::EmergencyStop(!life.emergency),
        Trigger::ToolCutOff,
        Trigger::SpindleFailed(SpindleFault::Drive),
        Trigger::DriverFailed(Motor::first(AXIS)),
        Trigger::Stalled(Motor::first(AXIS)),
        Trigger::TakenOver,
        Trigger::OutputsCut,
        Trigger::Unlock,
    ];
    if life.pending < MOTIONS {
        all.extend([Kind::Program, Kind::Jog, Kind::Homing].map(Trigger::Asked));
    }
    let is_under_way = life.pending > 0 && !life.is_locked();
    if life.moving {
        all.extend([Trigger::Moving(false), Trigger::Fault(JUDGED)]);
    } else if is_under_way {
        all.push(Trigger::Moving(true));
        let alarm = life.cause.map_or(JUDGED, |cause| cause.alarm(life.state));
        for motions in 1..=life.pending {
            all.extend([Ok(()), Err(alarm), Err(HARMLESS)].map(|result| Trigger::Ended(result, motions)));
        }
        if matches!(life.state, State::Run | State::Home | State::Hold { .. }) {
            all.push(Trigger::Homing);
        }
    }
    // The motion that moves is not one that was given up.
    if life.pending > usize::from(life.moving) {
        all.push(Trigger::PassedOver);
    }
    if life.state == State::Idle {
        all.push(Trigger::Raise(HARMLESS));
    }
    all
}

fn after(life: &Life, triggers: impl IntoIterator<Item = Trigger>) -> Life {
    let mut life = *life;
    for trigger in triggers {
        life.on(trigger);
        // Only whether there was a reset matters, not how many.
        life.resets = 0;
    }
    life
}

/// Every life that can be reached, each with the shortest way to it.
fn reached() -> BTreeMap<String, (Life, Vec<Trigger>)> {
    let mut found = BTreeMap::from([(format!("{:?}", Life::new()), (Life::new(), Vec::new()))]);
    let mut last: Vec<(Life, Vec<Trigger>)> = found.values().cloned().collect();
    while !last.is_empty() {
        let mut next = Vec::new();
        for (life, way) in &last {
            for trigger in triggers(life) {
                let to = after(life, [trigger]);
                found.entry(format!("{to:?}")).or_insert_with(|| {
                    next.push((to, [&way[..], &[trigger]].concat()));
                    next[next.len() - 1].clone()
                });
            }
        }
        last = next;
    }
    found
}

/// Calls `check` for every life that can be reached; a failure names the way to it.
fn for_all(check: impl Fn(&Life) -> Result<(), String>) {
    let reached = reached();
    // docs/states.md names the number.
    assert_eq!(reached.len(), 11412, "lives that can be reached");
    for (life, way) in reached.values() {
        if let Err(why) = check(life) {
            panic!("{why}: {life:?}\nafter {way:?}");
        }
    }
}

fn holds(condition: bool, why: &str) -> Result<(), String> {
    if condition { Ok(()) } else { Err(why.into()) }
}

#[test]
fn a_state_says_what_is_true() {
    for_all(|life| {
        let Life { pending, moving, held, cause, .. } = *life;
        match life.state {
            State::Idle => holds(pending == 0 && !held, "idle, and a motion waits or is held"),
            State::Run | State::Jog | State::Home => holds(pending > 0, "busy without a motion"),
            State::Hold { still: true } => holds(held && !moving, "a hold that is none, or moves"),
            State::Hold { still: false } => holds(pending > 0, "braking without a motion"),
            State::Alarm(_) => holds(cause.is_none() && !moving && !held, "locked, and not at rest"),
        }?;
        holds(!moving || pending > 0, "a run without a motion")
    });
}

#[test]
fn what_concerned_the_motions_is_forgotten_with_the_last_of_them() {
    for_all(|life| {
        let is_forgotten = life.cause.is_none() && life.forget == Forget::Nothing && !life.reset_heard;
        holds(life.pending > 0 || is_forgotten, "nothing is pending, but something concerns it")
    });
}

#[test]
fn a_pressed_emergency_stop_lets_nothing_begin() {
    for_all(|life| {
        let is_stopped = life.is_locked() || life.cause.is_some();
        holds(!life.emergency || is_stopped, "the emergency stop is pressed, and the machine is not stopped")
    });
}

/// A reset brakes like a hold, but a hold that comes meanwhile must not keep the machine from being ready after it.
#[test]
fn a_hold_does_not_change_a_reset() {
    let way = [Trigger::Asked(Kind::Program), Trigger::Moving(true), Trigger::Reset];
    let life = after(&Life::new(), way);
    assert_eq!((life.state, life.held), (State::Hold { still: false }, false));
    assert_eq!(after(&life, [Trigger::Hold]), life);
}

#[test]
fn no_stop_is_lost() {
    for_all(|life| match life.cause {
        Some(cause) if cause != Cause::Reset && !life.moving => {
            let ended = after(life, [Trigger::Ended(Ok(()), 1)]);
            holds(ended.is_locked(), "a motion was stopped and has ended, and the machine is not locked")
        }
        _ => Ok(()),
    });
}

#[test]
fn a_stop_halts_what_moves() {
    for_all(|life| {
        let is_halted = |trigger| {
            let mut next = *life;
            next.on(trigger) == Reaction::Halt && next.cause.is_some()
        };
        // Homing is to press limit switches, and to stall motors.
        let ends = [Trigger::Limit(Motor::first(AXIS)), Trigger::Stalled(Motor::first(AXIS))];
        let limit_halts = life.state == State::Home || ends.into_iter().all(is_halted);
        let others = [
            Trigger::EmergencyStop(true),
            Trigger::Fault(JUDGED),
            Trigger::ToolCutOff,
            Trigger::SpindleFailed(SpindleFault::Drive),
            Trigger::DriverFailed(Motor::first(AXIS)),
        ];
        let halt = limit_halts && others.into_iter().all(is_halted);
        holds(!life.moving || halt, "a stop came while axes moved, and they were not halted")
    });
}

/// Only its driver holds an axis where it is: also of a machine that is locked, braking or being reset.
#[test]
fn no_position_is_trusted_after_a_driver_has_failed() {
    for_all(|life| {
        let mut next = *life;
        let mut reactions =
            [Trigger::DriverFailed(Motor::first(AXIS)), Trigger::Moving(false)].map(|it| next.on(it)).to_vec();
        while next.pending > 0 {
            let result = next.cause.filter(|_| life.moving).map_or(Ok(()), |cause| Err(cause.alarm(next.state)));
            let ends = if next.is_locked() { Trigger::PassedOver } else { Trigger::Ended(result, 1) };
            reactions.push(next.on(ends));
        }
        holds(reactions.contains(&Reaction::Distrust), "the position is trusted")
    });
}

/// An interrupt of the board inhibits before it reports what it has heard. An inhibit that the report does not confirm would hold
/// the axes in a run which nobody ends, so there is none; and none is missing.
#[test]
fn an_interrupt_inhibits_exactly_where_its_report_stops_the_machine() {
    for_all(|life| {
        let reacts = |trigger| {
            let mut next = *life;
            (next.on(trigger), next)
        };
        let halts = |trigger| reacts(trigger).0 == Reaction::Halt;
        let [limit, stall] = [Trigger::Limit, Trigger::Stalled].map(|of| halts(of(Motor::first(AXIS))));
        holds(life.heeds_limits() == limit && limit == stall, "a limit switch, or a stall")?;
        holds(life.heeds_reset_byte() == halts(Trigger::ResetHeard), "a reset byte")?;
        // It locks a machine at rest too, whose outputs are switched off then.
        let (reaction, next) = reacts(Trigger::EmergencyStop(true));
        let stops = reaction == Reaction::Halt || next.is_locked() && !life.is_locked();
        holds(life.is_locked() != stops, "the emergency stop")
    });
}

#[test]
fn what_is_refused_changes_nothing() {
    for_all(|life| {
        for trigger in triggers(life) {
            let mut next = *life;
            if next.on(trigger) == Reaction::Refuse && next != *life {
                return Err(format!("{trigger:?} was refused, and changed it"));
            }
        }
        Ok(())
    });
}

/// Whatever has happened: when the inputs are released and the motions are over, a resume and an unlock lead to a
/// machine that takes a motion of every kind.
#[test]
fn every_wait_ends() {
    for_all(|life| {
        let mut life = after(life, [Trigger::EmergencyStop(false), Trigger::Door(false), Trigger::Moving(false)]);
        for _ in 0..=MOTIONS {
            life = after(&life, [Trigger::Resume, Trigger::GoesOn]);
            let ends = if life.is_locked() { Trigger::PassedOver } else { Trigger::Ended(Ok(()), 1) };
            if life.pending > 0 {
                life = after(&life, [ends]);
            }
        }
        life = after(&life, [Trigger::Resume, Trigger::Unlock]);
        holds(life.state == State::Idle, "it never becomes idle")?;
        for kind in [Kind::Program, Kind::Jog, Kind::Homing] {
            holds(after(&life, [Trigger::Asked(kind)]).pending == 1, "an idle machine takes no motion")?;
        }
        Ok(())
    });
}

/// The situations that the table shows: a name, and what leads to it.
const SITUATIONS: [(&str, &[Trigger]); 8] = [
    ("Idle", &[]),
    ("Run", &[Trigger::Asked(Kind::Program), Trigger::Moving(true)]),
    ("Jog", &[Trigger::Asked(Kind::Jog), Trigger::Moving(true)]),
    ("braking", &[Trigger::Asked(Kind::Program), Trigger::Moving(true), Trigger::Hold]),
    ("held", &[Trigger::Asked(Kind::Program), Trigger::Hold]),
    ("held, nothing asked", &[Trigger::Hold]),
    ("Home", &[Trigger::Asked(Kind::Homing), Trigger::Homing, Trigger::Moving(true)]),
    ("Alarm", &[Trigger::Raise(HARMLESS)]),
];

const ROWS: [(&str, Trigger); 20] = [
    ("a move is asked for", Trigger::Asked(Kind::Program)),
    ("a jog is asked for", Trigger::Asked(Kind::Jog)),
    ("homing is asked for", Trigger::Asked(Kind::Homing)),
    ("the motion ends", Trigger::Ended(Ok(()), 1)),
    ("the motion fails", Trigger::Ended(Err(JUDGED), 1)),
    ("feed hold `!`", Trigger::Hold),
    ("resume `~`", Trigger::Resume),
    ("jog cancel 0x85", Trigger::CancelJog),
    ("the door opens", Trigger::Door(true)),
    ("reset 0x18", Trigger::Reset),
    ("another, before it has braked", Trigger::ResetHeard),
    ("a limit switch", Trigger::Limit(Motor::first(AXIS))),
    ("emergency stop", Trigger::EmergencyStop(true)),
    ("a step port faults", Trigger::Fault(JUDGED)),
    ("the tool was cut off", Trigger::ToolCutOff),
    ("the spindle fails", Trigger::SpindleFailed(SpindleFault::Drive)),
    ("a driver fails", Trigger::DriverFailed(Motor::first(AXIS))),
    ("a driver says stall", Trigger::Stalled(Motor::first(AXIS))),
    ("a soft limit is found", Trigger::Raise(Alarm::SoftLimit { axis: AXIS })),
    ("`$X`", Trigger::Unlock),
];

fn name(state: State) -> &'static str {
    match state {
        State::Idle => "Idle",
        State::Run => "Run",
        State::Jog => "Jog",
        State::Hold { still: true } => "held",
        State::Hold { still: false } => "braking",
        State::Home => "Home",
        State::Alarm(_) => "Alarm",
    }
}

/// True if the table shows this: nothing ends where nothing is under way, and a limit of the travel is found at rest.
fn is_shown(life: &Life, trigger: Trigger) -> bool {
    match trigger {
        Trigger::Ended(..) | Trigger::Fault(_) => life.moving,
        Trigger::Raise(_) => !life.moving && !life.held,
        // A second reset byte is heard before the first has been obeyed.
        Trigger::ResetHeard => life.pending > 0,
        _ => true,
    }
}

/// The state to which the machine comes when the run is over.
fn settled(life: &Life) -> State {
    let rest = after(life, [Trigger::Moving(false)]);
    // An abrupt stop ends a run with its alarm.
    let result = if life.moving { life.cause.map_or(Ok(()), |cause| Err(cause.alarm(life.state))) } else { Ok(()) };
    if rest.is_to_forget() { after(&rest, [Trigger::Ended(result, 1)]).state } else { rest.state }
}

/// The effect of `trigger` on the machine: what it has to do, its state at once, and what that comes to.
fn cell(before: &Life, trigger: Trigger) -> String {
    if !is_shown(before, trigger) {
        return "-".into();
    }
    let before = if trigger == Trigger::ResetHeard { &after(before, [Trigger::Reset]) } else { before };
    let mut life = *before;
    if let Trigger::Ended(..) = trigger {
        life.on(Trigger::Moving(false));
    }
    let reaction = life.on(trigger);
    if reaction == Reaction::Refuse {
        return "refused".into();
    }
    let mut parts = Vec::new();
    if reaction == Reaction::Halt {
        parts.push(String::from("halt"));
    }
    if life.state != before.state {
        parts.push(name(life.state).into());
    }
    let end = settled(&life);
    if end != life.state && end != settled(before) {
        parts.push(format!("then {}", name(end)));
    }
    if parts.is_empty() { ".".into() } else { parts.join(", ") }
}

/// The table in the form of `docs/states.md`.
fn table() -> String {
    let mut table = String::from("| what happens in |");
    for (name, _) in SITUATIONS {
        write!(table, " {name} |").unwrap();
    }
    table += "\n|---|";
    table += &"---|".repeat(SITUATIONS.len());
    for (what, trigger) in ROWS {
        write!(table, "\n| {what} |").unwrap();
        for (_, way) in SITUATIONS {
            write!(table, " {} |", cell(&after(&Life::new(), way.iter().copied()), trigger)).unwrap();
        }
    }
    table
}

#[test]
fn the_table_of_the_page_is_true() {
    for (situation, way) in SITUATIONS {
        assert!(situation.starts_with(name(after(&Life::new(), way.iter().copied()).state)), "{situation}");
    }
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/states.md")).unwrap();
    let table = table();
    assert!(page.contains(&table), "docs/states.md is to show this table:\n{table}\n");
}
