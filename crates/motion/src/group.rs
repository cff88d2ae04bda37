//! Short moves that are taken together: as one move, from which their ends are no farther than they allow.
//!
//! # Design
//! Each block of the chain takes the processor a while to plan and to compile ([`Effort`](isostep_profile::chain::Effort)), and a
//! block that would be over sooner is made slower. So a path of short chords is slow although nothing on the path asks for that. Here
//! such moves wait before they go into the chain. The first of them, and those that go on from it so that one straight line passes
//! near all their ends, become one block. The others are marks in it ([`marks`](crate::marks)): each has its line and its power from
//! the place on where it would have begun. Only moves that are too short for the processor are taken together, and only until the
//! line is long enough.
//!
//! Whether a line passes near all ends is known without looking at them again. Let m be the axis that is the longest in the first
//! move. An end at (m, y), where y is another axis, allows lines of slopes from (y - q)/m to (y + q)/m. All ends together allow the
//! slopes that each of them does: from a greatest lower bound to a least upper bound, which are kept as fractions, so that
//! comparing takes products of integers and no division. An end is as far beside the line as it is by that, or less. If several
//! axes are beside m, each has a share of q by which all together stay within q. On m each move goes on.
//!
//! Nothing waits here for long: see [`Coordinator::settle_group`](crate::coordinator::Coordinator::settle_group).

use isostep_profile::OFFSET_PARTS;

use crate::axes::AXES;
use crate::machine::Move;
use crate::marks::Marks;
use crate::tag::Request;

/// The time that each move takes the processor that is taken together with others, s, as it reads and interprets it.
pub const JOIN_S: f64 = 0.36e-3;

/// A group is no longer than this on any axis, parts of a step, so that products of two such lengths fit into 64 bits.
const LENGTH_MAX_PARTS: i32 = 1 << 30;

/// How moves are taken together in the chain: what they are compared with.
pub(crate) struct GroupRule {
    /// The time that one move takes the processor at least, s; infinite if none may be taken together.
    least_s: f32,
    mm_per_part: [f32; AXES],
    top_parts_s: [f32; AXES],
}

impl GroupRule {
    /// None are taken together.
    pub const NONE: Self = Self { least_s: 0.0, mm_per_part: [0.0; AXES], top_parts_s: [0.0; AXES] };

    /// For moves of axes with these steps/mm and top speeds, of which each takes the processor `least_s` at least; 0 for none.
    pub fn new(least_s: f64, steps_per_mm: &[f64; AXES], top_steps_s: [f64; AXES]) -> Self {
        let parts = f64::from(OFFSET_PARTS);
        Self {
            least_s: least_s as f32,
            mm_per_part: core::array::from_fn(|axis| (1.0 / (steps_per_mm[axis] * parts)) as f32),
            top_parts_s: top_steps_s.map(|top_steps_s| (top_steps_s * parts) as f32),
        }
    }

    /// True if a line of so many parts is over, at this feed and at the top speed of each axis, before the processor has `moves` of
    /// them.
    fn is_short(&self, parts: &[i32; AXES], feed_mm_s: f32, moves: u8) -> bool {
        let least_s = self.least_s + JOIN_S as f32 * f32::from(moves - 1);
        let mut square_mm2 = 0.0;
        for axis in 0..AXES {
            let own_parts = parts[axis] as f32;
            if own_parts.abs() >= self.top_parts_s[axis] * least_s {
                return false;
            }
            let own_mm = own_parts * self.mm_per_part[axis];
            square_mm2 += own_mm * own_mm;
        }
        let most_mm = feed_mm_s * least_s;
        square_mm2 < most_mm * most_mm
    }
}

/// A fraction with a positive denominator.
#[derive(Clone, Copy)]
struct Slope {
    rise: i32,
    run: i32,
}

impl Slope {
    fn is_below(self, other: Self) -> bool {
        i64::from(self.rise) * i64::from(other.run) < i64::from(other.rise) * i64::from(self.run)
    }
}

/// The slopes that an axis beside the longest one may have.
#[derive(Clone, Copy)]
struct Slopes {
    /// The distance that an end may be beside the line, parts of a step.
    within: i32,
    least: Slope,
    most: Slope,
}

impl Slopes {
    const ANY: Self = Self { within: 0, least: Slope { rise: -1, run: 0 }, most: Slope { rise: 1, run: 0 } };

