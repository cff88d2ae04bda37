//! Tests of the swarm: runs are reproducible and failures are detected; also some of its worlds.

use isostep_motion::{Axis, State};

use super::*;
use crate::config::{Board, Config};
use crate::drivers::DriverFault;
use crate::faults::{Fault, Trouble};
use crate::vfd::{VfdFault, VfdKind};

const WORLDS: u64 = 100;

#[test]
fn no_promise_is_broken_in_some_worlds() {
    let mut amount = Amount::default();
    for seed in 0..WORLDS {
        match run(&Scenario::new(seed)) {
            Ok(more) => amount = amount.and(more),
            Err(failure) => panic!("{failure}; again: cargo xtask swarm --seed {seed}"),
        }
    }
    let least = Amount { virtual_ns: 300_000_000_000, faults: 300, lines: 1_000, steps: 200_000, sections: 1_000_000 };
    assert!(amount.virtual_ns > least.virtual_ns && amount.faults > least.faults, "{amount:?}");
    assert!(amount.lines > least.lines && amount.steps > least.steps && amount.sections > least.sections, "{amount:?}");
}

#[test]
fn a_seed_is_the_same_world_every_time() {
    for seed in [3, 4] {
        let (one, other) = (Scenario::new(seed), Scenario::new(seed));
        assert_eq!(one.acts, other.acts);
        assert_eq!(run(&one), run(&other));
        assert_ne!(one.acts, Scenario::new(seed + 2).acts);
    }
}

fn lines(lines: &[&str]) -> Vec<Act> {
    lines.iter().map(|line| Act::Line(0, (*line).to_owned())).collect()
}

/// A motor that cannot do what the settings require.
#[test]
fn a_failure_is_made_small() {
    let mut config = Config::default();
    config.settings.accel_mm_s2 = [40_000.0; 3];
    config.settings.max_rate_mm_min = [9_000.0; 3];
    let acts = lines(&["$$", "G4 P0.1", "G1 X0.1 F60", "G0 X100", "$G", "G4 P0.1", "G1 Y1 F60"]);
    let scenario = Scenario { config, acts };
    let failure = run(&scenario).expect_err("it pulls out");
    assert_eq!(failure.promise, "no step lost");
    let kept = shrink(&scenario, &failure);
    assert_eq!(kept, [3]);
    assert!(scenario.keeping(&kept).acts[0].to_string().ends_with("G0 X100"));
}

/// A fault excuses its own consequences only.
#[test]
fn a_motor_that_is_held_is_no_failure() {
    let config = Config { start_mm: [35.0, 40.0, 15.0], ..Config::default() };
    let acts = vec![
        Act::Line(0, "G1 X20 F600".to_owned()),
        Act::Wait(500_000),
        Act::Fault(Trouble::Stall(Axis::X.into()), 100_000),
        Act::Rest,
    ];
    assert!(run(&Scenario { config, acts }).is_ok());
}

/// Beyond its end a carriage is elsewhere than it says, before a step is lost.
#[test]
fn a_carriage_that_is_sent_beyond_its_end_is_no_failure() {
    let mut config = Config { board: Board::SkrPico, driver: Board::SkrPico.driver(), ..Config::default() };
    config.settings.soft_limits = false;
    let acts = [lines(&["$H"]), vec![Act::Rest], lines(&["G0 Y403.04"]), vec![Act::Rest]].concat();
    assert_eq!(run(&Scenario { config, acts }).map(|amount| amount.faults), Ok(0));
}

const RESET: Act = Act::Reset { by: 0, early: b"", late: b"", apart_us: 60 };

/// A start-up line may move onto a switch.
#[test]
fn an_alarm_of_a_start_up_line_is_no_failure() {
    let config = Config { start_mm: [3.0, 40.0, 15.0], ..Config::default() };
    let acts = [lines(&["$N0=G91 G1 X-2 F600"]), vec![Act::Wait(500_000), RESET]].concat();
    assert_eq!(run(&Scenario { config, acts }).map(drop), Ok(()));
}

