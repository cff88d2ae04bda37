//! The legs of a plan, for one axis.

use super::Leg;
use crate::blend::Blend;
use crate::chain::Plan;
use crate::fixed::is_zero;
use crate::sync::SyncMove;

impl<const N: usize> Plan<N> {
    /// The leg with this index that the axis with index `axis` has in this plan, and when that ends, s from the start of the
    /// run; `None` beyond the last. A leg that lasts no time has any place. Its place counts from the whole step next to where the move
    /// begins, signed by direction.
    #[must_use]
    pub fn leg(&self, axis: usize, index: usize) -> Option<(Leg, f64)> {
        match self {
            Self::Line(line) => line.leg(axis, index),
            Self::Blend(blend) => blend.leg(axis, index),
        }
    }
}

impl<const N: usize> SyncMove<N> {
    /// Speeding up, cruising and slowing down, at constant acceleration: the ramps of a curved law are no legs.
    // Not inlined, or sums of what may be a blend's numbers are computed before it is known that this is a line.
    #[inline(never)]
    fn leg(&self, axis: usize, index: usize) -> Option<(Leg, f64)> {
        let profile = &self.profile;
        let cruises_s = self.origin_s + profile.t_accel_s();
        let slows_s = || cruises_s + profile.t_cruise_s();
        let accel = |ramp: &crate::ramp::Ramp| ramp.constant_accel_steps_s2().unwrap_or(0.0);
        let cruise_steps_s = profile.cruise_speed_steps_s();
        let (begin_s, end_s, place_steps, speed_steps_s, accel_steps_s2) = match index {
            0 => (self.origin_s, cruises_s, 0.0, profile.entry_speed_steps_s(), accel(&profile.accel)),
            1 => (cruises_s, slows_s(), profile.accel_end_steps(), cruise_steps_s, 0.0),
            2 => (slows_s(), self.end_s(), profile.cruise_end_steps(), cruise_steps_s, -accel(&profile.decel)),
            _ => return None,
        };
        if is_zero(end_s - begin_s) {
            return Some((Leg::rest(begin_s, 0.0), end_s));
        }
        if self.steps[axis] == 0 && is_zero(self.axis_steps(axis)) {
            return Some((Leg::rest(begin_s, self.axis_place(axis, 0.0)), end_s));
        }
        let share = self.axis_steps(axis) / self.distance_steps();
        let place_steps = self.axis_place(axis, 0.0) + share * (self.origin_steps + place_steps);
        let speed_steps_s = share * speed_steps_s;
        let accel_steps_s2 = share * accel_steps_s2;
        let leg = Leg { begin_s, place_steps, speed_steps_s, accel_steps_s2 };
        Some((leg, end_s))
    }
}

impl<const N: usize> Blend<N> {
    /// The approach, and the corner.
    // Not inlined, for the same reason.
    #[inline(never)]
    fn leg(&self, axis: usize, index: usize) -> Option<(Leg, f64)> {
        let corner_s = self.corner_begins_s();
        let (place_steps, speed_steps_s) = self.corner_begins(axis);
        match index {
            0 if !self.has_approach() => Some((Leg::rest(corner_s, 0.0), corner_s)),
            0 => {
                let begin_s = self.begin_s();
                let place_steps = place_steps - speed_steps_s * (corner_s - begin_s);
                Some((Leg { place_steps, speed_steps_s, ..Leg::rest(begin_s, 0.0) }, corner_s))
            }
            1 => {
                let accel_steps_s2 = self.accel_steps_s2(axis);
                let leg = Leg { place_steps, speed_steps_s, accel_steps_s2, ..Leg::rest(corner_s, 0.0) };
                Some((leg, self.end_s()))
            }
            _ => None,
        }
    }
}
