//! Each field of the status reports, as listed in docs/console.md.

use embassy_time::Duration;
use isostep_motion::{Axis, State};
use isostep_sim::world::Wire;
use isostep_sim::{Config, Sim, SwitchFault};

use crate::talk::{begin, bytes, field, homed, powered_up, report, say, state};

#[test]
fn report_positions_go_by_the_mask() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "G10 L2 P1 X1 Y2\nG92 Z-3\nG43.1 Z0.5\nG0 X10"), ["ok"; 4]);
    // Machine X is 11. WCO is the sum of G54, G92 (Z was 0 and became 3) and the tool's length.
    assert_eq!(field(&mut sim, "MPos"), "11.000,0.000,0.000");
    assert_eq!(field(&mut sim, "WCO"), "1.000,2.000,3.500");
    assert_eq!(say(&mut sim, "$10=0"), ["ok"]);
    assert_eq!(field(&mut sim, "WPos"), "10.000,-2.000,-3.500");
    assert_eq!(say(&mut sim, "$13=1"), ["ok"]);
    assert_eq!(field(&mut sim, "WPos"), "0.3937,-0.0787,-0.1378");
    assert_eq!(field(&mut sim, "WCO"), "0.0394,0.0787,0.1378");
}

/// The moves with the old offset end first, so the work position never jumps.
#[test]
fn a_new_offset_waits_for_the_moves_before_it() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$10=0"), ["ok"]);
    sim.send(b"G1 X10 F600\nG92 X0\nG1 X5\n");
    let mut last_mm = 0.0;
    for _ in 0..40 {
        sim.run_for(Duration::from_millis(50)).unwrap();
        let report = report(&mut sim);
        let x_mm: f64 = report.split("WPos:").nth(1).unwrap().split(',').next().unwrap().parse().unwrap();
        let restarted = last_mm > 9.0 && x_mm < 1.0;
        assert!((x_mm - last_mm).abs() < 1.0 || restarted, "{last_mm} to {report}");
        last_mm = x_mm;
    }
    sim.run_until_idle().unwrap();
    assert_eq!(field(&mut sim, "WPos"), "5.000,0.000,0.000");
}

#[test]
fn report_buffers_when_asked() {
    let mut sim = homed();
    assert!(!report(&mut sim).contains("Bf:"));
    assert_eq!(say(&mut sim, "$10=3"), ["ok"]);
    assert_eq!(field(&mut sim, "Bf"), "79,128");
    begin(&mut sim, "G0 X10\nG0 X20\nG0 X30", Duration::from_millis(100));
    assert_eq!(field(&mut sim, "Bf"), "76,128");
    // As many moves as it reports are accepted at once. The others wait in the console, which holds more than it
    // promises.
    let ask_for = |sim: &mut Sim, moves: usize| {
        for i in 0..moves {
            sim.send(format!("G0 X{}\n", i % 10).as_bytes());
        }
        sim.run_for(Duration::from_millis(10)).unwrap();
        sim.replies().len()
    };
    assert_eq!(ask_for(&mut sim, 70), 70);
    assert_eq!(field(&mut sim, "Bf"), "6,128");
    assert_eq!(ask_for(&mut sim, 20), 6);
    assert_eq!(field(&mut sim, "Bf"), "0,128");
    ask_for(&mut sim, 20);
    sim.send(&[b' '; 280]);
    sim.run_for(Duration::from_millis(10)).unwrap();
    let bytes: u16 = field(&mut sim, "Bf").split(',').nth(1).unwrap().parse().unwrap();
    assert!(bytes < 128, "{bytes}");
}

/// Waiting moves are not planned during a hold, so there is room only in the queue.
#[test]
fn report_buffers_in_a_hold() {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$10=3"), ["ok"]);
    begin(&mut sim, "G0 X100", Duration::from_millis(800));
    for state_now in ["Hold:1", "Hold:0"] {
        sim.send(b"!");
        sim.run_for(Duration::from_millis(100)).unwrap();
        assert_eq!((state(&mut sim).as_str(), field(&mut sim, "Bf").as_str()), (state_now, "15,128"));
        sim.run_until_idle().unwrap();
    }
    (0..20).for_each(|_| sim.send(b"G0 X1\nX2\n"));
    sim.run_for(Duration::from_millis(10)).unwrap();
    assert_eq!(sim.replies().len(), 15);
}

