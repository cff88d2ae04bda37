use std::f64::consts::{FRAC_PI_2, TAU};

use proptest::prelude::*;

use super::*;

/// An arc, before its ends are rounded to the picometres that an interpreter keeps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drawn {
    pub(super) centre_mm: [f64; 2],
    pub(super) radius_mm: f64,
    pub(super) from_rad: f64,
    pub(super) travel_rad: f64,
    pub(super) rise_mm: f64,
    pub(super) plane: u8,
}

impl Drawn {
    fn place_mm(&self, rad: f64, across_mm: f64) -> [f64; AXES] {
        let [first, second, across] = PLANES[usize::from(self.plane)];
        let mut place_mm = [0.0; AXES];
        place_mm[first] = self.centre_mm[0] + self.radius_mm * rad.cos();
        place_mm[second] = self.centre_mm[1] + self.radius_mm * rad.sin();
        place_mm[across] = across_mm;
        place_mm
    }

    pub(super) fn ends(&self) -> ArcEnds {
        let start_mm = self.place_mm(self.from_rad, 7.0).map(kept);
        let target_mm = self.place_mm(self.from_rad + self.travel_rad, 7.0 + self.rise_mm).map(kept);
        ArcEnds { start_mm, target_mm, plane: self.plane, clockwise: self.travel_rad < 0.0 }
    }

    pub(super) fn offset_mm(&self) -> [f64; 2] {
        let ArcEnds { start_mm, .. } = self.ends();
        core::array::from_fn(|index| self.centre_mm[index] - start_mm[PLANES[usize::from(self.plane)][index]])
    }

    pub(super) fn arc(&self) -> Arc {
        Arc::around(self.ends(), self.offset_mm()).unwrap()
    }
}

pub(super) fn drawn() -> impl Strategy<Value = Drawn> {
    let circle = (prop::array::uniform2(-300.0..300.0), -1.0..3.0f64, 0.0..TAU, 0.01..TAU - 0.01);
    (circle, any::<bool>(), -50.0..50.0, 0..3u8).prop_map(
        |((centre_mm, power, from_rad, turn_rad), cw, rise_mm, plane)| {
            let travel_rad = if cw { -turn_rad } else { turn_rad };
            Drawn { centre_mm, radius_mm: 10f64.powf(power), from_rad, travel_rad, rise_mm, plane }
        },
    )
}

/// The start point, then the end points of the chords.
fn corners(arc: &Arc, tolerance_mm: f64) -> std::vec::Vec<[f64; AXES]> {
    [arc.start_mm()].into_iter().chain(arc.chords(tolerance_mm)).collect()
}

/// As an interpreter keeps it.
fn kept(mm: f64) -> f64 {
    crate::length::to_mm(crate::length::from_mm(mm))
}

pub(super) fn ends(start_mm: [f64; AXES], target_mm: [f64; AXES], clockwise: bool) -> ArcEnds {
    ArcEnds { start_mm, target_mm, plane: 0, clockwise }
}

#[test]
fn a_quarter_a_half_and_the_whole_of_a_circle() {
    let quarter = Arc::around(ends([10.0, 0.0, 0.0], [0.0, 10.0, 0.0], false), [-10.0, 0.0]).unwrap();
    assert_eq!((quarter.travel_rad, quarter.radius_mm), (FRAC_PI_2, 10.0));
    assert_eq!(quarter.bounds_mm(), [[0.0, 10.0], [0.0, 10.0], [0.0, 0.0]]);
    let other_way = Arc::around(ends([10.0, 0.0, 0.0], [0.0, 10.0, 0.0], true), [-10.0, 0.0]).unwrap();
    assert_eq!(other_way.travel_rad, FRAC_PI_2 - TAU);
    assert_eq!(other_way.bounds_mm(), [[-10.0, 10.0], [-10.0, 10.0], [0.0, 0.0]]);
    let half = Arc::of_radius(ends([10.0, 0.0, 0.0], [-10.0, 0.0, 0.0], false), 10.0).unwrap();
    assert_eq!(half.bounds_mm(), [[-10.0, 10.0], [0.0, 10.0], [0.0, 0.0]]);
    assert!((half.length_mm() - 10.0 * PI).abs() < 1e-12);
    for clockwise in [false, true] {
        let whole = Arc::around(ends([10.0, 0.0, 1.0], [10.0, 0.0, 5.0], clockwise), [0.0, 5.0]).unwrap();
        assert_eq!(whole.travel_rad.abs(), TAU);
        assert_eq!(whole.bounds_mm(), [[5.0, 15.0], [0.0, 10.0], [1.0, 5.0]]);
        assert!((whole.length_mm() - (10.0 * PI).hypot(4.0)).abs() < 1e-12, "a helix is as long as its thread");
    }
}

