//! A circle whose sides meet in blends is taken at an even acceleration, v²/r, and keeps its radius.

use isostep_motion::{AXES, State};
use isostep_profile::Blend;
use isostep_sim::{Config, Sim};

const CENTRE_MM: [f64; 2] = [30.0, 20.0];
const RADIUS_MM: f64 = 10.0;
/// v²/r is 46.9 mm/s² at this feed; X and Y have 50 mm/s² by default.
const FEED_MM_S: f64 = 1_300.0 / 60.0;
const DEVIATION_MM: f64 = 0.01;
/// Of `$12`: how far the path may be from the arc.
const ARC_MM: f64 = 0.002;

/// The size of what X and Y have, in steps of `steps_per_mm`, mm.
fn size_mm(of: impl Fn(usize) -> f64, steps_per_mm: f64) -> f64 {
    of(0).hypot(of(1)) / steps_per_mm
}

#[test]
fn a_circle_is_even_and_round() {
    for steps_per_mm in [50.0, 400.0] {
        let mut sim = Sim::new(&Config::default());
        sim.run_until_idle().unwrap();
        let settings = format!("$100={steps_per_mm}\n$101={steps_per_mm}\n$910=0\n$911=0\n$904={DEVIATION_MM}\n");
        let circle = "G17 G64\nG0 X40 Y20\nG2 X40 Y20 I-10 F1300\nG2 X40 Y20 I-10\n";
        sim.send(format!("{settings}{circle}").as_bytes());
        sim.run_until_idle().unwrap();
        assert_eq!(sim.machine().state(), State::Idle, "{:?}", sim.replies());
        let outcome = sim.outcome();

        let is_at_feed = |blend: &&Blend<AXES>| {
            [blend.begin_s(), blend.end_s()].iter().all(|t_s| {
                let along_mm_s = size_mm(|axis| blend.speed_at(axis, *t_s), steps_per_mm);
                (along_mm_s / FEED_MM_S - 1.0).abs() < 1e-3
            })
        };
        let asked_mm_s2 = FEED_MM_S * FEED_MM_S / RADIUS_MM;
        let ratio_of = |blend: &Blend<AXES>| size_mm(|axis| blend.accel_steps_s2(axis), steps_per_mm) / asked_mm_s2;
        // Where the circles meet the path bends less.
        let meet_steps = [40.0, 20.0, 0.0].map(|mm| (mm * steps_per_mm) as i32);
        let pairs = outcome.moves.windows(2);
        let (meetings, others): (Vec<_>, Vec<_>) = pairs
            .filter_map(|pair| Some((pair[0].next_corner_steps() == meet_steps, pair[1].blend?)))
            .filter(|(_, blend)| is_at_feed(&blend))
            .partition(|(meets, _)| *meets);
        let [meetings, ratios] =
            [meetings, others].map(|of| of.iter().map(|(_, blend)| ratio_of(blend)).collect::<Vec<_>>());
        assert!(meetings.len() == 1 && (0.9..1.0).contains(&meetings[0]), "{meetings:?}");
        let (least, most) = ratios.iter().fold((f64::MAX, 0.0), |(least, most), x| (x.min(least), x.max(most)));
        println!("{steps_per_mm} steps/mm: {} blends, {least:.4} to {most:.4} of v²/r", ratios.len());
        assert!(ratios.len() > 120 && least > 0.98 && most < 1.02, "{least} to {most}");

        let mut place_mm = [0.0; AXES];
        let mut farthest_mm = 0.0f64;
        // The first side begins in the corner behind the rapid.
        let circle_begins = outcome.moves[2].edges.start;
        for (index, edge) in outcome.edges.iter().enumerate() {
            place_mm[edge.axis] = f64::from(edge.position_steps) / steps_per_mm;
            if index >= circle_begins {
                let from_centre = size_mm(|axis| place_mm[axis] - CENTRE_MM[axis], 1.0);
                farthest_mm = farthest_mm.max((from_centre - RADIUS_MM).abs());
            }
        }
        // Right after its edge an axis is half a step ahead.
        let promised_mm = DEVIATION_MM + ARC_MM + 0.5f64.hypot(0.5) / steps_per_mm;
        println!("{steps_per_mm} steps/mm: radius off by {farthest_mm:.4} mm at most, {promised_mm:.4} promised");
        assert!(farthest_mm <= promised_mm, "{farthest_mm} mm");
    }
}
