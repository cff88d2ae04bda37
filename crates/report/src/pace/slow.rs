//! The slow places of a program: where the speed is lowest between two faster phases, why, and how much time that
//! costs. [`finder`](super::finder) finds them.

use isostep_motion::AXES;
use serde::Serialize;

use super::corner::CornerLimit;

/// Losses below this are not reported, s.
pub const LEAST_SHOWN_S: f64 = 0.0005;
/// Number of places that are listed one by one.
const WORST: usize = 10;
/// Number of corners that are listed one by one.
const WORST_CORNERS: usize = 5;

/// The reason why a place is slow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Why {
    /// The path turns, and `$11` or the blend allows no higher speed.
    Corner,
    /// The path bends from chord to chord of an arc, and `$11` or the blends allow no higher speed.
    Arc,
    /// The line asks for an exact stop: G61 or G61.1.
    ExactStop,
    /// With the thirds split every move goes from rest to rest: `$900`.
    Thirds,
    /// The machine is at standstill: a dwell, M0, a line that waits for standstill, the sender, or a hold.
    Stop,
    /// A curved speed profile has separate ramps in each move, so it changes the speed little over short moves: `$940`.
    SpeedProfile,
    /// The moves are so short that the board takes longer to plan them: each lasts as long as its
    /// [`LeastTimes`](isostep_motion::LeastTimes) say.
    ShortMoves,
    /// The moves behind it were not known early enough: the moves are so short that the whole look-ahead is needed for braking,
    /// or the sender was late. Also an override.
    LookAhead,
    /// The start of the first move, the end of the last one, or homing.
    Ends,
}

impl Why {
    /// All reasons, in the order of [`SlowPlaces::kinds`].
    pub const ALL: [Self; 9] = [
        Self::Corner,
        Self::Arc,
        Self::ExactStop,
        Self::Thirds,
        Self::Stop,
        Self::SpeedProfile,
        Self::ShortMoves,
        Self::LookAhead,
        Self::Ends,
    ];

    /// The reason in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Corner => "corner",
            Self::Arc => "arc",
            Self::ExactStop => "exact stop",
            Self::Thirds => "thirds split: rest to rest",
            Self::Stop => "stop",
            Self::SpeedProfile => "curved speed profile over short moves",
            Self::ShortMoves => "short moves",
            Self::LookAhead => "end of the look-ahead",
            Self::Ends => "begin and end",
        }
    }

    /// True if the machine is at standstill there.
    pub(super) const fn is_standstill(self) -> bool {
        matches!(self, Self::ExactStop | Self::Thirds | Self::Stop | Self::Ends)
    }
}

/// A place where the program is slow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SlowPlace {
    /// The reason.
    pub why: Why,
    /// When the speed is lowest, s from the start of the first move.
    pub at_s: f64,
    /// Position at that instant, mm.
    pub place_mm: [f64; AXES],
    /// Indices in [`Outcome::moves`](isostep_sim::Outcome::moves) of the move that ends there and of the one that begins there. They are equal if
    /// the place is within one move.
    pub moves: [usize; 2],
    /// Their lines of the program, from 1, if known.
    pub lines: [Option<usize>; 2],
    /// The lowest speed, mm/s.
    pub taken_mm_s: f64,
    /// The lower one of the speeds that the two moves ask for, mm/s.
    pub asked_mm_s: f64,
    /// The angle by which the path turns there, degrees; for an arc, that of the whole arc.
    pub turn_deg: f64,
    /// The limit of the speed there, if it is a corner or an arc.
    pub limit: Option<CornerLimit>,
    /// Duration of the standstill there, s.
    pub standing_s: f64,
    /// The additional time of the ramps to and from it, compared with the same distance at the speed asked for, s.
    pub lost_s: f64,
}

/// All slow places with one reason.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SlowKind {
    /// The reason.
    pub why: Why,
    /// Number of places.
    pub count: usize,
    /// Total time of the ramps to and from them, including slow phases between these ramps, s.
    pub ramps_s: f64,
    /// The additional time, compared with the same distance at the speed asked for, s.
    pub lost_s: f64,
}

/// The slow places of a program.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SlowPlaces {
    /// The places by reason.
    pub kinds: [SlowKind; Why::ALL.len()],
    /// The places with the highest loss, the worst first: ten at most. The start and the end, which every program has,
    /// are left out.
    pub worst: Vec<SlowPlace>,
    /// The corners with the highest loss, those of arcs apart, the worst first: five at most.
    pub corners: Vec<SlowPlace>,
}

impl SlowPlaces {
    /// No slow places.
    pub(super) fn new() -> Self {
        Self {
            kinds: Why::ALL.map(|why| SlowKind { why, count: 0, ramps_s: 0.0, lost_s: 0.0 }),
            worst: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// The places with this reason.
    pub fn of(&self, why: Why) -> &SlowKind {
        &self.kinds[why as usize]
    }

    pub(super) fn add(&mut self, place: SlowPlace, ramps_s: f64) {
        let kind = &mut self.kinds[place.why as usize];
        kind.count += 1;
        kind.ramps_s += ramps_s;
        kind.lost_s += place.lost_s;
        if place.why == Why::Ends || place.lost_s <= 0.0 {
            return;
        }
        rank(&mut self.worst, WORST, place);
        if place.why == Why::Corner {
            rank(&mut self.corners, WORST_CORNERS, place);
        }
    }
}

/// Puts a place into a list of so many at most, the worst first.
fn rank(places: &mut Vec<SlowPlace>, most: usize, place: SlowPlace) {
    let rank = places.partition_point(|other| other.lost_s >= place.lost_s);
    if rank < most {
        places.insert(rank, place);
        places.truncate(most);
    }
}
