//! Short moves that are taken together: as one move, from which their ends are no farther than they allow.
//!
//! # Design
//! Each block of the chain takes the processor a while to plan and to compile ([`Effort`](isostep_profile::chain::Effort)), and a
//! block that would be over sooner is made slower. So a path of short chords is slow although nothing on the path asks for that. Here
//! such moves wait before they go into the chain. The first of them, and those that go on from it so that one straight line passes
//! near all their ends, become one block. The others are marks in it ([`marks`](crate::marks)): each has its line and its power from
//! the place on where it would have begun. Only moves that are too short for the processor are taken together, and only until the
//! line is long enough. Where it ends, and so where the next one begins, is up to the [`Course`].
//!
//! Whether a line passes near all ends is known without looking at them again. Let m be the axis that is the longest in the first
//! move. An end at (m, y), where y is another axis, allows lines of slopes from (y - q)/m to (y + q)/m. All ends together allow the
//! slopes that each of them does: from a greatest lower bound to a least upper bound, which are kept as fractions, so that
//! comparing takes products of integers and no division. An end is as far beside the line as it is by that, or less. If several
//! axes are beside m, each has a share of q by which all together stay within q. On m each move goes on.
//!
//! The deviation has two halves: a line is within the first of all ends, and the blends at its ends have the second.

mod course;
mod slopes;
mod vector;

use isostep_profile::{Limits, OFFSET_PARTS};

pub(crate) use self::course::Course;
use self::course::Line;
use self::slopes::{Slope, Slopes};
use self::vector::{Vector, dot};
use crate::axes::AXES;
use crate::effort::LeastTimes;
use crate::machine::Move;
use crate::marks::Marks;
use crate::tag::Request;

/// A move may begin a group if it is over before the processor has it, or so much later, squared.
const NEARLY: f32 = 2.0;
/// A move does not join if the line is longer then than is needed for the processor to keep up, by so much squared.
const MUCH_LONGER: f32 = 9.0;
/// A line is no longer than this on any axis, steps, so that products of two such lengths fit into 32 bits.
const STEPS_MAX: u32 = 1 << 15;
/// On a curve a line is no longer than that its middle is within this share of what it may be beside the ends.
const SAGITTA_SHARE: f32 = 0.3;
/// The shares of several axes in a distance that all of them together are to stay within: the inverse root of their number.
const SHARES: [f32; 4] = [1.0, 1.0, core::f32::consts::FRAC_1_SQRT_2, 0.577_350_26];

/// What moves are compared with that may be taken together.
pub(crate) struct GroupRule {
    /// The time that a move takes the processor at least, s; 0 if none are taken together.
    least_s: f32,
    /// The time that several take at least, and more for each but the first, s.
    together_s: f32,
    join_s: f32,
    mm_per_part: Vector,
    parts_per_mm: Vector,
    /// The square of the highest speed along a path.
    top_mm2_s2: f32,
    /// The lowest acceleration of all axes.
    accel_mm_s2: f32,
}

impl GroupRule {
    /// None are taken together.
    pub const NONE: Self = Self {
        least_s: 0.0,
        together_s: 0.0,
        join_s: 0.0,
        mm_per_part: [0.0; AXES],
        parts_per_mm: [0.0; AXES],
        top_mm2_s2: 0.0,
        accel_mm_s2: 0.0,
    };

    /// For axes with these limits and steps/mm, if each move takes the processor `least_s` at least.
    #[cold]
    pub fn new(least_s: f64, times: &LeastTimes, limits: &[Limits; AXES], steps_per_mm: &[f64; AXES]) -> Self {
        let parts_per_mm = steps_per_mm.map(|steps_per_mm| steps_per_mm * f64::from(OFFSET_PARTS));
        let of_axes = || limits.iter().zip(steps_per_mm);
        let tops_mm_s = of_axes().map(|(limits, steps_per_mm)| limits.top_speed_steps_s / steps_per_mm);
        let accels_mm_s2 =
            of_axes().map(|(limits, steps_per_mm)| limits.accel_steps_s2.min(limits.decel_steps_s2) / steps_per_mm);
        Self {
            least_s: least_s as f32,
            together_s: least_s as f32 + times.together_s as f32,
            join_s: times.join_s as f32,
            mm_per_part: parts_per_mm.map(|parts_per_mm| (1.0 / parts_per_mm) as f32),
            parts_per_mm: parts_per_mm.map(|parts_per_mm| parts_per_mm as f32),
            top_mm2_s2: tops_mm_s.map(|mm_s| mm_s * mm_s).sum::<f64>() as f32,
            accel_mm_s2: accels_mm_s2.fold(f64::INFINITY, f64::min) as f32,
        }
    }

