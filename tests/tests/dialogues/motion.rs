//! Motion: homing, targets, resets, switches, the queue.

use embassy_futures::block_on;
use embassy_time::Duration;
use isostep_motion::{Alarm, Axis, Event, Finish, HomingPhase, Motion, Move, State};
use isostep_sim::{Config, Port, Sim, SwitchFault};
use isostep_trials::stride;

use crate::talk::{begin, homed, powered_up, report, say, status, switched_on};

#[test]
fn homing_finds_every_zero_in_the_configured_order() {
    let mut sim = homed();
    assert_eq!(status(&mut sim), "<Idle|MPos:0.000,0.000,0.000");
    let homing: Vec<_> = sim
        .outcome()
        .events
        .iter()
        .filter_map(|(_, event)| match event {
            Event::Homing { axis, phase } => Some(format!("{axis} {phase:?}")),
            Event::Homed { axis } => Some(format!("{axis} homed")),
            _ => None,
        })
        .collect();
    let axis = |axis| ["Seek", "BackOff", "Latch", "PullOff", "homed"].map(|phase| format!("{axis} {phase}"));
    assert_eq!(homing, [axis("Z"), axis("X"), axis("Y")].concat());
    // Zero is at the pull-off, 2 mm, from where the latch found the switch closed. That is beyond the place where the
    // switch closes by at most the distance at 1 mm/s during the debounce time (5 ms, and 1 ms of bounce).
    for place in sim.places_steps() {
        assert!((99..=100).contains(&place), "{place} steps from the switch");
    }
}

#[test]
fn homing_from_a_pressed_switch_backs_off_first() {
    let mut sim = switched_on(&Config { start_mm: [0.0, 40.0, -1.0], ..Config::default() });
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]", "[MSG:Check Limits]"]);
    assert!(report(&mut sim).contains("|Pn:XZ"), "both are pressed at power-up");
    assert_eq!(say(&mut sim, "$H"), ["ok"]);
    let phases = sim
        .outcome()
        .events
        .iter()
        .filter(|(_, event)| matches!(event, Event::Homing { phase: HomingPhase::Seek, .. }))
        .count();
    assert_eq!(phases, 1, "only Y had to seek");
}

#[test]
fn nonsense_moves_nothing_and_changes_nothing() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G0 X10"), ["ok"]);
    let modal = say(&mut sim, "$G");
    let long = "X".repeat(10_000);
    let nonsense = [
        ("G0 D5", "error:20"),
        ("G2 X5 I1", "error:22"),
        ("5X", "error:1"),
        ("G0 X", "error:2"),
        ("G0 X1e99", "error:20"),
        ("G0 X99999999999", "error:2"),
        ("G0 X20000", "error:33"),
        ("G1 X5", "error:22"),
        ("G0 G1 X5", "error:24"),
        ("G20 G21", "error:21"),
        ("G0 X1 X2", "error:25"),
        ("$999=1", "error:3"),
        ("$nonsense", "error:3"),
        (long.as_str(), "error:11"),
        ("\u{1}\u{2}\u{7f}", "error:1"),
    ];
    for (line, error) in nonsense {
        let heard = say(&mut sim, line);
        assert_eq!(heard.last().map(String::as_str), Some(error), "{line:?}: {heard:?}");
        assert_eq!(heard.iter().filter(|line| line.starts_with("error") || *line == "ok").count(), 1, "{line:?}");
    }
    assert_eq!(say(&mut sim, "$G"), modal);
    assert_eq!(status(&mut sim), "<Idle|MPos:10.000,0.000,0.000");
    assert_eq!(sim.counted_steps(), [500, 0, 0]);
}

#[test]
fn a_rate_the_pulses_cannot_carry_is_refused_with_the_one_that_works() {
    // A DRV8825 allows at most 250 kHz. In ticks of 8 ns with four to spare that is a period of 504. In ticks of 1 us,
    // 1.9 us high and low are 4; with one to spare, 5. At 50 steps/mm, 5 steps/s are 6 mm/min.
    for (port, max_mm_min) in [(Port::Pio, 297_618), (Port::Timer, 240_000)] {
        let mut sim = powered_up(&Config { port, ..Config::default() });
        let heard = say(&mut sim, &format!("$110={}\n$X", max_mm_min + 1));
        assert_eq!(heard.last().unwrap(), "error:12");
        let reported = format!("$110={}", max_mm_min + 1);
        assert!(heard[0].contains(&reported) && heard[0].contains(&max_mm_min.to_string()), "{heard:?}");
        assert_eq!(say(&mut sim, &format!("$110={max_mm_min}")), ["ok"]);
        assert_eq!(say(&mut sim, "$120=0").last().unwrap(), "error:2");
        assert!(say(&mut sim, "$$").contains(&"$120=50.000".to_owned()));
    }
}

