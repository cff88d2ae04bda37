//! Shaped runs keep their promises, and a fault in one is reported.

use embassy_time::Duration;
use isostep_console::Settings;
use isostep_motion::Finish;
use isostep_report::compare::compare;
use isostep_report::{Figures, pictures};
use isostep_sim::measure::across;
use isostep_sim::swarm::judge;
use isostep_sim::verify::shaped;
use isostep_sim::{AXES, Config, Outcome, Port, Sim, run};
use isostep_trials::{cases_that_count, window};
use oorandom::Rand64;

/// Numbers of the shapers in the settings: ZV, MZV, ZVD, EI.
const KINDS: std::ops::RangeInclusive<u16> = 1..=5;
/// Corners of all kinds, an axis that turns, an arc and a way back.
const CORNERS: &str = "G1 X10 F6000\nX20 Y8\nX5 Y3\nG2 X13 Y7 I4 J2\nG1 X13.2 Y6.9\nX13.1\nX0 Y0 Z-2\n";

/// Corners between steps and half way between two, where an axis may stand for a move; and back.
const HALVES: &str = "G1 X10 F6000 Y5.00625\nX20.00625\nY9.003\nX3\nY2.00625 X6.00625\nX14\nX0 Y0 Z-2\n";

/// 2,000 mm/s2 on every axis, and a shaper of this kind on X and Y.
fn machine(kind: u16, port: Port) -> Config {
    let mut settings = Settings {
        steps_per_mm: [80.0; AXES],
        max_rate_mm_min: [if port == Port::Pio { 12_000.0 } else { 3_000.0 }; AXES],
        accel_mm_s2: [2_000.0; AXES],
        soft_limits: false,
        junction_deviation_mm: 0.01,
        ..Settings::DEFAULT
    };
    (settings.shaper_kind[0], settings.shaper_kind[1]) = (kind, kind);
    (settings.shaper_hz[0], settings.shaper_hz[1]) = (40.0, 35.0);
    Config { settings, port, ..Config::default() }
}

fn made(kind: u16, port: Port, program: &str) -> Outcome {
    run(program.as_bytes(), &machine(kind, port)).unwrap()
}

/// The promises that are broken.
fn broken(outcome: &Outcome) -> Vec<String> {
    Figures::new("test", outcome).broken().map(|verdict| format!("{}: {}", verdict.promise, verdict.detail)).collect()
}

#[test]
fn programs_keep_all_promises() {
    for port in Port::ALL {
        for rule in ["G61", "G64 P0.05", "G61.1"] {
            for kind in KINDS {
                let outcome = made(kind, port, &format!("{rule}\n{CORNERS}G4 P0.1\nX3\n"));
                assert_eq!(broken(&outcome), [""; 0], "{port}, {rule}, kind {kind}");
                assert_eq!(shaped::runs(&outcome).count(), 2, "{port}, {rule}, kind {kind}");
            }
        }
    }
}

/// Holds, resumes, overrides, jogs and resets at random instants. Case by case the kind of the shapers is another, and the
/// rule at corners.
#[test]
fn orders_at_any_instant_lose_nothing() {
    let (mut held, mut stopped) = (0, 0);
    for case in window(cases_that_count(40, 400)) {
        let mut random = Rand64::new(case.into());
        let port = if case % 3 == 2 { Port::Timer } else { Port::Pio };
        let mut sim = Sim::new(&machine(1 + (case % 4) as u16, port));
        sim.send(if case % 8 < 4 { b"G61\n" } else { b"G64 P0.05\n" });
        for _ in 0..2 {
            sim.send(if case % 5 < 2 { HALVES } else { CORNERS }.as_bytes());
            for _ in 0..random.rand_range(1..6) {
                sim.run_for(Duration::from_micros(random.rand_range(0..300_000))).unwrap();
                let orders: [&[u8]; 7] =
                    [b"!", b"~", b"\x92\x92\x92", b"\x91\x91", b"\x90", b"\x97", b"$J=G91 X-3 Y1.3 F3000\n"];
                sim.send(orders[random.rand_range(0..orders.len() as u64) as usize]);
            }
            sim.send(b"~");
            if random.rand_range(0..3) == 0 {
                sim.send(b"\x18");
                sim.run_for(Duration::from_secs(1)).unwrap();
                sim.send(b"$X\n$J=G91 X4 Y-2 F6000\n");
                sim.run_for(Duration::from_micros(random.rand_range(0..200_000))).unwrap();
                sim.send(b"\x85");
            }
            sim.run_for(Duration::from_secs(3)).unwrap();
            sim.send(b"~");
            sim.run_until_idle().unwrap();
        }
        let outcome = sim.outcome();
        assert_eq!(judge::steps(&outcome), Ok(()), "case {case}");
        let finishes = |finish: Finish| outcome.moves.iter().filter(|record| record.finish == finish).count();
        (held, stopped) = (held + finishes(Finish::Held), stopped + finishes(Finish::Stopped));
    }
    println!("{held} runs were held, {stopped} stopped");
    assert!(held >= 20, "only {held} runs were held");
}

