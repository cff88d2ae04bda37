//! Arcs lie on their circle, from the edges: they are few sides outside of it, of which blends make it.

use std::f64::consts::{PI, TAU};

use embassy_time::Duration;
use isostep_motion::{AXES, State};
use isostep_sim::measure::across;
use isostep_sim::{Config, Outcome, Sim, run, verify};

const CENTRE_MM: [f64; 2] = [30.0, 20.0];
const BOX_10_MS: &str = "$950=5\n$951=5\n$960=100\n$961=100\n";
const ZV_40_HZ: &str = "$950=1\n$951=1\n$960=40\n$961=40\n";

/// A fast machine with this resolution.
fn machine(steps_per_mm: f32) -> Config {
    let mut config = Config::default();
    config.settings.steps_per_mm = [steps_per_mm; AXES];
    config.settings.max_rate_mm_min = [12_000.0; AXES];
    config.settings.accel_mm_s2 = [2_000.0; AXES];
    config
}

/// Checks every promise, and every axis's acceleration from its edges.
fn judge(what: &str, outcome: &Outcome) {
    for verdict in verify::verdicts(outcome, &verify::moves(outcome).collect()) {
        assert!(verdict.kept, "{what}: {} {}", verdict.promise, verdict.detail);
    }
    let most = across::highest(outcome);
    assert!(most.is_none_or(|window| window.ratio < 1.02), "{what}: {most:?}");
}

/// What such a machine makes of a program.
fn made(steps_per_mm: f32, program: &str) -> Outcome {
    let outcome = run(program.as_bytes(), &machine(steps_per_mm)).unwrap();
    assert!(outcome.refusals.is_empty() && outcome.state == State::Idle, "{program}: {:?}", outcome.refusals);
    judge(program, &outcome);
    outcome
}

/// The places of X and Y where either of them makes a step, half of which is made by then, mm; only where both go on.
fn places_mm(outcome: &Outcome, first: usize, steps_per_mm: f64) -> Vec<[f64; 2]> {
    struct Passed {
        t_ns: u64,
        direction: i32,
        mm: f64,
    }
    let of_axis = |axis: usize| {
        let edges = outcome.edges[first..].iter().filter(move |edge| edge.axis == axis);
        edges.map(|edge| {
            let mm = (f64::from(edge.position_steps) - 0.5 * f64::from(edge.direction)) / steps_per_mm;
            Passed { t_ns: edge.t_ns, direction: edge.direction, mm }
        })
    };
    let mut places = Vec::new();
    for axis in [0, 1] {
        let mut own = of_axis(axis).peekable();
        for pair in of_axis(1 - axis).collect::<Vec<_>>().windows(2) {
            while let Some(edge) = own.next_if(|edge| edge.t_ns < pair[1].t_ns) {
                if edge.t_ns < pair[0].t_ns || pair[0].direction != pair[1].direction {
                    continue;
                }
                let share = (edge.t_ns - pair[0].t_ns) as f64 / (pair[1].t_ns - pair[0].t_ns) as f64;
                let mut place = [edge.mm; 2];
                place[1 - axis] = pair[0].mm + share * (pair[1].mm - pair[0].mm);
                // The axis that changes the radius is where it is said to be, and the other is fast.
                if (place[axis] - CENTRE_MM[axis]).abs() >= (place[1 - axis] - CENTRE_MM[1 - axis]).abs() {
                    places.push(place);
                }
            }
        }
    }
    places
}

/// By how much these places are outside of a circle, mm: on the average, and farthest.
fn off_mm(places: &[[f64; 2]], radius_mm: f64) -> [f64; 2] {
    assert!(places.len() > 30, "{} places", places.len());
    let off = |place: &[f64; 2]| (place[0] - CENTRE_MM[0]).hypot(place[1] - CENTRE_MM[1]) - radius_mm;
    let sum: f64 = places.iter().map(off).sum();
    [sum / places.len() as f64, places.iter().map(|place| off(place).abs()).fold(0.0, f64::max)]
}

