//! The places of the axes of a run in closed form: by the plans of its moves, and by its shapers.
//!
//! The plans say where an axis would be unshaped. If the run is shaped, the axis is where the weighted sum of that at
//! several instants is. Before the first plan an axis stands where that begins, and after the last where that ends.

use isostep_motion::{AXES, Axis, Finish, Kinematics, Shaping};
use isostep_profile::SyncMove;

use crate::moves::MoveRecord;

/// The places of the axes of one run.
pub struct Places<'a> {
    run: &'a [MoveRecord],
    begins_s: Vec<f64>,
    /// When the acceleration of any axis changes, unshaped, in order; and some instants at which it does not.
    knots_s: Vec<f64>,
    kinematics: Kinematics,
}

impl<'a> Places<'a> {
    /// The places in a run of these moves, one at least.
    pub fn of(run: &'a [MoveRecord], kinematics: Kinematics) -> Self {
        Self { run, begins_s: run.iter().map(MoveRecord::begin_s).collect(), knots_s: knots_s(run), kinematics }
    }

    fn shaping(&self) -> Option<&'a Shaping> {
        self.run[0].shaping.as_deref()
    }

    /// The place where an axis is at `t_s` from the start of the run, steps.
    pub fn steps(&self, axis: usize, t_s: f64) -> f64 {
        match self.shaping() {
            Some(shaping) if self.is_crossed(axis) => {
                // What is shaped is what the motors do together.
                let axes = std::array::from_fn(|axis| self.shaped_steps(shaping, axis, t_s));
                self.kinematics.motors_of(axes)[axis]
            }
            Some(shaping) => self.shaped_steps(shaping, axis, t_s),
            None => self.unshaped_steps(axis, t_s),
        }
    }

    /// The place where its shaper has an axis, steps of the axis.
    fn shaped_steps(&self, shaping: &Shaping, axis: usize, t_s: f64) -> f64 {
        let impulses = shaping.impulses[axis];
        if let Some(ends_s) = impulses.box_ends_s() {
            let [to_s, from_s] = ends_s.map(|delay_s| t_s - delay_s);
            return self.mean_steps(axis, from_s, to_s);
        }
        impulses.iter().map(|(weight, delay_s)| weight * self.unshaped_axis_steps(axis, t_s - delay_s)).sum()
    }

    /// The place where it would be unshaped in the mean, steps: exact by Simpson's rule between the instants at which its
    /// acceleration changes.
    fn mean_steps(&self, axis: usize, from_s: f64, to_s: f64) -> f64 {
        let first = self.knots_s.partition_point(|t_s| *t_s <= from_s);
        let knots_s = self.knots_s[first..].iter().copied().take_while(|t_s| *t_s < to_s);
        let mut begin_s = from_s;
        let mut integral = 0.0;
        for end_s in knots_s.chain([to_s]) {
            let places = [begin_s, 0.5 * (begin_s + end_s), end_s].map(|t_s| self.unshaped_axis_steps(axis, t_s));
            integral += (end_s - begin_s) / 6.0 * (places[0] + 4.0 * places[1] + places[2]);
            begin_s = end_s;
        }
        integral / (to_s - from_s)
    }

    /// The place where an axis would be unshaped, steps of the axis.
    fn unshaped_axis_steps(&self, axis: usize, t_s: f64) -> f64 {
        if !self.is_crossed(axis) {
            return self.unshaped_steps(axis, t_s);
        }
        self.kinematics.axes_of(std::array::from_fn(|motor| self.unshaped_steps(motor, t_s)))[axis]
    }

    /// True if a motor moves more axes than one.
    fn is_crossed(&self, motor: usize) -> bool {
        self.kinematics.is_shared(Axis::ALL[motor])
    }

    /// The place where a motor would be unshaped, steps.
    fn unshaped_steps(&self, axis: usize, t_s: f64) -> f64 {
        let begun = self.begins_s.partition_point(|begin_s| *begin_s <= t_s);
        self.run[begun.saturating_sub(1)].place_steps(axis, t_s)
    }

    /// Every instant at which the acceleration of an axis changes, in order, s from the start of the run; and some at which
    /// it does not.
    pub(crate) fn bends_s(&self, axis: usize) -> impl Iterator<Item = f64> + use<> {
        let unshaped_s = self.knots_s.clone();
        let delays_s: Vec<f64> = match self.shaping() {
            Some(shaping) => delays_s(shaping, self.kinematics, axis),
            None => vec![0.0],
        };
        let mut next = vec![0; delays_s.len()];
        std::iter::from_fn(move || {
            let of = |index: usize| unshaped_s.get(next[index]).map(|t_s| (t_s + delays_s[index], index));
            let (t_s, index) = (0..delays_s.len()).filter_map(of).min_by(|one, other| one.0.total_cmp(&other.0))?;
            next[index] += 1;
            Some(t_s)
        })
    }
}

