//! The rest that a shaper's impulses leave of a load's vibration.

use core::f64::consts::TAU;

use isostep_profile::shaper::{EI_TOLERANCE, Impulses, Shaper, ShaperKind};

/// The rest that rounding may leave.
const SAME: f64 = 1e-12;

const KINDS: [ShaperKind; 4] = [ShaperKind::Zv, ShaperKind::Mzv, ShaperKind::Zvd, ShaperKind::Ei];
const RATIOS: [f64; 4] = [0.0, 0.02, 0.1, 0.5];

fn shaper(kind: ShaperKind, natural_hz: f64, damping_ratio: f64) -> Shaper {
    let shaper = Shaper { kind, natural_hz, damping_ratio };
    assert_eq!(shaper.check(), Ok(()));
    shaper
}

/// The weights and the delays; of a box, which is a mean over all delays from its first to its last, many of them.
fn parts(impulses: &Impulses) -> Vec<(f64, f64)> {
    const PARTS: u32 = 10_000;
    if impulses.box_ends_s().is_none() {
        return impulses.iter().collect();
    }
    let delay_s = |part: u32| (f64::from(part) + 0.5) / f64::from(PARTS) * impulses.last_s();
    (0..PARTS).map(|part| (1.0 / f64::from(PARTS), delay_s(part))).collect()
}

/// The swing of a load when the last impulse has passed, as a fraction of its swing after one alone.
fn left(impulses: &Impulses, natural_hz: f64, damping_ratio: f64) -> f64 {
    let fades_s = TAU * natural_hz * damping_ratio;
    let turns_s = TAU * natural_hz * (1.0 - damping_ratio * damping_ratio).sqrt();
    let swings = parts(impulses).into_iter().fold([0.0, 0.0], |[cos, sin], (weight, delay_s)| {
        let kept = weight * (-fades_s * (impulses.last_s() - delay_s)).exp();
        [cos + kept * (turns_s * delay_s).cos(), sin + kept * (turns_s * delay_s).sin()]
    });
    swings[0].hypot(swings[1])
}

#[test]
fn weights_add_up_to_one_and_delays_ascend_from_zero() {
    for kind in ShaperKind::ALL {
        for damping_ratio in RATIOS {
            let impulses: Vec<_> = shaper(kind, 35.0, damping_ratio).impulses().iter().collect();
            let sum: f64 = impulses.iter().map(|(weight, _)| weight).sum();
            assert!((sum - 1.0).abs() < SAME, "{kind:?}: {sum}");
            assert!(impulses.iter().all(|&(weight, _)| weight > 0.0), "{kind:?}: {impulses:?}");
            assert!(
                impulses[0].1 == 0.0 && impulses.is_sorted_by(|one, next| one.1 < next.1),
                "{kind:?}: {impulses:?}"
            );
        }
    }
}

/// In periods of the load, ZV lasts 1/2, MZV 3/4, ZVD and EI 1. Without damping weights are symmetric, so the mean is half of that.
#[test]
fn shapers_last_for_parts_of_a_period() {
    for (kind, periods) in KINDS.into_iter().zip([0.5, 0.75, 1.0, 1.0]) {
        let undamped = shaper(kind, 20.0, 0.0).impulses();
        assert!((undamped.last_s() * 20.0 - periods).abs() < SAME, "{kind:?}");
        assert!((undamped.mean_s() * 20.0 - 0.5 * periods).abs() < SAME, "{kind:?}");
        let damped = shaper(kind, 20.0, 0.5).impulses();
        assert!((damped.last_s() * 20.0 - periods / 0.75_f64.sqrt()).abs() < SAME, "{kind:?}");
        assert!(damped.mean_s() < 0.5 * damped.last_s(), "{kind:?}: the later, the weaker");
    }
    assert_eq!(shaper(ShaperKind::None, 20.0, 0.1).impulses(), Impulses::ONE);
}

