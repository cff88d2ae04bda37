//! Random chains whose corners are blends.

use isostep_profile::chain::{Chain, ChainConfig, Effort, Request};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile};
use isostep_trials::cases;
use oorandom::Rand32;
use proptest::prelude::*;

use super::bent::drive;
use super::case::{Case, case, trapezoid};
use super::drive::{holds, overrides, pushes};

/// Moves at whose corners the path may leave by some hundredths of a millimetre, or not at all; some say how much of them is for the
/// blend where they begin.
pub fn bent(most: usize) -> impl Strategy<Value = Case> {
    let deviation = prop_oneof![1 => Just(0.0f32), 4 => (1e-3f32.ln()..0.3f32.ln()).prop_map(f32::exp)];
    let jumps = prop::bool::weighted(0.1);
    let blend_s = prop_oneof![1 => Just(0.0), 1 => (1e-4f64.ln()..3e-2f64.ln()).prop_map(f64::exp)];
    let offset = || prop_oneof![1 => Just(0), 2 => -64..=64i8];
    let share = prop_oneof![2 => Just(0.0), 1 => 0.1..0.9f64];
    let beside = prop::collection::vec((deviation, [offset(), offset(), offset()], share), most);
    (case(trapezoid(), most), beside, jumps, blend_s).prop_map(|(mut case, beside, jumps, blend_s)| {
        (case.effort.straight_s, case.effort.blend_s) = (0.6 * blend_s, blend_s);
        if !jumps {
            case.limits.iter_mut().for_each(|limits| limits.start_speed_steps_s = 0.0);
        }
        let length_mm = |steps: &[i32; 3]| {
            let squares = steps.iter().zip(case.mm_per_step).map(|(&steps, mm)| (f64::from(steps) * mm).powi(2));
            squares.sum::<f64>().sqrt()
        };
        for (one, (deviation_mm, offsets, share)) in case.moves.iter_mut().zip(beside) {
            (one.deviation_mm, one.offsets, one.reach_mm) =
                (deviation_mm, offsets, (share * length_mm(&one.steps)) as f32);
        }
        case
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(1_000, 10_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn pushes_are_bent(case in bent(40), events in pushes()) {
        drive::<8>(&case, &events)?;
    }

    #[test]
    fn holds_are_bent(case in bent(40), events in holds()) {
        drive::<8>(&case, &events)?;
    }

    #[test]
    fn overrides_are_bent(case in bent(40), events in overrides()) {
        drive::<8>(&case, &events)?;
    }
}

/// Brief moves to and fro at high accelerations come one by one, far ahead of their time: each corner is a blend, although a
/// corner that comes later may be slower than what was final before.
#[test]
fn no_blend_is_left_out_because_its_move_came_later() {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 32e3,
        accel_steps_s2: 8e5,
        decel_steps_s2: 8e5,
        jerk_steps_s3: f64::INFINITY,
    };
    let effort = Effort { blend_s: 0.98e-3, ..Effort::NONE };
    let mm_per_step = [1.0 / 80.0; 2];
    let config = || ChainConfig::new([limits; 2], mm_per_step, 0.01, IntervalSplit::Fastest, SpeedProfile::Trapezoid);
    for seed in 0..40 {
        let mut random = Rand32::new(seed);
        let mut chain = Chain::<2, 16>::new(config().with_effort(effort));
        let (mut moves, mut blends, mut steps, mut parts) = (0, 0, [0; 2], [0; 2]);
        while moves < 400 {
            while !chain.is_full() {
                // To the next place, in parts of a step: 3 steps on, and some to either side.
                let side = 128 * [1, -1][moves % 2] * random.rand_range(1..5) as i32 + random.rand_range(0..64) as i32;
                parts = [parts[0] + 358 + random.rand_range(0..16) as i32, parts[1] + side];
                let whole = parts.map(|parts| (parts + 64).div_euclid(128));
                let offsets = [0, 1].map(|axis| (parts[axis] - 128 * whole[axis]) as i8);
                let request = Request {
                    steps: [whole[0] - steps[0], whole[1] - steps[1]],
                    offsets,
                    feed_mm_s: Some(100.0),
                    stops: false,
                    deviation_mm: 0.01,
                    reach_mm: 0.0,
                    least_s: 0.0,
                    tag: moves as u64,
                };
                chain.push(request).unwrap();
                (steps, moves) = (whole, moves + 1);
            }
            blends += usize::from(chain.advance(f64::INFINITY).unwrap().plan.blend().is_some());
        }
        while let Some(chunk) = chain.advance(f64::INFINITY) {
            blends += usize::from(chunk.plan.blend().is_some());
        }
        assert_eq!(blends, moves - 1, "seed {seed}");
    }
}
