//! The shapers of a run, from those of a configuration.

use isostep_motion::{Axis, Kinematics, LeastTimes, RampTimes, Shaping};
use isostep_profile::shaper::{Shaper, ShaperKind};

use super::common::works;

/// The largest change by rounding, s.
const SAME_S: f64 = 1e-15;

/// Those of no board.
const TIMES: LeastTimes = LeastTimes {
    straight_s: 0.1e-3,
    blend_s: 0.2e-3,
    join_s: 0.3e-3,
    together_s: 0.4e-3,
    shaped_s: 1.64e-3,
    box_s: 3.6e-3,
    box_root_step_s: 0.2e-3,
    queued_s: 0.5e-3,
    curved: [RampTimes { ramps_s: 0.6e-3, root_step_s: 0.7e-3 }; 6],
};

fn shaper(kind: ShaperKind, natural_hz: f64) -> Shaper {
    Shaper { kind, natural_hz, damping_ratio: 0.05 }
}

/// A run in which X and Y have these shapers, and Z has none.
fn shaping(x: Shaper, y: Shaper) -> Option<Shaping> {
    let mut config = works();
    (config.shapers[Axis::X as usize], config.shapers[Axis::Y as usize]) = (x, y);
    config.shaping()
}

#[test]
fn without_a_shaper_no_run_is_shaped() {
    let none = shaper(ShaperKind::None, 25.0);
    assert_eq!((works().shaping(), shaping(none, none)), (None, None));
    assert_eq!(TIMES.of_shaping_s(None, Kinematics::Cartesian), [0.0; 2]);
}

/// So the axes are on a line at constant speed, whatever their shapers are.
#[test]
fn all_axes_are_late_by_the_mean_of_the_latest() {
    for x in ShaperKind::ALL {
        for y in ShaperKind::ALL {
            let shapers = [shaper(x, 40.0), shaper(y, 25.0)];
            let Some(shaping) = shaping(shapers[0], shapers[1]) else {
                assert_eq!((x, y), (ShaperKind::None, ShaperKind::None));
                continue;
            };
            let means_s = shapers.map(|shaper| shaper.impulses().mean_s());
            assert_eq!(shaping.delay_s, means_s[0].max(means_s[1]), "{x:?}, {y:?}");
            let latest = usize::from(means_s[1] > means_s[0]);
            for (axis, impulses) in shaping.impulses.iter().enumerate() {
                assert!((impulses.mean_s() - shaping.delay_s).abs() < SAME_S, "{x:?}, {y:?}: axis {axis}");
                let first_s = impulses.iter().next().map(|(_, delay_s)| delay_s).unwrap();
                assert!(first_s >= 0.0 && (axis != latest || first_s == 0.0), "{x:?}, {y:?}: axis {axis} at {first_s}");
                assert!(impulses.last_s() <= shaping.lasts_s, "{x:?}, {y:?}: axis {axis}");
            }
            assert!(shaping.impulses.iter().any(|impulses| impulses.last_s() == shaping.lasts_s), "{x:?}, {y:?}");
            let (z, late) = (shaping.impulses[Axis::Z as usize].iter().collect::<Vec<_>>(), shaping.delay_s);
            assert_eq!(z, [(1.0, late)], "an axis without a shaper is only late");
        }
    }
}

/// A move has its phases, and all those of the shaper's length are kept.
#[test]
fn a_move_lasts_longer_with_low_frequencies() {
    let at_hz = |natural_hz| {
        TIMES.of_shaping_s(
            shaping(shaper(ShaperKind::Zvd, natural_hz), Shaper::default()).as_ref(),
            Kinematics::Cartesian,
        )[0]
    };
    assert_eq!((at_hz(500.0), at_hz(34.0)), (TIMES.shaped_s, TIMES.shaped_s));
    assert!(at_hz(32.0) > TIMES.shaped_s);
    let boxed = shaping(shaper(ShaperKind::Box, 100.0), shaper(ShaperKind::Zv, 100.0));
    assert_eq!(TIMES.of_shaping_s(boxed.as_ref(), Kinematics::Cartesian), [TIMES.box_s, TIMES.box_root_step_s]);
    assert!(at_hz(10.0) > 2.0 * TIMES.shaped_s && (at_hz(10.0) - 2.0 * at_hz(20.0)).abs() < SAME_S);
}
