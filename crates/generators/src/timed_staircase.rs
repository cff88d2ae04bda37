//! Forero's staircase on its microcontroller's timers, whose preloads are whole numbers.

use super::{PreloadTimer, Staircase, StaircaseError, Tread};

/// The index of the deceleration's last interval, which makes up for lost steps.
const LAST_TREAD: usize = 40;

/// A [`Staircase`] as a PIC18F4550 makes it (Forero 2023, sections 3.2 and 4). TMR0 interrupts after every interval.
/// TMR1 interrupts after every half period of STEP and toggles it. Both begin at a preload that is cut down to a whole
/// number (eq 14), so every half period is up to a count of 2 us too long, and steps are missing at the end of each
/// interval. "The last interval is used to correct the steps that may have been lost."
///
/// Eq 13, T_int = V_int/2, has its fraction upside down: half a step period is T_int = 1/(2 V_int).
///
/// The paper's flow charts are pictures, so the following rules are assumptions of this model:
///
/// - When the speed changes, TMR1 starts again: the half period under way is lost, and STEP keeps its level. The
///   cruise's 21 intervals are one part. An overflow exactly at the end of an interval still counts.
/// - The last interval, whose own speed is 0, continues at the lowest speed, V_c/20, for as long as steps are missing.
///   If none are missing, nothing moves in it.
/// - TMR1 counts from its preload without delay, unless `reload_ticks` says how many counts pass between an overflow
///   and the writing of the preload. The paper does not give this number; 0 shows the effect of truncation alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedStaircase {
    staircase: Staircase,
    reload_ticks: u32,
    interval_ticks: u64,
}

/// One part of a [`TimedStaircase`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedTread {
    /// The part of the ideal staircase.
    pub ideal: Tread,
    /// Its beginning, s.
    pub start_s: f64,
    /// Its length, s: that of its intervals, or more if it is the last one and steps are missing.
    pub duration_s: f64,
    /// Steps whose rising edge lies in it.
    pub steps: u32,
    /// The preload from which TMR1 counts; `None` while it stands still.
    pub preload: Option<Preload>,
    start_ticks: u64,
    half_ticks: u64,
    toggles: u64,
    is_high: bool,
}

/// A preload of TMR1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preload {
    /// The exact value by eq 14.
    pub exact: f64,
    /// The value that fits the register.
    pub truncated: u32,
}

impl TimedStaircase {
    /// The staircase on TMR0 and TMR1, with `reload_ticks` counts of 2 us lost at every overflow of TMR1.
    ///
    /// # Errors
    /// An interval or a half period is longer or shorter than its timer can count. t_1 is at most 5.24 s. At t_1 = 4.5
    /// s there must be at least 687 steps.
    pub fn plan(staircase: Staircase, reload_ticks: u32) -> Result<Self, StaircaseError> {
        let count = |timer: PreloadTimer, interval_s| {
            timer.preload(interval_s).map(|preload| timer.ticks(preload)).map_err(StaircaseError::Timer)
        };
        let counts = count(PreloadTimer::TMR0, staircase.interval_s())?;
        let (slowest, fastest) = (half_period_s(&staircase, 1), half_period_s(&staircase, 20));
        count(PreloadTimer::TMR1, slowest)?;
        count(PreloadTimer::TMR1, fastest)?;
        let interval_ticks = u64::from(counts * PreloadTimer::TMR0.prescaler / PreloadTimer::TMR1.prescaler);
        Ok(Self { staircase, reload_ticks, interval_ticks })
    }

    /// The ideal staircase.
    #[must_use]
    pub fn staircase(&self) -> Staircase {
        self.staircase
    }

    /// The 20 intervals of the acceleration, the cruise, and the 20 of the deceleration.
    pub fn treads(&self) -> impl Iterator<Item = TimedTread> + use<> {
        let plan = *self;
        let treads = plan.staircase.treads().enumerate();
        treads.scan(Progress::default(), move |progress, (index, ideal)| {
            let tread = plan.tread(index, ideal, progress);
            progress.intervals += ideal.intervals;
            progress.toggles += tread.toggles;
            Some(tread)
        })
    }

