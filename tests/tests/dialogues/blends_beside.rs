//! Motions that blends leave as they are, to the edge: homing, probes, single moves, moves from rest to rest, jogs; and what
//! follows the path round them: the modes, the speed that is reported, the laser.

use embassy_time::Duration;
use isostep_motion::{AXES, Axis, State};
use isostep_sim::measure::across;
use isostep_sim::plate::Plate;
use isostep_sim::{Config, Outcome, Sim, run};

use crate::talk::{ON, field, homed, powered_up, say};

/// The edges of a program without anything before its first, ns, and what the machine has said.
fn made(program: &str) -> (Vec<(u64, usize, i32)>, Vec<String>) {
    let config = Config { plate: Some(Plate { axis: Axis::Z, place_mm: 30.0, is_below: false }), ..Config::default() };
    let outcome = run(program.as_bytes(), &config).unwrap();
    assert!(outcome.refusals.is_empty() && outcome.state == State::Idle, "{program}: {:?}", outcome.refusals);
    let first_ns = outcome.edges[0].t_ns;
    let edges = outcome.edges.iter().map(|edge| (edge.t_ns - first_ns, edge.axis, edge.direction));
    (edges.collect(), outcome.said.iter().map(|said| said.text.clone()).collect())
}

/// Every edge of a program with `$904` is where it is with G61. A line more must not shift anything, so both have one.
#[track_caller]
fn assert_same(what: &str, program: &str) {
    let [with, without] = ["G64", "G61"].map(|mode| made(&format!("$904=0.05\n{mode}\n{program}")));
    assert!(with.0.len() > 1_000, "{what}: {} edges", with.0.len());
    assert!(with == without, "{what}: blends change it");
}

#[test]
fn what_has_no_corner_is_the_same_to_the_edge_with_blends_and_without() {
    assert_same("homing", "$H\n");
    assert_same("a probe", "$H\nG38.2 Z60 F300\nG4 P0\nG38.4 Z0 F60\n");
    assert_same("thirds", "$900=1\nG1 F1200 X20 Y3\nY20\nG2 X30 Y30 I10\nG0 X0 Y0\n");
    assert_same("single moves", "G1 F1200 X20.013 Y3.007\nG4 P0\nY20.004\nG4 P0\nG0 X1 Y2 Z3\nG4 P0\nX0\n");
    assert_same("exact stops", "G61.1 G1 F1200 X20.013 Y3.007\nX20 Y20.004\nX0\n");
    assert_same("straight on", "G1 F1200 X5\nX10\nX10.5\nG0 X30\n");
    assert_same("a curved speed profile", "$940=1\nG1 F1200 X20\nY20\nX0\n");
    assert_same("a start speed", "$910=60\n$911=60\nG1 F1200 X20\nY20\nX0\n");
}

/// G61 and G64 are a program's: jogs take their corners by `$904`.
#[test]
fn jogs_are_the_same_to_the_edge_with_g64_and_g61() {
    assert_same("jogs", "$J=X20 F1200\n$J=Y20 F1200\n$J=G91 X-5 Y3 F1200\n");
}

/// The same program with corners differs, so that the comparison could tell.
#[test]
fn what_has_corners_differs() {
    let [with, without] = ["G64", "G61"].map(|mode| made(&format!("$904=0.05\n{mode}\nG1 F1200 X20\nY20\nX0\n")));
    assert_eq!(with.0.len(), without.0.len());
    assert!(with != without);
}

/// A probe and a homing cycle between moves with blends: the moves before them end at rest, at their place.
#[test]
fn a_probe_comes_to_its_contact_after_blends() {
    let (edges, said) = made("$904=0.05\n$H\nG1 F1200 X20\nY20\nX10\nG38.2 Z60 F300\nG1 F1200 Z10\nX5\nY5\n");
    assert!(edges.len() > 1_000 && said.iter().any(|text| text == "[PRB:10.000,20.000,28.000:1]"), "{said:?}");
}

/// Each corner is as the block says that begins there.
#[test]
fn modes_take_turns_block_by_block() {
    const MODES: [&str; 4] = ["G61", "G64 P0.2", "G61.1", "G64"];
    let lines = (0..16_usize).map(|k| {
        let [x, y] = [k / 2 + 1, k.div_ceil(2)].map(|at| at * 5);
        format!("{} X{x} Y{}\n", MODES[k % 4], y + 5)
    });
    let program = format!("$904=0.1\nG1 F1200 Y5\n{}", lines.collect::<String>());
    let outcome = run(program.as_bytes(), &Config::default()).unwrap();
    assert_eq!((outcome.moves.len(), outcome.refusals.len()), (17, 0));
    for (k, pair) in outcome.moves.windows(2).enumerate() {
        let exit_steps_s = pair[0].parts.last().unwrap_or(&pair[0].plan).profile.exit_speed_steps_s();
        // A block that stops ends at rest, whatever the next one says.
        let stops = k > 0 && MODES[(k - 1) % 4] == "G61.1";
        let blends = MODES[k % 4].starts_with("G64") && !stops;
        assert_eq!(pair[1].blend.is_some(), blends, "corner {k}: {}", MODES[k % 4]);
        assert_eq!(exit_steps_s == 0.0, stops, "corner {k}: {exit_steps_s} steps/s");
    }
}