/// The machine is unlocked before a round has seen that the driver is well again: it is locked again, and reset meanwhile.
#[test]
fn an_alarm_of_a_driver_behind_a_reset_is_no_failure() {
    let config = Config { board: Board::SkrPico, driver: Board::SkrPico.driver(), ..Config::default() };
    let off = |us| Failing { motor: Axis::Y.into(), fault: DriverFault::Off, after_us: 0, us };
    for us in (450_000..550_000).step_by(10_000) {
        let reset = Act::Reset { by: 0, early: b"", late: b"", apart_us: 19 };
        let acts = [vec![Act::Drivers(vec![off(us)])], lines(&["$X"]), vec![reset]].concat();
        assert_eq!(run(&Scenario { config: config.clone(), acts }).map(|amount| amount.faults), Ok(2), "{us} us");
    }
}

/// A driver keeps a short that is over until it is switched off and on, which is tried once the machine is unlocked.
#[test]
fn a_machine_is_unlocked_at_any_instant_of_a_round() {
    let config = Config { board: Board::SkrPico, driver: Board::SkrPico.driver(), ..Config::default() };
    for after_us in (0..130_000).step_by(4_000) {
        let mut sim = crate::Sim::new(&config);
        let run_for = |sim: &mut crate::Sim, us| sim.run_for(embassy_time::Duration::from_micros(us)).unwrap();
        run_for(&mut sim, 300_000);
        let trouble = Trouble::Driver(Axis::Z.into(), DriverFault::Shorted);
        sim.suffer(Fault { trouble, at_ns: sim.now_ns(), lasts_ns: Some(60_000) });
        run_for(&mut sim, 500_000 + after_us);
        assert!(matches!(sim.machine().state(), State::Alarm(_)));
        sim.send(b"$X\n");
        run_for(&mut sim, 400_000);
        assert_eq!(sim.machine().state(), State::Idle, "{after_us} us later");
    }
}

/// Of the worlds that are to home by stall most can.
#[test]
fn worlds_home_by_stall() {
    let is_one = |config: &Config| config.diag.contains(&true);
    let worlds: Vec<_> = (0..200).map(|seed| Scenario::new(seed).config).filter(is_one).collect();
    let homes = |config: &&Config| {
        let mut sim = crate::Sim::new(&Config { faults: Vec::new(), ..(*config).clone() });
        sim.run_for(embassy_time::Duration::from_millis(500)).unwrap();
        sim.send(b"$H\n");
        sim.run_until_idle().unwrap();
        sim.replies().iter().any(|reply| reply.contains("has stalled twice"))
    };
    let homed = worlds.iter().filter(homes).count();
    assert!(worlds.len() > 15 && homed > worlds.len() / 2, "{homed} of {}", worlds.len());
}

/// A machine whose spindle a VFD turns, and acts on it while it turns.
fn turning(ramp_hz_s: f64, spin_up_s: f32, acts: Vec<Act>) -> Scenario {
    let mut config = Config { vfd: Some(VfdKind::Gs20), vfd_ramp_hz_s: ramp_hz_s, ..Config::default() };
    config.settings.spindle_type = 2;
    config.settings.spindle_max_rpm = 24_000.0;
    config.settings.spin_up_s = spin_up_s;
    let turns = [vec![Act::Wait(500_000)], lines(&["M3 S12000", "G91 G1 X1 F60"]), vec![Act::Wait(1_500_000)]];
    Scenario { config, acts: [turns.concat(), acts].concat() }
}

#[test]
fn an_alarm_of_a_vfd_has_a_cause() {
    let fails = |us| vec![Act::Vfd(VfdFault::Cut, us), Act::Wait(1_000_000)];
    for us in [1, 200_000, 1_000_000] {
        assert_eq!(run(&turning(200.0, 0.0, fails(us))).map(|amount| amount.faults), Ok(1), "{us} us");
    }
    // It is too slow for its settings, and nothing is wrong with it.
    let failure = run(&turning(50.0, 0.5, Vec::new())).expect_err("nothing fails");
    assert_eq!(failure.promise, "no VFD is said to fail that does not");
}

#[test]
fn worlds_have_vfds_of_each_type_that_fail_in_each_way() {
    let worlds: Vec<_> = (0..300).map(Scenario::new).filter(|world| world.config.vfd.is_some()).collect();
    let fails =
        |fault| worlds.iter().flat_map(|world| &world.acts).any(|act| matches!(act, Act::Vfd(f, _) if *f == fault));
    assert!(VfdKind::ALL.iter().all(|kind| worlds.iter().any(|world| world.config.vfd == Some(*kind))));
    assert!(VfdFault::ALL.into_iter().all(fails) && (40..90).contains(&worlds.len()), "{}", worlds.len());
}
