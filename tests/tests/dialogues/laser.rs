//! Laser mode, row by row of the table of the tool in docs/console.md.

use embassy_time::Duration;
use isostep_motion::State;
use isostep_sim::tool::ToolOutput;
use isostep_sim::{MoveRecord, Outcome, Port, Sim};

use crate::talk::{LOOK_US, ON, assert_at, begin, bytes, duty, field, homed, say, state, watch};

const OFF: [u16; 5] = [0; 5];
/// Laser mode is on and the laser is dark.
const DARK: [u16; 5] = [0, ON, 0, 0, 0];
const FULL: [u16; 5] = [ON, ON, 0, 0, 0];
const HALF: [u16; 5] = [32_768, ON, 0, 0, 0];

fn laser() -> Sim {
    let mut sim = homed();
    assert_eq!(say(&mut sim, "$32=1\n$394=3"), ["ok", "ok"]);
    sim
}

/// When a move begins or ends by its plan, ns since power-up.
fn ends_ns(record: &MoveRecord, end: usize) -> u64 {
    let end_s = record.parts.last().unwrap_or(&record.plan).end_s();
    if end == 0 { record.begin_ns() } else { record.start_ns + (end_s * 1e9) as u64 }
}

fn moves(outcome: &Outcome) -> Vec<&MoveRecord> {
    outcome.moves.iter().filter(|record| !record.homing).collect()
}

/// The outputs after each change, without the instants.
fn outputs(changes: &[(u64, [u16; 5])]) -> Vec<[u16; 5]> {
    changes.iter().map(|change| change.1).collect()
}

/// S, M3, M4 and M5 between consecutive moves cost no time: every edge is where it is without them.
#[test]
fn laser_words_between_moves_stop_nothing() {
    let edges = |switches: [&str; 6]| {
        let mut sim = laser();
        let begun_ns = sim.now_ns();
        let [a, b, c, d, e, f] = switches;
        sim.send(format!("{a}G1 X5 F1200\n{b}X10\n{c}X15 Y3\n{d}X20\n{e}G2 X25 I2.5\n{f}G1 X30 Y3\n").as_bytes());
        sim.run_until_idle().unwrap();
        assert!(sim.replies().iter().all(|answer| answer == "ok"));
        let edges = sim.outcome().edges.into_iter().filter(|edge| edge.t_ns > begun_ns);
        edges.map(|edge| (edge.t_ns - begun_ns, edge.axis, edge.direction)).collect::<Vec<_>>()
    };
    let plain = edges([""; 6]);
    assert!(plain.len() > 1_500, "{}", plain.len());
    assert!(plain == edges(["M3\nS500\n", "S100\n", "M4 S0\n", "M5\n", "M3 S900\n", "M5\nM4\n"]), "they took time");
    assert!(plain == edges(["M4 S1000 ", "S1 ", "M3 ", "M5 ", "M4 ", "S20 "]), "on the lines of the moves");
}

/// The level is constant during feed moves. The laser is dark between runs, in rapids and at rest. Every
/// change is on time.
#[test]
fn m3_of_a_laser_shines_evenly_while_it_feeds() {
    let mut sim = laser();
    assert_eq!(say(&mut sim, "M3 S1000"), ["ok"]);
    assert_eq!(sim.tool(), DARK);
    sim.send(b"G1 X5 F600\nG0 X10\nG1 X15 S500\nX20\nG4 P0.2\nX15\n");
    let changes = watch(&mut sim, Duration::from_secs(5));
    assert_eq!(outputs(&changes), [FULL, DARK, HALF, DARK, HALF, DARK]);
    let outcome = sim.outcome();
    let moves = moves(&outcome);
    assert_eq!((moves.len(), &moves[2].marks_steps[..]), (4, &[250][..]), "X20 goes straight on");
    for (change, (index, end)) in changes.iter().zip([(0, 0), (0, 1), (2, 0), (2, 1), (3, 0), (3, 1)]) {
        assert_at(change.0, ends_ns(moves[index], end), &format!("move {index}, {:?}", change.1));
    }
    assert_eq!(field(&mut sim, "FS"), "0,0");
    // There was no other level in between, not even for an instant.
    let levels = outcome.tool.iter().filter(|change| change.output == ToolOutput::Pwm).map(|change| change.duty);
    assert_eq!(levels.collect::<Vec<_>>(), [FULL, DARK, HALF, DARK, HALF, DARK].map(|outputs| outputs[0]));
}

