//! What the motors do for the axes to move. The rest of the project asks here.
//!
//! # Design
//! The coordinator plans in steps of motors, so whatever a chain promises it promises of motors: every edge by the closed form, equal
//! intervals, limits, stops. What a program asks for, and what is reported, are places of axes.
//!
//! With [crossed belts](Kinematics::CoreXy) the motors of X and Y are at an angle of 45° to the axes. A way of one millimetre along the
//! belts' directions turns each motor by √2 mm of belt, so with that as its unit a path has the same length, the same angles and the
//! same deviations in both. Only limits are another matter. A motor may be as fast as the faster of both axes, which needs that; and
//! the limits of the axes hold besides (`ChainConfig::with_crossed`). For equal axes these are implied, because an axis makes
//! half of what two motors make together.
//!
//! Each axis keeps its shaper, because it is axes that ring: see `Crossed` in isostep-profile.

use core::f64::consts::FRAC_1_SQRT_2;

use isostep_profile::chain::ChainConfig;
use isostep_profile::shaper::Combination;
use isostep_profile::{IntervalSplit, Limits, OFFSET_PARTS};

use crate::axes::{AXES, Axis};
use crate::config::Config;
use crate::machine::Move;
use crate::shaping::Shaping;

/// What the motors do for the axes to move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kinematics {
    /// Each axis has its motor.
    #[default]
    Cartesian,
    /// CoreXY and H-bot: the motor of X makes X + Y, that of Y makes X - Y. Both axes have the same steps per millimetre.
    CoreXy,
}

/// The axes that crossed belts move, as indices.
const X: usize = Axis::X as usize;
const Y: usize = Axis::Y as usize;

impl Kinematics {
    /// The steps of the motors for these of the axes, of a place or of a way.
    #[must_use]
    #[inline(always)]
    pub fn motors(self, axes: [i32; AXES]) -> [i32; AXES] {
        if self == Self::Cartesian { axes } else { crossed_motors(axes) }
    }

    /// The steps of the axes for these of the motors, of a place or of a way. With crossed belts an axis may stand half a step beside a
    /// whole one, which is said to be the one nearer to zero: so it is never beyond its travel by that.
    #[must_use]
    #[inline(always)]
    pub fn axes(self, motors: [i32; AXES]) -> [i32; AXES] {
        if self == Self::Cartesian { motors } else { crossed_axes(motors) }
    }

    /// The same for what need not be whole: places, ways, speeds or accelerations.
    #[must_use]
    pub fn axes_of(self, mut motors: [f64; AXES]) -> [f64; AXES] {
        if self == Self::CoreXy {
            (motors[X], motors[Y]) = (0.5 * (motors[X] + motors[Y]), 0.5 * (motors[X] - motors[Y]));
        }
        motors
    }

    /// The same the other way round.
    #[must_use]
    pub fn motors_of(self, mut axes: [f64; AXES]) -> [f64; AXES] {
        if self == Self::CoreXy {
            (axes[X], axes[Y]) = (axes[X] + axes[Y], axes[X] - axes[Y]);
        }
        axes
    }

    /// A way, a speed or an acceleration along the axes, from that along the directions of the motors; both in millimetres of path.
    #[must_use]
    pub fn along_axes(self, along_motors: [f64; AXES]) -> [f64; AXES] {
        match self {
            Self::Cartesian => along_motors,
            Self::CoreXy => {
                let mut along = self.axes_of(along_motors);
                along[..=Y].iter_mut().for_each(|along| *along /= FRAC_1_SQRT_2);
                along
            }
        }
    }

    /// The steps of each motor for a millimetre of path in its direction, from those of the axes.
    #[cold]
    pub(crate) fn motor_steps_per_mm(self, mut steps_per_mm: [f64; AXES]) -> [f64; AXES] {
        if self == Self::CoreXy {
            let motor = steps_per_mm[X] / FRAC_1_SQRT_2;
            (steps_per_mm[X], steps_per_mm[Y]) = (motor, motor);
        }
        steps_per_mm
    }