    /// With this end, too.
    fn narrow(&mut self, end: Slope) {
        let [least, most] = [-self.within, self.within].map(|by| Slope { rise: end.rise.saturating_add(by), ..end });
        if self.least.is_below(least) {
            self.least = least;
        }
        if most.is_below(self.most) {
            self.most = most;
        }
    }

    fn has(&self, slope: Slope) -> bool {
        !slope.is_below(self.least) && !self.most.is_below(slope)
    }
}

/// Moves that are taken together, of which more may come.
pub(crate) struct Group {
    /// The first of them, with the steps and the end of all.
    request: Request,
    /// How far its path may be beside the ends of its moves, mm.
    within_mm: f32,
    feed_mm_s: f32,
    moves: u8,
    /// The axis that is the longest.
    longest: u8,
    /// The parts of a step from its beginning to its end.
    parts: [i32; AXES],
    /// The parts of a step by which it begins beside whole steps.
    begin: [i8; AXES],
    slopes: [Slopes; AXES],
}

impl Group {
    /// A group of one move that begins `begin` parts of a step beside whole steps; `None` if others are not to be taken together
    /// with it.
    pub fn of(request: Request, one: &Move, begin: [i8; AXES], rule: &GroupRule, feed_ratio: f32) -> Option<Self> {
        let Move { exact_stop, together_mm: within_mm, feed_mm_s, .. } = *one;
        if exact_stop || within_mm.to_bits() == 0 || feed_mm_s == f64::INFINITY {
            return None;
        }
        let (parts, feed_mm_s) = (parts(&request.steps, &request.offsets, &begin)?, feed_mm_s as f32 * feed_ratio);
        if !rule.is_short(&parts, feed_mm_s, 1) {
            return None;
        }
        let longest = (0..AXES).max_by_key(|&axis| parts[axis].unsigned_abs())?;
        let goes_on = request.steps[longest] != 0;
        goes_on.then_some(Self {
            request,
            within_mm,
            feed_mm_s,
            moves: 1,
            longest: longest as u8,
            parts,
            begin,
            slopes: [Slopes::ANY; AXES],
        })
    }

    /// Takes a move together with it, and notes where that begins as a mark. Returns whether it could.
    pub fn join(&mut self, next: &Request, one: &Move, rule: &GroupRule, marks: &mut Marks) -> bool {
        let longest = usize::from(self.longest);
        let Some((steps, parts)) = self.with(next) else { return false };
        let is_alike = next.feed_mm_s.map(f64::to_bits) == self.request.feed_mm_s.map(f64::to_bits)
            && next.deviation_mm.to_bits() == self.request.deviation_mm.to_bits()
            && one.together_mm.to_bits() == self.within_mm.to_bits()
            && !next.stops;
        let is_longest = |axis: usize| steps[axis].unsigned_abs() <= steps[longest].unsigned_abs();
        if !is_alike
            || (parts[longest] ^ self.parts[longest]) < 0
            || parts[longest].unsigned_abs() <= self.parts[longest].unsigned_abs()
            || steps[longest] == 0
            || !(0..AXES).all(is_longest)
            || !rule.is_short(&self.parts, self.feed_mm_s, self.moves)
            || !rule.is_short(&self.step_parts(&parts), self.feed_mm_s, 1)
        {
            return false;
        }
        if self.moves == 1 {
            self.share(&parts, rule);
        }
        let slope = |axis: usize| self.slope(&parts, axis);
        if !(0..AXES).all(|axis| axis == longest || self.slopes[axis].has(slope(axis))) {
            return false;
        }
        let place_steps = self.parts[longest].unsigned_abs().div_ceil(OFFSET_PARTS.unsigned_abs());
        let Some(tag) = marks.join(self.request.tag, place_steps, &next.tag) else { return false };
        self.narrow(&parts);
        (self.request.steps, self.request.offsets, self.request.tag) = (steps, next.offsets, tag);
        (self.parts, self.moves) = (parts, self.moves + 1);
        true
    }

    /// The steps and parts from its beginning to the end of `next`; `None` if that is too far.
    fn with(&self, next: &Request) -> Option<([i32; AXES], [i32; AXES])> {
        let mut steps = self.request.steps;
        for (own, other) in steps.iter_mut().zip(next.steps) {
            *own = own.checked_add(other)?;
        }
        Some((steps, parts(&steps, &next.offsets, &self.begin)?))
    }