/// The speed along the path according to the plan of the current move, mm/s.
fn speed_mm_s(outcome: &Outcome, t_ns: u64) -> Option<f64> {
    let under_way = |record: &&MoveRecord| (record.begin_ns()..ends_ns(record, 1)).contains(&t_ns);
    let record = moves(outcome).into_iter().find(under_way)?;
    let t_s = (t_ns - record.start_ns) as f64 * 1e-9;
    let part = record.parts.iter().rfind(|part| part.begin_s() <= t_s).unwrap_or(&record.plan);
    let path_mm = record.plan.steps.iter().map(|steps| (f64::from(*steps) / 50.0).powi(2)).sum::<f64>().sqrt();
    Some(part.speed_at(t_s) * path_mm / record.plan.distance_steps())
}

/// At every instant, ramps and corners included, the level is proportional to the ratio of the speed to the feed.
#[test]
fn m4_of_a_laser_follows_the_speed() {
    for speed_profile in 0..7 {
        let mut sim = laser();
        assert_eq!(say(&mut sim, &format!("$910=60\n$911=60\n$912=60\n$940={speed_profile}\nM4 S800")), ["ok"; 5]);
        sim.send(b"G1 X10 F1200\nX14 Y3\nX10 Y8\n");
        let mut looks = Vec::new();
        while looks.len() < 100 || sim.machine().state() == State::Run {
            sim.run_for(Duration::from_micros(200)).unwrap();
            looks.push((sim.now_ns(), f64::from(sim.tool()[0]) / f64::from(ON)));
        }
        sim.run_until_idle().unwrap();
        assert_eq!(sim.tool(), DARK);
        let outcome = sim.outcome();
        let speeds = looks.iter().filter_map(|&(t_ns, level)| Some((level, speed_mm_s(&outcome, t_ns)?)));
        let off = speeds.map(|(level, speed_mm_s)| (level - 0.8 * speed_mm_s / 20.0).abs()).collect::<Vec<_>>();
        let highest = off.iter().copied().fold(0.0, f64::max);
        assert!(off.len() > 6_000, "{} looks", off.len());
        assert!(highest < 0.004, "speed profile {speed_profile}: {highest} off");
        let brightest = looks.iter().map(|look| look.1).fold(0.0, f64::max);
        assert!((0.3..0.801).contains(&brightest), "speed profile {speed_profile}: {brightest}");
    }
}

/// M4: at half the feed the laser has half the level. An override of the level multiplies it.
#[test]
fn overrides_of_a_laser() {
    for (mode, at_half) in [("M4", 0.25), ("M3", 0.5)] {
        let mut sim = laser();
        begin(&mut sim, &format!("{mode} S500\nG1 X60 F600"), Duration::from_secs(1));
        assert_eq!((sim.tool()[0], field(&mut sim, "FS").as_str()), (duty(0.5), "600,500"), "{mode}");
        bytes(&mut sim, &[0x92; 5]);
        sim.run_for(Duration::from_secs(1)).unwrap();
        assert!(sim.tool()[0].abs_diff(duty(at_half)) <= 1, "{mode}: {:?}", sim.tool());
        let before_ns = sim.now_ns();
        sim.send(&[0x9A; 5]);
        let changes = watch(&mut sim, Duration::from_millis(1));
        assert_eq!(changes.len(), 1, "{changes:?}");
        assert_at(changes[0].0, before_ns, mode);
        assert!(sim.tool()[0].abs_diff(duty(at_half * 1.5)) <= 1, "{mode}: {:?}", sim.tool());
        assert_eq!(field(&mut sim, "FS"), format!("300,{:.0}", at_half * 1_500.0));
    }
}