    fn tread(&self, index: usize, ideal: Tread, before: &Progress) -> TimedTread {
        let is_last = index == LAST_TREAD;
        let ticks = self.interval_ticks * u64::from(ideal.intervals);
        // Toggles that are left: each step has two, up and down.
        let left = 2 * u64::from(self.staircase.steps()) - before.toggles;
        let level = if is_last && left > 0 { 1 } else { ideal.level };
        let preload = (level > 0).then(|| self.preload(level));
        let half_ticks = preload.map_or(0, |preload| self.half_ticks(preload));
        let fitting = ticks.checked_div(half_ticks).unwrap_or(0);
        let toggles = if is_last { left } else { fitting.min(left) };
        let start_ticks = self.interval_ticks * u64::from(before.intervals);
        TimedTread {
            ideal,
            start_s: seconds(start_ticks),
            duration_s: seconds(if is_last { ticks.max(left * half_ticks) } else { ticks }),
            steps: (rises(before.toggles + toggles) - rises(before.toggles)) as u32,
            preload,
            start_ticks,
            half_ticks,
            toggles,
            is_high: before.toggles % 2 == 1,
        }
    }

    fn preload(&self, level: u32) -> Preload {
        let half_s = half_period_s(&self.staircase, level);
        // `plan` has checked that the longest and the shortest half period fit.
        let truncated = PreloadTimer::TMR1.preload(half_s).unwrap_or(0);
        Preload { exact: PreloadTimer::TMR1.exact_preload(half_s), truncated }
    }

    fn half_ticks(&self, preload: Preload) -> u64 {
        u64::from(PreloadTimer::TMR1.ticks(preload.truncated)) + u64::from(self.reload_ticks)
    }

    /// The instants of the rising edges of all steps, s from the beginning of the first interval, which stands still.
    pub fn edges_s(&self) -> impl Iterator<Item = f64> + use<> {
        self.treads().flat_map(|tread| tread.edges_s())
    }

    /// The number of steps that are missing when the last interval begins.
    #[must_use]
    pub fn lost_steps(&self) -> u32 {
        self.staircase.steps() - self.treads().take(LAST_TREAD).map(|tread| tread.steps).sum::<u32>()
    }

    /// Duration of the acceleration, s.
    #[must_use]
    pub fn t_accel_s(&self) -> f64 {
        self.treads().take(20).map(|tread| tread.duration_s).sum()
    }

    /// Duration of the cruise, s.
    #[must_use]
    pub fn t_cruise_s(&self) -> f64 {
        self.treads().skip(20).take(1).map(|tread| tread.duration_s).sum()
    }

    /// Duration of the deceleration, s. If it has to make up for lost steps, it ends with the falling edge of the last
    /// step.
    #[must_use]
    pub fn t_decel_s(&self) -> f64 {
        self.treads().skip(21).map(|tread| tread.duration_s).sum()
    }
}

impl TimedTread {
    /// The instants of its steps' rising edges, s from the beginning of the move.
    pub fn edges_s(&self) -> impl Iterator<Item = f64> + use<> {
        let (tread, first) = (*self, if self.is_high { 2 } else { 1 });
        let rising = (first..=tread.toggles).step_by(2);
        rising.map(move |toggle| seconds(tread.start_ticks + toggle * tread.half_ticks))
    }
}

/// The steps and the time before a part.
#[derive(Clone, Copy, Default)]
struct Progress {
    intervals: u32,
    toggles: u64,
}

/// Half a step period at `level` twentieths of V_c, s: eq 13 with its fraction corrected.
fn half_period_s(staircase: &Staircase, level: u32) -> f64 {
    let speed = staircase.cruise_speed_steps_s() * f64::from(level) / 20.0;
    1.0 / (2.0 * speed)
}

/// The number of rising edges among the first `toggles`.
fn rises(toggles: u64) -> u64 {
    toggles.div_ceil(2)
}

fn seconds(ticks: u64) -> f64 {
    ticks as f64 / PreloadTimer::TMR1.tick_hz()
}
