//! G38.2 to G38.5 of the G-code table in docs/console.md, compared with the record of the edges.

use embassy_time::Duration;
use isostep_motion::{Axis, Event, State};
use isostep_sim::faults::Trouble;
use isostep_sim::plate::Plate;
use isostep_sim::world::Wire;
use isostep_sim::{Config, Fault, Port, Sim};
use isostep_trials::stride;

use crate::talk::{begin, bytes, field, homed, powered_up, say, state, status};

/// A plate that Z reaches from below, `place_mm` above its switch.
fn plate(place_mm: f64) -> Option<Plate> {
    Some(Plate { axis: Axis::Z, place_mm, is_below: false })
}

/// A homed machine, 2 mm above the switch of Z, with a plate at `z_mm`.
fn with_plate(z_mm: f64) -> Sim {
    let mut sim = homed();
    sim.set_plate(plate(z_mm + 2.0));
    sim
}

/// The step counts of all axes when the probe's wire last changed, computed from the edges up to then.
fn steps_at_contact(sim: &Sim, falls: bool) -> [i32; 3] {
    let outcome = sim.outcome();
    let wave = outcome.waves.iter().rfind(|wave| wave.wire == Wire::Probe && wave.high != falls).expect("a contact");
    let homed_ns =
        outcome.events.iter().rfind(|(_, event)| matches!(event, Event::Homed { .. })).map_or(0, |each| each.0);
    let edges = outcome.edges.iter().filter(|edge| (homed_ns..=wave.t_ns).contains(&edge.t_ns));
    let mut steps = [0; 3];
    edges.for_each(|edge| steps[edge.axis] = edge.position_steps);
    steps
}

fn prb(steps: [i32; 3], touched: u8) -> String {
    let [x, y, z] = steps.map(|steps| f64::from(steps) / 50.0);
    format!("[PRB:{x:.3},{y:.3},{z:.3}:{touched}]")
}

/// The contact is reported and is in `$#`. The machine stands a little behind it, and the next moves start from there.
#[test]
fn g38_2_stops_at_the_contact() {
    let mut sim = with_plate(20.0);
    assert_eq!(say(&mut sim, "G38.2 Z40 F300"), ["[PRB:0.000,0.000,20.000:1]", "ok"]);
    assert_eq!(steps_at_contact(&sim, true), [0, 0, 1_000]);
    let behind = sim.counted_steps()[2];
    // From 5 mm/s the machine brakes within 0.25 mm, after some 20 ms at constant speed.
    assert!((1_001..1_040).contains(&behind), "{behind} steps");
    assert!(say(&mut sim, "$#").contains(&"[PRB:0.000,0.000,20.000:1]".to_owned()));
    assert_eq!(field(&mut sim, "Pn"), "P");
    assert_eq!(status(&mut sim), format!("<Idle|MPos:0.000,0.000,{:.3}", f64::from(behind) / 50.0));
    assert_eq!(say(&mut sim, "G91 G0 Z-1"), ["ok"]);
    assert_eq!(sim.counted_steps(), [0, 0, behind - 50]);
    assert_eq!(say(&mut sim, "$13=1\n$#")[14], "[PRB:0.0000,0.0000,0.7874:1]");
    assert_eq!(say(&mut sim, "$G")[0], "[GC:G0 G54 G17 G21 G91 G94 G64 M5 M9 T0 F11.8 S0]");
    assert_eq!(say(&mut sim, "G90 G0 Z0\nG38.2 Z40"), ["ok", "[PRB:0.0000,0.0000,0.7874:1]", "ok"]);
}

/// With both ports, every speed profile, from the slowest speed to the top speed, along one axis and along three.
#[test]
fn a_contact_is_exact_to_the_step() {
    for (port, speed_profile) in
        Port::ALL.into_iter().flat_map(|port| (0..7).map(move |speed_profile| (port, speed_profile))).step_by(stride(3))
    {
        let mut sim = powered_up(&Config { port, ..Config::default() });
        let settings = format!("$910=60\n$911=60\n$912=60\n$940={speed_profile}\n$H");
        assert!(say(&mut sim, &settings).iter().all(|answer| answer == "ok"));
        sim.set_plate(plate(22.34));
        for (way, feed) in [("Z40", 60), ("Z40", 600), ("Z90", 2_880), ("X60 Y35 Z90", 5_000), ("X13 Z21", 777)] {
            let heard = say(&mut sim, &format!("G38.2 {way} F{feed}"));
            let contact = steps_at_contact(&sim, true);
            assert_eq!(contact[2], 1_017, "{port} {speed_profile} {way}");
            assert_eq!(heard, [prb(contact, 1), "ok".to_owned()], "{port} {speed_profile} {way} F{feed}");
            let away = say(&mut sim, &format!("G38.4 X0 Y0 Z0 F{feed}"));
            assert_eq!(
                away,
                [prb(steps_at_contact(&sim, false), 1), "ok".to_owned()],
                "{port} {speed_profile} back, F{feed}"
            );
            assert_eq!(say(&mut sim, "G0 X0 Y0 Z0"), ["ok"]);
        }
    }
}

