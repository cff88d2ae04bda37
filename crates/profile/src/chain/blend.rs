//! The speed at which a corner may be taken by a blend.
//!
//! The path leaves the line at most `reach` before the corner and is on the next line at most as far after it. It enters
//! at the speed p, leaves at q and takes 2 reach/max(p, q); each axis has one acceleration for that time. With the
//! directions u and u', that of an axis is (q u' - p u) max(p, q)/(2 reach).
//!
//! With P = p² and Q = q², an axis that slows down (P > Q) bounds P - α √(P Q) by c, where α = u'/u and c = 2 reach a/u.
//! An axis that speeds up bounds Q in the same way (`bound`). At P = Q all axes together allow a highest square, the cap,
//! above which neither may be.
//!
//! So such a corner has two squares instead of one, and P is at most a rising concave function of Q, and Q of P. A pass goes
//! backwards from Q to P at each corner, and forwards from P to Q. Both may be lower together, so one pass each way is still
//! enough. A slower end of a blend begins nearer to its corner, so what is left of a block for its line depends on the speeds; the
//! passes count with the shortest line.
//!
//! The plan of a block's line ends where the blend begins, and promises P, Q and that place. From where the longest blend would
//! begin, it is kept to its end. A block that has room for its stop only, because the next one came late or bends too sharply,
//! ends at rest in the corner. A hold brakes on lines, and passes a blend at the lowest speeds that it can have. A blend is handed
//! out whole.

use super::bound::{BindingAxis, Bound};
use super::config::{ChainConfig, ONE, SQUARE_MAX, Square, is_as_low};
use super::corner::{self, Short, UnitVector};
use crate::fixed::product;

/// Blends do not last less than this, s, because of the speed alone.
const BRIEF_S: f32 = 0.5e-3;
/// The shortest time at the highest speed, s, for which a blend leaves a line between it and another of its length.
const LITTLE_S: f32 = 2e-3;
/// The factor by which a blend bounds a square higher than that of the highest speed, so that rounding does not make a corner
/// slower.
const SPARE: f32 = 1.000_02;

/// The reach of a blend, and the bounds of its speeds.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlendBounds {
    /// The distance that it reaches at most to either side of the corner, mm; 0 if there is no blend.
    pub(super) reach_mm: f64,
    /// The entry by the exit, and the exit by the entry.
    entry: Bound,
    exit: Bound,
}

/// The room of a blend at a corner.
pub(super) struct Room {
    /// The distance by which the path may leave the corner, mm.
    pub(super) deviation_mm: f32,
    /// The distance that a blend may reach on the shorter of both blocks, mm.
    pub(super) reach_mm: f64,
    /// The highest square that overrides can make of either block's.
    pub(super) fastest: Square,
    /// True if the blend reaches as far as it may, even if no speed needs that.
    pub(super) is_whole: bool,
}

impl BlendBounds {
    /// No blend.
    pub(super) const NONE: Self = Self { reach_mm: 0.0, entry: Bound::NONE, exit: Bound::NONE };

    pub(super) fn is_none(&self) -> bool {
        self.reach_mm.to_bits() == 0
    }

    /// The highest square at which a blend that leaves at `exit` may begin.
    pub(super) fn entry_at(&self, exit: Square) -> Square {
        self.entry.at(exit)
    }

    /// The highest square at which a blend that begins at `entry` may leave.
    pub(super) fn exit_at(&self, entry: Square) -> Square {
        self.exit.at(entry)
    }

    /// The lowest square at which a blend that begins at `entry` may leave.
    pub(super) fn lowest_exit_at(&self, entry: Square) -> Square {
        self.entry.least_for(entry)
    }

    /// The square at which a blend that begins at `entry` leaves, `wanted` if that is possible.
    #[inline(never)]
    pub(super) fn exit_near(&self, wanted: Square, entry: Square) -> Square {
        if entry <= self.entry_at(wanted) {
            return wanted.min(self.exit_at(entry));
        }
        // No rounding makes it faster, because what follows may have no room to brake from there.
        let lowest = self.lowest_exit_at(entry);
        if is_as_low(lowest, wanted) { wanted } else { lowest }
    }
}

