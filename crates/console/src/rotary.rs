//! The effects of a rotary axis: its words are degrees, and a feed may be that of the other axes.
//!
//! A path is as long as if a degree were a millimetre, as in grblHAL; so F is along all axes unless `$701` says
//! otherwise.

use crate::axes::A;
use crate::{AXES, Arc, path};

const INCH_MM: f32 = 25.4;

/// The meaning of A by the settings. With three axes nothing is rotary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Rotary {
    /// `$376`: A is in degrees, whatever the units of the program.
    pub is_on: bool,
    /// `$701`: a feed is the speed of the linear axes if any of them moves, by RS274/NGC, 2.1.2.5.
    pub feed_is_linear: bool,
    /// `$701`, bit 1: if only A moves, a feed in inches is one in degrees.
    pub feed_is_degrees: bool,
}

impl Rotary {
    /// The feed along the path of all axes, for F as it is for millimetres. `way_pm` is from the start to the target.
    pub(crate) fn along_path(self, mm_min: f32, way_pm: [i64; AXES], arc: Option<&Arc>, inches: bool) -> f32 {
        let turns = way_pm.get(A).is_some_and(|&turn_pm| turn_pm != 0);
        if !(AXES > A && self.is_on && self.feed_is_linear && turns) {
            return mm_min;
        }
        let linear_mm = match arc {
            Some(arc) => arc.linear_mm() as f32,
            None => path::length_mm::<3>(core::array::from_fn(|axis| way_pm[axis])),
        };
        if linear_mm > 0.0 {
            mm_min * length_mm(way_pm, arc) / linear_mm
        } else if self.feed_is_degrees && inches {
            mm_min / INCH_MM
        } else {
            mm_min
        }
    }
}

/// The length of a path; a degree counts as a millimetre.
pub(crate) fn length_mm(way_pm: [i64; AXES], arc: Option<&Arc>) -> f32 {
    arc.map_or_else(|| path::length_mm(way_pm), |arc| arc.length_mm() as f32)
}
