//! Compares the machine's seven profiles within the same limits, and says which to choose.

use anyhow::Result;
use isostep_profile::{Limits, Profile, SpeedProfile};
use isostep_report::pictures::chart::{self, Axis, Chart, Curve, Scale};
use isostep_report::pictures::document::{Picture, Section, Table};
use isostep_report::pictures::profile;
use isostep_report::pictures::theme::{CURVE, Colour};
use isostep_report::speed_profiles::Exact;
use isostep_sim::analysis::{Oscillator, deviation, mean};

use crate::frequency::vibration::{DAMPING_RATIO, Drive, NATURAL_HZ, without_jumps};

/// The gantry's default limits at 50 steps/mm, with the start speed that the profiles over displacement need.
pub const LIMITS: Limits = Limits {
    start_speed_steps_s: 480.0,
    top_speed_steps_s: 2_400.0,
    accel_steps_s2: 2_500.0,
    decel_steps_s2: 2_500.0,
    jerk_steps_s3: 25_000.0,
};
/// 200 mm on the gantry.
pub const STEPS: f64 = 10_000.0;

/// Number of sampled intervals per ramp.
const PIECES: u32 = 4_000;
/// The time for which the ringing is observed after the end of the longest move, s.
const AFTER_S: f64 = 0.5;
/// Samples of the carriage's acceleration per second.
const READINGS_HZ: f64 = 1_000.0;

/// The use of each profile, in the order of [`SpeedProfile::ALL`].
const ADVICE: [&str; 7] = [
    "the fastest there is within the limit of acceleration; a jolt at each of its four corners",
    "the first choice: a little longer, no jolt, and as gentle as its jerk is set",
    "gentler still and nothing to set; its ramps are pi/2 times as long as a trapezoid's",
    "gentle at low speed, hardest at the top, where a stepper has least torque; jolts at the top speed",
    "the same, more so: a long creep before a short burst",
    "no jolt: the gentlest of Fonseca-Campos's; slow to leave the start speed",
    "hardest at low speed, where a stepper has most torque: the fastest of Fonseca-Campos's; jolts at start and end",
];

/// The move by one profile.
struct Move {
    exact: Exact,
    curve: profile::Curve,
    /// The effect on a carriage, without the jump to the start speed, which is the same for all profiles.
    drive: Drive,
}

impl Move {
    fn by(speed_profile: SpeedProfile) -> Result<Self> {
        let exact = Exact(crate::plan(STEPS, &LIMITS, speed_profile)?);
        let curve = exact.curve(speed_profile.name());
        let drive = drive(&exact.0);
        Ok(Self { exact, curve, drive })
    }

    /// The standard deviation of the acceleration of a carriage with natural frequency `natural_hz`, over `window_s`;
    /// steps/s².
    fn ringing(&self, natural_hz: f64, window_s: f64) -> Result<f64> {
        let count = (window_s * READINGS_HZ) as usize;
        let instants: Vec<f64> = (0..count).map(|n| n as f64 / READINGS_HZ).collect();
        Ok(deviation(&Oscillator::new(natural_hz, DAMPING_RATIO)?.ring(&self.drive, &instants)))
    }

    /// The root of the mean square of [`ringing`](Self::ringing) over carriages of 40 to 50 Hz.
    fn mean_ringing(&self, window_s: f64) -> Result<f64> {
        let all = NATURAL_HZ.into_iter().map(|hz| self.ringing(hz, window_s)).collect::<Result<Vec<_>>>()?;
        let squares: Vec<f64> = all.iter().map(|deviation| deviation * deviation).collect();
        Ok(mean(&squares).sqrt())
    }
}

/// Corners of the speed: many on each ramp.
fn drive(plan: &Profile) -> Drive {
    let ramp =
        |from_s: f64, to_s: f64| (0..=PIECES).map(move |k| from_s + (to_s - from_s) * f64::from(k) / f64::from(PIECES));
    let total_s = plan.duration_s();
    let instants_s = ramp(0.0, plan.t_accel_s()).chain(ramp(total_s - plan.t_decel_s(), total_s));
    without_jumps(&instants_s.map(|t_s| (t_s, plan.speed_at(t_s))).collect())
}

