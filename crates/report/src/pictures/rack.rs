//! The rack of the papers' parking gantry, drawn behind the path of a program that parks cars.

use isostep_console::Settings;

use super::chart::{Curve, Label, Place, Style};
use super::theme::RACK;
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

/// The bays.
pub fn bays() -> impl Iterator<Item = Curve> {
    let (half_wide, half_high) = (BAY_MM.0 / 2.0, BAY_MM.1 / 2.0);
    let corners = move |(x, y): (f64, f64)| [(x - half_wide, y - half_high), (x + half_wide, y + half_high)];
    let outline = move |middle| {
        let [low, high] = corners(middle);
        Curve::new(Style::Thin, RACK, [low, (high.0, low.1), high, (low.0, high.1), low])
    };
    [Curve::bars(RACK, middles_mm().map(corners)).faint(0.12)].into_iter().chain(middles_mm().map(outline))
}

/// The names of the bays.
pub fn names() -> impl Iterator<Item = Label> {
    let bays = (1..).zip(middles_mm()).map(|(number, (x, y))| (format!("bay {number}"), (x, y - BAY_MM.1 * 0.36)));
    let (x, y) = PICK_UP_MM;
    let names = bays.chain([("pick-up point".to_owned(), (x, y - 16.0))]);
    names.map(|(text, at)| Label { colour: RACK, ..Label::new(at, Place::Centre, text) })
}