#[test]
fn report_line_number_of_the_move_under_way() {
    let mut sim = homed();
    sim.send(b"N10 G1 X5 F600\nN20 X10\nX15\nN30 G4 P1 X20\nN0 X25\n");
    let mut heard = Vec::new();
    for _ in 0..150 {
        sim.run_for(Duration::from_millis(50)).unwrap();
        let report = report(&mut sim);
        let number = report.split("|Ln:").nth(1).map_or("", |rest| rest.split('|').next().unwrap()).to_owned();
        if heard.last() != Some(&number) {
            heard.push(number);
        }
    }
    assert_eq!(heard, ["10", "20", "", "30", ""]);
    sim.run_until_idle().unwrap();
    // A reset brakes the current move and discards the waiting ones.
    begin(&mut sim, "N40 X0\nN50 X5", Duration::from_millis(50));
    bytes(&mut sim, b"\x18");
    assert_eq!(field(&mut sim, "Ln"), "40");
    sim.run_until_idle().unwrap();
    assert!(!report(&mut sim).contains("Ln:"));
    begin(&mut sim, "N60 G1 X1 F60", Duration::from_millis(50));
    assert_eq!(field(&mut sim, "Ln"), "60");
}

/// Lines of a laser that go straight on are one move, and each is reported while its part of it is made; after a hold,
/// too.
#[test]
fn report_line_number_of_the_part_of_a_move_that_is_under_way() {
    let mut sim = homed();
    sim.send(b"$32=1\nG91 M4 S500 G1 F600\nN1 X1\n");
    (1..=20).for_each(|number| sim.send(format!("N{}0 X1 S{}\n", number, 10 * number).as_bytes()));
    let mut heard = 0;
    while sim.machine().state() != State::Idle || heard == 0 {
        sim.run_for(Duration::from_millis(23)).unwrap();
        let status = sim.machine().status();
        let mm = f64::from(status.position_steps[0]) / 50.0;
        // A report is at most 5 ms old, in which it goes 0.05 mm, and a position half a step.
        let numbers = [mm - 0.06, mm + 0.01].map(|mm| if mm < 1.0 { 1 } else { mm as u32 * 10 });
        if status.state == State::Run {
            assert!(numbers.contains(&status.line), "N{} at {mm} mm", status.line);
            heard += u32::from(status.line >= 10);
        }
        if heard == 30 {
            bytes(&mut sim, b"!");
            sim.run_until_state(|state| state == State::Hold { still: true }).unwrap();
            bytes(&mut sim, b"~");
            heard += 1;
        }
    }
    let outcome = sim.outcome();
    let marks = outcome.moves.iter().filter(|record| !record.homing).map(|record| record.marks_steps.len());
    // N10 begins a move, which the hold divides.
    assert!(matches!(marks.collect::<Vec<_>>()[..], [0, before, after] if before > 2 && before + after == 19));
    assert!(heard > 60, "{heard} reports");
}

#[test]
fn report_speed_along_the_path() {
    let mut sim = homed();
    assert_eq!(field(&mut sim, "FS"), "0,0");
    begin(&mut sim, "M3 S1000 G1 X60 Y80 F1200", Duration::from_secs(1));
    assert_eq!(field(&mut sim, "FS"), "1200,1000");
    bytes(&mut sim, &[0x9B]);
    assert_eq!(field(&mut sim, "FS"), "1200,900", "as overridden");
}

#[test]
fn report_pins_when_pressed() {
    let mut sim = homed();
    let pins = |sim: &mut Sim| {
        sim.run_for(Duration::from_millis(20)).unwrap();
        field(sim, "Pn")
    };
    assert!(!report(&mut sim).contains("Pn:"));
    sim.set_switch(Axis::X, SwitchFault::StuckClosed);
    assert_eq!(pins(&mut sim), "X");
    sim.set_switch(Axis::Y, SwitchFault::StuckClosed);
    sim.set_switch(Axis::Z, SwitchFault::StuckClosed);
    assert_eq!(pins(&mut sim), "XYZ");
    sim.set_emergency_stop(true);
    assert_eq!(pins(&mut sim), "XYZR");
    let inputs = [Wire::Probe, Wire::Hold, Wire::Start];
    inputs.iter().for_each(|&wire| sim.set_hand_input(wire, true));
    assert_eq!(pins(&mut sim), "PXYZRHS");
    inputs.iter().for_each(|&wire| sim.set_hand_input(wire, false));
    for axis in Axis::ALL {
        sim.set_switch(axis, SwitchFault::None);
    }
    assert_eq!(pins(&mut sim), "R");
    sim.set_emergency_stop(false);
    sim.run_for(Duration::from_millis(20)).unwrap();
    assert!(!report(&mut sim).contains("Pn:"));
}

