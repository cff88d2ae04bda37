//! Canned cycles: the moves of a line that drills or bores one hole or several, one by one.
//!
//! They are made as LinuxCNC makes them: to R straight up if the tool is below it, across to the hole, down to R as a rapid, to the
//! depth at the feed, and up again, to R (G99) or to where the series began if that is higher (G98). The axis across the plane is
//! called Z here; in G18 it is Y, in G19 X.

use crate::{AXES, BlockMove, MotionMode, PathControl, Rate, arc::PLANES, axes::Z};

/// What a line of a canned cycle makes. Places are machine coordinates, in [picometres](crate::length).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cycle {
    /// G73, G81 to G83, G85, G86 or G89.
    pub(crate) mode: MotionMode,
    /// As in [`Modal::plane`](crate::Modal).
    pub(crate) plane: u8,
    /// Where the tool stands before.
    pub(crate) from_pm: [i64; AXES],
    /// The first hole; Z counts for nothing.
    pub(crate) hole_pm: [i64; AXES],
    /// From each hole to the next.
    pub(crate) step_pm: [i64; AXES],
    /// The number of holes, 1 at least.
    pub(crate) holes: u32,
    /// R: from here on the tool goes down at the feed.
    pub(crate) near_pm: i64,
    /// The depth.
    pub(crate) bottom_pm: i64,
    /// The height at which the tool leaves a hole.
    pub(crate) clear_pm: i64,
    /// The depth of each peck, above 0; of a cycle without pecks that of the hole or more.
    pub(crate) peck_pm: i64,
    /// How far the tool goes back up in G73, and how far above the last depth it goes down to in G83.
    pub(crate) clearance_pm: i64,
    /// The dwell at the bottom, s; 0 for none.
    pub(crate) dwell_s: f32,
    /// The feed.
    pub(crate) mm_min: f32,
}

/// A part of a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CyclePart {
    /// A straight move.
    Move(BlockMove),
    /// A dwell, s, above 0.
    Dwell(f32),
    /// G86: the spindle is to stand at the bottom.
    SpindleOff,
    /// G86: it is to turn again as before.
    SpindleOn,
}

/// How far a [`Cycle`] has come.
#[derive(Debug, Clone, Copy)]
pub struct CycleProgress {
    hole: u32,
    place_pm: [i64; AXES],
    /// How deep the hole is so far.
    depth_pm: i64,
    next: CycleStage,
}

/// What comes next, if it is not done already.
#[derive(Debug, Clone, Copy)]
enum CycleStage {
    Lift,
    Across,
    Near,
    Return,
    Cut,
    Withdraw,
    Dwell,
    Stop,
    Out,
    Start,
    Hole,
}

impl Cycle {
    /// Nothing of it.
    #[must_use]
    pub fn begin(&self) -> CycleProgress {
        CycleProgress { hole: 0, place_pm: self.from_pm, depth_pm: self.near_pm, next: CycleStage::Lift }
    }

    /// The next part; `None` behind the last.
    pub fn next(&self, progress: &mut CycleProgress) -> Option<CyclePart> {
        while progress.hole < self.holes {
            if let Some(part) = progress.step(self) {
                return Some(part);
            }
        }
        None
    }

    /// Its parts, in order.
    pub fn parts(&self) -> impl Iterator<Item = CyclePart> {
        let mut progress = self.begin();
        core::iter::from_fn(move || self.next(&mut progress))
    }

    /// Places that span the box in which all its moves are: if these are allowed, so are all.
    #[must_use]
    pub fn bounds_pm(&self) -> [[i64; AXES]; 4] {
        let last_pm = self.last_pm();
        let highest_pm = self.clear_pm.max(self.from_pm[self.axis()]);
        [(self.hole_pm, self.bottom_pm), (self.hole_pm, highest_pm), (last_pm, self.bottom_pm), (last_pm, highest_pm)]
            .map(|(place_pm, height_pm)| self.at(place_pm, height_pm))
    }

    /// Where the tool stands behind it.
    #[must_use]
    pub fn end_pm(&self) -> [i64; AXES] {
        self.at(self.last_pm(), self.clear_pm)
    }

    /// The axis along which it drills. A machine of two axes has none, and no cycles.
    pub(crate) fn axis(&self) -> usize {
        PLANES[usize::from(self.plane)].get(Z).copied().unwrap_or_default()
    }

