//! Stops at many instants, and the state afterwards.

use embassy_futures::block_on;
use embassy_time::Duration;
use isostep_motion::{AXES, Alarm, Axis, Motion, Move, ProbeMove, State};
use isostep_sim::faults::Trouble;
use isostep_sim::{Config, Fault, Port, Sim};
use isostep_trials::stride;

use crate::talk::{begin, bytes, field, homed, powered_up, say};

/// Presses the emergency stop, checks that nothing moves after it, and unlocks.
fn stop(sim: &mut Sim, case: &str) {
    let before = sim.steps();
    sim.set_emergency_stop(true);
    sim.run_for(Duration::from_millis(100)).unwrap();
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::EmergencyStop), "{case}");
    let heard = sim.replies();
    assert!(heard.contains(&"ALARM:10".to_owned()), "{case}: {heard:?}");
    assert_eq!(sim.steps(), before, "{case}: a step after the stop");
    sim.set_emergency_stop(false);
    sim.run_until_idle().unwrap();
    assert_eq!(say(sim, "$X"), ["[MSG:Caution: Unlocked]", "ok"], "{case}");
    assert_eq!((sim.steps(), sim.machine().state()), (before, State::Idle), "{case}: the move is forgotten");
}

/// The stop comes between the last byte of a line and the first step of its move, at every microsecond for the
/// trapezoid; and before the byte.
#[test]
fn an_emergency_stop_between_a_line_and_its_first_step_lets_nothing_move() {
    for (port, speed_profile) in
        Port::ALL.into_iter().flat_map(|port| [0, 1].map(|speed_profile| (port, speed_profile)))
    {
        let mut config = Config { port, keep_record: false, ..Config::default() };
        config.settings.speed_profile = speed_profile;
        let mut sim = powered_up(&config);
        let mut begun = 0;
        for at_us in (0..).step_by(stride(3) * (1 + 12 * usize::from(speed_profile))) {
            let (case, steps) = (format!("{port}, speed profile {speed_profile}, {at_us} us"), sim.steps());
            sim.send(b"G91 G0 X5 Y-3 Z1\n");
            sim.run_for(Duration::from_micros(at_us)).unwrap();
            if sim.steps() != steps {
                begun = at_us;
                sim.run_until_idle().unwrap();
                break;
            }
            stop(&mut sim, &case);
        }
        assert!(begun > 100, "{port}, speed profile {speed_profile}: the first step came after {begun} us");
        sim.replies();
        // If it is pressed before the line comes, there is an alarm at rest, and the line is refused.
        let steps = sim.steps();
        sim.set_emergency_stop(true);
        sim.send(b"G91 G0 X5\n");
        sim.run_for(Duration::from_millis(100)).unwrap();
        assert_eq!((sim.steps(), sim.machine().state()), (steps, State::Alarm(Alarm::EmergencyStop)));
    }
}

/// The stop's interrupt comes before the coordinator has looked at the requested motion, or while the motion waits for
/// a spindle to get its speed.
#[test]
fn an_emergency_stop_behind_a_motion_that_has_not_begun_lets_nothing_move() {
    let (target_steps, feed_mm_s) = ([500, 0, 0], 10.0);
    let motions = [
        Motion::Move(Move::to(target_steps)),
        Motion::Jog(Move { feed_mm_s, ..Move::to(target_steps) }),
        Motion::Probe(ProbeMove { target_steps, feed_mm_s, away: false, must: false, line: 0 }),
        Motion::Home { axes: [true; AXES] },
    ];
    for (motion, port) in motions.into_iter().flat_map(|motion| Port::ALL.map(|port| (motion, port))) {
        let mut sim = powered_up(&Config { port, keep_record: false, ..Config::default() });
        block_on(sim.machine().submit(motion)).unwrap();
        sim.machine().emergency_stop_edge(true);
        sim.run_for(Duration::from_millis(500)).unwrap();
        assert_eq!(sim.machine().state(), State::Alarm(Alarm::EmergencyStop), "{motion:?}, {port}");
        assert_eq!(sim.steps(), [0; AXES], "{motion:?}, {port}");
    }
    let mut config = Config::default();
    config.settings.spin_up_s = 1.0;
    let mut sim = powered_up(&config);
    assert_eq!(begin(&mut sim, "M3 S1000\nG0 X5", Duration::from_millis(500)), ["ok", "ok"]);
    sim.set_emergency_stop(true);
    sim.run_for(Duration::from_secs(2)).unwrap();
    assert_eq!((sim.machine().state(), sim.steps()), (State::Alarm(Alarm::EmergencyStop), [0; AXES]));
}