/// While the laser brakes its level follows the speed. It is off at standstill and on again after the resume.
#[test]
fn a_held_laser_is_off() {
    for mode in ["M3", "M4"] {
        let mut sim = laser();
        begin(&mut sim, &format!("{mode} S1000\nG1 X60 F600"), Duration::from_secs(1));
        assert_eq!(sim.tool(), FULL);
        sim.send(b"!");
        let changes = watch(&mut sim, Duration::from_secs(1));
        assert_eq!(changes.last().unwrap().1, OFF);
        if mode == "M3" {
            assert!(changes.len() <= 2, "{changes:?}");
        }
        assert_eq!(state(&mut sim), "Hold:0");
        bytes(&mut sim, b"\x9E");
        assert_eq!(sim.tool(), OFF, "0x9E lights no laser");
        sim.send(b"~");
        let resumed_us = sim.now().as_micros();
        let changes = watch(&mut sim, Duration::from_secs(1));
        assert!(changes[0].0 - resumed_us < 50_000 && sim.tool() == FULL, "no spin-up: {changes:?}");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.tool(), DARK);
        // M0 acts like a hold.
        sim.replies();
        assert_eq!(say(&mut sim, "M0"), [""; 0]);
        assert_eq!(sim.tool(), OFF);
        assert_eq!(bytes(&mut sim, b"~"), ["ok"]);
        assert_eq!(sim.tool(), DARK);
    }
}

/// M5 after moves: the laser stays on until they end and is then off, unless M3 comes before that. Coolant has no
/// effect on it.
#[test]
fn m5_of_a_laser_lets_the_moves_before_it_shine() {
    for (behind, expected) in [("", &[FULL, DARK, OFF][..]), ("M3\n", &[FULL, DARK])] {
        let mut sim = laser();
        sim.send(format!("M3 S1000\nG1 X5 F600\nM5\nG1 X10\n{behind}").as_bytes());
        let changes = watch(&mut sim, Duration::from_secs(2));
        assert_eq!(outputs(&changes), expected, "{behind:?}");
        let outcome = sim.outcome();
        assert_at(changes[1].0, ends_ns(moves(&outcome)[0], 1), "dark behind M5");
    }
    let mut sim = laser();
    begin(&mut sim, "M3 S1000\nG1 X5 F600\nM5", Duration::from_millis(300));
    bytes(&mut sim, b"\xA0");
    assert_eq!(sim.tool(), [ON, ON, 0, ON, 0]);
    sim.run_until_idle().unwrap();
    assert_eq!(sim.tool(), [0, 0, 0, ON, 0], "M5 still counts");
}

#[test]
fn a_line_that_ends_the_program_keeps_its_move_lit() {
    let mut sim = laser();
    sim.send(b"M4 S1000\nG1 X5 F600\nX10 M30\n");
    let changes = watch(&mut sim, Duration::from_secs(3));
    assert_eq!(sim.replies(), ["ok", "ok", "[MSG:Pgm End]", "ok"]);
    let lit: Vec<_> = changes.iter().filter(|change| change.1[0] > 0).collect();
    let outcome = sim.outcome();
    let last_ns = ends_ns(moves(&outcome)[1], 1);
    assert_eq!(sim.tool(), OFF);
    assert!(changes.last().unwrap().0 * 1_000 >= last_ns - 3_000_000, "{:?}", changes.last());
    assert!(last_ns - lit.last().unwrap().0 * 1_000 < 25_000_000, "lit to the end");
}

/// An arc of many chords, with either port.
#[test]
fn an_arc_is_lit_without_a_gap() {
    for port in Port::ALL {
        let mut sim = crate::talk::powered_up(&isostep_sim::Config { port, ..Default::default() });
        assert_eq!(say(&mut sim, "$32=1\nM3 S500\nG1 F1200"), ["ok"; 3]);
        sim.send(b"G2 X0 Y0 I10 J0\n");
        let changes = watch(&mut sim, Duration::from_secs(5));
        assert_eq!(outputs(&changes), [HALF, DARK]);
        let lit_s = (changes[1].0 - changes[0].0) as f64 * 1e-6;
        assert!((lit_s - sim.outcome().motion_s).abs() < 3.0 * LOOK_US as f64 * 1e-6, "{lit_s} s");
    }
}
