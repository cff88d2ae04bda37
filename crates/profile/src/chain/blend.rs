//! How fast a corner may be taken by a blend.
//!
//! The path leaves the line at most `reach` before the corner and is on the next line at most as far after it. It enters
//! at the speed p, leaves at q and takes 2 reach/max(p, q); each axis has one acceleration for that time. With the
//! directions u and u', that of an axis is (q u' - p u) max(p, q)/(2 reach).
//!
//! With P = p² and Q = q², an axis that slows down (P > Q) bounds P - α √(P Q) by c, where α = u'/u and c = 2 reach a/u.
//! So P is at most c Φ(α² Q/c), with Φ(y) = ((√y + √(y + 4))/2)². That rises and is concave, so a few chords stay below
//! it, and the least of them is a sum and a product of whole numbers. An axis that speeds up bounds Q in the same way. At
//! P = Q all axes together allow a highest square, the cap, above which neither may be.

use super::config::{ChainConfig, SQUARE_MAX, Square};
use super::corner::{Direction, Short};
use crate::fixed::product;
use crate::root::sqrt;

/// How many chords bound a speed.
const CHORDS: usize = 4;
/// Where chords meet: y, Φ(y).
const KNOTS: [[f32; 2]; 2] = [[1.0, 2.618_034], [8.0, 9.898_979]];
/// The slopes between knots, from y = 0, where Φ is 1.
const SLOPES: [f32; 2] = [1.618_034, 1.040_135];
/// Accelerations are lower by this ratio, so that the rounding of 24 bits exceeds none.
const SAFE: f32 = 0.999_99;
/// Blends do not last less than this, s, because of the speed alone.
const BRIEF_S: f32 = 0.5e-3;
/// Bounds of fewer units are too coarse, and this many are no bound.
const FINE: f32 = 16_777_216.0;
const ROOM_MAX: f32 = 1e30;
/// The unit of slopes, 2^-24.
const SLOPE_ONE: f32 = 16_777_216.0;
/// How many units the rounding of 24 bits may have made a slope too large.
const SLOPE_ERROR: u32 = 8;
/// A chord that bounds nothing: all zeros in memory.
const NO_CHORD: Chord = Chord { at_rest: 0.0, slope: 0 };

/// Bounds the squared speed at one end of a blend by that at the other end: `at_rest` + `slope` times that.
#[derive(Clone, Copy, Debug)]
struct Chord {
    /// In units of squares; 0 if it bounds nothing.
    at_rest: f32,
    slope: u32,
}

/// How far a blend reaches, and the bounds of its speeds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bend {
    /// How far it reaches at most to either side of the corner, mm; 0 if there is no blend.
    pub(super) reach_mm: f64,
    /// The entry by the exit, and the exit by the entry.
    entry: [Chord; CHORDS],
    exit: [Chord; CHORDS],
}

impl Chord {
    /// Up to which square it is above that square itself.
    fn equal(&self) -> f32 {
        let less = SLOPE_ONE - self.slope as f32;
        if less > 0.0 { self.at_rest / less * SLOPE_ONE * (1.0 - 1e-6) } else { f32::INFINITY }
    }

    fn at(&self, square: Square) -> Square {
        whole(self.at_rest) + scaled(square, self.slope)
    }
}

/// A float as a whole number, rounded down; it is 1 or above, and the largest square at most.
fn whole(x: f32) -> Square {
    let bits = x.to_bits();
    let (mantissa, exponent) = (u64::from(bits << 8 >> 8 | 1 << 23) & 0xff_ffff, (bits >> 23) as i32 - 150);
    match exponent {
        0..=38 => mantissa << exponent,
        // Beyond the largest square nothing is bounded.
        39.. => SQUARE_MAX as Square,
        _ => mantissa.checked_shr(exponent.unsigned_abs()).unwrap_or(0),
    }
}

/// `square` times `slope` in units of 2^-24, the largest square at most.
fn scaled(square: Square, slope: u32) -> Square {
    let upper = product((square >> 32) as u32, slope);
    if upper >> 54 == 0 { (upper << 8).wrapping_add(product(square as u32, slope) >> 24) } else { SQUARE_MAX as Square }
}

