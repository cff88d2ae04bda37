//! Forero 2023: the parking gantry.

mod interpolation;
mod intervals;

use anyhow::Result;
use isostep_report::pictures::document::Section;

use super::Part;
use super::row::Paper;

/// All rows and sections of this paper.
pub fn part() -> Result<Part> {
    let rows = [intervals::rows()?, interpolation::rows()?].concat();
    Ok(Part { paper: Paper::Gantry, rows, sections: vec![staircase()?, axes()?] })
}

fn staircase() -> Result<Section> {
    let section = Section::new("Figure 2 and Table 1: the staircase").with_text(
        "The paper's microcontroller makes a ramp in 20 intervals of constant speed (equations 8 to 12) with timers that \
         count from whole preloads (13 and 14). Its flow charts are pictures, so how it ends an interval is assumed: the \
         half period under way is lost. Whole preloads alone then lose the steps of the table, and the last interval, \
         which makes up for them at the lowest speed, ends the deceleration after 4.94 s. The paper timed 6.8 s: as \
         if every reload of a preload cost between one and two counts of 2 us more, which its program may well do and \
         the paper does not say. Equation 13 as printed, T_int = V_int/2, is upside down: half a step period is 1/(2 V_int).",
    );
    let tables = [intervals::reload_table()?, intervals::tread_table()?];
    Ok(section.with_pictures([intervals::picture()?]).with_tables(tables))
}

fn axes() -> Result<Section> {
    Ok(Section::new("Figure 9: two axes").with_pictures([interpolation::picture()?]))
}
