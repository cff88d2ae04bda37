//! Each field of the status reports, as listed in docs/console.md.

use embassy_time::Duration;
use isostep_motion::{Motion, Move, State};
use isostep_sim::{Config, Sim};

use crate::talk::{begin, bytes, field, homed, powered_up, report, say};

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

/// As many motions are taken at once as a report says there is room for, whatever waits behind the moves: a dwell, a probe
/// or nothing, in motion and held.
#[test]
fn as_many_motions_are_taken_as_there_is_room_for() {
    let to = |steps: i32| Motion::Move(Move { feed_mm_s: 10.0, ..Move::to([steps, 0, 0]) });
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