    /// The motors that move when `axis` does alone.
    #[must_use]
    pub fn moves(self, axis: Axis) -> [bool; AXES] {
        core::array::from_fn(|motor| motor == axis as usize || self.is_shared(axis) && motor <= Y)
    }

    /// Whether `axis` is moved by two motors, and so its motor moves another axis too.
    #[must_use]
    pub fn is_shared(self, axis: Axis) -> bool {
        self == Self::CoreXy && axis as usize <= Y
    }

    /// The places of the motors, if the place where `axis` stands is its zero and the others keep theirs.
    #[must_use]
    #[cold]
    pub fn with_zero(self, mut motors: [i32; AXES], axis: Axis) -> [i32; AXES] {
        match (self, axis) {
            (Self::CoreXy, Axis::X | Axis::Y) => {
                // Half of the sum is X, half of the difference Y. Where an axis stands at a whole step, so does the other.
                let (x, y) = (motors[X].wrapping_add(motors[Y]) / 2, motors[X].wrapping_sub(motors[Y]) / 2);
                let (x, y) = if axis == Axis::X { (0, y) } else { (x, 0) };
                (motors[X], motors[Y]) = (x + y, x - y);
            }
            _ => motors[axis as usize] = 0,
        }
        motors
    }

    /// Lengthens a way from `from` by a step of one motor, if the axes would end half a step beside a whole one otherwise. A stop in the
    /// middle of a step leaves them there.
    #[cold]
    pub(crate) fn end_whole(self, motors: &mut [i32; AXES], from: [i32; AXES]) {
        if self == Self::CoreXy {
            let ends = [X, Y].map(|motor| motors[motor].wrapping_add(from[motor]));
            motors[X] += (ends[0] ^ ends[1]) & 1;
        }
    }

    /// A move in steps of motors, for one in steps of axes.
    #[inline(always)]
    pub(crate) fn of_move(self, one: &Move) -> Move {
        if self == Self::Cartesian { *one } else { crossed_move(one) }
    }

    /// What a shaper of `axis` shapes, of what the chain plans.
    pub(crate) fn shaped(self, axis: Axis) -> Combination {
        match (self, axis) {
            (Self::CoreXy, Axis::X) => Combination::Sum,
            (Self::CoreXy, Axis::Y) => Combination::Difference,
            _ => Combination::Axis(axis as usize),
        }
    }
}

#[cold]
fn crossed_motors(mut axes: [i32; AXES]) -> [i32; AXES] {
    (axes[X], axes[Y]) = (axes[X].wrapping_add(axes[Y]), axes[X].wrapping_sub(axes[Y]));
    axes
}

#[cold]
fn crossed_axes(mut motors: [i32; AXES]) -> [i32; AXES] {
    (motors[X], motors[Y]) = (motors[X].wrapping_add(motors[Y]) / 2, motors[X].wrapping_sub(motors[Y]) / 2);
    motors
}

/// Where a path goes beside whole steps, each motor goes to the whole step that is nearest.
#[cold]
fn crossed_move(one: &Move) -> Move {
    let mut made = Move { target_steps: Kinematics::CoreXy.motors(one.target_steps), ..*one };
    if one.deviation_mm > 0.0 {
        let [x, y] = [X, Y].map(|axis| i32::from(one.offsets[axis]));
        (made.target_steps[X], made.offsets[X]) = beside(made.target_steps[X], x + y);
        (made.target_steps[Y], made.offsets[Y]) = beside(made.target_steps[Y], x - y);
    } else {
        made.offsets = [0; AXES];
    }
    made
}

/// The whole step nearest to a place which is so many parts beside another, and how far that is beside it: less than half a step.
#[cold]
fn beside(steps: i32, parts: i32) -> (i32, i8) {
    let half = OFFSET_PARTS / 2;
    let whole = if parts.abs() < half { 0 } else { parts.signum() };
    (steps.wrapping_add(whole), (parts - whole * OFFSET_PARTS).clamp(1 - half, half - 1) as i8)
}