/// A circle, clockwise from its right, with a line along it at either end. Returns what was done, the number of its moves, and
/// the places on it.
fn circle(steps_per_mm: f32, radius_mm: f64, before: &str, feed: u32) -> (Outcome, usize, Vec<[f64; 2]>) {
    let right_mm = CENTRE_MM[0] + radius_mm;
    let program = format!("{before}G0 X{right_mm} Y25\nG1 Y20 F{feed}\nG2 X{right_mm} Y20 I-{radius_mm}\nG1 Y15\n");
    let outcome = made(steps_per_mm, &program);
    let sides = outcome.moves.len() - 4;
    let is_on_it = |place: &[f64; 2]| place[0] < right_mm - 2e-4 * radius_mm;
    let first = outcome.moves[2].edges.start;
    let places = places_mm(&outcome, first, steps_per_mm.into()).into_iter().filter(is_on_it).collect();
    (outcome, sides, places)
}

/// Circles' radii, mm, with the number of their sides at F12000 and at F1200, and at F120 with 80 and 1,000 steps/mm.
const CIRCLES: [(f64, usize, [usize; 2]); 3] = [(10.0, 74, [157, 314]), (1.0, 24, [31, 32]), (0.2, 12, [12, 12])];

#[test]
fn circles_have_the_radius_that_is_asked_for() {
    for (index, steps_per_mm) in [80.0, 1_000.0].into_iter().enumerate() {
        for (radius_mm, sides, slow_sides) in CIRCLES {
            for (feed, sides) in [(12_000, sides), (1_200, sides), (120, slow_sides[index])] {
                let (_, found, places) = circle(steps_per_mm, radius_mm, "", feed);
                let [mean_mm, most_mm] = off_mm(&places, radius_mm);
                let what = format!(
                    "{steps_per_mm} steps/mm, radius {radius_mm}, F{feed}: {found} sides, {mean_mm} mm, {most_mm} at most"
                );
                println!("{what}");
                assert_eq!(found, sides, "{what}");
                // At 80 steps/mm the path is inside where it enters and leaves, by `$12` at most.
                let may_mm = if steps_per_mm > 100.0 { [0.000_1, 0.000_4] } else { [0.000_2, 0.002] };
                assert!(mean_mm.abs() < may_mm[0] && most_mm < may_mm[1], "{what}");
            }
        }
    }
}

/// A circle of 10 mm is taken in about the same time whatever the resolution and the shaper are, because its sides are few: with a box
/// at most a third longer, because each side lasts as long as the chip needs for its steps.
#[test]
fn shapers_do_not_make_circles_slow() {
    for steps_per_mm in [80.0, 1_000.0] {
        let [plain_s, zv_s, box_s] =
            ["", ZV_40_HZ, BOX_10_MS].map(|before| circle(steps_per_mm, 10.0, before, 12_000).0.motion_s);
        println!("{steps_per_mm} steps/mm: {plain_s:.3} s, {zv_s:.3} s with ZV, {box_s:.3} s with a box");
        assert!(plain_s < 0.88 && zv_s < plain_s + 0.02 && box_s < 1.333 * plain_s, "{plain_s} {zv_s} {box_s}");
    }
}

/// An arc of 20 degrees, and one whose radius grows by 0.009 mm: the path goes evenly from one radius to the other.
#[test]
fn short_arcs_and_spirals_are_where_they_should_be() {
    let outcome = made(1_000.0, "G0 X40 Y25\nG1 Y20 F6000\nG2 X39.396926 Y16.579799 I-10\nG1 X39 Y15.5\n");
    assert_eq!(outcome.moves.len(), 8);
    let first = outcome.moves[2].edges.start;
    let is_on_it = |place: &[f64; 2]| place[1] < 20.0 && place[1] > 16.58;
    let places: Vec<_> = places_mm(&outcome, first, 1_000.0).into_iter().filter(is_on_it).collect();
    // It brakes there.
    assert!(off_mm(&places, 10.0)[1] < 0.001, "{:?}", off_mm(&places, 10.0));

    let outcome = made(1_000.0, "G0 X40 Y25\nG1 Y20 F6000\nG2 X19.991 Y20 I-10\nG1 Y25\n");
    let first = outcome.moves[2].edges.start;
    for place in places_mm(&outcome, first, 1_000.0).iter().filter(|place| place[1] < 20.0 && place[0] < 39.9) {
        let [right_mm, up_mm] = [0, 1].map(|axis| place[axis] - CENTRE_MM[axis]);
        let wanted_mm = 10.0 + 0.009 * (-up_mm).atan2(right_mm) / PI;
        assert!(
            (right_mm.hypot(up_mm) - wanted_mm).abs() < 0.000_5,
            "{place:?}: {} mm",
            right_mm.hypot(up_mm) - wanted_mm
        );
    }
}

