//! Runs of a page are those of the simulator, to the byte, and its drawings are where the machine goes.

use isostep_report::{Figures, check};
use isostep_sim::measure::across;
use isostep_sim::program::Program;
use isostep_sim::tool::ToolOutput;
use isostep_sim::{Config, Port, lines_of_moves, run, settings, trace, vcd};
use isostep_web::{About, COLUMNS, End, Job, Kept, Kind, LOAD_PARTS, LOADS, Motion, Trouble, whole};
use serde_json::Value;

const PARKING: &[u8] = include_bytes!("../../../programs/parking.nc");
const ARCS: &[u8] = include_bytes!("../../../programs/arcs.nc");
const ENGRAVING: &[u8] = include_bytes!("../../../programs/engraving.nc");
/// An S-curve, a hold by M0, a dwell, and blends.
const CURVED: &[u8] = b"$940=1\nG21 G91\nG1 X30 Y7 F2400\nM0\nY12\nG4 P0.1\nX-5\n";

/// Its trace, its summary and its motion, taken every so often.
fn made(program: &[u8], every_us: f64) -> (Vec<u8>, Value, Motion) {
    let mut job = Job::new(program, "", Kept::Trace).unwrap();
    let (mut rows, mut motion, mut until_us) = (Vec::new(), Motion::default(), 0.0);
    let mut add = |rows_more: Vec<u8>, more: Motion| {
        rows.extend(rows_more);
        motion.times_s.extend(more.times_s);
        motion.kinds.extend(more.kinds);
        motion.values.extend(more.values);
        motion.changes_mm_s2.extend(more.changes_mm_s2);
    };
    loop {
        until_us += every_us;
        let has_ended = job.advance(until_us).unwrap();
        add(job.take_rows(), job.take_motion());
        if has_ended {
            break;
        }
    }
    let End { summary, motion: more, rows: rest, .. } = job.end().unwrap();
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
        let axes = outcome.position_mm.len();
        let rows: Vec<_> = motion.values.chunks_exact(COLUMNS * axes).zip(motion.times_s.chunks_exact(2)).collect();
        assert_eq!(rows.len(), motion.kinds.len());
        let program = |row: usize| motion.kinds[row] & Kind::HOMING == 0;
        let pairs = rows.windows(2).enumerate().filter(|(row, pair)| program(*row) && pair[0].1[1] == pair[1].1[0]);
        let mut compared = 0;
        for (row, pair) in pairs {
            let (values, times_s) = pair[0];
            let span_s = times_s[1] - times_s[0];
            for axis in 0..axes {
                let of = |values: &[f32]| -> [f64; COLUMNS] {
                    std::array::from_fn(|column| f64::from(values[axis * COLUMNS + column]))
                };
                let ([place, speed, begins], next) = (of(values), of(pair[1].0));
                let change = f64::from(motion.changes_mm_s2[row * axes + axis]);
                let then_mm_s = speed + (begins + change / 2.0) * span_s;
                let then_mm = place + speed * span_s + (3.0 * begins + change) / 6.0 * span_s * span_s;
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
            let [place, speed, begins] = last[axis * COLUMNS..][..COLUMNS].try_into().unwrap();
            let change = motion.changes_mm_s2[(rows.len() - 1) * axes + axis];
            let at = |value: f32| f64::from(value);
            let then_mm = at(place) + at(speed) * span_s + (3.0 * at(begins) + at(change)) / 6.0 * span_s * span_s;
            assert!((then_mm - end_mm).abs() < 0.02, "{name}: {then_mm} and {end_mm} mm");
        }
    }
}

/// Of a trapezoid and of an S-curve, along X.
#[test]
fn a_jerk_is_drawn_as_it_is() {
    let expected: [(&str, &[f64]); 2] = [("", &[0.0; 3]), ("$940=1\n", &[1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])];
    for (settings, expected) in expected {
        let mut job = Job::new(b"G21 G91\nG1 X40 F2400\n", settings, Kept::Nothing).unwrap();
        while !job.advance(job.now_us() + 1e6).unwrap() {}
        let mut motion = job.take_motion();
        let rest = job.end().unwrap().motion;
        motion.times_s.extend(rest.times_s);
        motion.changes_mm_s2.extend(rest.changes_mm_s2);
        let jerks: Vec<_> = (motion.changes_mm_s2.chunks_exact(3).zip(motion.times_s.chunks_exact(2)))
            .map(|(changes, times_s)| f64::from(changes[0]) / (times_s[1] - times_s[0]))
            .collect();
        let most = jerks.iter().copied().fold(0.0, f64::max);
        let signs: Vec<_> = jerks.iter().map(|jerk| (jerk / most.max(1e-9) * 100.0).round() / 100.0).collect();
        assert_eq!(signs, expected, "{settings:?}: {jerks:?}");
    }
}