    /// The time that so many moves take the processor together, s.
    fn together_s(&self, moves: u8) -> f32 {
        self.together_s + self.join_s * f32::from(moves - 1)
    }

    fn lengths_mm(&self, line: &[i32; AXES]) -> Vector {
        let mut lengths_mm = [0.0; AXES];
        for axis in 0..AXES {
            if line[axis] != 0 {
                lengths_mm[axis] = self.mm_per_part[axis] * line[axis] as f32;
            }
        }
        lengths_mm
    }

    #[inline(never)]
    fn square_mm2(&self, line: &[i32; AXES]) -> f32 {
        let lengths_mm = self.lengths_mm(line);
        dot(&lengths_mm, &lengths_mm)
    }
}

/// Moves that are taken together, of which more may come.
pub(crate) struct MoveGroup {
    /// The first of them, with the steps and the end of all.
    request: Request,
    /// How far the line may be beside the ends of its moves, mm.
    within_mm: f32,
    /// The squares of the highest speed on it, and of its length now and at most.
    most_mm2_s2: f32,
    square_mm2: f32,
    most_mm2: f32,
    moves: u8,
    /// The axis that is the longest in the first move.
    longest: u8,
    begin: Begin,
    /// True if it ends where the path is smooth.
    is_smooth: bool,
    /// True if it follows a line of which the course is known, so that it will end so.
    is_on_course: bool,
    /// The parts of a step from its beginning to its end.
    line: [i32; AXES],
    /// The slopes that each axis may have.
    slopes: [Slopes; AXES],
}

/// A place where a group begins.
#[derive(Clone, Copy)]
pub(crate) struct Begin {
    /// The parts of a step by which it is beside whole steps.
    pub beside: [i8; AXES],
    /// True if it is not where the move before was to end, but where the path is smooth.
    pub is_smooth: bool,
}

impl Begin {
    pub const WHOLE: Self = Self { beside: [0; AXES], is_smooth: false };
}

impl MoveGroup {
    /// A group of one move; `None` if others are not to be taken together with it.
    pub fn of(
        request: &Request,
        one: &Move,
        begin: Begin,
        rule: &GroupRule,
        course: &Course,
        feed_percent: u8,
    ) -> Option<Self> {
        let Move { exact_stop, together_mm: within_mm, feed_mm_s, .. } = *one;
        if exact_stop || within_mm.to_bits() == 0 || feed_mm_s == f64::INFINITY {
            return None;
        }
        let line = line(&request.steps, &request.offsets, &begin.beside)?;
        let feed_mm_s = feed_mm_s as f32 * (f32::from(feed_percent) / 100.0);
        let square_mm2 = rule.square_mm2(&line);
        let mut most_mm2_s2 = rule.top_mm2_s2.min(feed_mm_s * feed_mm_s);
        if square_mm2 >= NEARLY * most_mm2_s2 * rule.least_s * rule.least_s {
            return None;
        }
        most_mm2_s2 = most_mm2_s2.min(rule.accel_mm_s2 * course.radius_mm());
        let most_mm2 = 8.0 * SAGITTA_SHARE * within_mm * course.radius_mm();
        let longest = (0..AXES).max_by_key(|&axis| line[axis].unsigned_abs())?;
        Some(Self {
            request: *request,
            within_mm,
            most_mm2_s2,
            square_mm2,
            most_mm2,
            moves: 1,
            longest: longest as u8,
            begin,
            is_smooth: false,
            is_on_course: course.is_known(),
            line,
            slopes: [Slopes::any(0); AXES],
        })
    }

    /// Takes a move together with it, and notes where that begins as a mark. Returns whether it could.
    pub fn join(&mut self, next: &Request, one: &Move, rule: &GroupRule, marks: &mut Marks) -> bool {
        let longest = usize::from(self.longest);
        let Some((steps, line)) = self.with(next) else { return false };
        let is_alike = next.feed_mm_s.map(f64::to_bits) == self.request.feed_mm_s.map(f64::to_bits)
            && next.deviation_mm.to_bits() == self.request.deviation_mm.to_bits()
            && one.together_mm.to_bits() == self.within_mm.to_bits()
            && !next.stops;
        let goes_on = (line[longest] ^ self.line[longest]) >= 0
            && line[longest].unsigned_abs() > self.line[longest].unsigned_abs();
        if !is_alike || !goes_on {
            return false;
        }
        let is_alone = self.moves == 1 && !self.is_on_course;
        let least_s = if is_alone { rule.least_s } else { rule.together_s(self.moves) };
        let enough_mm2 = self.most_mm2_s2 * least_s * least_s;
        let square_mm2 = rule.square_mm2(&line);
        if self.square_mm2 >= enough_mm2 || square_mm2 >= MUCH_LONGER * enough_mm2 || square_mm2 >= self.most_mm2 {
            return false;
        }
        if self.moves == 1 {
            self.share(line.map(|parts| parts != 0), rule);
        }
        if !self.passes_ends(&line) {
            return false;
        }
        let place_steps = self.whole_steps();
        let Some(tag) = marks.join(self.request.tag, place_steps, &next.tag) else { return false };
        (self.request.steps, self.request.offsets, self.request.tag) = (steps, next.offsets, tag);
        (self.line, self.square_mm2, self.moves) = (line, square_mm2, self.moves + 1);
        self.narrow();
        true
    }

