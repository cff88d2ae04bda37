//! The rack of the papers' parking gantry, drawn behind the path of a program that parks cars.

use isostep_console::Settings;
use plotters::prelude::*;

use super::theme::{self, RACK};
use isostep_sim::Outcome;

/// Centres of its bays, mm.
const COLUMNS_MM: [f64; 3] = [25.0, 175.0, 325.0];
const ROWS_MM: [f64; 3] = [160.0, 240.0, 320.0];
/// Width and height of a bay, mm.
const BAY_MM: (f64, f64) = (150.0, 80.0);
/// Where cars are picked up and delivered, mm.
const PICK_UP_MM: (f64, f64) = (175.0, 40.0);

/// Whether the machine is the parking gantry, which is recognised by its travel.
pub fn is_of(outcome: &Outcome) -> bool {
    outcome.travel_mm == Settings::DEFAULT.travel_mm.map(f64::from)
}

/// The range of X and Y that is shown of it, mm.
pub fn extent_mm() -> ((f64, f64), (f64, f64)) {
    let half_mm = BAY_MM.0 / 2.0;
    ((COLUMNS_MM[0] - half_mm, COLUMNS_MM[2] + half_mm), (0.0, 400.0))
}

fn middles_mm() -> impl Iterator<Item = (f64, f64)> {
    ROWS_MM.into_iter().flat_map(|y| COLUMNS_MM.into_iter().map(move |x| (x, y)))
}

/// The bays, for a picture drawn larger by the factor `fine`.
pub fn bays(fine: u32) -> impl Iterator<Item = Rectangle<(f64, f64)>> {
    let (width, height) = BAY_MM;
    middles_mm().flat_map(move |(x, y)| {
        let corners = [(x - width / 2.0, y - height / 2.0), (x + width / 2.0, y + height / 2.0)];
        [Rectangle::new(corners, RACK.mix(0.12).filled()), Rectangle::new(corners, RACK.stroke_width(fine))]
    })
}

/// The names of the bays.
pub fn names(fine: u32) -> impl Iterator<Item = Text<'static, (f64, f64), String>> {
    let bays = middles_mm().enumerate().map(move |(index, (x, y))| {
        Text::new(format!("bay {}", index + 1), (x, y - BAY_MM.1 * 0.36), theme::centred(14 * fine).color(&RACK))
    });
    let (x, y) = PICK_UP_MM;
    bays.chain([Text::new("pick-up point".to_owned(), (x, y - 16.0), theme::centred(14 * fine).color(&RACK))])
}
