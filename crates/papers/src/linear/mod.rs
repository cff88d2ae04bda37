//! Stoychitch 2018: linear speed over time.

mod generators;
mod planning;
mod speed_error;

use anyhow::Result;
use isostep_report::pictures::document::Section;

use super::Part;
use super::row::Paper;

/// All rows and sections of this paper.
pub fn part() -> Result<Part> {
    let rows = [planning::rows()?, speed_error::rows()?].concat();
    Ok(Part { paper: Paper::Linear, rows, sections: vec![trajectory()?, pulses()?] })
}

fn trajectory() -> Result<Section> {
    let section = Section::new("Figures 1 and 3: planning").with_text(
        "The motor of the appendix: K = 4096 steps a revolution, v_s = 0.5 rad/s, v_M = 2 rad/s, a_M = 2 rad/s2, m = 2. \
         The paper prints the method and no results, so its equations 1 to 8 are run here as they stand, whole steps as \
         its appendix makes them, beside our planner. One slip: for a triangle the appendix cuts N/(1+m) down where \
         eq 5 rounds it; 326 steps have N_a = 109 by eq 5 and 108 by the appendix.",
    );
    Ok(section.with_pictures([planning::picture()?]))
}

fn pulses() -> Result<Section> {
    let section = Section::new("Figures 2 and 5: the generators").with_text(
        "Each generator makes one revolution of that motor; ours and time per step count microseconds, steps per time is \
         served 10,000 times a second as in the paper's program. Time per step is held against the speed that the profile \
         has at each step, which is what its equations mean; the others against the time that the profile takes from step \
         to step. Simulated, in double precision.",
    );
    let pictures = [speed_error::steps()?, speed_error::stairs()?, speed_error::picture()?];
    Ok(section.with_pictures(pictures).with_tables([speed_error::table()?]))
}