    fn step_parts(&self, parts: &[i32; AXES]) -> [i32; AXES] {
        core::array::from_fn(|axis| parts[axis] - self.parts[axis])
    }

    /// Divides what the path may be beside the ends among the axes that move beside the longest one: in the first two moves, of
    /// which the second ends at `parts`. An axis that moves in neither may not move in the others.
    #[inline(never)]
    fn share(&mut self, parts: &[i32; AXES], rule: &GroupRule) {
        let longest = usize::from(self.longest);
        let moves = |axis: usize| axis != longest && (parts[axis] != 0 || self.parts[axis] != 0);
        let share = [1.0, 1.0, core::f32::consts::FRAC_1_SQRT_2, 0.577_350_26];
        let within_mm = self.within_mm * share[(0..AXES).filter(|&axis| moves(axis)).count().min(3)];
        let within = core::array::from_fn::<_, AXES, _>(|axis| {
            if moves(axis) { (within_mm / rule.mm_per_part[axis]) as i32 } else { 0 }
        });
        for (axis, within) in within.into_iter().enumerate() {
            self.slopes[axis] = Slopes { within, ..Slopes::ANY };
        }
        let parts = self.parts;
        self.narrow(&parts);
    }

    /// Notes an end of a move as one that the path passes.
    fn narrow(&mut self, parts: &[i32; AXES]) {
        for axis in (0..AXES).filter(|&axis| axis != usize::from(self.longest)) {
            let slope = self.slope(parts, axis);
            self.slopes[axis].narrow(slope);
        }
    }

    fn slope(&self, parts: &[i32; AXES], axis: usize) -> Slope {
        let run = parts[usize::from(self.longest)];
        Slope { rise: if run < 0 { -parts[axis] } else { parts[axis] }, run: run.abs() }
    }

    /// True if it is of several moves.
    pub fn is_several(&self) -> bool {
        self.moves > 1
    }

    /// How far its path may be beside the ends of its moves, mm; 0 if it is one move.
    pub fn used_mm(&self) -> f32 {
        if self.is_several() { self.within_mm } else { 0.0 }
    }

    /// The move for the chain, to which the blend may leave the corner by as much less as the path is beside the moves before it, or
    /// after it.
    pub fn request(&self, used_before_mm: f32) -> Request {
        let needs_s = JOIN_S as f32 * f32::from(self.moves - 1);
        let deviation_mm = deviation_beside(self.request.deviation_mm, self.used_mm().max(used_before_mm));
        Request { deviation_mm, needs_s, ..self.request }
    }

    /// True if `next` goes on in exactly its direction, and both are of whole steps.
    pub fn is_straight_to(&self, next: &Request) -> bool {
        let longest = usize::from(self.longest);
        let (own, other) = (&self.request.steps, &next.steps);
        let is_whole = self.begin == [0; AXES] && self.request.offsets == [0; AXES] && next.offsets == [0; AXES];
        let is_along = |axis: usize| {
            i64::from(own[axis]) * i64::from(other[longest]) == i64::from(other[axis]) * i64::from(own[longest])
        };
        is_whole && (own[longest] ^ other[longest]) >= 0 && (0..AXES).all(is_along)
    }
}

/// The distance by which a blend may leave a corner, of which so much is used by the path beside it; half of it is left if the moves
/// before allowed more.
pub(crate) fn deviation_beside(deviation_mm: f32, used_mm: f32) -> f32 {
    (deviation_mm - used_mm).max(0.5 * deviation_mm)
}

/// The parts of a step from `begin` beside whole steps to the end of a move; `None` if that is too far.
fn parts(steps: &[i32; AXES], end: &[i8; AXES], begin: &[i8; AXES]) -> Option<[i32; AXES]> {
    let mut parts = [0; AXES];
    for axis in 0..AXES {
        let whole = steps[axis].checked_mul(OFFSET_PARTS)?;
        parts[axis] = whole.checked_add(i32::from(end[axis]) - i32::from(begin[axis]))?;
        if parts[axis].abs() > LENGTH_MAX_PARTS {
            return None;
        }
    }
    Some(parts)
}