/// The delays of all impulses that a motor makes, of whichever axis, s.
pub(crate) fn delays_s(shaping: &Shaping, kinematics: Kinematics, motor: usize) -> Vec<f64> {
    let axes = Axis::ALL.into_iter().filter(|axis| kinematics.moves(*axis)[motor]);
    axes.flat_map(|axis| shaping.impulses[axis as usize].iter().map(|(_, delay_s)| delay_s)).collect()
}

/// When the acceleration of any axis of these moves changes, and some instants at which it does not, in order.
fn knots_s(run: &[MoveRecord]) -> Vec<f64> {
    let mut knots_s = Vec::with_capacity(4 * run.len());
    for record in run {
        knots_s.extend(record.blend.iter().flat_map(|blend| [blend.begin_s(), blend.corner_begins_s(), blend.end_s()]));
        knots_s.extend(std::iter::once(&record.plan).chain(&record.parts).flat_map(ramp_ends_s));
        knots_s.extend(record.rests_s());
    }
    knots_s.sort_by(f64::total_cmp);
    knots_s
}

/// When a plan begins and ends, and when it begins to cruise and to slow down, s from the start of the run.
fn ramp_ends_s(plan: &SyncMove<AXES>) -> [f64; 4] {
    let slows_s = plan.end_s() - plan.profile.t_decel_s();
    [plan.begin_s(), slows_s - plan.profile.t_cruise_s(), slows_s, plan.end_s()]
}

impl MoveRecord {
    /// The place where its plan has an axis at `t_s` from the start of the run, unshaped, steps.
    pub fn place_steps(&self, axis: usize, t_s: f64) -> f64 {
        if let Some(blend) = self.blend {
            let corner = f64::from(self.origin_steps[axis] - blend.ends_steps(axis)[0]);
            if t_s < blend.end_s() {
                return corner + blend.place_at(axis, t_s);
            }
            return corner + self.line_place_steps(axis, t_s);
        }
        let before = (self.plan.step_numbers(axis).start - 1) as i32 * self.plan.steps[axis].signum();
        f64::from(self.origin_steps[axis] - before) + self.line_place_steps(axis, t_s)
    }

    /// The same, from the whole step next to the beginning of the move.
    fn line_place_steps(&self, axis: usize, t_s: f64) -> f64 {
        let plan = self.parts.iter().rfind(|part| part.begin_s() <= t_s).unwrap_or(&self.plan);
        let place = match t_s {
            _ if self.rests_s().is_some_and(|rests_s| t_s >= rests_s) => self.held_at_steps,
            _ if t_s >= plan.end_s() => plan.end_steps(),
            _ if t_s <= plan.begin_s() => plan.begin_steps(),
            _ => plan.place_at(t_s),
        };
        plan.axis_place(axis, place)
    }

    /// When it rests, unshaped, if it was held, s from the start of the run: so slow a move rests in the middle of its plan.
    fn rests_s(&self) -> Option<f64> {
        (self.finish == Finish::Held).then(|| self.plan_s - self.lasts_s())
    }
}