/// The blend between two directions, and the highest square at which it may begin and leave at once. `None` if the machine
/// has to stop there.
pub(super) fn bounds<const N: usize>(
    [before, after]: [&UnitVector<N>; 2],
    room: &Room,
    config: &ChainConfig<N>,
) -> Option<(BlendBounds, Square)> {
    let difference = Short::<N>::of(&core::array::from_fn(|axis| after[axis].abs_diff(before[axis])))?;
    let half_length = difference.half_length();
    if corner::is_reversal([before, after], half_length) {
        return None;
    }
    let across = difference.most(&config.across);
    let free_mm = 2.0 * room.deviation_mm / half_length;
    let most_mm = room.reach_mm as f32;
    let mut reach_mm = if is_less(free_mm, most_mm) { free_mm } else { most_mm };
    let mut cap = config.bend_units_mm * reach_mm / difference.scaled(across);
    let fastest = room.fastest as f32 * SPARE;
    let mut spare = ONE;
    if is_less(fastest, cap) {
        // No blend needs more room than the highest speed asks for, unless it would be too brief, or leave too little.
        let half_s_mm = 0.5 * config.scale.speed_mm_s(room.fastest) as f32;
        let [needed, brief] = [fastest / cap, BRIEF_S * half_s_mm / reach_mm];
        let mut share = if is_less(needed, brief) { brief } else { needed };
        if room.is_whole || is_less(1.0, share) || is_less(most_mm * (1.0 - share), LITTLE_S * half_s_mm) {
            share = 1.0;
        }
        if is_less(needed, share) {
            spare = (cap * share / fastest * ONE as f32) as u32;
        }
        reach_mm *= share;
        cap = fastest;
    }
    let top = if is_less(cap, SQUARE_MAX as f32) { cap as Square } else { SQUARE_MAX as Square };
    let sizes: [[u32; 3]; N] = core::array::from_fn(|axis| {
        let ([before, after], point) = sizes(before[axis], after[axis]);
        [before, after, times(difference.in_units(across, point), spare)]
    });
    let axes = |own: usize, other: usize, accel: usize| {
        core::array::from_fn(|axis| {
            let (sizes, ratio) = (&sizes[axis], config.accel_ratios[axis][accel]);
            BindingAxis { own: sizes[own], other: sizes[other], room: times(sizes[2], ratio) }
        })
    };
    let ([before, after], [speeds_up, slows_down]) = ([0, 1], [0, 1]);
    let entry = Bound::of::<N>(&axes(before, after, slows_down), top)?;
    let exit = Bound::of::<N>(&axes(after, before, speeds_up), top)?;
    let reach_mm = f64::from(reach_mm);
    let reach_mm = if reach_mm < room.reach_mm { reach_mm } else { room.reach_mm };
    Some((BlendBounds { reach_mm, entry, exit }, top))
}

/// The sizes of two components, to the 31 leading bits of the larger, and the point of their units.
fn sizes(one: i64, other: i64) -> ([u32; 2], u32) {
    let sizes = [one, other].map(i64::unsigned_abs);
    let zeros = (sizes[0] | sizes[1] | 1).leading_zeros();
    (sizes.map(|size| (size << zeros >> 33) as u32), 28 + zeros)
}

/// True if a number of 0 or more is less than another: as bits, because comparing floats is a call.
fn is_less(one: f32, other: f32) -> bool {
    (one.to_bits() as i32) < other.to_bits() as i32
}

/// A number times a ratio in units of 2^-16, [`ONE`] or more; the largest number at most.
fn times(value: u32, ratio: u32) -> u32 {
    if ratio == ONE { value } else { u32::try_from(product(value, ratio) >> 16).unwrap_or(u32::MAX) }
}
