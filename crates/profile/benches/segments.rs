//! The cost of planning and compiling on the host: `cargo bench -p isostep-profile`. `cargo xtask bench` gives the
//! figures of the chip.
#![expect(clippy::disallowed_types, reason = "what is measured is the time on the clock of this computer")]

use std::hint::black_box;
use std::sync::atomic::AtomicU32;
use std::time::{Duration, Instant};

use isostep_profile::{IntervalSplit, Limits, Segment, SpeedProfile, SyncMove};

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

/// The least number of times that the work is done, and the least time.
const SAMPLES_MIN: u32 = 100;
const LONG_ENOUGH: Duration = Duration::from_secs(1);

fn main() {
    plan(IntervalSplit::Fastest);
    plan(IntervalSplit::Thirds);
    compile();
    fill();
}

/// Prints the shortest and the median time of the work, for each of its items.
fn time<T>(name: &str, items: usize, mut work: impl FnMut() -> T) {
    let start = Instant::now();
    let mut samples_ns = Vec::new();
    while samples_ns.len() < SAMPLES_MIN as usize || start.elapsed() < LONG_ENOUGH {
        let start = Instant::now();
        black_box(work());
        samples_ns.push(start.elapsed().as_nanos() as f64 / items as f64);
    }
    samples_ns.sort_by(f64::total_cmp);
    println!(
        "{name:<16} {:>10.1} ns at least {:>10.1} ns in the median",
        samples_ns[0],
        samples_ns[samples_ns.len() / 2]
    );
}

fn plan_of(steps: [i32; 3], interval_split: IntervalSplit) -> SyncMove<3> {
    SyncMove::plan(steps, &[LIMITS; 3], interval_split, SpeedProfile::Trapezoid, None)
        .expect("the limits are constants that work")
}

fn ramp() -> SyncMove<3> {
    plan_of([STEPS, 0, 0], IntervalSplit::Fastest)
}

/// Plans a move of three axes and compiles the first segment of each axis.
fn plan(interval_split: IntervalSplit) {
    time(&format!("plan, {interval_split:?}"), 1, || {
        let plan = plan_of(black_box([STEPS, -70_001, 33_333]), interval_split);
        let firsts = [0, 1, 2].map(|axis| plan.segments(axis, TICK_HZ).next());
        firsts.iter().flatten().map(Segment::last_ticks).sum::<u64>()
    });
}

/// All segments of an axis, from rest to rest.
fn compile() {
    let plan = ramp();
    let segments = || black_box(&plan).segments(0, TICK_HZ);
    time("compile, each", segments().count(), || segments().map(|segment| segment.last_ticks()).max());
}

/// All intervals of an axis, a buffer at a time: the work that is done per step.
fn fill() {
    let segments: Vec<Segment> = ramp().segments(0, TICK_HZ).collect();
    let words: Vec<AtomicU32> = (0..256).map(AtomicU32::new).collect();
    time("fill, each step", STEPS as usize, || {
        for segment in &segments {
            let mut intervals = segment.intervals();
            while intervals.fill(black_box(&words), 1) > 0 {}
        }
    });
}
