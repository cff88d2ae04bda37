//! How far the axes leave the path of a program, from the closed forms of its plans.

use isostep_report::shaping::ShapingFigures;
use isostep_sim::verify::Together;
use isostep_sim::{AXES, MoveRecord, Outcome};
use serde::Serialize;

/// The farthest of each kind, mm; `None` where there is nothing of that kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Departures {
    /// Of a corner from the blend round it.
    pub corners_mm: Option<f64>,
    /// Of the end of a short move from the line that it is made as, together with others.
    pub together_mm: Option<f64>,
    /// Of the axes from all that, by what shapers make of it.
    pub shaped_mm: Option<f64>,
    /// The last move is a part of an arc, and more parts follow: blends are what makes the arc of them.
    #[serde(skip)]
    is_in_arc: bool,
}

impl Departures {
    /// Adds those of the next piece of a run. Shaped runs are whole in a piece.
    pub fn add(&mut self, piece: &Outcome) {
        for record in piece.program_moves() {
            let steps_per_mm = &piece.config_of(record).steps_per_mm;
            farther(&mut self.corners_mm, corner_mm(record, steps_per_mm).filter(|_| !self.is_in_arc));
            self.is_in_arc = record.asked.last().is_some_and(|asked| asked.in_arc);
            let together = Together::of(record, steps_per_mm);
            farther(&mut self.together_mm, (together.lines > 0).then_some(together.farthest_mm));
        }
        let shaping = ShapingFigures::of(piece, &vec![None; piece.moves.len()]);
        farther(&mut self.shaped_mm, shaping.and_then(|shaping| shaping.deviation).map(|farthest| farthest.mm));
    }
}

fn farther(most_mm: &mut Option<f64>, mm: Option<f64>) {
    *most_mm = [*most_mm, mm].into_iter().flatten().reduce(f64::max);
}

/// The distance of a corner from the middle of its blend: the acceleration of its axes for half of its time, up to there and away.
fn corner_mm(record: &MoveRecord, steps_per_mm: &[f64; AXES]) -> Option<f64> {
    let blend = record.blend?;
    let by_axis =
        (0..AXES).map(|axis| blend.accel_steps_s2(axis) * blend.corner_s().powi(2) / 8.0 / steps_per_mm[axis]);
    Some(by_axis.map(|mm| mm * mm).sum::<f64>().sqrt())
}
