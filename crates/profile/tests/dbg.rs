use isostep_profile::chain::{Chain, ChainConfig, Request};
use isostep_profile::{IntervalLaw, Limits, SpeedLaw};
#[test]
fn dbg() {
    let l = Limits { start_speed_steps_s: 0.0, top_speed_steps_s: 10.0, accel_steps_s2: 50.0, decel_steps_s2: 50.0, jerk_steps_s3: 250.0 };
    let mut chain = Chain::<3, 8>::new(ChainConfig::new([l; 3], [0.1; 3], 0.0, IntervalLaw::Fastest, SpeedLaw::Trapezoid));
    let r = |steps, feed_mm_s, deviation_mm| Request { steps, feed_mm_s, stops: false, deviation_mm, tag: 0 };
    let f = Some(0.021640992034939084);
    chain.push(r([1, 0, 0], f, 0.0)).unwrap();
    chain.push(r([0, 1, 0], f, 0.3)).unwrap();
    chain.push(r([1, 0, 0], f, 0.3)).unwrap();
    for _ in 0..3 { println!("{:?}", chain.advance(f64::INFINITY)); }
    for _ in 0..2 { println!("{:?}", chain.advance(1.0)); }
    println!("pushed");
    chain.push(r([0, 0, 1], None, 0.3)).unwrap();
    while let Some(c) = chain.advance(f64::INFINITY) { println!("{c:?}"); }
}
