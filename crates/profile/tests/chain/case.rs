//! Random machines, and the moves that they make.

use isostep_profile::chain::{ChainConfig, Chunk, Effort, Request};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};
use proptest::prelude::*;

pub const AXES: usize = 3;

/// A machine and its moves.
#[derive(Clone, Debug)]
pub struct Case {
    pub limits: [Limits; AXES],
    pub mm_per_step: [f64; AXES],
    pub deviation_mm: f64,
    pub interval_split: IntervalSplit,
    pub speed_profile: SpeedProfile,
    pub effort: Effort,
    pub moves: Vec<Request<AXES>>,
}

impl Case {
    /// The steps of all moves together.
    pub fn all_steps(&self) -> [i32; AXES] {
        let add = |sum: [i32; AXES], one: &Request<AXES>| std::array::from_fn(|axis| sum[axis] + one.steps[axis]);
        self.moves.iter().fold([0; AXES], add)
    }

    pub fn config(&self) -> ChainConfig<AXES> {
        let plain =
            ChainConfig::new(self.limits, self.mm_per_step, self.deviation_mm, self.interval_split, self.speed_profile);
        plain.with_effort(self.effort)
    }
}

/// The line that a chunk is of.
pub fn line<const N: usize>(chunk: &Chunk<N>) -> &SyncMove<N> {
    chunk.plan.line().expect("a line")
}

fn log(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.ln()..to.ln()).prop_map(f64::exp)
}

/// An axis of a usual machine: some 10 to 400 steps/mm, 1 to 500 mm/s, 5 to 5,000 mm/s². The start speed is mostly 0.
fn axis(speed_profile: SpeedProfile) -> impl Strategy<Value = (Limits, f64)> {
    let start = prop_oneof![3 => Just(0.0), 2 => 0.0..0.3f64];
    let jerk = prop_oneof![3 => log(0.1, 100.0), 1 => Just(f64::INFINITY)];
    let decel = prop_oneof![Just(1.0), 0.5..2.0f64];
    (log(10.0, 400.0), log(1.0, 500.0), log(5.0, 5e3), decel, start, jerk).prop_map(
        move |(per_mm, top_mm_s, accel_mm_s2, decel, start, jerk)| {
            let least = if speed_profile.is_over_displacement() { 0.01 } else { 0.0 };
            let (top, accel) = (top_mm_s * per_mm, accel_mm_s2 * per_mm);
            let limits = Limits {
                start_speed_steps_s: top * start.max(least),
                top_speed_steps_s: top,
                accel_steps_s2: accel,
                decel_steps_s2: accel * decel,
                jerk_steps_s3: jerk * accel * accel / top,
            };
            (limits, 1.0 / per_mm)
        },
    )
}

fn count() -> impl Strategy<Value = i32> {
    prop_oneof![2 => Just(0), 1 => Just(1), 2 => -3..=3i32, 4 => -100..=100i32, 1 => -5_000..=5_000i32]
}

/// A move of its own, one in the direction of the move before or back, or one at a small angle to it.
#[derive(Clone, Debug)]
enum Follows {
    New([i32; AXES]),
    On(i32),
    Bend([i32; AXES]),
}

fn follows() -> impl Strategy<Value = Follows> {
    prop_oneof![
        4 => [count(), count(), count()].prop_map(Follows::New),
        2 => prop_oneof![3 => 1..3i32, 1 => Just(-1)].prop_map(Follows::On),
        3 => [-2..=2i32, -2..=2i32, -2..=2i32].prop_map(Follows::Bend),
    ]
}

/// The components of a request. Feeds begin at 1 mm/min.
fn request() -> impl Strategy<Value = (Follows, Option<f64>, bool)> {
    let feed =
        prop_oneof![2 => Just(None), 3 => log(1.0, 500.0).prop_map(Some), 1 => log(1.0 / 60.0, 1.0).prop_map(Some)];
    let stops = prop_oneof![12 => Just(false), 1 => Just(true)];
    (follows(), feed, stops)
}

/// The requests. Most have the feed of the one before.
fn moves(all: Vec<(Follows, Option<f64>, bool)>) -> Vec<Request<AXES>> {
    let mut moves: Vec<Request<AXES>> = Vec::new();
    for (index, (follows, feed, stops)) in all.into_iter().enumerate() {
        let last = moves.last().copied();
        let before = last.map_or([1, 0, 0], |last| last.steps);
        let mut steps = match follows {
            Follows::New(steps) => steps,
            Follows::On(times) => before.map(|steps| (steps * times).clamp(-10_000, 10_000)),
            Follows::Bend(by) => core::array::from_fn(|axis| before[axis] + by[axis]),
        };
        if steps == [0; AXES] {
            steps = [1, 0, 0];
        }
        let feed_mm_s = match (index % 3, last) {
            (0, _) | (_, None) => feed,
            (_, Some(last)) => last.feed_mm_s,
        };
        moves.push(Request { feed_mm_s, stops, tag: index as u64, ..Request::new(steps) });
    }
    moves
}

/// None, or some milliseconds for a move, and more for its ramps.
fn effort() -> impl Strategy<Value = Effort> {
    let time = || prop_oneof![1 => Just(0.0), 2 => log(1e-4, 3e-2)];
    let some = (time(), time(), time(), time(), [time(), time()]).prop_map(
        |(step_s, move_s, straight_s, ramps_s, roots_s)| {
            let [root_step_s, shaped_root_step_s] = roots_s;
            Effort { step_s: 0.01 * step_s, move_s, straight_s, blend_s: 0.0, ramps_s, root_step_s, shaped_root_step_s }
        },
    );
    prop_oneof![2 => Just(Effort::NONE), 1 => some]
}

/// A case of `most` moves at most, by this speed profile.
pub fn case(speed_profile: impl Strategy<Value = SpeedProfile>, most: usize) -> impl Strategy<Value = Case> {
    speed_profile.prop_flat_map(move |speed_profile| {
        let deviation = prop_oneof![1 => Just(0.0), 8 => log(1e-3, 0.1)];
        let interval = prop_oneof![15 => Just(IntervalSplit::Fastest), 1 => Just(IntervalSplit::Thirds)];
        let requests = prop::collection::vec(request(), 1..=most);
        ([axis(speed_profile), axis(speed_profile), axis(speed_profile)], deviation, interval, effort(), requests)
            .prop_map(move |(axes, deviation_mm, interval_split, effort, all)| {
                let (limits, mm_per_step) = (axes.map(|axis| axis.0), axes.map(|axis| axis.1));
                let moves = moves(all);
                Case { limits, mm_per_step, deviation_mm, interval_split, speed_profile, effort, moves }
            })
    })
}

/// The trapezoid.
pub fn trapezoid() -> impl Strategy<Value = SpeedProfile> {
    Just(SpeedProfile::Trapezoid)
}

/// All other speed profiles.
pub fn curved() -> impl Strategy<Value = SpeedProfile> {
    prop::sample::select(&SpeedProfile::ALL[1..])
}
