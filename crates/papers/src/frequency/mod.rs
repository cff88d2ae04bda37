//! Fonseca-Campos 2023: frequency over the step index.

mod durations;
mod figures;
mod parameters;
mod ringing;
mod straightness;
pub mod vibration;

use anyhow::Result;
use isostep_report::pictures::document::Section;

use super::Part;
use super::row::Paper;

/// All rows and sections of this paper.
pub fn part() -> Result<Part> {
    let rows = [durations::rows()?, straightness::rows()?, figures::rows()?, ringing::rows()?].concat();
    Ok(Part { paper: Paper::Frequency, rows, sections: vec![simulations()?, ramp()?, vibration()?] })
}

fn simulations() -> Result<Section> {
    let section = Section::new("Figures 7, 10, 11 and 12: the four profiles").with_text(
        "Equations 5 to 8 give the frequency of each step; the instants are the sums of the periods. Speed, acceleration \
         and jerk are second-order differences on unequal spacing, as NumPy's gradient takes them for the paper. \"As \
         printed\" are the program's even microseconds, \"exact\" the same equations without truncation. Simulated.",
    );
    Ok(section.with_pictures(figures::pictures()?).with_tables([durations::table()?, figures::table()?]))
}

fn ramp() -> Result<Section> {
    Ok(Section::new("Why the linear profile is not linear").with_pictures([straightness::picture()?]))
}

fn vibration() -> Result<Section> {
    let section = Section::new("Figure 13 and Table 7: residual vibration (a model)")
        .with_text(format!(
            "A model, not a measurement: the carriage is one mass on a damped spring, x'' + 2 ζ ω x' + ω² x = -a(t), \
             solved in closed form between the steps of Table 6's profiles; what is read is x''. Damping ζ = {}; natural \
             frequencies 40 to 50 Hz in steps of 1 Hz, where the paper saw most power, and the mean square of all. \
             Sampling as the paper's: 10 ms, 180 samples, ten waveforms.",
            vibration::DAMPING_RATIO
        ))
        .with_text(
            "Left out: how the turning stage couples into the vertical, hence no absolute scale (one number is taken from \
             the paper: the sinusoidal profile's 0.022 m/s2); other modes, friction, the steps of the motor itself, the sensor's \
             5 Hz filter and its noise, gravity. Nothing else is fitted.",
        )
        .with_text(
            "Each move begins and ends with a jump of its speed to tau_max's, the same for all profiles, and much of what rings \
             is that jump: it is why the paper's linear and quadratic profiles are so close to the sinusoidal one. The last \
             column shows what the ramps alone would do: there the profiles are far apart. The logarithmic profile's multiple comes \
             out lower than the paper's.",
        );
    Ok(section.with_pictures(ringing::pictures()?).with_tables([ringing::table()?]))
}
