//! The speed profiles side by side, for a move of one axis.

use isostep_profile::{IntervalSplit, Limits, Profile, SpeedProfile};
use isostep_report::speed_profiles::{Curve, Derivatives, Row, STEPS_MAX, rows};
use serde::Serialize;

use crate::trouble::Trouble;

/// Points of a phase that are drawn.
const POINTS: usize = 100;

/// The move that they are asked for.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "the names say what they are, and the unit")]
pub struct Asked {
    pub distance_mm: f64,
    pub steps_per_mm: f64,
    pub start_mm_s: f64,
    pub top_mm_s: f64,
    pub accel_mm_s2: f64,
    pub decel_mm_s2: f64,
    pub jerk_mm_s3: f64,
}

#[derive(Serialize)]
struct Table {
    names: Vec<&'static str>,
    rows: Vec<Row>,
    refused: Vec<Refused>,
    curves: Vec<Drawn>,
}

#[derive(Serialize)]
struct Refused {
    name: &'static str,
    words: String,
}

/// Times in s, and then mm.
#[derive(Serialize)]
struct Drawn {
    name: &'static str,
    times: Vec<f64>,
    speed: Vec<f64>,
    accel: Vec<f64>,
    jerk: Vec<f64>,
}

/// The figures of `isostep profile` for all speed profiles, and their curves, as JSON. A speed profile that cannot make the move
/// says why.
///
/// # Errors
/// [`Trouble`] if the move has no step, or too many.
pub fn of(asked: &Asked) -> Result<String, Trouble> {
    let steps = (asked.distance_mm * asked.steps_per_mm).round();
    if !(1.0..=f64::from(STEPS_MAX)).contains(&steps) {
        let words = format!("a move of {steps} steps: enter a distance and steps/mm that make 1 to {STEPS_MAX}");
        return Err(Trouble::without_line(words));
    }
    let (mut curves, mut refused) = (Vec::new(), Vec::new());
    for speed_profile in SpeedProfile::ALL {
        match plan(asked, speed_profile, steps) {
            Ok(profile) => curves.push((speed_profile, Curve::exact(speed_profile.name(), profile, steps as u32))),
            Err(words) => refused.push(Refused { name: speed_profile.name(), words }),
        }
    }
    let drawn = curves
        .iter()
        .filter_map(|(speed_profile, curve)| drawn(speed_profile.name(), curve, asked.steps_per_mm))
        .collect();
    let names = curves.iter().map(|(speed_profile, _)| speed_profile.name()).collect();
    let curves: Vec<_> = curves.into_iter().map(|(_, curve)| curve).collect();
    let speed_profiles = Table { names, rows: rows(&curves), refused, curves: drawn };
    Ok(serde_json::to_string(&speed_profiles).expect("numbers and texts have a form in JSON"))
}

fn plan(asked: &Asked, speed_profile: SpeedProfile, steps: f64) -> Result<Profile, String> {
    let per_mm = asked.steps_per_mm;
    let jerk = if speed_profile == SpeedProfile::SCurve { asked.jerk_mm_s3 * per_mm } else { f64::INFINITY };
    let limits = Limits {
        start_speed_steps_s: asked.start_mm_s * per_mm,
        top_speed_steps_s: asked.top_mm_s * per_mm,
        accel_steps_s2: asked.accel_mm_s2 * per_mm,
        decel_steps_s2: asked.decel_mm_s2 * per_mm,
        jerk_steps_s3: jerk,
    };
    let start = limits.start_speed_steps_s;
    Profile::plan(steps, start, start, &limits, IntervalSplit::Fastest, speed_profile)
        .map_err(|error| error.to_string())
}

fn drawn(name: &'static str, curve: &Curve, steps_per_mm: f64) -> Option<Drawn> {
    let Derivatives { speed, accel, jerk, .. } = curve.exact.as_ref()?.curve_of(name, POINTS);
    let mm = |points: &[(f64, f64)]| points.iter().map(|(_, steps)| steps / steps_per_mm).collect();
    let times = speed.iter().map(|(t_s, _)| *t_s).collect();
    Some(Drawn { name, times, speed: mm(&speed), accel: mm(&accel), jerk: mm(&jerk) })
}
