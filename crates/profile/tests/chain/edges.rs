use isostep_profile::chain::*;
use isostep_profile::*;
#[test]
fn debug() {
    let l = |s, t, a, d| Limits {
        start_speed_steps_s: s,
        top_speed_steps_s: t,
        accel_steps_s2: a,
        decel_steps_s2: d,
        jerk_steps_s3: 1e4,
    };
    let limits = [l(5.238748290188814, 523.87, 1422.5, 711.25), l(0.1, 10.0, 50.0, 50.0), l(0.1, 10.0, 422.13, 422.13)];
    let mut chain =
        Chain::<3, 8>::new(Terms::new(limits, [0.1; 3], 0.00112625, IntervalLaw::Fastest, SpeedLaw::Linear));
    chain.override_speed(1.647599996290743, 0.25);
    for (tag, steps) in [[1, 0, 0], [0, 0, 1]].into_iter().enumerate() {
        chain.push(Wanted { steps, feed_mm_s: Some(0.5051201225339788), stops: false, tag: tag as u32 }).unwrap();
    }
    let tell = |leg: Leg<3>| {
        println!(
            "{} {:?} {} {} to {} | {} {} {}",
            leg.tag,
            leg.kind,
            leg.until_steps,
            leg.until_s,
            leg.part.end_s(),
            leg.part.profile.entry_speed_steps_s(),
            leg.part.profile.cruise_speed_steps_s(),
            leg.part.profile.exit_speed_steps_s()
        )
    };
    tell(chain.advance(0.08527419645875675).unwrap());
    for _ in 0..4 {
        tell(chain.advance(0.006203608925765449).unwrap());
    }
    chain.override_speed(0.34653338049951193, 0.25);
    println!("{chain:?}");
    while let Some(leg) = chain.advance(1e9) {
        tell(leg);
    }
}