#[test]
fn what_cannot_be_is_reported_at_its_line() {
    let trouble = |program: &[u8], settings| Job::new(program, settings, Kept::Nothing).err().unwrap();
    let words = "line 2: '?' is a real-time command, obeyed the moment it arrives: take it out of the program";
    assert_eq!(trouble(b"G21\n?\n", ""), Trouble { about: About::Program, line: Some(2), words: words.to_owned() });
    let words = "settings:2: `$110=-1`: $110=-1 is negative";
    let of_settings = trouble(b"G21\n", "$100=50\n$110=-1\n");
    assert_eq!((of_settings.about, of_settings.line), (About::Settings, Some(2)));
    assert!(of_settings.words.starts_with(words), "{of_settings}");
    let (_, summary, _) = made(b"G21\nG42\nG0 X1\n", 1e6);
    let refusal = &summary["refusals"][0];
    assert_eq!((refusal["line"].as_u64(), refusal["code"].as_u64()), (Some(2), Some(20)));
    assert!(refusal["words"].as_str().unwrap().contains("G42"), "{refusal}");
    assert_eq!(summary["verdicts"][0]["kept"], false);
}

#[test]
fn lines_behind_a_sleep_are_reported_of() {
    let mut job = Job::new(b"G0 X1\nG4 P0\n$SLP\nG0 X2\n", "", Kept::Nothing).unwrap();
    while !job.advance(job.now_us() + 1e6).unwrap() {}
    let trouble = job.end().err().unwrap();
    assert_eq!(trouble.line, Some(4), "{trouble}");
}

/// Runs a program to its end, with all that was kept.
fn ended(program: &[u8], settings: &str, kept: Kept) -> (Motion, End) {
    let mut job = Job::new(program, settings, kept).unwrap();
    let mut until_us = 0.0;
    // Not from the present time on: it stands while nothing is due.
    while !job.advance(until_us).unwrap() {
        until_us += 1e5;
    }
    let motion = job.take_motion();
    (motion, job.end().unwrap())
}

#[test]
fn waves_are_the_simulators_to_the_byte() {
    for (program, settings) in [(PARKING, ""), (ENGRAVING, "")] {
        let outcome = run(program, &Config::default()).unwrap();
        let mut expected = Vec::new();
        vcd::write(&outcome.waves, &outcome.tool, outcome.limits_high_at_start, &mut expected).unwrap();
        let (_, end) = ended(program, settings, Kept::Waves);
        assert!(end.rows == expected, "{} of {} bytes", end.rows.len(), expected.len());
    }
}

/// Each section of a move begins with its line, those of a move that is made for several lines too.
#[test]
fn every_time_has_its_line() {
    for program in [PARKING, ENGRAVING] {
        let outcome = run(program, &Config::default()).unwrap();
        let expected: Vec<_> = lines_of_moves::sections(&outcome)
            .iter()
            .map(|section| section.source.map_or(0, |source| source.line as u32))
            .collect();
        let (_, End { lines, .. }) = ended(program, "", Kept::Lines);
        assert_eq!(lines.lines, expected);
        assert!(lines.times_s.is_sorted() && lines.times_s.len() == lines.lines.len());
    }
    let (_, End { lines, .. }) = ended(b"G21 G91\nG1 X10 F600\nG4 P1\nY5\n", "", Kept::Lines);
    assert_eq!(lines.lines, [2, 4]);
    let one_move = b"$32=1\nG21G91\nM4 S500 G1 F600 X-1\nX1\nX2 S0\nX1 S100\nY1\nM5\n";
    let (_, End { lines: merged, .. }) = ended(one_move, "", Kept::Lines);
    assert_eq!(merged.lines, [3, 4, 5, 6, 7]);
    assert!(merged.times_s.len() == 5 && merged.times_s.is_sorted_by(|one, next| one < next), "{merged:?}");
    assert!(lines.times_s[1] - lines.times_s[0] > 2.0, "{lines:?}");
}

#[test]
fn accelerations_are_shares_of_their_limits() {
    let most = |program: &[u8], settings, of: usize| {
        let (motion, end) = ended(program, settings, Kept::Nothing);
        let loads = motion.loads.iter().chain(&end.motion.loads).skip(of).step_by(LOADS);
        f64::from(loads.copied().max().unwrap_or_default()) / LOAD_PARTS
    };
    for speed_profile in ["", "$940=1", "$920=20"] {
        let load = most(b"G91\nG1 X30 Y10 F2400\nY20\nX-5\n", speed_profile, 0);
        assert!((0.98..1.01).contains(&load), "{speed_profile}: {load}");
    }
    assert!(most(b"G91 G1 X100 F600\n", "$120=5", 1) < 1e-3, "intervals of seconds go on from each other");
    let corner: &[u8] = b"G91 G1 X10 F1200\nY10\n";
    assert!(most(corner, "", 1) < 1e-3, "a blend has no jump");
    let jump = most(&[b"G61 ", corner].concat(), "", 1);
    let outcome = run(&[b"G61 ", corner].concat(), &Config::default()).unwrap();
    let expected = across::highest(&outcome).unwrap().ratio;
    assert!((0.7..1.4).contains(&(jump / expected)), "{jump}, by the edges {expected}");
}