/// Z rises evenly with the angle: where it makes its steps, X and Y are as far round.
#[test]
fn a_helix_rises_evenly() {
    let outcome = made(400.0, "G0 X40 Y20\nG3 X40 Y20 Z9 I-10 F3000\n");
    let mut places_steps = [0; AXES];
    let mut farthest = 0.0_f64;
    for edge in &outcome.edges {
        places_steps[edge.axis] = edge.position_steps;
        if edge.axis == 2 {
            let [right_mm, up_mm] = [0, 1].map(|axis| f64::from(places_steps[axis]) / 400.0 - CENTRE_MM[axis]);
            let turned = up_mm.atan2(right_mm).rem_euclid(TAU) / TAU;
            let risen = (f64::from(edge.position_steps) - 0.5) / 3_600.0;
            let off = (turned - risen + 0.5).rem_euclid(1.0) - 0.5;
            farthest = farthest.max(off.abs());
        }
    }
    // Half a step of X and Y is a fifty-thousandth of a turn, and that of Z a seven-thousandth.
    assert!(farthest * 3_600.0 < 0.6, "{} steps of Z", farthest * 3_600.0);
}

/// Without blends the path would go to the vertices: an arc is of chords then, on the circle.
#[test]
fn without_blends_arcs_are_of_chords() {
    for before in ["G61", "$904=0", "$900=1", "$940=1", "$910=60"] {
        let program = format!("{before}\nG0 X40 Y20\nG2 X20 Y20 I-10 F1200\n");
        let outcome = run(program.as_bytes(), &machine(80.0)).unwrap();
        assert_eq!(outcome.moves.len(), 1 + 79, "{before}");
        for record in &outcome.moves[1..] {
            let [x_mm, y_mm, _] = record.next_corner_steps().map(|steps| f64::from(steps) / 80.0);
            let off_mm = (x_mm - CENTRE_MM[0]).hypot(y_mm - CENTRE_MM[1]) - 10.0;
            assert!(off_mm.abs() < 0.009, "{before}: {off_mm}");
        }
    }
}

/// A hold comes to rest within the deviation of the circle, and goes on to what the circle would have been.
#[test]
fn a_hold_on_an_arc_stays_by_it() {
    for at_ms in (400..1_600).step_by(41) {
        let mut sim = Sim::new(&machine(400.0));
        sim.send(b"G0 X40 Y25\nG1 Y20 F3000\nG2 X40 Y20 I-10\nG1 Y15\n");
        sim.run_for(Duration::from_millis(at_ms)).unwrap();
        sim.send(b"!");
        sim.run_until_state(|state| !matches!(state, State::Run | State::Hold { still: false })).unwrap();
        let [x_mm, y_mm, _] = sim.counted_steps().map(|steps| f64::from(steps) / 400.0);
        let off_mm = (x_mm - CENTRE_MM[0]).hypot(y_mm - CENTRE_MM[1]) - 10.0;
        let is_on_it = y_mm < 20.0 && x_mm < 39.9;
        assert!(!is_on_it || (-0.003..0.012).contains(&off_mm), "at {at_ms} ms: {off_mm} mm");
        sim.send(b"~");
        sim.run_until_idle().unwrap();
        assert_eq!(sim.counted_steps(), [16_000, 6_000, 0], "at {at_ms} ms");
        judge(&format!("a hold at {at_ms} ms"), &sim.outcome());
    }
}
