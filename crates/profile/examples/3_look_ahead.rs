//! Moves that follow each other without a stop: how fast each corner is taken, and a feed hold on the way.
//!
//! Run it with `cargo run -p isostep-profile --example 3_look_ahead`.

use isostep_profile::chain::{Chain, ChainConfig, ChunkKind, Request};
use isostep_profile::{IntervalSplit, Limits, PlanError, SpeedProfile};

const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 5_000.0,
    accel_steps_s2: 2_500.0,
    decel_steps_s2: 2_500.0,
    jerk_steps_s3: f64::INFINITY,
};
const STEPS_PER_MM: f64 = 50.0;
/// Grbl's `$11`: it decides how fast a corner is taken.
const JUNCTION_DEVIATION_MM: f64 = 0.01;
/// A chunk lasts so long at most, s. What has been told can no longer be changed.
const CHUNK_S: f64 = 0.05;

/// Two moves straight on, one round a corner: prints the chunks as a machine would get them.
pub fn main() -> Result<(), PlanError> {
    let mm_per_step = [1.0 / STEPS_PER_MM; 2];
    let config = ChainConfig::new(
        [LIMITS; 2],
        mm_per_step,
        JUNCTION_DEVIATION_MM,
        IntervalSplit::Fastest,
        SpeedProfile::Trapezoid,
    );
    let mut chain: Chain<2, 8> = Chain::new(config);
    for (tag, steps) in (1..).zip([[250, 0], [250, 0], [0, 250]]) {
        chain.push(Request { feed_mm_s: Some(30.0), tag, ..Request::new(steps) })?;
    }
    chain.start();
    while let Some(chunk) = chain.advance(CHUNK_S) {
        let kind = match chunk.kind {
            ChunkKind::Move => "begins",
            ChunkKind::Replan => "goes on by another plan",
            ChunkKind::Continuation => "goes on",
        };
        let speed_mm_s = chunk.plan.line().map_or(0.0, |line| line.speed_at(chunk.until_s) * chunk.mm_per_step);
        println!("{:.3} s: move {} {kind}, then has {speed_mm_s:.1} mm/s", chunk.until_s, chunk.tag);
        if chunk.tag == 2 && !chain.is_held() {
            // It brakes from here on. It comes to rest within what it knows.
            chain.hold();
        }
    }
    assert!(chain.is_held() && chain.is_at_rest() && !chain.is_empty());
    println!("held at {:.3} s, with {} moves left", chain.at_s(), chain.len());

    // The rest is made on another clock.
    chain.start();
    while chain.advance(CHUNK_S).is_some() {}
    assert!(chain.is_empty());
    println!("resumed, the rest takes {:.3} s", chain.at_s());
    Ok(())
}