/// The window in which all moves end and ring out, s.
fn window_s(moves: &[Move]) -> f64 {
    moves.iter().map(|one| one.exact.0.duration_s()).fold(0.0, f64::max) + AFTER_S
}

/// The section of the page.
pub fn section() -> Result<Section> {
    let moves = SpeedProfile::ALL.into_iter().map(Move::by).collect::<Result<Vec<_>>>()?;
    let section = Section::new("What to choose: the machine's seven profiles within the same limits")
        .with_text(format!(
            "One move of {STEPS} steps by every profile that Isostep can be set to, each as fast as the same limits allow: \
             {} steps/s2 and {} steps/s, from a start speed of {} steps/s, and {} steps/s3 for the S-curve. Trapezoid, \
             S-curve and sine are profiles over time. The others are Fonseca-Campos's, over displacement: from standstill they would \
             never start, and the slower the start speed, the longer they take.",
            LIMITS.accel_steps_s2, LIMITS.top_speed_steps_s, LIMITS.start_speed_steps_s, LIMITS.jerk_steps_s3
        ))
        .with_text(
            "Ringing is that of the model of figure 13, for carriages of 40 to 50 Hz and all profiles over the same time; the jump \
             to the start speed, the same for all, is left out. That the torque of a stepper falls with its speed is in no \
             limit here: it speaks for profiles that accelerate early.",
        );
    Ok(section.with_pictures([motion(&moves), resonance(&moves)?]).with_tables([figures(&moves)?, advice()]))
}

fn figures(moves: &[Move]) -> Result<Table> {
    let window_s = window_s(moves);
    let duration_s = |one: &Move| one.exact.0.duration_s();
    let (trapezoid_s, trapezoid) = (duration_s(&moves[0]), moves[0].mean_ringing(window_s)?);
    let mut rows = Vec::new();
    for one in moves {
        rows.push(vec![
            one.curve.name.clone(),
            format!("{:.3}", duration_s(one)),
            format!("{:.1}", 100.0 * (duration_s(one) / trapezoid_s - 1.0)),
            format!("{:.0}", one.exact.peak_accel()),
            format!("{:.0}", one.exact.accel_jump()),
            format!("{:.0}", one.exact.jerk_beside_jumps()),
            format!("{:.3}", one.mean_ringing(window_s)? / trapezoid),
        ]);
    }
    let head = [
        "profile",
        "duration, s",
        "longer, %",
        "acceleration, steps/s²",
        "its jump",
        "jerk, steps/s³",
        "ringing (a model)",
    ];
    let caption =
        "Duration, highest acceleration, its greatest jump, highest jerk beside that, ringing of the trapezoid's";
    Ok(Table::new(&head, rows).captioned(caption))
}

fn advice() -> Table {
    let rows = SpeedProfile::ALL
        .into_iter()
        .zip(ADVICE)
        .map(|(speed_profile, advice)| [speed_profile.name(), advice].map(str::to_owned).to_vec());
    Table::new(&["profile", ""], rows.collect()).captioned("What each is good for")
}

fn key() -> Vec<(Colour, String)> {
    chart::key(SpeedProfile::ALL.map(SpeedProfile::name))
}

fn motion(moves: &[Move]) -> Picture {
    let chart = |name: &str, quantity: fn(&profile::Curve) -> &[(f64, f64)]| {
        let curves = moves.iter().zip(CURVE).rev();
        let lines = curves.map(|(one, colour)| Curve::line(colour, quantity(&one.curve).iter().copied()));
        Chart::new("time, s", name, lines.collect())
    };
    let panels = [chart("speed, steps/s", |curve| &curve.speed), chart("acceleration, steps/s²", |curve| &curve.accel)];
    Picture::new(
        "profiles-motion",
        chart::picture("Speed and acceleration of the seven profiles within the same limits", &key(), 1, 300, &panels),
        "All of them touch the limit of acceleration; how much of a ramp is spent there makes a profile fast or slow. A \
         trapezoid's ramp is nowhere else.",
    )
}

