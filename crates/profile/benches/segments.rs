//! What planning and compiling cost on the host: `cargo bench -p isostep-profile`. `cargo xtask bench` gives the
//! figures of the chip.

use std::hint::black_box;
use std::sync::atomic::AtomicU32;

use divan::Bencher;
use divan::counter::ItemsCount;
use isostep_profile::{IntervalLaw, Limits, Segment, SpeedLaw, SyncMove};

const TICK_HZ: u32 = 125_000_000;
const STEPS: i32 = 120_000;

/// From rest to 1,000,000 steps/s in 0.1 s.
const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 1_000_000.0,
    accel_steps_s2: 10_000_000.0,
    decel_steps_s2: 10_000_000.0,
    jerk_steps_s3: f64::INFINITY,
};

fn main() {
    divan::main();
}

fn plan_of(steps: [i32; 3], law: IntervalLaw) -> SyncMove<3> {
    SyncMove::plan(steps, &[LIMITS; 3], law, SpeedLaw::Trapezoid, None).expect("the limits are constants that work")
}

fn ramp() -> SyncMove<3> {
    plan_of([STEPS, 0, 0], IntervalLaw::Fastest)
}

/// Plans a move of three axes and compiles the first segment of each axis.
#[divan::bench(args = [IntervalLaw::Fastest, IntervalLaw::Thirds])]
fn plan(law: IntervalLaw) -> u64 {
    let plan = plan_of(black_box([STEPS, -70_001, 33_333]), law);
    let firsts = [0, 1, 2].map(|axis| plan.segments(axis, TICK_HZ).next());
    firsts.iter().flatten().map(Segment::last_ticks).sum()
}

/// All segments of an axis, from rest to rest.
#[divan::bench]
fn compile(bencher: Bencher) {
    let plan = ramp();
    let segments = || black_box(&plan).segments(0, TICK_HZ);
    bencher.counter(ItemsCount::new(segments().count())).bench(|| segments().map(|segment| segment.last_ticks()).max());
}

/// All intervals of an axis, a buffer at a time: the work that is done per step.
#[divan::bench]
fn fill(bencher: Bencher) {
    let segments: Vec<Segment> = ramp().segments(0, TICK_HZ).collect();
    let words: Vec<AtomicU32> = (0..256).map(AtomicU32::new).collect();
    bencher.counter(ItemsCount::new(STEPS as usize)).bench(|| {
        for segment in &segments {
            let mut intervals = segment.intervals();
            while intervals.fill(black_box(&words), 1) > 0 {}
        }
    });
}
