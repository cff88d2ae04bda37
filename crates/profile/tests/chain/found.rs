//! Cases that random tests have found.

use isostep_profile::chain::{Effort, Request};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile};

use super::case::{AXES, Case};
use super::drive::{Event, drive};
use super::optimum::is_the_fastest;

fn limits(top_speed_steps_s: f64, accel_steps_s2: f64, jerk_steps_s3: f64) -> Limits {
    let decel_steps_s2 = accel_steps_s2;
    Limits { start_speed_steps_s: 0.0, top_speed_steps_s, accel_steps_s2, decel_steps_s2, jerk_steps_s3 }
}

fn requests(all: &[[i32; AXES]]) -> Vec<Request<AXES>> {
    all.iter().enumerate().map(|(tag, &steps)| Request { tag: tag as u64, ..Request::new(steps) }).collect()
}

/// Beyond the corner at the end of the move that is held, the machine would go at 0.003 mm/s.
#[test]
fn a_hold_rests_where_next_to_no_speed_is_left() {
    let case = Case {
        limits: [limits(6349.1, 127.4744, 2.5593), limits(10.0, 50.0, 250.0), limits(231.963, 1159.8, 5799.1)],
        mm_per_step: [0.0392235584, 0.1, 0.00431103144],
        deviation_mm: 0.00174175,
        interval_split: IntervalSplit::Fastest,
        speed_profile: SpeedProfile::Trapezoid,
        effort: Effort::NONE,
        moves: requests(&[[0, 7, 0], [1, 0, 0], [3333, 0, 58], [3333, 0, 58], [3333, 0, 58], [-1, 0, 0]]),
    };
    drive::<64>(&case, &[Event::Push(6), Event::Advance(4, f64::INFINITY), Event::Settle]).unwrap();
}

/// The change of speed in a move is computed for the top speed that it has if a blend leads to it.
#[test]
fn an_s_curve_is_as_fast_as_it_would_be_behind_a_blend() {
    let case = Case {
        limits: [limits(238.87, 50.0, 10.466), limits(10963.9, 197.15, 3.5451), limits(10.0, 50.0, 250.0)],
        mm_per_step: [0.1, 0.0414072688, 0.1],
        deviation_mm: 0.1,
        interval_split: IntervalSplit::Fastest,
        speed_profile: SpeedProfile::SCurve,
        effort: Effort { move_s: 0.03, straight_s: 0.03, ..Effort::NONE },
        moves: requests(&[[0, 25, 1], [2, 25, -1], [3, 25, 0]]),
    };
    is_the_fastest(&case).unwrap();
}