#[test]
fn the_tools_power_is_what_its_output_is() {
    let program = b"$32=1\nG21 G91\nM3 S500\nG1 X5 F1200\nX5 S1000\nM5\n";
    let (Motion { power, .. }, _) = ended(program, "", Kept::Nothing);
    let of_output = run(program, &Config::default()).unwrap().tool;
    let expected = of_output.iter().filter(|change| change.output == ToolOutput::Pwm);
    assert_eq!(power.shares, expected.map(|change| change.duty_ratio() as f32).collect::<Vec<_>>());
    for share in [0.5, 1.0] {
        assert!(power.shares.iter().any(|power| (power - share).abs() < 0.01), "{power:?}");
    }
    assert!(power.times_s.is_sorted() && power.shares.last() == Some(&0.0));
}

/// The words of the tool, for a machine with these settings.
#[test]
fn a_check_says_what_the_tool_says() {
    let program = b"G42\nG1 X10 F1200\nG61 Y10\nG0 X900\n";
    let rows: Value = serde_json::from_str(&whole::check(program, "$110=1200\n").unwrap()).unwrap();
    let lines = Program::read(program).unwrap();
    let settings = settings::read("settings", b"$110=1200\n", Port::Pio, Config::default().driver).unwrap();
    let expected = check::rows(&check::Check::of(&lines, &settings, check::Stand::default(), &mut |_| {}), false);
    assert_eq!(rows, serde_json::to_value(&expected).unwrap());
    let row = |name: &str| expected.iter().find(|row| row.name == name).unwrap();
    assert!(row("refused").places[0].starts_with("line 1 `G42`"), "{expected:?}");
    assert!(row("travel").words.contains("line 4"), "{expected:?}");
    let tools = whole::tools(b"(T2 D=6)\nT2 M6\nM6 T3\n").unwrap();
    assert_eq!(tools, r#"[{"line":2,"tool":2,"comment":"D=6"},{"line":3,"tool":3,"comment":null}]"#);
    let rows = whole::check(b"G21\n?\n", "").unwrap();
    assert!(rows.contains("line 2 `?`: '?' is a real-time command"), "{rows}");
}

#[test]
fn a_program_that_computes_is_made_plain() {
    assert_eq!(whole::plain(b"G21\nG1 X1\n").unwrap(), "null");
    let made = whole::plain(b"#1=3\no1 repeat [2]\nG1 X#1 F600\no1 endrepeat\n").unwrap();
    assert_eq!(made, r#"[[3,"G1 X3 F600"],[3,"G1 X3 F600"]]"#);
    assert!(whole::plain(b"G1 X[1/0]\n").unwrap_err().words.contains("line 1"));
}

#[test]
fn a_check_of_a_program_that_is_too_long_for_a_page_is_of_its_lines_alone() {
    let program = [b"G21 G91\n".as_slice(), &b"G1 X0.001 F600\n".repeat(50_000), b"G42\n"].concat();
    let rows = whole::check(&program, "").unwrap();
    assert!(rows.contains("line 50002 `G42`") && rows.contains("X 0.000 to 50.000"), "{rows}");
    assert!(rows.contains("more lines than 50000"), "{rows}");
}

#[test]
fn a_report_has_the_figures_of_the_simulator() {
    let figures = Figures::new("arcs.nc", &run(ARCS, &Config::default()).unwrap());
    assert_eq!(whole::report("arcs.nc", ARCS, "").unwrap(), serde_json::to_string_pretty(&figures).unwrap());
    let trouble = whole::report("long.nc", &b"G1 X1 F600\n".repeat(50_001), "").unwrap_err();
    assert!(trouble.words.contains("50001") && trouble.words.contains("isostep sim"), "{trouble}");
}

/// What a plan draws is what the run draws, and every line moves the machine at the same time.
#[test]
fn a_plan_is_the_run_without_its_edges() {
    for program in [ARCS, ENGRAVING] {
        let [run, plan] = [Kept::Lines, Kept::Plan].map(|kept| {
            let (motion, end) = ended(program, "", kept);
            let values = [motion.values, end.motion.values].concat();
            let times_s = [motion.times_s, end.motion.times_s].concat();
            let changes = [motion.changes_mm_s2, end.motion.changes_mm_s2].concat();
            (values, times_s, changes, end.lines)
        });
        assert!(run.0.len() > 1_000);
        assert!(run == plan);
    }
}

#[test]
fn a_phase_knows_the_speed_that_was_asked_for() {
    let (motion, end) = ended(b"G21 G91 G61\nG1 X10 F1200\nX1 Y1 F600\nG0 X3 Y4\n", "", Kept::Plan);
    let asked = [motion.asked_mm_s, end.motion.asked_mm_s].concat();
    let kinds = [motion.kinds, end.motion.kinds].concat();
    assert_eq!(asked.len(), kinds.len());
    // $111 is 2880 mm/min, and Y has four fifths of the way.
    let expected = [20.0, 10.0, 48.0 / 0.8];
    let mut found = asked.clone();
    found.dedup();
    assert_eq!(found.len(), expected.len(), "{asked:?}");
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-4, "{found} instead of {expected}");
    }
}
