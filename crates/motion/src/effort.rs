//! The processor time that a move costs. The chain plans no move to last less.
//!
//! # Design
//! A curved speed profile has its ramps within a move, and to compile them can take far longer than a short move lasts. That
//! cannot be noticed in time: what is known to be too much to compile would have to be braked from, by more such ramps.
//! So the cost is known beforehand, and limits the speed of a move as its feed does.
//!
//! How long that is, is a property of the board, which hands it to the coordinator.

use isostep_profile::SpeedProfile;
use isostep_profile::chain::Effort;

use crate::axes::AXES;
use crate::kinematics::Kinematics;
use crate::port::{Capabilities, Wiring};
use crate::shaping::{PHASES, Shaping};

/// The times that moves last at least, s, so that a board's processor keeps up with them, and some of it is left for the consoles and
/// the ports. A faster processor is never late by them.
///
/// They are laid out in this order, so that a board may keep them in words of its image.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastTimes {
    /// A move without a blend where hardware makes the steps. It needs a bound, because moves that are known ahead, after a hold
    /// or a longer move, could all be made at once: the last of them would be planned too late. It may be a little shorter than
    /// planning takes, because no more are known than the chain and the queue have room for. It also bounds how many of them make
    /// up what has to be known ahead, and so the axes that stand still know that they do.
    pub straight_s: f64,
    /// A move to which a blend leads: that is planned and compiled, too, and the end of a line at another place than that of the
    /// move.
    pub blend_s: f64,
    /// Each move that is taken together with others: to read and to interpret it.
    pub join_s: f64,
    /// By so much several moves last longer than one if they are made as one, beside `join_s` for each but the first: where the
    /// line ends has to be found, and on a line that is longer the speed changes more often.
    pub together_s: f64,
    /// A move in a shaped run: each impulse makes phases of its own of each move.
    pub shaped_s: f64,
    /// The same with a box, by which the acceleration changes all the time.
    pub box_s: f64,
    /// Instead with a box, if it is more: this times the root of the steps of all axes, of
    /// [`SHAPED_STEPS_MAX`](isostep_profile::chain::SHAPED_STEPS_MAX) at most.
    pub box_root_step_s: f64,
    /// Reading, planning and queueing a move without ramps, where the processor makes the steps, beside the steps.
    pub queued_s: f64,
    /// The ramps of each curved speed profile, in the order of [`SpeedProfile::ALL`] without the trapezoid.
    pub curved: [RampTimes; SpeedProfile::ALL.len() - 1],
}

/// The times that the ramps of a move by a curved speed profile take at least, s.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RampTimes {
    /// Both ramps, however short.
    pub ramps_s: f64,
    /// More for longer ones: this times the root of their steps.
    pub root_step_s: f64,
}

/// The number of phases that a short move has, which are kept for as long as the shaper is long, and how many may be kept, with
/// some to spare.
const PHASES_OF_A_MOVE: f64 = 3.0;
const PHASES_KEPT: f64 = (PHASES - PHASES / 8) as f64;

/// By so much a shaped move takes longer with crossed belts, where what a motor makes is put together from both axes: with equal
/// shapers, and with unlike ones, whose phases do not begin together.
const BELTS: f64 = 1.5;
const UNLIKE_BELTS: f64 = 2.5;

fn of_belts(shaping: &Shaping, kinematics: Kinematics) -> f64 {
    match kinematics {
        Kinematics::Cartesian => 1.0,
        Kinematics::CoreXy if shaping.is_unlike() => UNLIKE_BELTS,
        Kinematics::CoreXy => BELTS,
    }
}

impl LeastTimes {
    /// The time that a move lasts at least if its run is shaped like this, s, and that for the root of its steps; 0 if it is not.
    #[must_use]
    pub fn of_shaping_s(&self, shaping: Option<&Shaping>, kinematics: Kinematics) -> [f64; 2] {
        shaping.map_or([0.0; 2], |shaping| {
            let has_box = shaping.impulses.iter().any(|impulses| impulses.box_ends_s().is_some());
            let [least_s, root_step_s] =
                if has_box { [self.box_s, self.box_root_step_s] } else { [self.shaped_s, 0.0] };
            let belts = of_belts(shaping, kinematics);
            let kept_s = shaping.lasts_s * PHASES_OF_A_MOVE / PHASES_KEPT;
            [(belts * least_s).max(kept_s), belts * root_step_s]
        })
    }

    /// The time for a move by `speed_profile` with these ports.
    pub(crate) fn effort(
        &self,
        speed_profile: SpeedProfile,
        ports: &[Option<Capabilities>; AXES],
        wiring: &[Wiring; AXES],
        shaping: Option<&Shaping>,
        kinematics: Kinematics,
    ) -> Effort {
        let [shaped_s, shaped_root_step_s] = self.of_shaping_s(shaping, kinematics);
        let by_core = ports.iter().flatten().zip(wiring).filter(|(port, _)| port.core_ns > 0);
        let step_ns = by_core.map(|(port, wiring)| port.core_ns + port.pulse_ns(*wiring)).max().unwrap_or(0);
        let curved = (speed_profile as usize).checked_sub(1).and_then(|index| self.curved.get(index));
        let RampTimes { ramps_s, root_step_s } =
            curved.copied().unwrap_or(RampTimes { ramps_s: 0.0, root_step_s: 0.0 });
        // Where the processor makes the steps, each line has a time of its own. In a shaped run the time of a move is that of its
        // corner, too.
        let by_hardware = step_ns == 0;
        Effort {
            step_s: f64::from(step_ns) * 1e-9,
            move_s: if by_hardware { shaped_s } else { self.queued_s + shaped_s },
            straight_s: if by_hardware && shaping.is_none() { self.straight_s } else { 0.0 },
            blend_s: if shaping.is_some() { 0.0 } else { self.blend_s },
            ramps_s,
            root_step_s,
            shaped_root_step_s,
        }
    }
}