/// The least that the chords allow.
#[inline(never)]
fn least(chords: &[Chord; CHORDS], square: Square) -> Square {
    let mut least = SQUARE_MAX as Square;
    for chord in chords {
        if is_none(chord) {
            break;
        }
        let bound = chord.at(square);
        if bound < least {
            least = bound;
        }
    }
    least
}

/// Whether it bounds nothing. Those that do come first.
fn is_none(chord: &Chord) -> bool {
    chord.at_rest.to_bits() == 0
}

impl Bend {
    /// No blend.
    pub(super) const NONE: Self = Self { reach_mm: 0.0, entry: [NO_CHORD; CHORDS], exit: [NO_CHORD; CHORDS] };

    pub(super) fn is_none(&self) -> bool {
        self.reach_mm == 0.0
    }

    /// The highest square at which a blend that leaves at `exit` may begin.
    pub(super) fn entry_at(&self, exit: Square) -> Square {
        least(&self.entry, exit)
    }

    /// The highest square at which a blend that begins at `entry` may leave.
    pub(super) fn exit_at(&self, entry: Square) -> Square {
        least(&self.exit, entry)
    }

    /// The lowest square at which a blend that begins at `entry` may leave.
    // Seldom needed: in a hold, and where a change came too late.
    #[inline(never)]
    pub(super) fn lowest_exit_at(&self, entry: Square) -> Square {
        let needed = |chord: &Chord| match entry.saturating_sub(whole(chord.at_rest)) {
            0 => 0,
            // Rounded up.
            rise if chord.slope > 0 => {
                (rise as f64 * (1.0 + 1e-9) / f64::from(chord.slope) * f64::from(SLOPE_ONE)) as Square + 1
            }
            _ => entry,
        };
        self.entry.iter().filter(|chord| !is_none(chord)).map(needed).max().unwrap_or(0).min(entry)
    }

    /// The square at which a blend that begins at `entry` leaves, `wanted` if that is possible.
    #[inline(never)]
    pub(super) fn exit_near(&self, wanted: Square, entry: Square) -> Square {
        if entry <= self.entry_at(wanted) { wanted.min(self.exit_at(entry)) } else { self.lowest_exit_at(entry) }
    }
}

/// What a blend may do at a corner.
pub(super) struct Room {
    /// How far the path may leave the corner, mm.
    pub(super) deviation_mm: f32,
    /// How far a blend may reach on the shorter of both blocks, mm.
    pub(super) reach_mm: f64,
    /// The highest square that either block has.
    pub(super) nominal: Square,
}

/// The blend between two directions, and the highest square at which it may begin and leave at once. `None` if the machine
/// has to stop there.
pub(super) fn bend<const N: usize>(
    [before, after]: [&Direction<N>; 2],
    room: &Room,
    config: &ChainConfig<N>,
) -> Option<(Bend, Square)> {
    let difference = Short::<N>::of(&core::array::from_fn(|axis| after[axis].abs_diff(before[axis])))?;
    let length = 2.0 * difference.half_length();
    let free_mm = 4.0 * room.deviation_mm / length;
    let reach_mm = if f64::from(free_mm) < room.reach_mm { free_mm } else { room.reach_mm as f32 };
    let units = config.scale.units_f32();
    let doubled = (2.0 * SAFE * reach_mm * units).min(ROOM_MAX);
    let mut cap = f32::INFINITY;
    for axis in 0..N {
        let (Some(change), [speeds_up, slows_down]) = (difference.component(axis), config.axis_mm_s2[axis]) else {
            continue;
        };
        let turns = before[axis].signum() * after[axis].signum() < 0;
        let accel_mm_s2 = match after[axis].unsigned_abs() > before[axis].unsigned_abs() {
            _ if turns => speeds_up.min(slows_down),
            true => speeds_up,
            false => slows_down,
        };
        cap = cap.min(doubled * accel_mm_s2 / change);
    }
    // No blend needs more room than the highest speed asks for.
    let nominal = room.nominal as f32;
    let brief_mm = 0.5 * BRIEF_S * sqrt(f64::from(nominal / units)) as f32;
    let mut share = 1.0;
    if cap > nominal {
        share = (nominal / cap).max(brief_mm / reach_mm).min(1.0);
    }
    cap *= share;
    let mut bend = Bend { reach_mm: f64::from(reach_mm * share), ..Bend::NONE };
    if bend.reach_mm > room.reach_mm {
        bend.reach_mm = room.reach_mm;
    }
    let top = cap.min(SQUARE_MAX as f32);
    let (mut entry, mut exit) = (Envelope::up_to(top), Envelope::up_to(top));
    for axis in 0..N {
        let [from, to] = [before[axis], after[axis]];
        if from.signum() * to.signum() < 0 {
            continue;
        }
        let [from, to] = [from, to].map(component);
        let [speeds_up, slows_down] = config.axis_mm_s2[axis].map(|accel_mm_s2| doubled * share * accel_mm_s2);
        let change = difference.component(axis).unwrap_or(0.0);
        entry.bound(from, to, change, slows_down);
        exit.bound(to, from, change, speeds_up);
    }
    (bend.entry, bend.exit) = (entry.chords(), exit.chords());
    for chord in bend.entry.iter().chain(&bend.exit).filter(|chord| !is_none(chord)) {
        if chord.at_rest < FINE {
            return None;
        }
        cap = cap.min(chord.equal());
    }
    (cap >= FINE).then(|| (bend, whole(cap).min(SQUARE_MAX as Square)))
}

