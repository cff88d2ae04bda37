//! Compares the machine's seven laws within the same limits, and says which to choose.

mod moves;

use anyhow::Result;
use isostep_profile::{Profile, SpeedLaw};
use isostep_report::pictures::chart::{self, Axis, Chart, Curve, Scale};
use isostep_report::pictures::document::{Picture, Section, Table};
use isostep_report::pictures::theme::{CURVE, Colour};

use self::moves::{LIMITS, STEPS};

/// What each law is good for, in the order of [`SpeedLaw::ALL`].
const ADVICE: [&str; 7] = [
    "the fastest there is within the limit of acceleration; a jolt at each of its four corners",
    "the first choice: a little longer, no jolt, and as gentle as its jerk is set",
    "gentler still and nothing to set; its ramps are pi/2 times as long as a trapezoid's",
    "gentle at low speed, hardest at the top, where a stepper has least torque; jolts at the top speed",
    "the same, more so: a long creep before a short burst",
    "no jolt: the gentlest of Fonseca-Campos's; slow to leave the start speed",
    "hardest at low speed, where a stepper has most torque: the fastest of Fonseca-Campos's; jolts at start and end",
];

/// The section of the page.
pub fn section() -> Result<Section> {
    let plans = SpeedLaw::ALL.into_iter().map(moves::plan).collect::<Result<Vec<_>>>()?;
    Ok(Section {
        heading: "What to choose: the machine's seven laws within the same limits".to_owned(),
        text: vec![
            format!(
                "One move of {STEPS} steps by every law that Isostep can be set to, each as fast as the same limits allow: \
                 {} steps/s2 and {} steps/s, from a start speed of {} steps/s, and {} steps/s3 for the S-curve. Trapezoid, \
                 S-curve and sine are laws over time. The others are Fonseca-Campos's, over displacement: from standstill they would \
                 never start, and the slower the start speed, the longer they take.",
                LIMITS.accel_steps_s2, LIMITS.top_speed_steps_s, LIMITS.start_speed_steps_s, LIMITS.jerk_steps_s3
            ),
            "Ringing is that of the model of figure 13, for carriages of 40 to 50 Hz and all laws over the same time; the jump \
             to the start speed, the same for all, is left out. That the torque of a stepper falls with its speed is in no \
             limit here: it speaks for laws that accelerate early."
                .to_owned(),
        ],
        pictures: vec![motion(&plans), resonance(&plans)?],
        tables: vec![figures(&plans)?, advice()],
    })
}

fn figures(plans: &[Profile]) -> Result<Table> {
    let window_s = moves::window_s(plans);
    let ringing = |plan: &Profile| moves::mean_ringing(&moves::drive(plan), window_s);
    let (trapezoid_s, trapezoid) = (plans[0].duration_s(), ringing(&plans[0])?);
    let mut rows = Vec::new();
    for (law, plan) in SpeedLaw::ALL.into_iter().zip(plans) {
        let figures = [
            format!("{:.3}", plan.duration_s()),
            format!("{:.1}", 100.0 * (plan.duration_s() / trapezoid_s - 1.0)),
            format!("{:.0}", moves::peak_accel(plan)),
            format!("{:.0}", moves::accel_jump(plan)),
            format!("{:.0}", moves::peak_jerk(plan)),
            format!("{:.3}", ringing(plan)? / trapezoid),
        ];
        rows.push([law.name().to_owned()].into_iter().chain(figures).collect());
    }
    let head = [
        "law",
        "duration, s",
        "longer, %",
        "acceleration, steps/s²",
        "its jump",
        "jerk, steps/s³",
        "ringing (a model)",
    ];
    let caption =
        "Duration, highest acceleration, its greatest jump, highest jerk beside that, ringing of the trapezoid's"
            .to_owned();
    Ok(Table { caption, ..Table::new(&head, rows) })
}

fn advice() -> Table {
    let rows =
        SpeedLaw::ALL.into_iter().zip(ADVICE).map(|(law, advice)| vec![law.name().to_owned(), advice.to_owned()]);
    let head = ["law", ""];
    Table { caption: "What each is good for".to_owned(), ..Table::new(&head, rows.collect()) }
}

fn key() -> Vec<(Colour, String)> {
    chart::key(SpeedLaw::ALL.map(SpeedLaw::name))
}

fn motion(plans: &[Profile]) -> Picture {
    let chart = |name: &str, value: fn(&Profile, f64) -> f64| {
        let curve = |(colour, plan): (usize, &Profile)| {
            let inside = moves::instants_s(plan).into_iter().map(|t_s| (t_s, value(plan, t_s)));
            Curve::line(CURVE[colour], inside)
        };
        Chart::new("time, s", name, plans.iter().enumerate().rev().map(curve).collect())
    };
    let panels = [chart("speed, steps/s", Profile::speed_at), chart("acceleration, steps/s²", Profile::accel_at)];
    Picture::new(
        "laws-motion",
        chart::picture("Speed and acceleration of the seven laws within the same limits", &key(), 1, 300, &panels),
        "All of them touch the limit of acceleration; how much of a ramp is spent there makes a law fast or slow. A \
                  trapezoid's ramp is nowhere else.",
    )
}

fn resonance(plans: &[Profile]) -> Result<Picture> {
    let window_s = moves::window_s(plans);
    let mut curves = Vec::new();
    for (colour, plan) in plans.iter().enumerate().rev() {
        let drive = moves::drive(plan);
        let ringing = |hz: f64| Ok((hz, moves::ringing(&drive, hz, window_s)?));
        let points = (10..=100).map(|hz| ringing(f64::from(hz))).collect::<Result<Vec<_>>>()?;
        curves.push(Curve::line(CURVE[colour], points));
    }
    let chart = Chart::new(
        "natural frequency of the carriage, Hz",
        Axis::scaled("ringing, steps/s²", Scale::Logarithmic),
        curves,
    );
    Ok(Picture {
        name: "laws-ringing".to_owned(),
        svg: chart::picture("Ringing of the seven laws over the natural frequency of the carriage", &key(), 1, 320, &[chart]),
        caption:
            "What rings in carriages of 10 to 100 Hz (a model), standard deviation. Above: laws whose acceleration jumps. Far below: \
                  laws where only the jerk does. The S-curve dips where its jerk lasts for whole periods of the \
                  carriage, 0.1 s here, every 10 Hz."
                .to_owned(),
    })
}
