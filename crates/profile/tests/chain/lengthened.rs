//! Moves that go straight on and lengthen the move before them: what holds for a single move holds for the longer one,
//! and nothing is slower for it.

use isostep_profile::chain::{Chain, ChainConfig, Chunk, Effort, Request};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile};
use isostep_trials::cases;
use proptest::prelude::*;

use super::bent;
use super::blends;
use super::case::{AXES, Case, case, curved, line, trapezoid};
use super::drive::{drive_lengthened, overrides, pushes};

/// A case of which about half of the moves go straight on at the feed of the one before, and no time is needed for a
/// move at constant speed.
fn straighter(speed_profile: impl Strategy<Value = SpeedProfile>) -> impl Strategy<Value = Case> {
    let at_once = |case: Case| Case { effort: Effort { straight_s: 0.0, ..case.effort }, ..case };
    straightened(case(speed_profile, 30)).prop_map(at_once)
}

fn straightened(all: impl Strategy<Value = Case>) -> impl Strategy<Value = Case> {
    let goes_on = prop::collection::vec(prop_oneof![Just(None), (1..5i32).prop_map(Some)], 30);
    (all, goes_on).prop_map(|(mut case, goes_on)| {
        (case.effort.step_s, case.effort.move_s, case.effort.shaped_root_step_s) = (0.0, 0.0, 0.0);
        let mut unit = case.moves[0].steps;
        for (index, goes_on) in goes_on.iter().enumerate().take(case.moves.len()).skip(1) {
            match goes_on {
                Some(times) => {
                    let Request { feed_mm_s, .. } = case.moves[index - 1];
                    let steps = unit.map(|steps| steps * times);
                    case.moves[index] = Request { steps, offsets: [0; 3], feed_mm_s, ..case.moves[index] };
                }
                None => unit = case.moves[index].steps,
            }
        }
        case
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(500, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_lengthened_trapezoid_keeps_to_what_it_knows(case in straighter(trapezoid()), events in pushes()) {
        drive_lengthened::<8>(&case, &events)?;
    }

    #[test]
    fn a_lengthened_trapezoid_is_held_and_takes_on_other_speeds(case in straighter(trapezoid()), events in overrides()) {
        drive_lengthened::<64>(&case, &events)?;
    }

    #[test]
    fn lengthened_moves_are_bent(case in straightened(blends::bent(30)), events in overrides()) {
        bent::drive_lengthened::<8>(&case, &events)?;
    }

    /// All moves are known before the first begins. Each place is passed no later than without lengthening.
    #[test]
    fn no_place_is_passed_later(case in straighter(trapezoid())) {
        let [plain, lengthened] = [false, true].map(|lengthens| ends(&case, lengthens));
        prop_assert_eq!(plain.len(), lengthened.len());
        for (index, (plain_s, lengthened_s)) in plain.into_iter().zip(lengthened).enumerate() {
            prop_assert!(lengthened_s <= plain_s * (1.0 + 1e-6) + 1e-6, "move {index}: {lengthened_s} for {plain_s} s");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(200, 2_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_lengthened_curved_speed_profile_is_held_and_takes_on_other_speeds(case in straighter(curved()), events in overrides()) {
        drive_lengthened::<64>(&case, &events)?;
    }
}

/// When each of the moves asked for ends, s from the beginning of the first one.
fn ends(case: &Case, lengthens: bool) -> Vec<f64> {
    let mut chain = Chain::<AXES, 32>::new(case.config());
    // The number of the move in the chain that each belongs to, and where in it it ends.
    let (mut places, mut last) = (Vec::new(), 0);
    for request in &case.moves {
        let steps = request.steps.map(i32::unsigned_abs).into_iter().max().unwrap();
        if lengthens && chain.lengthen(request, |tag, _| Some(tag)) {
            last += steps;
        } else {
            chain.push(Request { tag: chain.len() as u64, ..*request }).unwrap();
            last = steps;
        }
        places.push((chain.len() as u64 - 1, f64::from(last)));
    }
    let mut chunks: Vec<Chunk<AXES>> = Vec::new();
    while let Some(chunk) = chain.advance(f64::INFINITY) {
        chunks.push(chunk);
    }
    let time_s = |&(tag, place): &(u64, f64)| {
        let chunk = chunks.iter().rfind(|chunk| chunk.tag == tag && line(chunk).begin_steps() < place).unwrap();
        line(chunk).time_at(place)
    };
    places.iter().map(time_s).collect()
}

/// Moves of 100 steps/mm at 10 mm/s and 100 mm/s².
fn config(speed_profile: IntervalSplit, effort: Effort) -> ChainConfig<2> {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 1e3,
        accel_steps_s2: 1e4,
        decel_steps_s2: 1e4,
        jerk_steps_s3: f64::INFINITY,
    };
    ChainConfig::new([limits; 2], [0.01; 2], 0.01, speed_profile, SpeedProfile::Trapezoid).with_effort(effort)
}

fn request(steps: [i32; 2]) -> Request<2> {
    Request { feed_mm_s: Some(5.0), ..Request::new(steps) }
}

/// True if the second move lengthens the first.
fn is_one([first, second]: [Request<2>; 2], config: ChainConfig<2>) -> bool {
    let mut chain = Chain::<2, 2>::new(config);
    chain.push(first).unwrap();
    chain.lengthen(&second, |tag, _| Some(tag))
}

#[test]
fn only_what_goes_straight_on_at_the_same_feed_lengthens_a_move() {
    let plain = || config(IntervalSplit::Fastest, Effort::NONE);
    let first = request([20, -10]);
    for (steps, expected) in [
        ([2, -1], true),
        ([40, -20], true),
        ([-20, 10], false),
        ([20, -11], false),
        ([20, 0], false),
        ([0, -10], false),
    ] {
        assert_eq!(is_one([first, request(steps)], plain()), expected, "{steps:?}");
    }
    assert!(is_one([request([0, 3]), request([0, 1])], plain()));
    let long = request([10_000_000, 0]);
    assert!(!is_one([long, request([1, 0])], plain()), "it might last too long");
    let others = [
        Request { feed_mm_s: Some(5.1), ..first },
        Request { feed_mm_s: None, ..first },
        Request { stops: true, ..first },
    ];
    for other in others {
        assert!(!is_one([first, other], plain()) && !is_one([other, first], plain()), "{other:?}");
    }
    assert!(!is_one([first; 2], config(IntervalSplit::Thirds, Effort::NONE)), "each is divided into thirds");
    assert!(!is_one([first; 2], config(IntervalSplit::Fastest, Effort { move_s: 1e-3, ..Effort::NONE })));
}

/// A move that has begun is committed as it is: what follows is another one, also while the chain is held within it.
#[test]
fn a_move_that_has_begun_is_not_lengthened() {
    let mut chain = Chain::<2, 4>::new(config(IntervalSplit::Fastest, Effort::NONE));
    chain.push(request([100, 0])).unwrap();
    chain.advance(0.1).unwrap();
    let lengthens = |chain: &mut Chain<2, 4>| chain.lengthen(&request([10, 0]), |_, place| Some(u64::from(place)));
    assert!(!lengthens(&mut chain));
    chain.hold();
    while chain.advance(0.1).is_some() {}
    assert!(chain.is_at_rest() && !lengthens(&mut chain));
    chain.push(request([10, 0])).unwrap();
    assert!(lengthens(&mut chain) && lengthens(&mut chain), "the one after it is");
    chain.start();
    let mut made = Vec::new();
    while let Some(chunk) = chain.advance(f64::INFINITY) {
        made.push((line(&chunk).steps[0], chunk.tag));
    }
    made.dedup();
    assert_eq!(made, [(100, 0), (30, 20)]);
}

/// The highest speed of moves by a caller that needs some time for each.
fn cruise_steps_s(effort: Effort, moves: &[[i32; 2]], lengthens: bool) -> f64 {
    let bent = |steps| Request { deviation_mm: 0.05, ..request(steps) };
    let mut chain = Chain::<2, 32>::new(config(IntervalSplit::Fastest, effort));
    for &steps in moves {
        if !(lengthens && chain.lengthen(&bent(steps), |tag, _| Some(tag))) {
            chain.push(bent(steps)).unwrap();
        }
    }
    let mut fastest_steps_s = 0.0_f64;
    while let Some(chunk) = chain.advance(f64::INFINITY) {
        if let Some(line) = chunk.plan.line().filter(|line| line.steps[0] != 0) {
            fastest_steps_s = fastest_steps_s.max(line.profile.cruise_speed_steps_s());
        }
    }
    fastest_steps_s
}

/// Moves of 10 steps: each lasts a second, and so do 16 of them that are one.
#[test]
fn what_goes_straight_on_needs_its_time_once() {
    let effort = Effort { straight_s: 1.0, ..Effort::NONE };
    let straight = [[10, 0]; 16];
    assert_eq!(cruise_steps_s(effort, &straight, false), 10.0);
    assert_eq!(cruise_steps_s(effort, &straight, true), 160.0);
    assert_eq!(cruise_steps_s(Effort { blend_s: 9.0, ..effort }, &straight, true), 160.0, "no blend leads to it");
    let round = [&[[0, 1], [0, -1]], &straight[..]].concat();
    assert_eq!(cruise_steps_s(Effort { blend_s: 2.0, ..effort }, &round, true), 80.0, "one does");
}

/// Moves of 10 steps: under a speed profile with which a move that a blend leads to lasts a second, straight ones go on at their
/// feed.
#[test]
fn what_goes_straight_on_needs_no_time_for_a_blend() {
    let effort = Effort { blend_s: 1.0, ..Effort::NONE };
    let cruise_steps_s = |moves: &[[i32; 2]], lengthens: bool| cruise_steps_s(effort, moves, lengthens);
    let straight = [[10, 0]; 16];
    for lengthens in [false, true] {
        assert_eq!(cruise_steps_s(&straight, lengthens), 500.0, "lengthened: {lengthens}");
    }
    // A blend leads to the third, which lasts a second, alone and where others lengthen it.
    let round = [&[[0, 1], [0, -1]], &straight[..]].concat();
    assert_eq!(cruise_steps_s(&round[..3], true), 10.0);
    assert_eq!(cruise_steps_s(&round, true), 160.0);
    // Each leads to the next.
    let bends: Vec<_> = (0..16).map(|k| [10 * i32::from(k > 0), 1 + k % 2]).collect();
    assert!(cruise_steps_s(&bends, true) < 11.0);
}