/// With exact stops an arc's chords are blends by `$904`, and it ends in a stop, at a whole step.
#[test]
fn an_arc_with_exact_stops_is_smooth_and_ends_at_rest() {
    let program = "$904=0.005\nG61.1 G1 F1200 X10\nG2 X20.013 Y10.007 I10\nG1 X30\n";
    let outcome = run(program.as_bytes(), &Config::default()).unwrap();
    let (line, chords) = (&outcome.moves[0], &outcome.moves[1..outcome.moves.len() - 1]);
    assert_eq!(line.plan.profile.exit_speed_steps_s(), 0.0);
    assert!(chords.len() > 20 && chords[1..].iter().all(|chord| chord.blend.is_some()), "{} chords", chords.len());
    let end = chords[chords.len() - 1].plan;
    let last = chords[chords.len() - 1].parts.last().unwrap_or(&end);
    assert_eq!(last.profile.exit_speed_steps_s(), 0.0);
    assert!(last.axis_place(0, last.distance_steps()).fract() == 0.0, "{last:?}");
    assert!(across::highest(&outcome).unwrap().ratio < 1.02);
}

/// Where the path goes straight back, the machine goes to the place and stops there.
#[test]
fn a_path_that_goes_straight_back_stops_at_its_end() {
    for back in ["X0 Y0", "X10 Y5", "X5 Y2.5"] {
        let program = format!("G64 P0.2\nG1 F1200 X20 Y10\n{back}\n");
        let outcome = run(program.as_bytes(), &Config::default()).unwrap();
        assert!(outcome.moves.iter().all(|record| record.blend.is_none()), "{back}");
        assert_eq!(outcome.moves[0].end_steps, [1_000, 500, 0], "{back}");
        assert_eq!(outcome.moves[0].plan.profile.exit_speed_steps_s(), 0.0, "{back}");
    }
}

#[test]
fn the_mode_of_corners_is_listed() {
    let mut sim = powered_up(&Config::default());
    let listed = |sim: &mut Sim, line: &str| {
        assert_eq!(say(sim, line).last_line(), "ok", "{line}");
        let heard = say(sim, "$G");
        let words: Vec<_> = heard[0].split([' ', ':', ']']).filter(|word| word.starts_with("G6")).collect();
        words.join(" ")
    };
    for (line, word) in [
        ("$$", "G64"),
        ("$904=0", ""),
        ("G64 P0.1", "G64"),
        ("G61", ""),
        ("G61.1", "G61.1"),
        ("G64 P0", ""),
        ("$904=0.1", "G61"),
        ("G64", "G64"),
        ("G61", "G61"),
        ("G61.1", "G61.1"),
        ("M2", "G64"),
        ("G64 P0", "G61"),
        ("M30", "G64"),
    ] {
        assert_eq!(listed(&mut sim, line), word, "after {line}");
    }
}

/// The true speed along the path, from the plans, mm/s: in a blend, of all axes.
fn speed_mm_s(outcome: &Outcome, t_ns: u64) -> Option<(f64, bool)> {
    let record = outcome.moves.iter().rfind(|record| !record.homing && record.begin_ns() <= t_ns)?;
    let t_s = (t_ns - record.start_ns) as f64 * 1e-9;
    let length = |steps: [f64; AXES]| steps.iter().map(|steps| (steps / 50.0).powi(2)).sum::<f64>().sqrt();
    if let Some(blend) = record.blend.filter(|blend| t_s < blend.end_s()) {
        return Some((length(std::array::from_fn(|axis| blend.speed_at(axis, t_s))), true));
    }
    let part = record.parts.iter().rfind(|part| part.begin_s() <= t_s).unwrap_or(&record.plan);
    let speed_steps_s = if t_s < part.end_s() { part.speed_at(t_s) } else { part.profile.exit_speed_steps_s() };
    let way = std::array::from_fn(|axis| record.plan.axis_steps(axis));
    (t_s <= record.plan_s).then_some((speed_steps_s * length(way) / record.plan.distance_steps(), false))
}

/// The feed of each line of a path, mm/s.
fn feeds_mm_s(path: &str) -> Vec<f64> {
    let mut feed_mm_s = 0.0;
    let feed_of = |line: &str| {
        let word = line.split(' ').find_map(|word| word.strip_prefix('F'));
        feed_mm_s = word.map_or(feed_mm_s, |feed| feed.parse::<f64>().unwrap() / 60.0);
        feed_mm_s
    };
    path.lines().map(feed_of).collect()
}