/// The move comes late. Its run gets ready while the previous plan ends, and waits for that.
#[test]
fn an_emergency_stop_while_a_run_waits_for_the_one_before_lets_it_not_begin() {
    for port in Port::ALL {
        let mut waited = 0;
        for at_us in (0..4_000).step_by(97 * stride(2)) {
            let mut sim = powered_up(&Config { port, keep_record: false, ..Config::default() });
            begin(&mut sim, "G91 G1 X1 F600", Duration::from_millis(10));
            // The last step of the move comes half a step before the end of its plan.
            while sim.counted_steps()[0] < 50 {
                sim.run_for(Duration::from_micros(5)).unwrap();
            }
            sim.send(b"G0 X1\n");
            sim.run_for(Duration::from_micros(at_us)).unwrap();
            if sim.counted_steps()[0] == 50 {
                stop(&mut sim, &format!("{port}, {at_us} us"));
                waited += 1;
            }
        }
        assert!(waited > 10, "{port}: {waited} stops before the first step");
    }
}

/// Only the current jog has begun. Jogs that are planned ahead, and those that wait behind them, never begin.
/// A console resets the drive before it asks. Whoever asks without that is refused, also from the edge on that has just come.
#[test]
fn a_machine_stays_locked_while_a_drive_is_in_alarm() {
    let mut config = Config::default();
    config.settings.drive_alarm_mask = 1;
    let mut sim = Sim::new(&config);
    sim.set_emergency_stop(true);
    sim.run_for(Duration::from_millis(50)).unwrap();
    sim.set_emergency_stop(false);
    sim.run_for(Duration::from_millis(50)).unwrap();
    sim.set_drive(Axis::X, true);
    for us in [1, 10_000] {
        sim.run_for(Duration::from_micros(us)).unwrap();
        let machine = sim.machine();
        assert_eq!(machine.state(), State::Alarm(Alarm::EmergencyStop), "{us} us later");
        assert!(machine.unlock().is_err(), "{us} us later");
        assert!(block_on(machine.submit(Motion::Home { axes: [true; AXES] })).is_err(), "{us} us later");
    }
}

#[test]
fn a_jog_cancel_forgets_every_jog_that_waits() {
    // Up to the number that is planned ahead, and more.
    for waiting in [0, 1, 4, 75] {
        let mut sim = homed();
        assert_eq!(begin(&mut sim, "$J=X100 F1200", Duration::from_millis(500)), ["ok"]);
        for jog in 0..waiting {
            let line = format!("$J=X{} Y{} F1200", 110 + jog % 2, 5 + jog % 3);
            assert_eq!(begin(&mut sim, &line, Duration::from_millis(1)), ["ok"], "jog {jog} of {waiting}");
        }
        assert_eq!(bytes(&mut sim, b"\x85"), [""; 0], "{waiting} wait");
        sim.run_until_idle().unwrap();
        assert_eq!((sim.replies(), sim.machine().state()), (vec![], State::Idle), "{waiting} wait");
        let [x, y, z] = sim.counted_steps();
        assert!((1..5_000).contains(&x) && (y, z) == (0, 0), "{waiting} wait: {x}, {y}, {z}");
        let outcome = sim.outcome();
        let begun = outcome.moves.iter().filter(|record| !record.homing).count();
        assert_eq!((begun, outcome.position_steps), (1, [x, 0, 0]), "{waiting} wait");
        assert_eq!(sim.machine().status().queue_free, isostep_motion::MOVES_AHEAD, "{waiting} wait");
        // The next move counts from there.
        assert_eq!(say(&mut sim, "G91 G0 X1 Y2"), ["ok"]);
        assert_eq!(sim.counted_steps(), [x + 50, 100, 0], "{waiting} wait");
    }
}