/// The probing move is held and resumed at several instants. The reported place is always the same.
#[test]
fn a_probe_is_held_and_goes_on() {
    for hold_ms in (100..1_230).step_by(70) {
        let mut sim = with_plate(20.0);
        assert_eq!(begin(&mut sim, "G38.2 X10 Z40 F1200", Duration::from_millis(hold_ms)), [""; 0]);
        for _ in 0..2 {
            sim.send(b"!");
            sim.run_until_idle().unwrap();
            assert_eq!(sim.machine().state(), State::Hold { still: true }, "{hold_ms} ms");
            sim.send(b"~");
            sim.run_for(Duration::from_millis(150)).unwrap();
        }
        sim.run_until_idle().unwrap();
        let contact = steps_at_contact(&sim, true);
        assert_eq!(contact[2], 1_000);
        assert_eq!(sim.replies(), [prb(contact, 1), "ok".to_owned()], "{hold_ms} ms");
        let outcome = sim.outcome();
        assert_eq!(outcome.counted_steps, outcome.position_steps);
        assert_eq!(state(&mut sim), "Idle");
    }
}

/// The hold and the contact come within the same milliseconds, in either order: 20 mm at 20 mm/s take 1.2 s.
#[test]
fn a_contact_while_it_brakes_for_a_hold_is_exact() {
    let mut brakes_first = 0;
    for hold_us in (1_120_000..1_230_000).step_by(1_357 * stride(2)) {
        let mut sim = with_plate(20.0);
        assert_eq!(begin(&mut sim, "G38.2 Z40 F1200", Duration::from_micros(hold_us)), [""; 0]);
        let is_before = sim.counted_steps()[2] < 1_000;
        sim.send(b"!");
        sim.run_until_idle().unwrap();
        brakes_first += u32::from(is_before && sim.counted_steps()[2] >= 1_000);
        assert_eq!((state(&mut sim).as_str(), sim.replies()), ("Hold:0", vec![]), "{hold_us} us");
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.replies(), ["[PRB:0.000,0.000,20.000:1]", "ok"], "{hold_us} us");
        assert_eq!(state(&mut sim), "Idle");
    }
    assert!(brakes_first > 5, "{brakes_first} of them braked before they touched");
}

/// The plate is put under the probe by hand. The reported place is where the machine stands.
#[test]
fn a_contact_that_comes_while_it_is_held_ends_the_probe() {
    let mut sim = homed();
    assert_eq!(begin(&mut sim, "G38.2 Z40 F600", Duration::from_secs(1)), [""; 0]);
    bytes(&mut sim, b"!");
    sim.run_until_idle().unwrap();
    let held = sim.counted_steps();
    sim.set_hand_input(Wire::Probe, true);
    sim.run_for(Duration::from_millis(10)).unwrap();
    sim.set_hand_input(Wire::Probe, false);
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), [prb(held, 1), "ok".to_owned()]);
    assert_eq!(sim.counted_steps(), held);
}

/// The machine brakes, and `$#` keeps reporting the previous contact.
#[test]
fn a_reset_ends_a_probe() {
    let mut sim = with_plate(20.0);
    assert_eq!(say(&mut sim, "G38.2 Z40 F600\nG0 Z0"), ["[PRB:0.000,0.000,20.000:1]", "ok", "ok"]);
    assert_eq!(begin(&mut sim, "G38.2 Z40 F600", Duration::from_secs(1)), [""; 0]);
    sim.send(b"\x18");
    sim.run_until_idle().unwrap();
    assert_eq!(sim.replies(), ["Grbl 1.1h ['$' for help]"]);
    assert_eq!((state(&mut sim).as_str(), sim.machine().status().homed), ("Idle", [true; 3]));
    let stands = sim.counted_steps()[2];
    assert!((100..1_000).contains(&stands), "{stands}");
    assert!(say(&mut sim, "$#").contains(&"[PRB:0.000,0.000,20.000:1]".to_owned()));
    assert_eq!(say(&mut sim, "G91 G0 Z1"), ["ok"]);
    assert_eq!(sim.counted_steps()[2], stands + 50);
}

/// The probing move waits for the moves before it, ignores the feed override, and its line number is reported.
#[test]
fn a_probe_comes_behind_the_moves_before_it() {
    let mut sim = with_plate(20.0);
    bytes(&mut sim, &[0x91; 5]);
    sim.send(b"G1 X5 F600\nN7 G38.2 X10 Z40\nG1 X5\n");
    sim.run_for(Duration::from_millis(1_500)).unwrap();
    assert_eq!((field(&mut sim, "FS").as_str(), field(&mut sim, "Ln").as_str()), ("600,0", "7"));
    sim.run_until_idle().unwrap();
    let heard = sim.replies();
    assert_eq!((heard.len(), heard[0].as_str()), (3, prb(steps_at_contact(&sim, true), 1).as_str()), "{heard:?}");
    assert_eq!(sim.counted_steps()[0], 250);
}

/// A contact bounces before the coordinator gets time to look at it. What counts is the first touch.
#[test]
fn a_bouncing_contact_is_where_it_was_touched_first() {
    let mut sim = homed();
    begin(&mut sim, "G38.2 Z40 F2400", Duration::from_secs(1));
    let (at_ns, lasts_ns) = (sim.now_ns(), Some(4_000_000));
    sim.suffer(Fault { trouble: Trouble::Starve, at_ns, lasts_ns });
    let mut places = Vec::new();
    for _ in 0..3 {
        sim.run_for(Duration::from_micros(600)).unwrap();
        places.push(sim.counted_steps()[2]);
        sim.set_hand_input(Wire::Probe, true);
        sim.run_for(Duration::from_micros(600)).unwrap();
        sim.set_hand_input(Wire::Probe, false);
    }
    sim.run_until_idle().unwrap();
    assert!(places[0] < places[1], "it moves meanwhile: {places:?}");
    assert_eq!(sim.replies(), [prb([0, 0, places[0]], 1), "ok".to_owned()]);
}
