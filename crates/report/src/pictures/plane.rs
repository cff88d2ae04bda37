//! The plane of two axes as a picture: its frame with labels, and where places are in it, with the travel where the machine
//! was homed.

use isostep_console::Settings;

use super::chart::{Axis, Chart, Curve, FRAME, Label, Place, Style};
use super::strokes::Point;
pub use super::theme::FINE;
use super::theme::{self, AXIS_NAMES, Area, BOUND, Drawn, RACK};
use isostep_motion::AXES;
use isostep_sim::MoveRecord;
use isostep_sim::Outcome;

/// The axes of a plane: to the right, and upwards.
pub type Axes = [usize; 2];
/// The plane that is always drawn.
pub const XY: Axes = [0, 1];

/// The letters of a plane.
pub fn letters(axes: Axes) -> String {
    axes.map(|axis| AXIS_NAMES[axis]).concat()
}

/// True if a move moves either axis.
pub fn moves_in(outcome: &Outcome, record: &MoveRecord, axes: Axes) -> bool {
    let [from_mm, to_mm] = [record.origin_steps, record.end_steps].map(|steps| outcome.mm(steps));
    axes.iter().any(|&axis| from_mm[axis] != to_mm[axis])
}

/// The room that a plane may take.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Room {
    /// Size of the area inside the labels, in fine pixels; a flat path is lower.
    pub inner: (f64, f64),
    /// The least height.
    pub lowest: f64,
    /// The height kept free above, pixels.
    pub above: u32,
    /// True if the whole machine may be shown: the rack of the parking gantry.
    pub with_rack: bool,
}

/// Converts millimetres to positions in the picture.
pub struct Plane {
    /// Its axes.
    pub axes: Axes,
    /// The least and greatest positions on both axes, mm.
    pub extent_mm: [(f64, f64); 2],
    room: Room,
    homed: bool,
    /// True if the machine is the parking gantry, whose rack is shown.
    has_rack: bool,
    /// The ranges shown to the right and upwards.
    right_mm: (f64, f64),
    up_mm: (f64, f64),
}

impl Plane {
    /// Chooses the area that is shown, with the same scale in both directions.
    pub fn new(outcome: &Outcome, axes: Axes, room: Room) -> Self {
        let homed = outcome.moves.iter().any(|record| record.homing);
        let has_rack = room.with_rack && homed && axes == XY && is_parking_gantry(outcome);
        let extent_mm = extent_mm(outcome, axes);
        let [mut right, mut up] = extent_mm;
        if has_rack {
            let (rack_x, rack_y) = rack_extent_mm();
            right = (right.0.min(rack_x.0), right.1.max(rack_x.1));
            up = (up.0.min(rack_y.0), up.1.max(rack_y.1));
        }
        let (wide, high) = room.inner;
        let scale = ((right.1 - right.0) / wide).max((up.1 - up.0) / high).max(1e-3) * 1.08;
        let high = ((up.1 - up.0) * 1.08 / scale).clamp(room.lowest, high).round();
        let around = |range: (f64, f64), pixels: f64| {
            let middle = (range.0 + range.1) / 2.0;
            (middle - scale * pixels / 2.0, middle + scale * pixels / 2.0)
        };
        let room = Room { inner: (wide, high), ..room };
        Self { axes, extent_mm, room, homed, has_rack, right_mm: around(right, wide), up_mm: around(up, high) }
    }

    /// The size of the picture, fine pixels.
    pub fn size(&self) -> (u32, u32) {
        let (wide, high) = self.room.inner;
        let around = (FRAME.left + FRAME.right, FRAME.above + FRAME.below + self.room.above);
        (wide as u32 + around.0 * FINE, high as u32 + around.1 * FINE)
    }

    /// The upper left corner inside the labels, in fine pixels.
    pub fn corner(&self) -> Point {
        [FRAME.left, FRAME.above + self.room.above].map(|pixels| f64::from(pixels * FINE))
    }

    /// The number of fine pixels to a millimetre.
    pub fn fine_per_mm(&self) -> f64 {
        self.room.inner.0 / (self.right_mm.1 - self.right_mm.0)
    }

    /// The place of a position in the picture.
    pub fn point(&self, mm: [f64; AXES]) -> Point {
        let (scale, [left, top]) = (self.fine_per_mm(), self.corner());
        let [right, up] = self.axes.map(|axis| mm[axis]);
        [left + (right - self.right_mm.0) * scale, top + (self.up_mm.1 - up) * scale]
    }