/// The resets come at 200 instants, a fixed interval apart, during a diagonal move. So no seed is needed.
#[test]
fn a_second_reset_in_motion_leaves_the_exact_count_of_the_edges_that_left() {
    for i in 0..200_u64 {
        let mut sim = powered_up(&Config::default());
        assert_eq!(begin(&mut sim, "G0 X20 Y-7.3 Z3", Duration::from_micros(1_000 + i * 6_199)), ["ok"]);
        sim.send(b"\x18\x18");
        sim.run_until_idle().unwrap();
        let heard = sim.replies();
        assert!(heard.contains(&"ALARM:3".to_owned()), "instant {i}: {heard:?}");
        assert!(status(&mut sim).starts_with("<Alarm|"), "instant {i}");
        let outcome = sim.outcome();
        assert_eq!(outcome.position_steps, outcome.counted_steps, "instant {i}");
        assert!(outcome.violations.is_empty(), "instant {i}: {:?}", outcome.violations);
        assert_eq!(outcome.moves.last().unwrap().finish, Finish::Stopped, "instant {i}");
        // Queued lines are discarded, and the program continues from where the machine stands.
        let stopped_at = outcome.position_steps;
        say(&mut sim, "$X");
        say(&mut sim, "G91 G0 X1");
        let wanted = [stopped_at[0] + 50, stopped_at[1], stopped_at[2]];
        assert_eq!(sim.counted_steps(), wanted, "instant {i}");
    }
}

#[test]
fn a_reset_in_a_dwell_forgets_what_waits_and_keeps_the_position() {
    let mut sim = homed();
    let target_steps = [500, 0, 0];
    for motion in [Motion::Dwell(Duration::from_secs(1)), Motion::Move(Move::to(target_steps))] {
        block_on(sim.machine().submit(motion)).unwrap();
    }
    sim.run_for(Duration::from_millis(500)).unwrap();
    sim.machine().reset();
    sim.run_until_idle().unwrap();
    assert_eq!(sim.machine().state(), State::Idle);
    assert_eq!(sim.machine().status().homed, [true; 3]);
    assert_eq!(sim.counted_steps(), [0; 3]);
}

#[test]
fn an_emergency_stop_around_the_end_of_a_move_locks_whenever_it_comes() {
    // 1 mm at 50 mm/s2 takes 282.8 ms without a cruise, from 500 us after the line.
    for at_us in (263_000..285_000).step_by(131 * stride(3)) {
        let mut sim = homed();
        begin(&mut sim, "G0 X1", Duration::from_micros(at_us));
        sim.set_emergency_stop(true);
        sim.run_until_idle().unwrap();
        assert_eq!(sim.machine().state(), State::Alarm(Alarm::EmergencyStop), "at {at_us} us");
        let outcome = sim.outcome();
        assert_eq!(outcome.position_steps, outcome.counted_steps, "at {at_us} us");
    }
}

#[test]
fn an_emergency_stop_is_not_lost_behind_a_reset() {
    let mut sim = homed();
    block_on(sim.machine().submit(Motion::Dwell(Duration::from_secs(1)))).unwrap();
    sim.run_for(Duration::from_millis(100)).unwrap();
    sim.machine().reset();
    sim.set_emergency_stop(true);
    sim.run_until_idle().unwrap();
    assert_eq!(sim.machine().state(), State::Alarm(Alarm::EmergencyStop));
    assert_eq!(say(&mut sim, "$X").last().unwrap(), "error:9");
}

#[test]
fn motors_rest_when_the_idle_delay_says_so() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(say(&mut sim, "$1=100"), ["ok"]);
    assert_eq!(say(&mut sim, "G0 X1"), ["ok"]);
    let enable = |sim: &Sim| {
        let outcome = sim.outcome();
        let waves = outcome.waves.iter().filter(|wave| wave.wire == isostep_sim::world::Wire::Enable);
        waves.map(|wave| (wave.t_ns, wave.high)).collect::<Vec<_>>()
    };
    let [.., (on_ns, false), (off_ns, true)] = enable(&sim)[..] else { panic!("{:?}", enable(&sim)) };
    let moved_ns = sim.outcome().moves.last().map(|record| record.end_ns - on_ns).unwrap();
    // Timers have a resolution of a microsecond; the last step does not.
    let rested_ns = off_ns - on_ns - moved_ns;
    assert!((99_999_000..=100_000_000).contains(&rested_ns), "{rested_ns} ns");
    assert!(sim.outcome().violations.is_empty());
}