/// One letter per report: w for the work offset, o for the overrides, a dot for neither.
fn extras(sim: &mut Sim, count: usize) -> String {
    let kind = |report: String| match (report.contains("|WCO:"), report.contains("|Ov:")) {
        (true, false) => 'w',
        (false, true) => 'o',
        (false, false) => '.',
        (true, true) => panic!("{report}"),
    };
    (0..count).map(|_| kind(report(sim))).collect()
}

#[test]
fn report_offset_and_overrides_take_turns() {
    let mut sim = powered_up(&Config::default());
    assert_eq!(extras(&mut sim, 22), "wo........wo........wo");
    // A changed value is reported at once. If both have changed, they take turns.
    assert_eq!(say(&mut sim, "G92 X1"), ["ok"]);
    assert_eq!(extras(&mut sim, 3), "w..");
    bytes(&mut sim, b"\x91");
    assert_eq!(extras(&mut sim, 3), "o..");
    assert_eq!(say(&mut sim, "G92 X2"), ["ok"]);
    bytes(&mut sim, b"\x91");
    assert_eq!(extras(&mut sim, 3), "wo.");
    bytes(&mut sim, b"\x18");
    assert_eq!(extras(&mut sim, 2), "wo", "a reset begins anew");
    begin(&mut sim, "G1 X100 F600", Duration::from_millis(50));
    let busy = extras(&mut sim, 70);
    let (offsets, overrides): (Vec<_>, Vec<_>) =
        (busy.match_indices('w').map(|(at, _)| at).collect(), busy.match_indices('o').map(|(at, _)| at).collect());
    assert_eq!(offsets[1] - offsets[0], 30, "{busy}");
    assert_eq!(overrides[2] - overrides[1], 20, "{busy}");
}

/// Accessories are reported in the very next report, and then together with the overrides.
#[test]
fn report_accessories_that_are_on() {
    let mut sim = homed();
    extras(&mut sim, 2);
    for (line, reported) in
        [("M3 S1000", "|A:S>"), ("M8", "|A:SF>"), ("M4 M7", "|A:CFM>"), ("M5", "|A:FM>"), ("M9", "0>")]
    {
        assert_eq!(say(&mut sim, line), ["ok"]);
        let report = report(&mut sim);
        assert!(report.contains("|Ov:100,100,100") && report.ends_with(reported), "{line}: {report}");
    }
    assert_eq!(say(&mut sim, "M3"), ["ok"]);
    let reports: Vec<_> = (0..21).map(|_| report(&mut sim)).collect();
    assert_eq!(reports.iter().filter(|report| report.contains("|A:S")).count(), 3, "{reports:?}");
    assert!(reports.iter().all(|report| report.contains("|A:S") == report.contains("|Ov:")), "{reports:?}");
}

/// As many motions are taken at once as a report says there is room for, whatever waits behind the moves: a dwell, a probe
/// or nothing, in motion and held.
#[test]
fn as_many_motions_are_taken_as_there_is_room_for() {
    let to = |steps: i32| {
        let power = isostep_motion::Power::Off;
        let target_steps = [steps, 0, 0];
        isostep_motion::Motion::Move {
            target_steps,
            offsets: [0; 3],
            feed_mm_s: Some(10.0),
            exact_stop: false,
            deviation_mm: 0.0,
            line: 0,
            power,
        }
    };
    for begun in [
        "G0 X60",
        "G0 X60\nG4 P9",
        "G0 X30\nG0 X60\nG4 P9",
        "G4 P9",
        "G38.3 X60 F600",
        "G0 X60\nM3 S5",
        "G0 X60\nG92 X0",
    ] {
        for held in [false, true] {
            let mut sim = homed();
            assert_eq!(say(&mut sim, "$10=3"), ["ok"]);
            begin(&mut sim, begun, Duration::from_millis(400));
            if held {
                begin(&mut sim, "!", Duration::from_millis(100));
            }
            let reported: usize = field(&mut sim, "Bf").split(',').next().unwrap().parse().unwrap();
            let mut taken = 0;
            while taken < 200 {
                let motion = to(3_000 + 10 * taken as i32);
                if embassy_futures::poll_once(sim.machine().submit(motion)).is_pending() {
                    break;
                }
                taken += 1;
                sim.run_for(Duration::from_millis(2)).unwrap();
            }
            // While the first move goes on, one more may be taken than was reported.
            assert!(
                (reported..=reported + 1).contains(&taken),
                "{taken} taken, {reported} reported, behind `{begun}`, held: {held}"
            );
        }
    }
}
