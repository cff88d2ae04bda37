//! A move under way that goes on otherwise: a hold, a resume, another speed.
//!
//! # Design
//! A move is never patched: from an instant on it is made by another [`SyncMove`], a part of the same path with a
//! profile of its own, whose speed is the first one's at that instant. Steps keep their numbers, and so their places on
//! the path. Parts that follow each other on one clock are compiled into segments that follow each other.
//!
//! Where an acceleration is under way, a law whose jerk is limited (the S-curve) first brings it to nothing at that
//! jerk, by the second half of a ramp that is all jerk; the others may drop it at once.

use crate::law::{IntervalLaw, SpeedLaw};
use crate::limits::Limits;
use crate::profile::{Profile, ProfileError};
use crate::sync::{PlanError, SyncMove, shared_limits};

/// The parts that a move goes on by, in order; of the first that are there, each begins where the one before it ends.
pub type Parts<const N: usize> = [Option<SyncMove<N>>; PARTS];

/// So many parts there are at most.
pub const PARTS: usize = 3;

impl<const N: usize> SyncMove<N> {
    /// Brakes to the start speed as fast as `limits` allow, from `at_s` (from the start of the run) on. `None` if it is
    /// braking by then to its end.
    ///
    /// # Errors
    /// As [`SyncMove::plan`].
    pub fn held(&self, at_s: f64, limits: &[Limits; N], law: SpeedLaw) -> Result<Option<Parts<N>>, PlanError> {
        let shared = shared_limits(&self.steps, limits, None)?;
        Ok(self.eased(at_s, &shared, law).map(|(easing, steady)| {
            let braking = steady.braked(shared.start_speed_steps_s, &shared, law);
            [easing, braking.map(|(braking, _)| braking), None]
        }))
    }

    /// Goes on from `at_s` (from the start of the run) on at `path_speed_steps_s`, or as fast as the limits allow.
    /// `None` if it is braking by then to its end, or about to.
    ///
    /// # Errors
    /// As [`SyncMove::plan`].
    pub fn respeeded(
        &self,
        at_s: f64,
        limits: &[Limits; N],
        law: SpeedLaw,
        path_speed_steps_s: Option<f64>,
    ) -> Result<Option<Parts<N>>, PlanError> {
        let shared = shared_limits(&self.steps, limits, path_speed_steps_s)?;
        let Some((easing, steady)) = self.eased(at_s, &shared, law) else { return Ok(None) };
        let (braking, steady) = match steady.braked(shared.top_speed_steps_s, &shared, law) {
            Some((braking, slower)) => (Some(braking), slower),
            None => (None, steady),
        };
        match steady.rest(&shared, law) {
            Ok(last) => Ok(Some([easing, braking, Some(last)])),
            // It is about to brake.
            Err(PlanError::Profile(ProfileError::EntrySpeed { .. } | ProfileError::Distance { .. })) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// What is left of it from `from_steps` of the longest axis on, from rest, on a run of its own. `None` if no step is.
    ///
    /// # Errors
    /// As [`SyncMove::plan`].
    pub fn resumed(
        &self,
        from_steps: f64,
        limits: &[Limits; N],
        interval_law: IntervalLaw,
        law: SpeedLaw,
        path_speed_steps_s: Option<f64>,
    ) -> Result<Option<Self>, PlanError> {
        if (0..N).all(|axis| self.steps_before(axis, from_steps) == self.steps[axis].unsigned_abs()) {
            return Ok(None);
        }
        let shared = shared_limits(&self.steps, limits, path_speed_steps_s)?;
        let start = shared.start_speed_steps_s;
        let profile = Profile::plan(self.way_steps() - from_steps, start, start, &shared, interval_law, law)?;
        Ok(Some(Self { profile, steps: self.steps, from_steps, origin_steps: from_steps, origin_s: 0.0 }))
    }

    /// How it moves from `at_s` on when its acceleration has come to nothing, and the part until then, if that takes
    /// time. `None` if it is braking by then.
    fn eased(&self, at_s: f64, shared: &Limits, law: SpeedLaw) -> Option<(Option<Self>, Steady<N>)> {
        let t_s = at_s - self.origin_s;
        let brakes_at_s = self.profile.duration_s() - self.profile.t_decel_s();
        if t_s >= brakes_at_s && self.profile.t_decel_s() > 0.0 || t_s >= self.profile.duration_s() {
            return None;
        }
        let (way_steps, speed_steps_s, accel_steps_s2) = self.profile.motion_at(t_s);
        let place_steps = self.origin_steps + way_steps;
        let steady = Steady { steps: self.steps, place_steps, speed_steps_s, at_s };
        if law != SpeedLaw::SCurve || accel_steps_s2 <= 0.0 || shared.jerk_steps_s3.is_infinite() {
            return Some((None, steady));
        }
        let profile = Profile::easing(speed_steps_s, accel_steps_s2, shared.jerk_steps_s3);
        let (half_s, half_steps) = (profile.duration_s() / 2.0, profile.position_at(profile.duration_s() / 2.0));
        let easing = Self {
            profile,
            steps: self.steps,
            from_steps: place_steps,
            origin_steps: place_steps - half_steps,
            origin_s: at_s - half_s,
        };
        let after = Steady {
            place_steps: easing.end_steps(),
            speed_steps_s: profile.cruise_speed_steps_s(),
            at_s: easing.end_s(),
            ..steady
        };
        Some((Some(easing), after))
    }
}

/// A place on a path where the speed is what it is, without an acceleration.
#[derive(Clone, Copy)]
struct Steady<const N: usize> {
    steps: [i32; N],
    place_steps: f64,
    speed_steps_s: f64,
    at_s: f64,
}

impl<const N: usize> Steady<N> {
    /// The part that brakes to `slower_steps_s`, and how it moves then; `None` if it is no faster.
    fn braked(&self, slower_steps_s: f64, shared: &Limits, law: SpeedLaw) -> Option<(SyncMove<N>, Self)> {
        if self.speed_steps_s <= slower_steps_s {
            return None;
        }
        let part = self.by(Profile::braking(self.speed_steps_s, slower_steps_s, shared, law));
        let then = Self { place_steps: part.end_steps(), speed_steps_s: slower_steps_s, at_s: part.end_s(), ..*self };
        Some((part, then))
    }

    /// The part to the end of the path.
    fn rest(&self, shared: &Limits, law: SpeedLaw) -> Result<SyncMove<N>, PlanError> {
        let left_steps = f64::from(crate::sync::longest(&self.steps)) - self.place_steps;
        let exit = shared.start_speed_steps_s.min(self.speed_steps_s);
        let profile = Profile::plan(left_steps, self.speed_steps_s, exit, shared, IntervalLaw::Fastest, law)?;
        Ok(self.by(profile))
    }

    fn by(&self, profile: Profile) -> SyncMove<N> {
        SyncMove {
            profile,
            steps: self.steps,
            from_steps: self.place_steps,
            origin_steps: self.place_steps,
            origin_s: self.at_s,
        }
    }
}
