//! How far lines that are made for several moves are from where these moves were to end.

use std::fmt;

use isostep_motion::{AXES, Move};
use isostep_profile::OFFSET_PARTS;

use super::Verdict;
use crate::moves::MoveRecord;
use crate::outcome::Outcome;

/// Lines that are made for several moves, or that end beside where the last one was to end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Together {
    /// Number of moves that were made together with others.
    pub moves: usize,
    /// Number of lines that they were made as.
    pub lines: usize,
    /// The farthest that one of these lines, or another, is from where one of its moves was to end, mm.
    pub farthest_mm: f64,
    /// The farthest that one may be that is allowed most, mm.
    pub allowed_mm: f64,
    /// Number of lines that are farther from such a place than they may be.
    pub beyond: usize,
}

impl Together {
    /// Of one line. `steps_per_mm` are those of the axes then.
    pub fn of(record: &MoveRecord, steps_per_mm: &[f64; AXES]) -> Self {
        let asked = record.asked.iter().filter(|asked| asked.together_mm > 0.0);
        let far_mm = asked.map(|asked| (from_line_mm(record, asked, steps_per_mm), f64::from(asked.together_mm)));
        // A place is given in parts of a step, and made in whole steps where the machine stops.
        let grain_mm = size(&steps_per_mm.map(|steps_per_mm| 0.5 / steps_per_mm));
        let is_several = record.asked.len() > 1;
        let none = Self {
            moves: if is_several { record.asked.len() } else { 0 },
            lines: usize::from(is_several),
            ..Self::default()
        };
        far_mm.fold(none, |all, (far_mm, allowed_mm)| Self {
            farthest_mm: all.farthest_mm.max(far_mm),
            allowed_mm: all.allowed_mm.max(allowed_mm),
            beyond: all.beyond.max(usize::from(far_mm > allowed_mm + grain_mm)),
            ..all
        })
    }

    /// Of all lines of a program that are made for several moves.
    pub fn of_several(outcome: &Outcome) -> Self {
        let several = outcome.program_moves().filter(|record| record.asked.len() > 1);
        let each = several.map(|record| Self::of(record, &outcome.config_of(record).steps_per_mm));
        each.fold(Self::default(), Self::and)
    }

    /// Of these lines and others.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            moves: self.moves + other.moves,
            lines: self.lines + other.lines,
            farthest_mm: self.farthest_mm.max(other.farthest_mm),
            allowed_mm: self.allowed_mm.max(other.allowed_mm),
            beyond: self.beyond + other.beyond,
        }
    }

    /// The promise about them; `None` if no moves were taken together.
    pub(super) fn verdict(&self) -> Option<Verdict> {
        let Self { lines, beyond, .. } = *self;
        let detail = match beyond {
            0 => String::new(),
            _ => format!(", {beyond} farther than they may be"),
        };
        (lines > 0 || beyond > 0).then(|| Verdict {
            promise: "moves taken together near enough",
            kept: beyond == 0,
            detail: format!("{self}{detail}"),
        })
    }
}

impl fmt::Display for Together {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { moves, lines, farthest_mm, allowed_mm, .. } = self;
        write!(f, "{moves} as {lines} lines, {farthest_mm:.4} mm beside their ends at most, of {allowed_mm:.4}")
    }
}

/// The distance of the place where a move was to end from the line that it is made as, mm.
fn from_line_mm(record: &MoveRecord, asked: &Move, steps_per_mm: &[f64; AXES]) -> f64 {
    let corner_steps = record.corner_steps();
    let [begin, end, place] = [0, 1, 2].map(|which| {
        std::array::from_fn::<_, AXES, _>(|axis| {
            // A move that was held goes on in the middle of its line.
            let gone = match record.blend {
                Some(_) => 0,
                None => (record.plan.step_numbers(axis).start - 1) as i32 * record.plan.steps[axis].signum(),
            };
            let from_steps = f64::from(corner_steps[axis] - gone);
            let steps = match which {
                0 => from_steps + record.plan.axis_place(axis, 0.0),
                1 => from_steps + record.plan.axis_place(axis, record.plan.distance_steps()),
                _ => f64::from(asked.target_steps[axis]) + f64::from(asked.offsets[axis]) / f64::from(OFFSET_PARTS),
            };
            steps / steps_per_mm[axis]
        })
    });
    let [along, off]: [[f64; AXES]; 2] = [end, place].map(|to| std::array::from_fn(|axis| to[axis] - begin[axis]));
    let product: f64 = (0..AXES).map(|axis| along[axis] * off[axis]).sum();
    let ratio = (product / size(&along).powi(2)).clamp(0.0, 1.0);
    size(&std::array::from_fn(|axis| off[axis] - ratio * along[axis]))
}

fn size(of: &[f64; AXES]) -> f64 {
    of.iter().map(|each| each * each).sum::<f64>().sqrt()
}