#[test]
fn start_and_target_fit_one_circle_as_closely_as_grbl_wants() {
    let around = |radius_mm: f64, target_mm: f64| {
        let ends = ends([radius_mm, 0.0, 0.0], [0.0, target_mm, 0.0], false);
        Arc::around(ends, [-radius_mm, 0.0]).map(|_| ())
    };
    for (radius_mm, target_mm) in [(1.0, 1.0049), (0.001, 0.0059), (100.0, 99.91), (1000.0, 1000.49), (400.0, 400.39)] {
        assert_eq!(around(radius_mm, target_mm), Ok(()), "{radius_mm} {target_mm}");
    }
    for (radius_mm, target_mm) in [(1.0, 1.0051), (4.0, 4.0051), (100.0, 100.11), (1000.0, 1000.51), (0.0, 0.006)] {
        assert_eq!(around(radius_mm, target_mm), Err(Error::InvalidTarget), "{radius_mm} {target_mm}");
    }
}

#[test]
fn a_radius_that_is_half_the_way_is_half_a_circle_wherever_it_is_drawn() {
    for start in (0..4_000).map(|tenths| f64::from(tenths) / 10.0) {
        let target = kept(start + 0.3);
        let arc = Arc::of_radius(ends([start, 7.7, 0.0], [target, 7.7, 0.0], true), 0.15).unwrap();
        assert!((arc.travel_rad + PI).abs() < 0.05 && (arc.radius_mm - 0.15).abs() < 1e-4, "{start} {arc:?}");
    }
    let too_far = ends([0.0; 3], [10.0, 0.0, 0.0], true);
    assert_eq!(Arc::of_radius(too_far, 4.9949), Err(Error::RadiusTooSmall));
    assert_eq!(Arc::of_radius(too_far, 0.0), Err(Error::RadiusTooSmall));
    let nowhere = ends([5.0, 0.0, 0.0], [5.0, 0.0, 3.0], true);
    assert_eq!(Arc::of_radius(nowhere, 4.0), Err(Error::InvalidTarget));
}

/// A turn by little is no full circle, however little it is, whichever way it is written and wherever it is drawn.
#[test]
fn a_full_circle_leads_back_to_its_start_and_nowhere_else() {
    let length_mm = |arc: Result<Arc, Error>| arc.unwrap().length_mm();
    for (x_mm, y_mm) in [(0.0, 0.0), (123.456, -87.654), (1_000.0, 3.7)] {
        for (along_mm, aside_mm) in [(0.001, 0.0), (0.0, 0.001), (-0.0007, 0.0007), (1e-6, 0.0), (1e-9, 1e-9)] {
            let (start_mm, target_mm) = ([x_mm, y_mm, 0.0], [kept(x_mm + along_mm), kept(y_mm + aside_mm), 0.0]);
            let chord_mm = (target_mm[0] - x_mm).hypot(target_mm[1] - y_mm);
            for clockwise in [false, true] {
                let short = length_mm(Arc::of_radius(ends(start_mm, target_mm, clockwise), 3_000.0));
                assert!((short - chord_mm).abs() < 1e-12, "{short} mm from {start_mm:?} to {target_mm:?}");
                let long = length_mm(Arc::of_radius(ends(start_mm, target_mm, clockwise), -3_000.0));
                assert!((long + chord_mm - 3_000.0 * TAU).abs() < 1e-8, "{long} mm");
            }
        }
        // By its centre: from (3000, 0) some 0.001 mm on, or nearly all the way round.
        let around = |clockwise, up_mm: f64| {
            let start_mm = [x_mm, y_mm, 0.0];
            Arc::around(ends(start_mm, [x_mm, kept(y_mm + up_mm), 0.0], clockwise), [-3_000.0, 0.0])
        };
        for up_mm in [0.001, 1e-6, 2e-9] {
            assert!((length_mm(around(false, up_mm)) - up_mm).abs() < 1e-9, "{up_mm} mm on");
            assert!((length_mm(around(true, up_mm)) + up_mm - 3_000.0 * TAU).abs() < 1e-8, "{up_mm} mm back");
        }
        // Beside the start, in its direction from the centre: as far as the ends may differ from a circle.
        for (x_far_mm, clockwise) in [(0.004, true), (-0.004, true), (0.004, false), (-1e-9, false)] {
            let target_mm = [kept(x_mm + x_far_mm), y_mm, 0.0];
            let beside = Arc::around(ends([x_mm, y_mm, 0.0], target_mm, clockwise), [-10.0, 0.0]).unwrap();
            assert!(beside.length_mm() < 1e-9, "{} mm", beside.length_mm());
            assert_eq!(corners(&beside, 0.002), [[x_mm, y_mm, 0.0], target_mm]);
            assert!(beside.bounds_mm()[0][0] > x_mm - 0.01, "{:?}", beside.bounds_mm());
        }
    }
}