/// A component of a direction, as a size.
fn component(component: i64) -> f32 {
    component.unsigned_abs() as f32 * 4.336_809e-19
}

/// Whether a number of 0 or more is less than another: as bits, because comparing floats is a call.
fn is_less(one: f32, other: f32) -> bool {
    (one.to_bits() as i32) < other.to_bits() as i32
}

/// The least of chords, from a square of 0 up to a highest one.
struct Envelope {
    top: f32,
    /// The values at 0 and at the highest square.
    ends: [[f32; 2]; CHORDS],
    len: usize,
}

impl Envelope {
    fn up_to(top: f32) -> Self {
        Self { top, ends: [[0.0; 2]; CHORDS], len: 0 }
    }

    /// Adds the chords by which an axis bounds the square on the side where its component is `own`. That on the other
    /// side is `other`, `change` the size of their difference, and `room` twice the reach times the acceleration.
    fn bound(&mut self, own: f32, other: f32, change: f32, room: f32) {
        if own == 0.0 {
            return;
        }
        let inverse = 1.0 / own;
        let at_rest = room * inverse;
        if !is_less(at_rest, self.top) {
            return;
        }
        let ratio = other * inverse;
        let squared = ratio * ratio;
        let per_y = at_rest / squared;
        // Where both squares are equal, if the axis allows no more than that.
        let equal = if other < own { room / change } else { f32::INFINITY };
        let (mut from, mut to) = (0.0, at_rest);
        for ([y, high], slope) in KNOTS.into_iter().zip(SLOPES) {
            let next = y * per_y;
            if !is_less(next, equal) {
                break;
            }
            self.add(to, from, slope * squared);
            (from, to) = (next, high * at_rest);
            if !is_less(to, self.top) {
                return;
            }
        }
        let slope = if equal.is_finite() { (equal - to) / (equal - from) } else { squared };
        self.add(to, from, slope);
    }

    /// Adds the chord through a value at a square.
    fn add(&mut self, value: f32, square: f32, slope: f32) {
        let at_rest = value - slope * square;
        let mut own = [at_rest, at_rest + slope * self.top];
        let is_below = |one: &[f32; 2], other: &[f32; 2]| !is_less(other[0], one[0]) && !is_less(other[1], one[1]);
        let mut kept = 0;
        for index in 0..self.len {
            let other = self.ends[index];
            if is_below(&other, &own) {
                return;
            }
            if !is_below(&own, &other) {
                self.ends[kept] = other;
                kept += 1;
            }
        }
        if kept == CHORDS {
            // Below both of the last ones.
            kept -= 1;
            let last = self.ends[kept];
            own = [own[0].min(last[0]), own[1].min(last[1])];
        }
        self.ends[kept] = own;
        self.len = kept + 1;
    }

    fn chords(&self) -> [Chord; CHORDS] {
        core::array::from_fn(|index| match self.ends[index] {
            [at_rest, end] if index < self.len => {
                let slope = ((end - at_rest) / self.top * SLOPE_ONE) as u32;
                Chord { at_rest, slope: slope.saturating_sub(SLOPE_ERROR) }
            }
            _ => NO_CHORD,
        })
    }
}
