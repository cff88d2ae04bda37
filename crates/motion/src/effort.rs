//! The processor time that a move costs. The chain plans no move to last less.
//!
//! # Design
//! A curved speed profile has its ramps within a move, and to compile them can take far longer than a short move lasts. That
//! cannot be noticed in time: what is known to be too much to compile would have to be braked from, by more such ramps.
//! So the cost is known beforehand, and limits the speed of a move as its feed does.
//!
//! The constants are measured on an RP2040 of 125 MHz, `flow.*` of `cargo xtask bench`, with moves of 4 to 360 steps of
//! three axes from corner to corner. They leave at least a tenth of the processor to the consoles and the ports. A faster
//! processor is never late by them.

use isostep_profile::SpeedProfile;
use isostep_profile::chain::Effort;

use crate::axes::AXES;
use crate::port::{Capabilities, Wiring};
use crate::shaping::{PHASES, Shaping};

/// Reading, planning and queueing a move without ramps.
const MOVE_S: f64 = 0.6e-3;

/// The time that a move without a blend lasts at least where hardware makes the steps, s. It needs a bound, because moves that
/// are known ahead, after a hold or a longer move, could all be made at once: the last of them would be planned too late. It may
/// be a little shorter than planning takes, because no more are known than the chain and the queue have room for. It also bounds
/// how many of them make up what has to be known ahead, and so the axes that stand still know that they do.
pub const STRAIGHT_S: f64 = 0.5e-3;

/// The time that a move lasts at least to which a blend leads, s: that is planned and compiled, too, and the end of a line at
/// another place than that of the move.
pub const BLEND_S: f64 = 1.0e-3;

/// The time that each move takes that is taken together with others, s: to read and to interpret it.
pub const JOIN_S: f64 = 0.25e-3;

/// The time that several moves take longer than one if they are made as one, s, beside [`JOIN_S`] for each but the first: where the
/// line ends has to be found, and on a line that is longer the speed changes more often.
pub const TOGETHER_S: f64 = 0.75e-3;

/// The time that a move lasts at least in a shaped run, s: each impulse makes phases of its own of each move.
pub const SHAPED_S: f64 = 1.64e-3;

/// The same with a box, whose steps take a root of a cubic each.
pub const BOX_S: f64 = 3.6e-3;

/// The number of phases that a short move has, which are kept for as long as the shaper is long, and how many may be kept, with
/// some to spare.
const PHASES_OF_A_MOVE: f64 = 3.0;
const PHASES_KEPT: f64 = (PHASES - PHASES / 8) as f64;

/// The time that a move lasts at least if its run is shaped like this, s; 0 if it is not.
#[must_use]
pub fn shaped_s(shaping: Option<&Shaping>) -> f64 {
    shaping.map_or(0.0, |shaping| {
        let has_box = shaping.impulses.iter().any(|impulses| impulses.box_ends_s().is_some());
        let least_s = if has_box { BOX_S } else { SHAPED_S };
        least_s.max(shaping.lasts_s * PHASES_OF_A_MOVE / PHASES_KEPT)
    })
}

/// The time for a move by `speed_profile` with these ports.
pub(crate) fn effort(
    speed_profile: SpeedProfile,
    ports: &[Option<Capabilities>; AXES],
    wiring: &[Wiring; AXES],
    shaping: Option<&Shaping>,
) -> Effort {
    let shaped_s = shaped_s(shaping);
    let by_core = ports.iter().flatten().zip(wiring).filter(|(port, _)| port.core_ns > 0);
    let step_ns = by_core.map(|(port, wiring)| port.core_ns + port.pulse_ns(*wiring)).max().unwrap_or(0);
    let (ramps_ms, root_step_ms) = match speed_profile {
        SpeedProfile::Trapezoid => (0.0, 0.0),
        SpeedProfile::SCurve => (1.0, 2.3),
        SpeedProfile::Sine => (2.0, 2.5),
        SpeedProfile::Linear => (1.0, 2.2),
        SpeedProfile::Quadratic => (1.0, 2.0),
        SpeedProfile::Sinusoidal => (6.0, 2.6),
        // The logarithmic speed profile, which costs most; and any speed profile that is not measured.
        _ => (14.0, 3.8),
    };
    // Where the processor makes the steps, each line has a time of its own. In a shaped run the time of a move is that of its
    // corner, too.
    let by_hardware = step_ns == 0;
    Effort {
        step_s: f64::from(step_ns) * 1e-9,
        move_s: if by_hardware { shaped_s } else { MOVE_S + shaped_s },
        straight_s: if by_hardware && shaping.is_none() { STRAIGHT_S } else { 0.0 },
        blend_s: if shaping.is_some() { 0.0 } else { BLEND_S },
        ramps_s: ramps_ms * 1e-3,
        root_step_s: root_step_ms * 1e-3,
    }
}
