//! The pace of a program: how its time is spent, and what limits its speed.
//!
//! Everything is computed from the plans of the moves and nothing from edges, so it is also available with
//! [`Config::only_time`]. Homing is left out. The limits are those at the end of the run. If a program changes limits
//! during the run, results that need limits are left out: [`Pace::limits_changed`].
//!
//! [`Config::only_time`]: isostep_sim::Config::only_time

mod asked;
mod carried;
mod corner;
mod finder;
pub(crate) mod phases;
mod seconds;
mod slow;
pub mod words;

use isostep_motion::{AXES, LeastTimes};
use serde::Serialize;

use self::asked::top_mm_s;
use self::finder::Finder;
use self::phases::{Change, Phase, phases};
use self::seconds::Clock;
use isostep_sim::Outcome;
use isostep_sim::lines_of_moves::{self, Source};

pub use self::asked::asked_mm_s;
pub use self::carried::BOARD_MOVES_PER_S;
pub use self::corner::{CornerLimit, Rule};
pub use self::seconds::Second;
pub use self::slow::{LEAST_SHOWN_S, SlowKind, SlowPlace, SlowPlaces, Why};

/// The time of a program, divided by what limits it, s. The sum is the total: [`Pace::total_s`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Shares {
    /// At the feed that the lines ask for, and on ramps between feeds.
    pub feed_s: f64,
    /// At the top speed of X, Y or Z, `$110`-`$112`: rapids, and feeds above the top speed.
    pub top_speed_s: [f64; AXES],
    /// On ramps to and from corners, including those of arcs.
    pub corners_s: f64,
    /// On ramps to and from standstill.
    pub standstill_s: f64,
    /// On ramps of a curved speed profile over short moves: [`Why::SpeedProfile`].
    pub speed_profile_s: f64,
    /// Over short moves, each as long as the board takes for it: [`Why::ShortMoves`].
    pub short_moves_s: f64,
    /// On ramps to and from places where the look-ahead was too short: [`Why::LookAhead`].
    pub look_ahead_s: f64,
    /// At the ends of shaped runs, until the last impulse has passed.
    pub shaping_s: f64,
    /// At standstill between moves.
    pub standing_s: f64,
    /// In motion, if what limits it is not known: [`Pace::limits_changed`].
    pub unknown_s: f64,
}

impl Shares {
    /// The sum, s.
    pub fn sum_s(&self) -> f64 {
        let top_speed_s: f64 = self.top_speed_s.iter().sum();
        let ramps_s =
            self.corners_s + self.standstill_s + self.speed_profile_s + self.short_moves_s + self.look_ahead_s;
        self.feed_s + top_speed_s + ramps_s + self.shaping_s + self.standing_s + self.unknown_s
    }
}

/// The pace of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AxisPace {
    /// Its highest planned speed, mm/s.
    pub highest_mm_s: f64,
    /// Its top speed: `$110`-`$112`, mm/s.
    pub top_mm_s: f64,
    /// The highest speed as a fraction of the top speed.
    pub share: f64,
    /// Time during which it is the axis that limits the acceleration on ramps, s.
    pub ramps_s: f64,
}

/// The pace of a program.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Pace {
    /// True if the program sets steps/mm, or anything that limits speed, after its first move. Then the times in motion
    /// and at standstill are given, but not what limits them: [`slow`](Self::slow) is empty, [`axes`](Self::axes) are
    /// 0, and there is no second and no fastest axis.
    pub limits_changed: bool,
    /// Number of moves.
    pub moves: usize,
    /// Distance along the path, mm; 0 if limits changed.
    pub distance_mm: f64,
    /// Time in motion, s.
    pub moving_s: f64,
    /// Time that shapers add at the ends of runs, s.
    pub shaping_s: f64,
    /// Time at standstill between the first move and the last one, without homing, s.
    pub standing_s: f64,
    /// The total time, divided by what limits it.
    pub shares: Shares,
    /// The slow places of the program, and the time that they cost.
    pub slow: SlowPlaces,
    /// Of all seconds in progress, the one with the shortest distance; null if there is none.
    pub slowest_second: Option<Second>,
    /// The second in which most moves begin; null for a program of less than a second.
    pub busiest_second: Option<Second>,
    /// The time that it takes longer at least on the board, which plans [`BOARD_MOVES_PER_S`] moves a second, s.
    pub longer_on_board_s: f64,
    /// The times that moves last at least on the board.
    #[serde(skip)]
    pub least_times: LeastTimes,
    /// The pace of the motors of X, Y and Z; speeds are those of their belts and screws.
    pub axes: [AxisPace; AXES],
    /// Index of the axis that comes closest to its top speed; null without a move.
    pub fastest_axis: Option<usize>,
}