#[test]
fn a_circle_within_the_tolerance_is_one_chord() {
    for radius_mm in [0.0, 0.001] {
        let circle = Arc::around(ends([3.0; 3], [3.0; 3], true), [radius_mm, 0.0]).unwrap();
        assert_eq!(corners(&circle, 0.002), [[3.0; 3]; 2]);
    }
}

#[test]
fn a_hundred_thousand_chords_stay_on_the_circle() {
    let drawn = Drawn {
        centre_mm: [300.0, -20.0],
        radius_mm: 1_000.0,
        from_rad: 1.0,
        travel_rad: -6.2,
        rise_mm: 40.0,
        plane: 0,
    };
    let arc = drawn.arc();
    let corners = corners(&arc, 4.8e-7);
    assert!(corners.len() > 100_000, "{}", corners.len());
    let turn_rad = arc.travel_rad / (corners.len() - 1) as f64;
    let [start, _] = arc.radii_mm();
    let from_rad = start[1].atan2(start[0]);
    let farthest_mm = corners.iter().enumerate().map(|(index, corner)| {
        let rad = from_rad + turn_rad * index as f64;
        let radius_mm = arc.radius_mm + (arc.target_radius_mm - arc.radius_mm) * index as f64 / corners.len() as f64;
        let [x, y] = [300.0 + radius_mm * rad.cos(), -20.0 + radius_mm * rad.sin()];
        let z = 7.0 + 40.0 * index as f64 / (corners.len() - 1) as f64;
        (corner[0] - x).hypot(corner[1] - y).hypot(corner[2] - z)
    });
    let farthest_mm = farthest_mm.fold(0.0, f64::max);
    assert!(farthest_mm < 1e-6, "{farthest_mm} mm");
}