    /// Draws the frame below what is kept free.
    pub fn draw(&self, area: &Area, outcome: &Outcome) -> Drawn {
        let (_, own) = area.split_vertically(self.room.above * FINE);
        self.chart(outcome).draw(&own)
    }

    fn chart(&self, outcome: &Outcome) -> Chart {
        let [right, up] = self.axes;
        let axis =
            |axis: usize, (low, high): (f64, f64)| Axis::from(format!("{}, mm", AXIS_NAMES[axis])).within(low, high);
        let mut chart = Chart::new(axis(right, self.right_mm), axis(up, self.up_mm), Vec::new());
        if self.has_rack {
            chart.curves.extend(bays());
            chart.labels.extend(names());
        }
        if self.homed {
            let far = (outcome.travel_mm[right], outcome.travel_mm[up]);
            chart.curves.push(Curve::dashed(BOUND, [(0.0, 0.0), (far.0, 0.0), far, (0.0, far.1), (0.0, 0.0)]));
        }
        chart
    }

    /// A dot where the program starts, in the colour of a CSS variable.
    pub fn start(&self, outcome: &Outcome, colour: &str) -> String {
        let first = outcome.program_moves().find(|record| moves_in(outcome, record, self.axes));
        let Some(record) = first else { return String::new() };
        let [x, y] = self.point(outcome.mm(record.origin_steps));
        let is_low = y + 96.0 > self.corner()[1] + self.room.inner.1;
        let below = if is_low { y - 44.0 } else { y + 96.0 };
        let at = [x - 64.0, below].map(|at| at.round_ties_even() as u32);
        let dot = format!("<circle cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"{}\" fill=\"var({colour})\"/>", 7 * FINE);
        dot + &theme::text(at, 14, "", "start")
    }
}

/// The range of both axes over the moves that move either, mm.
fn extent_mm(outcome: &Outcome, axes: Axes) -> [(f64, f64); 2] {
    let moved = outcome.program_moves().filter(|record| moves_in(outcome, record, axes));
    let ends = moved.flat_map(|record| [record.origin_steps, record.end_steps].map(|steps| outcome.mm(steps)));
    axes.map(|axis| theme::range(ends.clone().map(|mm| mm[axis])))
}

/// The centres of the bays in the rack of the papers' parking gantry, mm. It is drawn behind the path of a program that parks
/// cars.
const COLUMNS_MM: [f64; 3] = [25.0, 175.0, 325.0];
const ROWS_MM: [f64; 3] = [160.0, 240.0, 320.0];
/// Width and height of a bay, mm.
const BAY_MM: (f64, f64) = (150.0, 80.0);
/// The place where cars are picked up and delivered, mm.
const PICK_UP_MM: (f64, f64) = (175.0, 40.0);

/// Recognises the parking gantry by its travel.
fn is_parking_gantry(outcome: &Outcome) -> bool {
    outcome.travel_mm == Settings::DEFAULT.travel_mm.map(f64::from)
}

/// The range of X and Y that is shown of the rack, mm.
fn rack_extent_mm() -> ((f64, f64), (f64, f64)) {
    let half_mm = BAY_MM.0 / 2.0;
    ((COLUMNS_MM[0] - half_mm, COLUMNS_MM[2] + half_mm), (0.0, 400.0))
}

fn middles_mm() -> impl Iterator<Item = (f64, f64)> {
    ROWS_MM.into_iter().flat_map(|y| COLUMNS_MM.into_iter().map(move |x| (x, y)))
}

/// The bays.
fn bays() -> impl Iterator<Item = Curve> {
    let (half_wide, half_high) = (BAY_MM.0 / 2.0, BAY_MM.1 / 2.0);
    let corners = move |(x, y): (f64, f64)| [(x - half_wide, y - half_high), (x + half_wide, y + half_high)];
    let outline = move |middle| {
        let [low, high] = corners(middle);
        Curve::new(Style::Thin, RACK, [low, (high.0, low.1), high, (low.0, high.1), low])
    };
    [Curve::bars(RACK, middles_mm().map(corners)).faint(0.12)].into_iter().chain(middles_mm().map(outline))
}

/// The names of the bays.
fn names() -> impl Iterator<Item = Label> {
    let bays = (1..).zip(middles_mm()).map(|(number, (x, y))| (format!("bay {number}"), (x, y - BAY_MM.1 * 0.36)));
    let (x, y) = PICK_UP_MM;
    let names = bays.chain([("pick-up point".to_owned(), (x, y - 16.0))]);
    names.map(|(text, at)| Label { colour: RACK, ..Label::new(at, Place::Centre, text) })
}
