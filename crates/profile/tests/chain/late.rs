//! Blends that moves, holds and overrides leave no room for, each found among tens of thousands of random chains.

use isostep_profile::chain::{Effort, Request};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile};

use super::bent::drive;
use super::case::{AXES, Case};
use super::drive::Event;
use super::model::OverrideRatios;

/// A machine of trapezoids. Of each axis: top speed, acceleration, mm for a step.
fn machine(axes: [[f64; 3]; AXES], moves: Vec<Request<AXES>>) -> Case {
    let limits = axes.map(|[top, accel, _]| Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: top,
        accel_steps_s2: accel,
        decel_steps_s2: accel,
        jerk_steps_s3: f64::INFINITY,
    });
    Case {
        limits,
        mm_per_step: axes.map(|axis| axis[2]),
        deviation_mm: 0.1,
        interval_split: IntervalSplit::Fastest,
        speed_profile: SpeedProfile::Trapezoid,
        effort: Effort::NONE,
        moves: moves.into_iter().zip(0..).map(|(one, tag)| Request { tag, ..one }).collect(),
    }
}

fn bent(steps: [i32; AXES], offsets: [i8; AXES]) -> Request<AXES> {
    Request { offsets, deviation_mm: 0.3, ..Request::new(steps) }
}

fn overrides(feed: f64, rapid: f64) -> Event {
    Event::Override(OverrideRatios { feed, rapid })
}

/// The move slows down to an override before the third one comes. It is beyond where its blend would begin by then.
#[test]
fn a_blend_that_should_have_begun_is_none() {
    let axes = [
        [54.2274723831538, 81355.87701500223, 0.018440837384680647],
        [1143.1935493568549, 283.5393709170725, 0.1],
        [4202.8128036242815, 159.49549301823632, 0.03134884820493524],
    ];
    let feed_mm_s = Some(7.1151109311691085);
    let moves = [Request::new([0, -2, 1]), Request::new([1, -2, 2]), bent([0, 0, 3], [0, 26, 0])];
    let case = machine(axes, moves.map(|one| Request { feed_mm_s, ..one }).to_vec());
    let events = [
        Event::Push(2),
        Event::Advance(2, 0.009676917681930982),
        Event::Advance(2, 0.05989015089980412),
        Event::Advance(1, 0.03676973233965922),
        overrides(0.1, 0.25),
        Event::Advance(1, 0.003385844397658401),
    ];
    drive::<8>(&Case { deviation_mm: 0.0014201436652534136, ..case }, &events).unwrap();
}

/// The third move comes when the second cannot brake any more to what the third may begin with.
#[test]
fn a_blend_that_would_be_left_too_fast_is_none() {
    let axes = [
        [15389.608129689139, 4409.750742185108, 0.013214233894007677],
        [98.18611111986279, 13986.721399544624, 0.010184739863861486],
        [2923.6742120127506, 77.68107802421801, 0.1],
    ];
    let moves = vec![bent([-76, 0, 2], [-38, 0, -44]), bent([-78, 0, 1], [0; AXES]), bent([0, -701, 0], [-5, 0, 0])];
    let events = [Event::Push(2), Event::Advance(3, 0.047790133993997404), Event::Advance(2, 1.0), Event::Push(1)];
    drive::<8>(&machine(axes, moves), &events).unwrap();
}

/// A plan that slows down before a blend leads to it, too: another override cannot make it rest instead.
#[test]
fn a_blend_that_is_promised_while_slowing_down_is_made() {
    let axes = [
        [139.57899338917161, 2334.034319335724, 0.0482336317177778],
        [10.0, 10997.187474014312, 0.1],
        [10.0, 50.0, 0.1],
    ];
    let moves = vec![
        Request::new([0, 0, 4]),
        Request::new([-73, 0, 0]),
        bent([-73, 1, 0], [-11, 0, 0]),
        bent([-73, 1, 0], [0; AXES]),
    ];
    let events = [
        Event::Push(3),
        Event::Advance(1, f64::INFINITY),
        Event::Advance(1, 0.015352539167075262),
        Event::Advance(4, 0.027862230769510814),
        overrides(0.1, 0.4710536028270041),
        Event::Push(1),
        Event::Advance(1, 1.0),
        Event::Advance(3, 0.878343802274238),
        overrides(0.1, 0.8782130308917752),
        Event::Advance(5, 0.024508066191567326),
        overrides(0.1, 0.7404620156488158),
        Event::Advance(1, 1.0),
        overrides(0.1, 0.25),
    ];
    drive::<8>(&machine(axes, moves), &events).unwrap();
}

/// A hold is taken back where the second move begins at rest. It ends at rest too, for the third to begin as fast as it can.
#[test]
fn a_blend_from_rest_begins_at_the_corner() {
    let axes = [
        [553.4037983076805, 9196.67972605239, 0.021978462537880973],
        [273.8219656777344, 770.2434029241559, 0.022430869237020878],
        [387.88241536379894, 1939.4120768189944, 0.002578100889317423],
    ];
    let moves = vec![bent([2, 0, 0], [0, -23, 0]), bent([0, 0, -1], [0; 3]), bent([0, 0, 1], [-22, 0, 18])];
    let events =
        [Event::Push(2), Event::Advance(3, 0.006326485122175529), Event::Hold, Event::Advance(1, f64::INFINITY)];
    drive::<8>(&Case { deviation_mm: 0.0, ..machine(axes, moves) }, &events).unwrap();
}