proptest! {
    #[test]
    fn chords_are_within_the_tolerance_and_no_more_than_it_takes(drawn in drawn(), tolerance_mm in 0.001..0.05f64) {
        let arc = drawn.arc();
        let [first, second, _] = arc.axes();
        let from_centre_mm = |place_mm: [f64; AXES]| {
            (place_mm[first] - drawn.centre_mm[0]).hypot(place_mm[second] - drawn.centre_mm[1])
        };
        let corners = corners(&arc, tolerance_mm);
        // Start and target have been rounded to picometres.
        let rounding_mm = 1e-7;
        for pair in corners.windows(2) {
            let middle_mm = core::array::from_fn(|axis| 0.5 * (pair[0][axis] + pair[1][axis]));
            let [end_mm, middle_mm] = [pair[1], middle_mm].map(|place_mm| from_centre_mm(place_mm) - drawn.radius_mm);
            prop_assert!(end_mm.abs() < rounding_mm, "{end_mm}");
            prop_assert!((-tolerance_mm - rounding_mm..rounding_mm).contains(&middle_mm), "{middle_mm}");
        }
        let widest_rad = 2.0 * (1.0 - tolerance_mm / drawn.radius_mm).acos();
        let least = (arc.travel_rad.abs() / widest_rad).ceil() as usize;
        prop_assert!((least..=least + 1).contains(&(corners.len() - 1)), "{} chords, {least} would do", corners.len() - 1);
        prop_assert_eq!(arc.chords(tolerance_mm).len(), corners.len() - 1);
        prop_assert_eq!(corners.last().copied(), Some(drawn.ends().target_mm));
        prop_assert!((arc.travel_rad - drawn.travel_rad).abs() * drawn.radius_mm < 1e-3);
    }

    #[test]
    fn the_box_holds_every_point_and_is_no_larger(drawn in drawn()) {
        let arc = drawn.arc();
        let bounds_mm = arc.bounds_mm();
        let mut seen_mm = [[f64::MAX, f64::MIN]; AXES];
        for corner in corners(&arc, 1e-5) {
            for (seen_mm, mm) in seen_mm.iter_mut().zip(corner) {
                *seen_mm = [seen_mm[0].min(mm), seen_mm[1].max(mm)];
            }
        }
        for (bounds_mm, seen_mm) in bounds_mm.iter().zip(seen_mm) {
            prop_assert!(bounds_mm[0] <= seen_mm[0] + 1e-9 && bounds_mm[1] >= seen_mm[1] - 1e-9);
            prop_assert!((bounds_mm[0] - seen_mm[0]).abs() < 1e-4 && (bounds_mm[1] - seen_mm[1]).abs() < 1e-4);
        }
    }

    #[test]
    fn a_radius_means_the_circle_that_its_centre_does(drawn in drawn()) {
        let radius_mm = if drawn.travel_rad.abs() > PI { -drawn.radius_mm } else { drawn.radius_mm };
        // Where the chord is close to a diameter, rounding of the radius moves the centre a lot.
        prop_assume!((drawn.travel_rad.abs() - PI).abs() > 0.3 && drawn.travel_rad.abs() < 6.0);
        prop_assume!(drawn.travel_rad.abs() > 0.3);
        let arc = Arc::of_radius(drawn.ends(), radius_mm).unwrap();
        for (given_mm, found_mm) in drawn.offset_mm().into_iter().zip(arc.offset_mm) {
            prop_assert!((given_mm - found_mm).abs() < 2e-3, "{given_mm} {found_mm}");
        }
        prop_assert!((arc.travel_rad - drawn.travel_rad).abs() * drawn.radius_mm < 5e-3);
    }

    /// If the centre was rounded, the arc still ends at its target, and no chord has to absorb the whole error.
    #[test]
    fn what_does_not_fit_is_spread_over_all_chords(drawn in drawn(), wrong in -0.00099..0.00099f64) {
        let wrong_mm = if drawn.radius_mm < 1.0 { 0.0 } else { wrong * drawn.radius_mm.min(400.0) };
        let [i_mm, j_mm] = drawn.offset_mm();
        let (along, radius_mm) = (wrong_mm / drawn.radius_mm, drawn.radius_mm);
        let Ok(arc) = Arc::around(drawn.ends(), [i_mm * (1.0 + along), j_mm * (1.0 + along)]) else { return Ok(()) };
        let corners = corners(&arc, 0.001);
        let (last, rest) = corners.split_last().unwrap();
        let [first, second, _] = arc.axes();
        let lengths_mm: std::vec::Vec<_> = rest.iter().zip(&rest[1..]).map(|(a, b)| {
            (a[first] - b[first]).hypot(a[second] - b[second])
        }).collect();
        if let (Some(&usual_mm), Some(before)) = (lengths_mm.last(), rest.last()) {
            let last_mm = (last[first] - before[first]).hypot(last[second] - before[second]);
            prop_assert!((last_mm - usual_mm).abs() < 1e-3 + 1e-3 * radius_mm.min(1.0), "{last_mm} {usual_mm}");
        }
    }
}
