//! A machine to operate answers as a board does.

use isostep_web::Live;

/// Runs it for a time, in slices as a page does, and returns what it said.
fn said(live: &mut Live, for_s: f64) -> String {
    let end_us = live.now_us() + for_s * 1e6;
    let mut bytes = Vec::new();
    while live.now_us() < end_us {
        live.advance((live.now_us() + 16_667.0).min(end_us)).unwrap();
        bytes.extend(live.take_output());
    }
    String::from_utf8(bytes).unwrap()
}

#[test]
fn it_homes_jogs_and_stops_where_the_jog_is_cancelled() {
    let mut live = Live::new("").unwrap();
    assert!(said(&mut live, 0.1).contains("Grbl 1.1"));
    live.send(b"$H\n");
    assert!(said(&mut live, 30.0).contains("ok"));
    assert_eq!(live.position_mm(), [0.0; 3]);
    live.send(b"$J=G91 X100 F1200\n");
    said(&mut live, 1.5);
    live.send(&[0x85]);
    said(&mut live, 2.0);
    let [x_mm, ..] = live.position_mm();
    assert!((20.0..60.0).contains(&x_mm), "{x_mm} mm");
    live.send(b"?");
    assert!(said(&mut live, 0.1).contains(&format!("<Idle|MPos:{x_mm:.3},")));
    assert!(live.verdicts().iter().all(|verdict| verdict.kept), "{:?}", live.verdicts());
    assert!(!live.take_motion().times_s.is_empty());
}

#[test]
fn an_emergency_stop_is_an_alarm_until_it_is_released_and_unlocked() {
    let mut live = Live::new("").unwrap();
    said(&mut live, 0.1);
    live.set_emergency_stop(true);
    assert!(said(&mut live, 0.1).contains("ALARM:"));
    live.send(b"$X\n");
    assert!(!said(&mut live, 0.1).contains("ok"), "it is pressed still");
    live.set_emergency_stop(false);
    said(&mut live, 0.1);
    live.send(b"$X\n");
    assert!(said(&mut live, 0.1).contains("ok"));
}

#[test]
fn settings_are_those_asked_for() {
    let mut live = Live::new("$100=80\n").unwrap();
    live.send(b"$100\n$$\n");
    assert!(said(&mut live, 1.0).contains("$100=80"));
    assert!(Live::new("$100=x\n").is_err());
}

/// What a page draws is where the belts take the carriage, and how fast: not what a motor does.
#[test]
fn belts_are_drawn_as_the_axes_that_they_move() {
    let mut live = Live::new("$907=1\n$904=0\n").unwrap();
    live.send(b"$H\n");
    assert!(said(&mut live, 40.0).contains("ok"));
    live.take_motion();
    live.send(b"G91 G1 X30 F1200\nY20\nX10 Y-10\nG4 P0.01\n");
    said(&mut live, 6.0);
    assert_eq!(live.position_mm(), [40.0, 10.0, 0.0]);
    let motion = live.take_motion();
    // The end of each phase in closed form, axis by axis: its place, its speed and its acceleration.
    let ends = motion.times_s.chunks(2).zip(motion.values.chunks(9)).map(|(times_s, values)| {
        let lasts_s = times_s[1] - times_s[0];
        let end = |of: &[f32]| {
            let [place, speed, accel] = [of[0], of[1], of[2]].map(f64::from);
            place + speed * lasts_s + 0.5 * accel * lasts_s * lasts_s
        };
        [0, 1, 2].map(|axis| (end(&values[3 * axis..]) * 1e3).round() / 1e3)
    });
    let ends: Vec<_> = ends.collect();
    for corner_mm in [[30.0, 0.0, 0.0], [30.0, 20.0, 0.0]] {
        assert!(ends.contains(&corner_mm), "{corner_mm:?} is not among {ends:?}");
    }
    assert!(live.verdicts().iter().all(|verdict| verdict.kept), "{:?}", live.verdicts());
}