/// A step may have just risen. ENABLE must stay on for as long as the driver requires and until the plan ends, half a
/// step later.
#[test]
fn motors_are_freed_no_sooner_than_their_drivers_take_it() {
    // Moves that end, are held, or are stopped.
    for (port, speed_profile) in
        Port::ALL.into_iter().flat_map(|port| [0, 1].map(|speed_profile| (port, speed_profile)))
    {
        for (settings, end) in
            [("$1=0", ""), ("$1=0", "!"), ("$1=0", "\x18\x18"), ("$1=0", "stop"), ("$1=1", ""), ("$1=255", "sleep")]
        {
            let case = format!("{port}, speed profile {speed_profile}, {settings}, {end:?}");
            let mut sim = powered_up(&Config { port, ..Config::default() });
            assert_eq!(say(&mut sim, &format!("$940={speed_profile}\n{settings}\n$910=600")), ["ok"; 3], "{case}");
            sim.send(b"G0 X1 Y0.5\n");
            match end {
                "sleep" => {
                    // Exactly at the instant at which the move ends.
                    sim.run_until_state(|state| state == State::Run).unwrap();
                    sim.run_until_state(|state| state == State::Idle).unwrap();
                    sim.send(b"$SLP\n");
                }
                "stop" => {
                    sim.run_for(Duration::from_millis(150)).unwrap();
                    sim.set_switch(Axis::Z, SwitchFault::StuckClosed);
                }
                bytes => {
                    sim.run_for(Duration::from_millis(150)).unwrap();
                    sim.send(bytes.as_bytes());
                }
            }
            sim.run_until_idle().unwrap();
            // Motors stay energised during a hold.
            sim.send(b"~");
            sim.run_until_idle().unwrap();
            let outcome = sim.outcome();
            assert_eq!(outcome.violations.first().map(ToString::to_string), None, "{case}");
            let freed = outcome.waves.iter().rfind(|wave| wave.wire == isostep_sim::world::Wire::Enable).unwrap();
            assert!(freed.high, "{case}: the motors are free in the end");
            let last = outcome.moves.last().unwrap();
            if last.finish == Finish::Done {
                let over_ns = last.start_ns + (last.plan_s * 1e9) as u64;
                assert!(freed.t_ns >= over_ns, "{case}: freed {} ns before the plan is over", over_ns - freed.t_ns);
            }
        }
    }
}

/// Forero 2023 on the paper's machine: 20,000 steps of Y in three intervals of 4.5 s. The paper measured 4.5 / 4.725 /
/// 6.8 s and lost steps. 9.8766 mm/s2 are the paper's V_c/t1 = 2,222.2/4.5 steps/s2 at 50 steps/mm.
#[test]
fn forero_2023_moves_in_three_equal_intervals_without_losing_a_step() {
    let mut sim = homed();
    for line in ["$900=1", "$120=9.8766", "$121=9.8766", "G0 X150 Y400"] {
        assert_eq!(say(&mut sim, line), ["ok"]);
    }
    let outcome = sim.outcome();
    assert_eq!(outcome.counted_steps, [7_500, 20_000, 0]);
    assert_eq!(outcome.drift_steps, [0; 3], "every edge moved its carriage");
    let checks = isostep_sim::verify::moves(&outcome);
    let check = checks.last().unwrap();
    for axis in [0, 1] {
        let measured = check.measured[axis].expect("enough edges to measure").intervals;
        for interval_s in [measured.accel_s, measured.cruise_s, measured.decel_s] {
            assert!((interval_s - 4.5).abs() < 50e-6, "axis {axis}: {measured:?}");
        }
        assert!((measured.accel_s - measured.cruise_s).abs() < 8e-9, "axis {axis}: {measured:?}");
    }
    assert!(check.apart_s().unwrap() < 8e-9, "equal to the tick on both axes: {check:?}");
}

/// Each axis brakes with a limit of its own, `$920` to `$922`. If that is 0, it brakes with its acceleration limit.
#[test]
fn an_axis_brakes_by_its_own_limit() {
    for axis in Axis::ALL {
        let (mut sim, number) = (homed(), axis as usize);
        say(&mut sim, "$120=400\n$121=400\n$122=400");
        for (decel_mm_s2, ratio) in [("100", 4.0), ("0", 1.0)] {
            assert_eq!(say(&mut sim, &format!("$92{number}={decel_mm_s2}")), ["ok"]);
            assert_eq!(say(&mut sim, &format!("G91 G0 {axis}20")), ["ok"]);
            let outcome = sim.outcome();
            let profile = outcome.moves.last().expect("it moved").plan.profile;
            let found = profile.t_decel_s() / profile.t_accel_s();
            assert!((found - ratio).abs() < 1e-6, "{axis}, $92{number}={decel_mm_s2}: it brakes {found} times as long");
        }
    }
}