impl Config {
    /// The same machine as its motors see it: their limits, and their steps along a path. Where an axis has its own motor, that is no
    /// other.
    #[must_use]
    #[cold]
    pub fn of_motors(&self) -> Self {
        let mut config = *self;
        if self.kinematics == Kinematics::CoreXy {
            let highest = looser(&self.limits[X], &self.limits[Y]);
            (config.limits[X], config.limits[Y]) = (highest, highest);
            config.steps_per_mm = self.motor_steps_per_mm();
        }
        config
    }

    /// The place of the axes where the motors are at these steps, mm.
    #[must_use]
    #[cold]
    pub fn mm_at(&self, motors_steps: [i32; AXES]) -> [f64; AXES] {
        let steps = self.kinematics.axes_of(motors_steps.map(f64::from));
        core::array::from_fn(|axis| steps[axis] / self.steps_per_mm[axis])
    }

    /// The steps of each motor for a millimetre of path in its direction.
    #[cold]
    pub(crate) fn motor_steps_per_mm(&self) -> [f64; AXES] {
        self.kinematics.motor_steps_per_mm(self.steps_per_mm)
    }

    /// The limits of the axes that crossed belts move, for runs that are shaped like this.
    ///
    /// If the shapers of X and Y differ, a motor may make at once what X did at one instant and Y at another. So that it keeps its own
    /// limits whatever that is, both axes together may then do no more than one motor.
    #[must_use]
    #[cold]
    pub fn crossed_limits(&self, shaping: Option<&Shaping>) -> [Limits; 2] {
        let own = [self.limits[X], self.limits[Y]];
        match shaping {
            Some(shaping) if shaping.is_unlike() => {
                let motor = looser(&own[0], &own[1]);
                own.map(|limits| shared(&limits, &own, &motor))
            }
            _ => own,
        }
    }

    /// The configuration of a chain that plans in steps of motors, for runs that are shaped like this.
    #[cold]
    pub(crate) fn chain(&self, interval_split: IntervalSplit, shaping: Option<&Shaping>) -> ChainConfig<AXES> {
        let Self { limits, steps_per_mm, .. } = self.of_motors();
        let mm_per_step = steps_per_mm.map(|steps| 1.0 / steps);
        let chain =
            ChainConfig::new(limits, mm_per_step, self.junction_deviation_mm, interval_split, self.speed_profile);
        match self.kinematics {
            Kinematics::Cartesian => chain,
            Kinematics::CoreXy => chain.with_crossed(self.crossed_limits(shaping)),
        }
    }
}

/// The share of an axis in what a motor may do, limit by limit.
fn shared(limits: &Limits, both: &[Limits; 2], motor: &Limits) -> Limits {
    let share = |of: fn(&Limits) -> f64| {
        let [own, all] = [of(limits), of(&both[0]) + of(&both[1])];
        // Of no limit, or of none at all, an axis has all.
        if own > 0.0 && all.is_finite() { own * of(motor) / all } else { own }
    };
    Limits {
        start_speed_steps_s: share(|limits| limits.start_speed_steps_s),
        top_speed_steps_s: share(|limits| limits.top_speed_steps_s),
        accel_steps_s2: share(|limits| limits.accel_steps_s2),
        decel_steps_s2: share(|limits| limits.decel_steps_s2),
        jerk_steps_s3: share(|limits| limits.jerk_steps_s3),
    }
}

/// The looser of both, limit by limit.
fn looser(one: &Limits, other: &Limits) -> Limits {
    Limits {
        start_speed_steps_s: one.start_speed_steps_s.max(other.start_speed_steps_s),
        top_speed_steps_s: one.top_speed_steps_s.max(other.top_speed_steps_s),
        accel_steps_s2: one.accel_steps_s2.max(other.accel_steps_s2),
        decel_steps_s2: one.decel_steps_s2.max(other.decel_steps_s2),
        jerk_steps_s3: one.jerk_steps_s3.max(other.jerk_steps_s3),
    }
}