#[test]
fn nothing_is_left_at_the_own_frequency_and_a_tolerance_by_ei() {
    for damping_ratio in RATIOS {
        for kind in KINDS {
            let left = left(&shaper(kind, 47.0, damping_ratio).impulses(), 47.0, damping_ratio);
            match (kind, damping_ratio) {
                (ShaperKind::Ei, 0.0) => assert!((left - EI_TOLERANCE).abs() < SAME, "{left}"),
                // The damping takes its part of it.
                (ShaperKind::Ei, _) => assert!(left < EI_TOLERANCE && left > 0.0, "{damping_ratio}: {left}"),
                _ => assert!(left < SAME, "{kind:?}, {damping_ratio}: {left}"),
            }
        }
    }
}

/// The distances below and above its own frequency up to which a shaper leaves a twentieth at most, thousandths of that frequency.
fn insensitive(kind: ShaperKind) -> [u32; 2] {
    let impulses = shaper(kind, 100.0, 0.0).impulses();
    [-1.0, 1.0].map(|sign| {
        let steps = (1..500).find(|&step| {
            let natural_hz = 100.0 + sign * 0.1 * f64::from(step);
            left(&impulses, natural_hz, 0.0) > 0.05 + SAME
        });
        steps.expect("a bound") - 1
    })
}

/// In docs/ringing.md.
#[test]
fn a_twentieth_at_most_is_left_beside_the_own_frequency_by_so_much() {
    // By the closed form |(2 - s) cos(3 pi r/4) + s - 1|, s the root of 2, MZV leaves it for r from 0.9514 to 1.0549.
    let all = KINDS.into_iter().chain([ShaperKind::Box]);
    for (kind, beside) in all.zip([[31, 31], [48, 54], [143, 143], [199, 199], [47, 52]]) {
        assert_eq!(insensitive(kind), beside, "{kind:?}");
    }
}

/// In docs/moves.md: an axis at a steady acceleration is beside its place, later by the mean, by half of it times the mean square of
/// the delays from their mean. In thousandths of a square period.
#[test]
fn a_steady_acceleration_leaves_an_axis_beside_its_place_by_so_much() {
    let all = KINDS.into_iter().chain([ShaperKind::Box]);
    for (kind, beside) in all.zip([31.25, 41.19, 62.5, 65.63, 41.67]) {
        let impulses = shaper(kind, 100.0, 0.0).impulses();
        let mean_s = impulses.mean_s();
        let square_s2: f64 = parts(&impulses).iter().map(|(weight, delay_s)| weight * (delay_s - mean_s).powi(2)).sum();
        let found = 0.5 * square_s2 * 100.0 * 100.0 * 1e3;
        assert!((found - beside).abs() < 0.01, "{kind:?}: {found}");
    }
}

/// A box lasts for a period of the frequency without damping, also with damping; its mean is in the middle. Without damping it leaves nothing of
/// that frequency and its multiples.
#[test]
fn a_box_lasts_for_a_period() {
    for damping_ratio in RATIOS {
        let ends = shaper(ShaperKind::Box, 25.0, damping_ratio).impulses();
        assert!(
            ends.box_ends_s().is_some()
                && !KINDS.iter().any(|&kind| shaper(kind, 25.0, damping_ratio).impulses().box_ends_s().is_some())
        );
        assert_eq!((ends.mean_s(), ends.last_s()), (0.02, 0.04));
        assert!((1..5).all(|times| left(&ends, 25.0 * f64::from(times), 0.0) < 1e-6));
    }
}

/// Of a motion later by the same time the shaper is as good.
#[test]
fn later_impulses_leave_the_same() {
    let impulses = shaper(ShaperKind::Mzv, 30.0, 0.1).impulses();
    let later = impulses.later(0.02);
    assert!((later.mean_s() - impulses.mean_s() - 0.02).abs() < SAME);
    assert!((later.last_s() - impulses.last_s() - 0.02).abs() < SAME);
    for natural_hz in [20.0, 30.0, 45.0] {
        assert!((left(&impulses, natural_hz, 0.1) - left(&later, natural_hz, 0.1)).abs() < SAME);
    }
}