/// The index of the move that is under way. The next begins where the corner is, in the middle of a blend.
fn move_at(outcome: &Outcome, t_ns: u64) -> Option<usize> {
    let program: Vec<_> = outcome.moves.iter().filter(|record| !record.homing).collect();
    program.iter().rposition(|record| {
        let corner_s = record.blend.map_or(record.begin_s(), |blend| blend.end_s() - blend.corner_s() / 2.0);
        record.start_ns as f64 + corner_s * 1e9 <= t_ns as f64
    })
}

/// Wide corners, one of them sharp.
const CORNERS: &str = "G1 F1200 X10\nY10\nX3 Y4\nX20 Y6\nX26 Y0\nX10\n";
/// Half a circle, of chords, and corners before and behind it.
const ROUND: &str = "G1 F1200 X10\nY10\nG2 X26 I8\nG1 X26 Y0\nX10\n";

/// A small half circle: its chords are brief.
const BRIEF: &str = "G1 F1200 X10\nY10\nX3 Y4\nX20 Y6\nG2 X26 I3\n";

/// `FS:` is the true speed along the path in blends, too.
#[test]
fn the_speed_that_is_reported_in_a_blend_is_the_true_one() {
    let reported = [CORNERS, ROUND, BRIEF].map(reported_truly);
    let (in_blends, slow) = reported.iter().fold((0, 0), |sum, reported| (sum.0 + reported.0, sum.1 + reported.1));
    assert!(in_blends > 60 && slow > 3, "{in_blends} in blends, {slow} of them slow");
}

/// Asks for the speed all over a path. Returns how often it was in a blend, and how often of these it was slow.
fn reported_truly(path: &str) -> (usize, usize) {
    let mut sim = powered_up(&Config::default());
    sim.send(format!("G64 P1\n{path}").as_bytes());
    let mut reported = Vec::new();
    for _ in 0..1_200 {
        sim.run_for(Duration::from_micros(5_300)).unwrap();
        let asked_ns = sim.now_ns();
        let speed = field(&mut sim, "FS");
        if sim.machine().state() == State::Run {
            reported.push((asked_ns, speed.split(',').next().unwrap().parse::<f64>().unwrap() / 60.0));
        }
    }
    let outcome = sim.outcome();
    let (mut in_blends, mut slow) = (0, 0);
    for (t_ns, reported_mm_s) in reported {
        let Some((mm_s, in_blend)) = speed_mm_s(&outcome, t_ns) else { continue };
        // It is reported within the millisecond after, rounded to 1 mm/min, and a chunk is known up to 15 ms late.
        assert!(
            (reported_mm_s - mm_s).abs() < 0.016 * 50.0 * 2.0_f64.sqrt() + 0.02,
            "{reported_mm_s} mm/s reported for {mm_s}"
        );
        in_blends += usize::from(in_blend);
        slow += usize::from(in_blend && mm_s < 5.0);
    }
    (in_blends, slow)
}

/// Half a circle whose chords' feeds take turns, which none of them comes to.
const UNEVEN: &str = "G1 F1200 X10\nX10.3 Y0.1 F6000\nX10.6 Y0.3 F9000\nX10.8 Y0.5 F6000\nX11 Y0.8 F9000\nX11.1 Y1.1 \
    F6000\nX11.15 Y1.5 F9000\nX11.15 Y6 F6000\nX10 Y8 F3000\nX5 F2000\n";

/// M4: the level is as the true speed along the path is to the feed, in blends as on lines. At a corner the feed changes
/// in the middle of the blend.
#[test]
fn the_level_of_a_laser_follows_the_true_speed_round_blends() {
    for path in [CORNERS, ROUND, UNEVEN] {
        let mut sim = homed();
        assert_eq!(say(&mut sim, "$32=1\n$394=3\nG64 P1\nM4 S800").len(), 4);
        sim.send(path.as_bytes());
        let mut looks = Vec::new();
        while looks.len() < 100 || sim.machine().state() == State::Run {
            sim.run_for(Duration::from_micros(200)).unwrap();
            looks.push((sim.now_ns(), f64::from(sim.tool()[0]) / f64::from(ON)));
        }
        let outcome = sim.outcome();
        let (feeds, mut highest, mut in_blends) = (feeds_mm_s(path), [0.0_f64; 2], 0);
        for (t_ns, level) in looks {
            let Some((mm_s, in_blend)) = speed_mm_s(&outcome, t_ns) else { continue };
            let off = &mut highest[usize::from(in_blend)];
            // The chords of an arc are moves, and its feed is that of all lines.
            let feed_mm_s = move_at(&outcome, t_ns).and_then(|index| feeds.get(index)).unwrap_or(&feeds[0]);
            *off = off.max((level - 0.8 * mm_s / feed_mm_s).abs());
            in_blends += usize::from(in_blend);
        }
        println!("the level is off by at most {highest:?} on lines and in blends, in {in_blends} looks");
        assert!(in_blends > 500, "{in_blends} looks in blends");
        assert!(highest.iter().all(|off| *off < 0.006), "{highest:?} off on lines and in blends");
    }
}