/// At 11,250 steps/s2 the brake from 60 ms on ends at 40.5 steps. Whether the step there is made is what the motion counts, for
/// an axis that is only late, too.
#[test]
fn a_hold_that_ends_half_way_between_two_steps_counts_as_planned() {
    let mut config = machine(0, Port::Pio);
    config.settings.steps_per_mm[1] = 50.0;
    config.settings.accel_mm_s2[1] = 225.0;
    config.settings.shaper_kind[2] = 2;
    for line in [b"G0 Y16\n", b"G0 Y-9\n"] {
        let mut sim = Sim::new(&config);
        sim.send(line);
        sim.run_for(Duration::from_millis(5)).unwrap();
        sim.send(b"!");
        sim.run_for(Duration::from_secs(1)).unwrap();
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        let outcome = sim.outcome();
        assert!((outcome.moves[0].held_at_steps - 40.5).abs() < 1e-9, "{:?}", outcome.moves[0]);
        assert_eq!(broken(&outcome), [""; 0]);
    }
}

/// What is slower than the start speed rests at once, in the middle of its plan.
#[test]
fn a_hold_of_a_slow_move_ends_its_plan() {
    let mut config = machine(2, Port::Pio);
    config.settings.start_rate_mm_min = [60.0; AXES];
    let mut sim = Sim::new(&config);
    sim.send(b"G1 X5 Y2 F50\n");
    sim.run_for(Duration::from_millis(1_234)).unwrap();
    sim.send(b"!");
    sim.run_for(Duration::from_secs(1)).unwrap();
    sim.send(b"~");
    sim.run_until_idle().unwrap();
    let outcome = sim.outcome();
    assert_eq!(outcome.moves[0].finish, Finish::Held);
    assert_eq!(broken(&outcome), [""; 0]);
}

/// The promises that are broken once the edges of a good run have been changed.
fn broken_by(change: impl Fn(&mut Outcome)) -> Vec<String> {
    let mut outcome = made(4, Port::Pio, &format!("G64 P0.05\n{CORNERS}"));
    assert_eq!(broken(&outcome), [""; 0]);
    change(&mut outcome);
    broken(&outcome)
}

/// Removes an edge, as if it had not been made.
fn remove(outcome: &mut Outcome, index: usize) {
    outcome.edges.remove(index);
    for record in &mut outcome.moves {
        record.edges.start -= usize::from(record.edges.start > index);
        record.edges.end -= usize::from(record.edges.end > index);
    }
}

#[test]
fn an_edge_beside_its_instant_is_reported() {
    let off = |ns: i64| {
        broken_by(|outcome| {
            for index in [700, 701, 702, 703] {
                outcome.edges[index].t_ns = outcome.edges[index].t_ns.checked_add_signed(ns).unwrap();
            }
        })
    };
    for ns in [-24, 24] {
        let reported = off(ns);
        assert!(reported.len() == 1 && reported[0].starts_with("every step at its instant: at most "), "{reported:?}");
    }
}

#[test]
fn a_missing_edge_is_reported() {
    for index in [0, 700] {
        let reported = broken_by(|outcome| remove(outcome, index));
        assert!(
            reported.iter().any(|reported| reported.starts_with("step counts exact: 0 of 1 shaped runs; a step of ")),
            "{reported:?}"
        );
    }
    // The last edge: nothing after it is late.
    let reported = broken_by(|outcome| remove(outcome, outcome.edges.len() - 1));
    assert!(reported[0].starts_with("step counts exact: 0 of 1 shaped runs; a step of "), "{reported:?}");
}