fn resonance(moves: &[Move]) -> Result<Picture> {
    let window_s = window_s(moves);
    let mut curves = Vec::new();
    for (one, colour) in moves.iter().zip(CURVE).rev() {
        let ringing = |hz: f64| Ok((hz, one.ringing(hz, window_s)?));
        let points = (10..=100).map(|hz| ringing(f64::from(hz))).collect::<Result<Vec<_>>>()?;
        curves.push(Curve::line(colour, points));
    }
    let y = Axis::scaled("ringing, steps/s²", Scale::Logarithmic);
    let chart = Chart::new("natural frequency of the carriage, Hz", y, curves);
    let title = "Ringing of the seven profiles over the natural frequency of the carriage";
    Ok(Picture::new(
        "profiles-ringing",
        chart::picture(title, &key(), 1, 320, &[chart]),
        "What rings in carriages of 10 to 100 Hz (a model), standard deviation. Above: profiles whose acceleration jumps. Far below: \
         profiles where only the jerk does. The S-curve dips where its jerk lasts for whole periods of the \
         carriage, 0.1 s here, every 10 Hz.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(speed_profile: SpeedProfile) -> Exact {
        Move::by(speed_profile).unwrap().exact
    }

    #[test]
    fn every_speed_profile_keeps_the_limits() {
        for speed_profile in SpeedProfile::ALL {
            let exact = exact(speed_profile);
            assert!(
                exact.peak_accel() <= LIMITS.accel_steps_s2 * (1.0 + 1e-9),
                "{speed_profile}: {}",
                exact.peak_accel()
            );
            assert!(exact.0.cruise_speed_steps_s() <= LIMITS.top_speed_steps_s * (1.0 + 1e-9), "{speed_profile}");
        }
    }

    #[test]
    fn the_trapezoid_is_the_fastest_and_the_s_curve_next() {
        let duration_s = |speed_profile| exact(speed_profile).0.duration_s();
        let (trapezoid, s_curve) = (duration_s(SpeedProfile::Trapezoid), duration_s(SpeedProfile::SCurve));
        for speed_profile in SpeedProfile::ALL {
            assert!(duration_s(speed_profile) >= trapezoid, "{speed_profile}");
            assert!(
                speed_profile == SpeedProfile::Trapezoid || duration_s(speed_profile) >= s_curve,
                "{speed_profile}"
            );
        }
    }

    /// By hand: 1,920 steps/s at 2,500 steps/s² take 0.768 s. At 25,000 steps/s³ the acceleration is reached after 0.1
    /// s, which makes each ramp 0.1 s longer.
    #[test]
    fn ramps_by_hand() {
        let [trapezoid, s_curve] = [SpeedProfile::Trapezoid, SpeedProfile::SCurve].map(exact);
        assert!((trapezoid.0.t_accel_s() - 0.768).abs() < 1e-9);
        assert!((s_curve.0.t_accel_s() - 0.868).abs() < 1e-9);
        assert!((s_curve.jerk_beside_jumps() - 25_000.0).abs() < 1e-6);
        assert!((trapezoid.accel_jump() - 2_500.0).abs() < 1e-6);
    }

    #[test]
    fn speed_profiles_that_are_smooth_over_time_hardly_ring() {
        let moves = SpeedProfile::ALL.map(|speed_profile| Move::by(speed_profile).unwrap());
        let ringing = |index: usize| moves[index].mean_ringing(window_s(&moves)).unwrap();
        let trapezoid = ringing(0);
        assert!(ringing(1) < trapezoid / 10.0 && ringing(2) < trapezoid / 50.0);
    }
}