    fn hole_pm(&self, index: u32) -> [i64; AXES] {
        core::array::from_fn(|axis| self.hole_pm[axis] + self.step_pm[axis] * i64::from(index))
    }

    fn last_pm(&self) -> [i64; AXES] {
        self.hole_pm(self.holes - 1)
    }

    fn at(&self, mut place_pm: [i64; AXES], height_pm: i64) -> [i64; AXES] {
        place_pm[self.axis()] = height_pm;
        place_pm
    }
}

impl CycleProgress {
    /// Takes one step of the sequence: what is to be done, if it is not done already.
    fn step(&mut self, cycle: &Cycle) -> Option<CyclePart> {
        let height_pm = self.place_pm[cycle.axis()];
        let feed = Rate::Feed { mm_min: cycle.mm_min };
        let (part, next) = match self.next {
            CycleStage::Lift if height_pm < cycle.near_pm => {
                (self.along(cycle, cycle.near_pm, Rate::Rapid), CycleStage::Across)
            }
            CycleStage::Lift => (None, CycleStage::Across),
            CycleStage::Across => {
                (self.to(cycle.at(cycle.hole_pm(self.hole), height_pm), Rate::Rapid, true), CycleStage::Near)
            }
            CycleStage::Near => {
                self.depth_pm = cycle.near_pm;
                (self.down(cycle, cycle.near_pm), CycleStage::Cut)
            }
            // G83 goes on from just above where it has been; a clearance above R is none.
            CycleStage::Return => {
                (self.down(cycle, (self.depth_pm + cycle.clearance_pm).min(cycle.near_pm)), CycleStage::Cut)
            }
            CycleStage::Cut => {
                self.depth_pm = (self.depth_pm - cycle.peck_pm).max(cycle.bottom_pm);
                let is_deep = self.depth_pm == cycle.bottom_pm;
                (self.along(cycle, self.depth_pm, feed), if is_deep { CycleStage::Dwell } else { CycleStage::Withdraw })
            }
            CycleStage::Withdraw if cycle.mode == MotionMode::Peck => {
                (self.along(cycle, cycle.near_pm, Rate::Rapid), CycleStage::Return)
            }
            CycleStage::Withdraw => {
                let height_pm = (self.depth_pm + cycle.clearance_pm).min(cycle.near_pm);
                (self.along(cycle, height_pm, Rate::Rapid), CycleStage::Cut)
            }
            CycleStage::Dwell => ((cycle.dwell_s > 0.0).then_some(CyclePart::Dwell(cycle.dwell_s)), CycleStage::Stop),
            CycleStage::Stop => {
                ((cycle.mode == MotionMode::BoreStop).then_some(CyclePart::SpindleOff), CycleStage::Out)
            }
            CycleStage::Out => {
                let is_fed = matches!(cycle.mode, MotionMode::Bore | MotionMode::BoreDwell);
                (self.along(cycle, cycle.clear_pm, if is_fed { feed } else { Rate::Rapid }), CycleStage::Start)
            }
            CycleStage::Start => {
                ((cycle.mode == MotionMode::BoreStop).then_some(CyclePart::SpindleOn), CycleStage::Hole)
            }
            CycleStage::Hole => {
                self.hole += 1;
                (None, CycleStage::Across)
            }
        };
        self.next = next;
        part
    }

    /// To a height above the hole, where the direction changes.
    fn along(&mut self, cycle: &Cycle, height_pm: i64, rate: Rate) -> Option<CyclePart> {
        self.to(cycle.at(self.place_pm, height_pm), rate, true)
    }

    /// Down as a rapid; the feed goes on in the same direction.
    fn down(&mut self, cycle: &Cycle, height_pm: i64) -> Option<CyclePart> {
        self.to(cycle.at(self.place_pm, height_pm), Rate::Rapid, false)
    }

    /// To a place, if it is not there already. Corners are not rounded in a hole.
    fn to(&mut self, target_pm: [i64; AXES], rate: Rate, stops: bool) -> Option<CyclePart> {
        let path = if stops { PathControl::Stop } else { PathControl::Exact };
        let is_elsewhere = target_pm != self.place_pm;
        self.place_pm = target_pm;
        is_elsewhere.then_some(CyclePart::Move(BlockMove { target_pm, rate, arc: None, path }))
    }
}
