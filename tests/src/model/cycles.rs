//! Canned cycles, by LinuxCNC's rules: which words they need, and the places to which they lead, in order.

use super::block::{Block, Refused, near};
use super::machine::{Model, Place};
use super::words::ONE;

/// What a line leaves to the next of its series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Series {
    code: i64,
    plane: i64,
    /// The height at which the series began.
    initial: i64,
    r: i64,
    z: i64,
    q: i64,
}

/// True for the codes of canned cycles, in tenths.
#[must_use]
pub fn is_cycle(motion: i64) -> bool {
    matches!(motion, 730 | 810 | 820 | 830 | 850 | 860 | 890)
}

impl Model {
    /// The places of a line of a canned cycle, in order, without those where it is already.
    ///
    /// # Errors
    /// The number of the error.
    pub(super) fn drill(&mut self, block: &mut Block) -> Result<Vec<Place>, Refused> {
        let code = self.modes.motion;
        if self.modes.feed < if self.modes.inverse_time { 1 } else { ONE } {
            return Err(22);
        }
        if self.modes.inverse_time {
            return Err(39);
        }
        if !block.has("XYZ") {
            return Err(26);
        }
        let up = match self.modes.plane {
            17 => 2,
            18 => 1,
            _ => 0,
        };
        let before = self.series.filter(|series| series.plane == self.modes.plane);
        let same = before.filter(|series| series.code == code);
        let initial = before.map_or(self.position[up], |series| series.initial);
        let length = |block: &mut Block, letter| block.take(letter).map(|value| block.modes.length(value));
        let r = length(block, 'R').or(same.map(|series| series.r)).ok_or(28)?;
        let z = block.lengths()[up].or(same.map(|series| series.z)).ok_or(28)?;
        let pecks = matches!(code, 730 | 830);
        let q = match pecks {
            true => length(block, 'Q').or(same.map(|series| series.q)).ok_or(28)?,
            false => before.map_or(0, |series| series.q),
        };
        if matches!(code, 820 | 860 | 890) && block.take('P').is_none() && same.is_none() && code != 860 {
            return Err(28);
        }
        self.series = Some(Series { code, plane: self.modes.plane, initial, r, z, q });
        let zero = self.work_zero()[up];
        let (r, bottom) = if self.modes.incremental { (initial + r, initial + r + z) } else { (zero + r, zero + z) };
        let (r, bottom) = (near(r)?, near(bottom)?);
        if r < bottom {
            return Err(39);
        }
        let holes = block.take('L').map_or(1, |count| count / ONE);
        if !(1..=9_999).contains(&holes) {
            return Err(39);
        }
        let clear = if self.modes.leaves_at_r { r } else { initial.max(r) };
        let lengths = block.lengths();
        let mut places = vec![self.position];
        let mut go = |axis_values: &[(usize, i64)]| -> Result<(), Refused> {
            let mut place = *places.last().expect("it begins somewhere");
            for &(axis, value) in axis_values {
                place[axis] = near(value)?;
            }
            places.push(place);
            Ok(())
        };
        go(&[(up, self.position[up].max(r))])?;
        let mut hole = self.position;
        for index in 0..holes {
            for axis in (0..3).filter(|&axis| axis != up) {
                match lengths[axis] {
                    Some(length) if self.modes.incremental => hole[axis] += length,
                    Some(length) if index == 0 => hole[axis] = self.work_zero()[axis] + length,
                    _ => {}
                }
            }
            go(&[((up + 1) % 3, hole[(up + 1) % 3]), ((up + 2) % 3, hole[(up + 2) % 3])])?;
            go(&[(up, r)])?;
            if pecks && q <= 0 {
                return Err(39);
            }
            let mut depth = r;
            while pecks && depth - q > bottom {
                depth -= q;
                let back = (depth + ONE * self.settings.get(28) as i64).min(r);
                go(&[(up, depth)])?;
                go(&[(up, if code == 830 { r } else { back })])?;
                go(&[(up, back)])?;
            }
            go(&[(up, bottom)])?;
            go(&[(up, clear)])?;
        }
        places.dedup();
        Ok(places.split_off(1))
    }
}