    /// The steps, and the line, from its beginning to the end of `next`; `None` if that is too far.
    fn with(&self, next: &Request) -> Option<([i32; AXES], [i32; AXES])> {
        let mut steps = self.request.steps;
        for (own, other) in steps.iter_mut().zip(next.steps) {
            *own = own.saturating_add(other);
        }
        Some((steps, line(&steps, &next.offsets, &self.begin.beside)?))
    }

    /// Divides the distance by which the line may be beside the ends among the axes that move beside the longest one; the others
    /// may not move. Notes the ends so far.
    #[inline(never)]
    fn share(&mut self, mut moves: [bool; AXES], rule: &GroupRule) {
        let mut beside = 0;
        for (axis, moves) in moves.iter_mut().enumerate() {
            *moves = (*moves || self.line[axis] != 0) && axis != usize::from(self.longest);
            beside += usize::from(*moves);
        }
        let share_mm = self.within_mm * SHARES[beside.min(SHARES.len() - 1)];
        for (axis, slopes) in self.slopes.iter_mut().enumerate() {
            let within = if moves[axis] { (share_mm * rule.parts_per_mm[axis]) as i32 } else { 0 };
            *slopes = Slopes::any(within);
        }
        self.narrow();
    }

    /// Notes that its line ends at the end of a move, which is not to be far from it if more come.
    fn narrow(&mut self) {
        let run = self.line[usize::from(self.longest)];
        for (slopes, &rise) in self.slopes.iter_mut().zip(&self.line) {
            if slopes.within != 0 {
                slopes.narrow(Slope::of(rise, run));
            }
        }
    }

    /// True if a line passes near enough to all ends.
    fn passes_ends(&self, line: &[i32; AXES]) -> bool {
        let run = line[usize::from(self.longest)];
        let passes = |(axis, (slopes, &rise)): (usize, (&Slopes, &i32))| match slopes.within {
            0 => rise == 0 || axis == usize::from(self.longest),
            _ => slopes.has(Slope::of(rise, run)),
        };
        self.slopes.iter().zip(line).enumerate().all(passes)
    }

    /// True if it may end where the path is smooth: it is of several moves, or follows one that is.
    pub fn may_be_smooth(&self, course: &Course) -> bool {
        self.moves > 1 || course.is_known()
    }

    /// Has its line end beside the end of its last move, where the path is smooth, if it passes all ends then.
    #[cold]
    pub fn smooth(&mut self, course: &mut Course, rule: &GroupRule) {
        if self.moves == 1 {
            self.share(course.direction().map(|share| share != 0.0), rule);
        }
        let mut line = Line::of(rule.lengths_mm(&self.line));
        let mut is_as_wanted = false;
        if course.is_known()
            && let Some(wanted) = self.wanted(&course.wanted_mm(&line), &line.lengths_mm, rule)
        {
            is_as_wanted = self.end_beside(wanted);
            line.lengths_mm = rule.lengths_mm(&self.line);
        }
        course.go_on(&line, is_as_wanted);
    }

    /// The parts of a step on the axes beside the longest one by which a place is beside the line; `None` if that is so far that
    /// the path has not gone on as it was expected to.
    #[cold]
    fn wanted(&self, wanted_mm: &Vector, line_mm: &Vector, rule: &GroupRule) -> Option<[i32; AXES]> {
        let longest = usize::from(self.longest);
        let along = wanted_mm[longest] / line_mm[longest];
        let mut wanted = [0; AXES];
        for axis in (0..AXES).filter(|&axis| axis != longest) {
            let within = self.slopes[axis].within;
            let parts = ((wanted_mm[axis] - along * line_mm[axis]) * rule.parts_per_mm[axis]) as i32;
            if parts.unsigned_abs() > within.unsigned_abs().saturating_mul(4) {
                return None;
            }
            wanted[axis] = parts.clamp(-within, within);
        }
        Some(wanted)
    }