/// The override changes from twice the feed to a tenth of it, and back to 100 % before that has taken effect. The speed
/// must never be lower than the feed.
#[test]
fn an_override_asked_for_while_another_one_brakes_counts_at_once() {
    let mut sim = powered_up(&Config::default());
    begin(&mut sim, "G1 X300 F600", Duration::from_secs(1));
    bytes(&mut sim, &[0x91; 10]);
    sim.run_for(Duration::from_secs(1)).unwrap();
    assert_eq!(field(&mut sim, "FS"), "1200,0");
    // At 50 mm/s2 it takes 0.18 s to reach 660 mm/min, and 0.38 s to reach a tenth.
    bytes(&mut sim, &[0x92; 19]);
    sim.run_for(Duration::from_millis(120)).unwrap();
    let braking = speed(&mut sim);
    assert!((660.0..1_150.0).contains(&braking), "it brakes: {braking}");
    bytes(&mut sim, &[0x90]);
    let reported: Vec<_> = (0..100)
        .map(|_| {
            sim.run_for(Duration::from_millis(5)).unwrap();
            speed(&mut sim)
        })
        .collect();
    assert!(reported.iter().all(|&speed| speed >= 600.0), "{reported:?}");
    assert_eq!(reported.last(), Some(&600.0), "{reported:?}");
    let outcome = {
        sim.run_until_idle().unwrap();
        sim.outcome()
    };
    assert_eq!((outcome.counted_steps, outcome.position_steps), ([15_000, 0, 0], [15_000, 0, 0]));
    assert_eq!(outcome.drift_steps, [0; AXES]);
}

/// The speed in a status report, mm/min.
fn speed(sim: &mut Sim) -> f64 {
    let reported = field(sim, "FS");
    reported.split(',').next().and_then(|speed| speed.parse().ok()).unwrap_or_else(|| panic!("FS:{reported}"))
}

/// The coordinator gets no time until an axis has run dry, and in some cases until the others would have too. The one that runs dry
/// stops the others itself, at the instant of its last edge.
#[test]
fn an_axis_that_runs_dry_stops_the_others() {
    let mut alarms = 0;
    for starved_ms in 25..70 {
        let mut sim = homed();
        begin(&mut sim, "G1 X90 Y61 Z37 F2400", Duration::from_secs(2));
        let (at_ns, lasts_ns) = (sim.now_ns(), starved_ms * 1_000_000);
        sim.suffer(Fault { trouble: Trouble::Starve, at_ns, lasts_ns: Some(lasts_ns) });
        sim.run_until_idle().unwrap();
        let outcome = sim.outcome();
        if let State::Alarm(alarm) = outcome.state {
            assert!(matches!(alarm, Alarm::Underrun { .. }), "{alarm:?} after {starved_ms} ms");
            let [x, y, z] = Axis::ALL.map(|axis| u32::from(Alarm::Underrun { axis } == alarm));
            let dry = Axis::ALL.into_iter().find(|&axis| Alarm::Underrun { axis } == alarm).unwrap();
            let edges = &outcome.edges[outcome.edges.partition_point(|edge| edge.t_ns <= at_ns)..];
            let fault_ns = edges.iter().rfind(|edge| edge.axis == dry as usize).map_or(at_ns, |edge| edge.t_ns);
            let late = edges.iter().find(|edge| edge.t_ns > fault_ns + 1_000);
            assert_eq!(late, None, "a step after {dry} has run dry, {starved_ms} ms without time");
            assert_eq!(sim.machine().faults(), [x, y, z]);
            if alarms == 0 {
                assert_eq!(say(&mut sim, "$X").last().map(String::as_str), Some("ok"));
                let heard = say(&mut sim, "$I");
                let words = format!("[MSG:step ports faulted since power-up: X {x}, Y {y}, Z {z} times]");
                assert!(heard.contains(&words), "{heard:?}");
            }
            alarms += 1;
        }
    }
    assert!(alarms > 10, "an axis ran dry {alarms} times");
}