/// An edge out and its edge back where an axis turns: the counts before and after, and all other instants, are right.
#[test]
fn a_turn_that_is_missing_is_reported() {
    let reported = broken_by(|outcome| {
        let of_x: Vec<_> = (0..outcome.edges.len()).filter(|index| outcome.edges[*index].axis == 0).collect();
        let pair = of_x.windows(2).find(|pair| outcome.edges[pair[0]].direction != outcome.edges[pair[1]].direction);
        let [out, back] = [0, 1].map(|at| pair.unwrap()[at]);
        remove(outcome, back);
        remove(outcome, out);
    });
    assert!(
        reported.len() == 1 && reported[0].starts_with("step counts exact: 0 of 1 shaped runs; a step of X"),
        "{reported:?}"
    );
}

#[test]
fn a_last_count_that_is_one_off_is_reported() {
    let reported = broken_by(|outcome| {
        let mut last = *outcome.edges.last().unwrap();
        last.t_ns += 100_000;
        outcome.edges.push(last);
        outcome.moves.last_mut().unwrap().edges.end += 1;
    });
    assert!(
        reported.iter().any(|reported| reported.starts_with("step counts exact: 0 of 1 shaped runs")),
        "{reported:?}"
    );
}

/// A laser is late as the axes are: each level begins where its line does, and shines on the path alone.
#[test]
fn a_beam_is_late_as_the_axes_are() {
    let outcome = made(1, Port::Pio, "$32=1\nG91 G1 F600 M3 S500\nX5\nG0 X5\nG1 S1000\nX5\nY5\nM5\n");
    assert_eq!(broken(&outcome), [""; 0]);
    let beam = Figures::new("test", &outcome).tool.unwrap().beam.unwrap();
    assert!((beam.path_mm - 15.0).abs() < 1e-3 && beam.still_s < 1e-5, "{beam:?}");
    let beginnings = beam.beginnings.unwrap();
    assert!(beginnings.total == 3 && beginnings.most_us < 1.0, "{beginnings:?}");
}

/// The acceleration over whole runs keeps its limit where all corners are blends, and no slice of the path loses any of it.
#[test]
fn whole_runs_are_measured_where_the_axes_are() {
    for kind in KINDS {
        let outcome = made(kind, Port::Pio, &format!("G64 P0.05\n{CORNERS}"));
        let highest = across::highest(&outcome).unwrap();
        assert!((0.9..across::WITHIN).contains(&highest.ratio), "kind {kind}: {highest:?}");
        let most = across::slices(&outcome).map(|slice| slice.ratio).fold(0.0, f64::max);
        assert_eq!(most, highest.ratio, "kind {kind}");
    }
}

/// Another machine's trace of a shaped run is held against the closed form of the whole run.
#[test]
fn a_trace_of_a_shaped_run_is_compared_with_its_closed_form() {
    let outcome = made(4, Port::Pio, &format!("G64 P0.05\n{CORNERS}"));
    let mut trace = outcome.edges.clone();
    let found = compare(&outcome, &trace).unwrap();
    assert_eq!(found.all.steps, trace.len());
    assert!(found.all.max_ns < 2.0 * Port::Pio.tolerance_ns(), "{:?}", found.all);
    trace[700].t_ns += 9_000;
    let late_ns = compare(&outcome, &trace).unwrap().all.max_ns;
    assert!((8_900.0..9_100.0).contains(&late_ns), "{late_ns}");
}

/// The pictures of moves, and of the path by its edges, are those of the moves.
#[test]
fn the_page_has_what_shaping_costs_and_what_rings_without_it() {
    let config = Config { springs: "X:40:0.05".parse().unwrap(), ..machine(1, Port::Pio) };
    let outcome = run(b"G1 X10 F6000\nY10\n", &config).unwrap();
    let mut figures = Figures::new("test", &outcome);
    figures.ringing_unshaped = figures.ringing.clone();
    let page = pictures::page(&outcome, &pictures::BothRules::of(&outcome, None), &figures).html();
    assert!(page.contains(">Shaping</h2>") && page.contains("s more for 1 stop, "), "{page}");
    assert!(page.contains(">without shapers, for comparison</td>"));
}