    /// Has its line end so far beside its end, or half as far and so on, if it passes all ends then.
    #[cold]
    fn end_beside(&mut self, mut by: [i32; AXES]) -> bool {
        for _ in 0..3 {
            let line = core::array::from_fn(|axis| self.line[axis] + by[axis]);
            if self.passes_ends(&line) {
                (self.line, self.is_smooth) = (line, true);
                for (axis, (parts, begin)) in line.into_iter().zip(self.begin.beside).enumerate() {
                    let end = parts + i32::from(begin);
                    let steps = (end + OFFSET_PARTS / 2) >> OFFSET_PARTS.ilog2();
                    self.request.steps[axis] = steps;
                    self.request.offsets[axis] = (end - steps * OFFSET_PARTS) as i8;
                }
                return true;
            }
            by = by.map(|parts| parts / 2);
        }
        false
    }

    /// The length of its line on the axis that is the longest in its first move, steps.
    fn whole_steps(&self) -> u32 {
        let parts = self.line[usize::from(self.longest)].unsigned_abs();
        ((parts + OFFSET_PARTS.unsigned_abs() / 2) >> OFFSET_PARTS.ilog2()).max(1)
    }
}

/// For the chain.
impl MoveGroup {
    /// The move that it becomes, and the distance by which its line is beside the ends of its moves, mm, at most. The blend at its
    /// beginning has what is left of the deviation beside it, and beside the move before, where that distance is `used_before_mm`.
    /// Its marks count in steps of its longest axis from now on.
    pub fn finish(
        &self,
        used_before_mm: f32,
        course: &mut Course,
        rule: &GroupRule,
        marks: &mut Marks,
    ) -> (Request, f32) {
        let mut request = self.request;
        let is_plain = self.moves == 1 && !self.is_smooth && !self.begin.is_smooth;
        let used_mm = if is_plain { 0.0 } else { self.finish_line(&mut request, course, rule, marks) };
        request.deviation_mm = deviation_beside(request.deviation_mm, used_mm.max(used_before_mm));
        (request, used_mm)
    }

    #[cold]
    fn finish_line(&self, request: &mut Request, course: &mut Course, rule: &GroupRule, marks: &mut Marks) -> f32 {
        let most = request.steps.iter().map(|steps| steps.unsigned_abs()).max().unwrap_or(0);
        if self.moves > 1 && self.whole_steps() != most {
            marks.stretch(&request.tag, [most, self.whole_steps()]);
        }
        request.least_s = course.shared_s(rule.together_s(self.moves), Line::of(rule.lengths_mm(&self.line)).length_mm);
        self.within_mm
    }

    /// Where it begins.
    #[cold]
    pub fn begin(&self) -> Begin {
        self.begin
    }

    /// The steps to its end, and where the next group begins.
    pub fn end(&self) -> ([i32; AXES], Begin) {
        (self.request.steps, Begin { beside: self.request.offsets, is_smooth: self.is_smooth })
    }

    /// True if it has no step.
    pub fn is_empty(&self) -> bool {
        self.request.steps == [0; AXES]
    }

    /// True if `next` goes on in exactly its direction, and both are of whole steps.
    #[cold]
    pub fn is_straight_to(&self, next: &Request) -> bool {
        let longest = usize::from(self.longest);
        let (own, other) = (&self.request.steps, &next.steps);
        let is_whole = self.begin.beside == [0; AXES] && self.request.offsets == [0; AXES] && next.offsets == [0; AXES];
        let is_along = |axis: usize| {
            i64::from(own[axis]) * i64::from(other[longest]) == i64::from(other[axis]) * i64::from(own[longest])
        };
        is_whole && (own[longest] ^ other[longest]) >= 0 && (0..AXES).all(is_along)
    }
}

/// The parts of a step from `begin` beside whole steps to the end of a move; `None` if that is too far.
#[inline(never)]
fn line(steps: &[i32; AXES], end: &[i8; AXES], begin: &[i8; AXES]) -> Option<[i32; AXES]> {
    let mut line = [0; AXES];
    for axis in 0..AXES {
        if steps[axis].unsigned_abs() > STEPS_MAX {
            return None;
        }
        line[axis] = steps[axis] * OFFSET_PARTS + i32::from(end[axis]) - i32::from(begin[axis]);
    }
    Some(line)
}

/// The distance by which a blend may leave a corner, if the path beside it uses so much; half of it at least, if the moves before
/// allow more.
pub(crate) fn deviation_beside(deviation_mm: f32, used_mm: f32) -> f32 {
    if used_mm.to_bits() == 0 { deviation_mm } else { (deviation_mm - used_mm).max(0.5 * deviation_mm) }
}
