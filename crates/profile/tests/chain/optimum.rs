//! If all moves are known before the first begins, every one begins and ends as fast as limits and corners allow.

use isostep_profile::chain::{Chain, ChunkKind, Effort};
use isostep_trials::cases;
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

use super::case::{AXES, Case, case, curved, line, trapezoid};
use super::follow::Follower;
use super::model::{Ends, Move, OverrideRatios, fastest};

pub fn is_the_fastest(case: &Case) -> TestCaseResult {
    let mut chain = Chain::<AXES, 64>::new(case.config());
    for request in &case.moves {
        chain.push(*request).unwrap();
    }
    let moves: Vec<Move> = case.moves.iter().map(|request| Move::new(case, *request, OverrideRatios::ALL)).collect();
    let speeds = fastest(case, &moves, None);
    let mut follower = Follower::new(case);
    let top_mm_s: f64 =
        case.limits.iter().zip(case.mm_per_step).map(|(limits, mm)| limits.top_speed_steps_s * mm).sum();
    let unit = 1e-9 * top_mm_s;
    // The square up to which a block may change its speed is kept in fewer digits.
    let coarse_square = if case.effort == Effort::NONE { 0.0 } else { 1e-8 * top_mm_s * top_mm_s };
    let mut chunks = 0;
    while let Some(chunk) = chain.advance(f64::INFINITY) {
        follower.follow(chunk)?;
        prop_assert_eq!(chunk.kind, ChunkKind::Move);
        let Ends { entry, exit, .. } = speeds[chunk.tag as usize];
        for (speed, square) in
            [(line(&chunk).profile.entry_speed_steps_s(), entry), (line(&chunk).profile.exit_speed_steps_s(), exit)]
        {
            let (speed, expected) = (speed * chunk.mm_per_step, square.sqrt());
            // Near standstill the units of squares are larger than this fraction.
            prop_assert!(
                (speed - expected).abs() <= 1e-6 * expected + unit || (speed * speed - square).abs() <= coarse_square,
                "move {}: {speed} for {expected}",
                chunk.tag
            );
        }
        chunks += 1;
    }
    prop_assert_eq!(chunks, case.moves.len());
    prop_assert!(chain.is_at_rest());
    follower.ends(case.moves.len() - 1)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(1_000, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn moves_known_beforehand_are_as_fast_as_can_be(case in case(trapezoid(), 20)) {
        is_the_fastest(&case)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(200, 2_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn curved_ones_are_as_fast_as_their_gains_allow(case in case(curved(), 20)) {
        is_the_fastest(&case)?;
    }
}