impl Pace {
    /// The pace of `outcome`.
    pub fn of(outcome: &Outcome) -> Self {
        Self::new(outcome, &lines_of_moves::of_moves(outcome))
    }

    /// The pace of `outcome`, for moves with these sources.
    pub fn new(outcome: &Outcome, sources: &[Option<Source>]) -> Self {
        let pace = Self::by_last_limits(outcome, sources);
        if lines_of_moves::sets_limits_on_the_way(outcome) { pace.without_limits() } else { pace }
    }

    /// Keeps only what does not depend on the limits.
    fn without_limits(self) -> Self {
        let Self { moves, moving_s, shaping_s, standing_s, longer_on_board_s, least_times, .. } = self;
        Self {
            limits_changed: true,
            moves,
            distance_mm: 0.0,
            moving_s,
            shaping_s,
            standing_s,
            shares: Shares { shaping_s, standing_s, unknown_s: moving_s, ..Shares::default() },
            slow: SlowPlaces::new(),
            slowest_second: None,
            busiest_second: None,
            longer_on_board_s,
            least_times,
            axes: [AxisPace::default(); AXES],
            fastest_axis: None,
        }
    }

    /// The pace as if the limits at the end had been in force all the time.
    fn by_last_limits(outcome: &Outcome, sources: &[Option<Source>]) -> Self {
        let mut finder = Finder::new(outcome, sources);
        let mut clock = Clock::default();
        let mut axes =
            std::array::from_fn(|axis| AxisPace { top_mm_s: top_mm_s(outcome, axis), ..AxisPace::default() });
        let (mut moving_s, mut distance_mm) = (0.0, 0.0);
        for phase in phases(outcome, sources) {
            moving_s += phase.span_s;
            distance_mm += phase.distance_mm;
            take_axes(&mut axes, outcome, &phase);
            clock.take(&phase);
            finder.take(&phase);
        }
        for (motor, axis) in axes.iter_mut().enumerate() {
            axis.share = axis.highest_mm_s / axis.top_mm_s;
            axis.highest_mm_s *= outcome.turned_mm(motor);
            axis.top_mm_s *= outcome.turned_mm(motor);
        }
        let found = finder.finish();
        let ramps_s = |is_it: fn(Why) -> bool| {
            let kinds = found.places.kinds.iter().filter(|kind| is_it(kind.why));
            kinds.map(|kind| kind.ramps_s).sum()
        };
        let shares = Shares {
            feed_s: found.feed_s,
            top_speed_s: found.top_speed_s,
            corners_s: ramps_s(|why| matches!(why, Why::Corner | Why::Arc)),
            standstill_s: ramps_s(Why::is_standstill),
            speed_profile_s: ramps_s(|why| why == Why::SpeedProfile),
            short_moves_s: ramps_s(|why| why == Why::ShortMoves),
            look_ahead_s: ramps_s(|why| why == Why::LookAhead),
            shaping_s: found.shaping_s,
            standing_s: found.standing_s,
            unknown_s: 0.0,
        };
        let [slowest_second, busiest_second] = clock.finish(sources);
        let nearest = (0..AXES).rev().max_by(|&one, &other| axes[one].share.total_cmp(&axes[other].share));
        Self {
            limits_changed: false,
            moves: outcome.program_moves().count(),
            distance_mm,
            moving_s,
            shaping_s: found.shaping_s,
            standing_s: found.standing_s,
            shares,
            slow: found.places,
            slowest_second,
            busiest_second,
            longer_on_board_s: carried::longer_s(outcome),
            least_times: outcome.config.least_times,
            axes,
            fastest_axis: nearest.filter(|&axis| axes[axis].share > 0.0),
        }
    }

    /// Time from the start of the first move to the end of the last one, without homing, s.
    pub fn total_s(&self) -> f64 {
        self.moving_s + self.shaping_s + self.standing_s
    }
}

fn take_axes(axes: &mut [AxisPace; AXES], outcome: &Outcome, phase: &Phase) {
    let [begin_mm_s, end_mm_s] = phase.speeds_mm_s;
    for (axis, direction) in axes.iter_mut().zip(phase.asked.direction) {
        axis.highest_mm_s = axis.highest_mm_s.max(begin_mm_s.max(end_mm_s) * direction.abs());
    }
    if phase.change != Change::Level {
        axes[phase.asked.weakest_axis(outcome, phase.change == Change::Up)].ramps_s += phase.span_s;
    }
}

#[cfg(test)]
mod tests;
