//! What a page runs is what the simulator runs, to the byte, and what it draws is where the machine goes.

use isostep_report::Figures;
use isostep_sim::{Config, run, trace};
use isostep_web::{COLUMNS, Job, Kind, Motion, Trouble};
use serde_json::Value;

const PARKING: &[u8] = include_bytes!("../../../programs/parking.nc");
const ARCS: &[u8] = include_bytes!("../../../programs/arcs.nc");
/// An S-curve, a hold by M0, a dwell, and blends.
const CURVED: &[u8] = b"$940=1\nG21 G91\nG1 X30 Y7 F2400\nM0\nY12\nG4 P0.1\nX-5\n";

/// Its trace, its summary and its motion, taken every so often.
fn made(program: &[u8], every_us: f64) -> (Vec<u8>, Value, Motion) {
    let mut job = Job::new(program, "").unwrap().with_trace();
    let (mut rows, mut motion, mut until_us) = (Vec::new(), Motion::default(), 0.0);
    let mut add = |rows_more: Vec<u8>, more: Motion| {
        rows.extend(rows_more);
        motion.times_s.extend(more.times_s);
        motion.kinds.extend(more.kinds);
        motion.values.extend(more.values);
    };
    loop {
        until_us += every_us;
        let has_ended = job.advance(until_us).unwrap();
        add(job.take_trace(), job.take_motion());
        if has_ended {
            break;
        }
    }
    let (summary, more, rest) = job.end_with().unwrap();
    add(rest, more);
    (rows, serde_json::from_str(&summary).unwrap(), motion)
}

#[test]
fn a_trace_is_the_simulators_to_the_byte() {
    for program in [PARKING, ARCS, CURVED] {
        let outcome = run(program, &Config::default()).unwrap();
        let mut expected = Vec::new();
        trace::write(&outcome.edges, &mut expected).unwrap();
        let figures = serde_json::to_value(Figures::new("a page", &outcome)).unwrap();
        for every_us in [33_333.0, 1e6] {
            let (rows, summary, _) = made(program, every_us);
            assert!(rows == expected, "{} of {} bytes", rows.len(), expected.len());
            assert_eq!(summary["verdicts"], figures["verdicts"]);
            assert_eq!(summary["moves"], figures["moves_total"]);
            assert_eq!(summary["position_mm"], figures["position_mm"]);
            let homing_s = figures["homing_ns"].as_f64().unwrap() * 1e-9;
            assert!((summary["homing_s"].as_f64().unwrap() - homing_s).abs() < 1e-9);
        }
    }
}

/// Places, speeds and accelerations of the rows fit: each is the integral of the next, from row to row.
#[test]
fn the_motion_drawn_is_the_motion_made() {
    for (name, program) in [("parking", PARKING), ("arcs", ARCS), ("curved", CURVED)] {
        let outcome = run(program, &Config::default()).unwrap();
        let (_, _, motion) = made(program, 100_000.0);
        let columns = COLUMNS * outcome.position_mm.len();
        let rows: Vec<_> = motion.values.chunks_exact(columns).zip(motion.times_s.chunks_exact(2)).collect();
        assert_eq!(rows.len(), motion.kinds.len());
        let program = |row: usize| motion.kinds[row] & Kind::HOMING == 0;
        let pairs = rows.windows(2).enumerate().filter(|(row, pair)| program(*row) && pair[0].1[1] == pair[1].1[0]);
        let mut compared = 0;
        for (row, pair) in pairs {
            let (values, times_s) = pair[0];
            let span_s = times_s[1] - times_s[0];
            for axis in 0..outcome.position_mm.len() {
                let of = |values: &[f32]| -> Vec<f64> {
                    values[axis * COLUMNS..][..COLUMNS].iter().map(|value| f64::from(*value)).collect()
                };
                let ([place, speed, begins, ends], next) = (of(values)[..].try_into().unwrap(), of(pair[1].0));
                let then_mm_s = speed + (begins + ends) / 2.0 * span_s;
                let then_mm = place + speed * span_s + (2.0 * begins + ends) / 6.0 * span_s * span_s;
                let place = (name, row, axis);
                assert!((then_mm - next[0]).abs() < 0.01, "{place:?}: {then_mm} and {} mm", next[0]);
                let is_turn = motion.kinds[row + 1] == Kind::Accelerate as u8;
                assert!(is_turn || (then_mm_s - next[1]).abs() < 0.2, "{place:?}: {then_mm_s} and {} mm/s", next[1]);
                compared += 1;
            }
        }
        assert!(compared > 20, "{name}: {compared}");
        let (last, times_s) = rows[rows.len() - 1];
        let span_s = times_s[1] - times_s[0];
        for (axis, end_mm) in outcome.position_mm.into_iter().enumerate() {
            let [place, speed, begins, ends] = last[axis * COLUMNS..][..COLUMNS].try_into().unwrap();
            let at = |value: f32| f64::from(value);
            let then_mm = at(place) + at(speed) * span_s + (2.0 * at(begins) + at(ends)) / 6.0 * span_s * span_s;
            assert!((then_mm - end_mm).abs() < 0.02, "{name}: {then_mm} and {end_mm} mm");
        }
    }
}

/// Of a trapezoid and of an S-curve, along X.
#[test]
fn a_jerk_is_drawn_as_it_is() {
    let expected: [(&str, &[f64]); 2] = [("", &[0.0; 3]), ("$940=1\n", &[1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])];
    for (settings, expected) in expected {
        let mut job = Job::new(b"G21 G91\nG1 X40 F2400\n", settings).unwrap();
        while !job.advance(job.now_us() + 1e6).unwrap() {}
        let mut motion = job.take_motion();
        let (_, rest, _) = job.end_with().unwrap();
        motion.times_s.extend(rest.times_s);
        motion.values.extend(rest.values);
        let jerks: Vec<_> = (motion.values.chunks_exact(COLUMNS * 3).zip(motion.times_s.chunks_exact(2)))
            .map(|(values, times_s)| f64::from(values[3] - values[2]) / (times_s[1] - times_s[0]))
            .collect();
        let most = jerks.iter().copied().fold(0.0, f64::max);
        let signs: Vec<_> = jerks.iter().map(|jerk| (jerk / most.max(1e-9) * 100.0).round() / 100.0).collect();
        assert_eq!(signs, expected, "{settings:?}: {jerks:?}");
    }
}

#[test]
fn what_cannot_be_is_told_at_its_line() {
    let trouble = |program: &[u8], settings| Job::new(program, settings).err().unwrap();
    let words = "line 2: '?' is a real-time command, obeyed the moment it arrives: take it out of the program";
    assert_eq!(trouble(b"G21\n?\n", ""), Trouble { line: Some(2), words: words.to_owned() });
    assert_eq!(trouble(b"G21\n", "$100=50\n$110=-1\n").line, Some(2));
    let (_, summary, _) = made(b"G21\nG42\nG0 X1\n", 1e6);
    let refusal = &summary["refusals"][0];
    assert_eq!((refusal["line"].as_u64(), refusal["code"].as_u64()), (Some(2), Some(20)));
    assert!(refusal["words"].as_str().unwrap().contains("G42"), "{refusal}");
    assert_eq!(summary["verdicts"][0]["kept"], false);
}

#[test]
fn lines_behind_a_sleep_are_told_of() {
    let mut job = Job::new(b"G0 X1\nG4 P0\n$SLP\nG0 X2\n", "").unwrap();
    while !job.advance(job.now_us() + 1e6).unwrap() {}
    let trouble = job.end().unwrap_err();
    assert_eq!(trouble.line, Some(4), "{trouble}");
}
