//! The work of a port: one move, or several in one run; and when the closed form has their steps.

use embassy_time::Instant;
use isostep_motion::{Capabilities, Direction, StreamItem, Wiring};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile, SyncMove};
use isostep_sim::time;
use oorandom::Rand32;

/// The plan of an axis in a move of two axes. The axis is the second; the first is the longer.
#[derive(Clone, Copy, Debug)]
pub struct Plan(pub SyncMove<2>);

/// Limits that every port can keep.
pub const LIMITS: Limits = Limits {
    start_speed_steps_s: 0.0,
    top_speed_steps_s: 20_000.0,
    accel_steps_s2: 400_000.0,
    decel_steps_s2: 400_000.0,
    jerk_steps_s3: f64::INFINITY,
};

impl Plan {
    /// A move of so many steps.
    pub fn new(steps: i32) -> Self {
        Self::within(steps, LIMITS)
    }

    /// The same within other limits.
    pub fn within(steps: i32, limits: Limits) -> Self {
        Self::beside(steps, steps, limits)
    }

    /// A move of `steps` while another axis makes more.
    pub fn beside(longer: i32, steps: i32, limits: Limits) -> Self {
        Self(
            SyncMove::plan([longer, steps], &[limits; 2], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None)
                .unwrap(),
        )
    }

    /// Its steps; below 0 if they go back.
    #[must_use]
    pub fn steps(&self) -> i32 {
        self.0.steps[1]
    }

    /// The steps as the items for a port with this tick rate.
    pub fn items(&self, tick_hz: u32) -> impl Iterator<Item = StreamItem> + Clone + use<> {
        let direction = Direction::of(self.steps());
        self.0.segments(1, tick_hz).map(move |segment| StreamItem::Steps { segment, direction })
    }

    /// The closed-form instants of the steps, ns since power-up, and their direction.
    pub fn instants_ns(self, start: Instant) -> impl Iterator<Item = (f64, i32)> {
        let start_ns = time::ns(start) as f64;
        let of = move |k| (start_ns + self.0.step_time_s(1, k) * 1e9, self.steps().signum());
        (1..=self.steps().unsigned_abs()).map(of)
    }
}

/// The signed number of steps that an item makes.
pub fn steps_of(item: StreamItem) -> i32 {
    match item {
        StreamItem::Steps { segment, direction } => segment.steps() as i32 * direction.sign(),
        StreamItem::Rest { .. } | StreamItem::End => 0,
    }
}

/// Seed of the random chains.
pub(crate) const SEED: u64 = 11;

/// Consecutive moves. Each begins when the previous one ends, rounded to the port's tick.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chain {
    /// Of the port.
    pub tick_hz: u32,
    /// When each move begins, ticks from the start of the run, and its plan.
    pub moves: Vec<(u64, Plan)>,
    /// When the last move ends, ticks from the start of the run.
    pub end_ticks: u64,
}

impl Chain {
    /// These moves.
    pub fn new(tick_hz: u32, plans: impl IntoIterator<Item = Plan>) -> Self {
        let mut chain = Self { tick_hz, ..Self::default() };
        for plan in plans {
            let lasts_ticks = (plan.0.end_s() * f64::from(tick_hz)).ceil() as u64;
            chain.push(plan, lasts_ticks);
        }
        chain
    }

    /// Single steps in alternating directions, `period_ticks` apart.
    pub(crate) fn to_and_fro(tick_hz: u32, steps: i32, period_ticks: u32) -> Self {
        let rate = f64::from(tick_hz) / f64::from(period_ticks);
        let limits = Limits { start_speed_steps_s: rate, top_speed_steps_s: rate, ..LIMITS };
        let mut chain = Self { tick_hz, ..Self::default() };
        (0..steps).for_each(|k| chain.push(Plan::within(1 - 2 * (k % 2), limits), period_ticks.into()));
        chain
    }

    /// A hundred moves of up to `steps` steps at random speeds and in random directions.
    pub fn random(random: &mut Rand32, capabilities: &Capabilities, steps: u32) -> Self {
        let rate = f64::from(capabilities.rate_max_steps_s(Wiring::default()));
        let plan = |_| {
            // Speeds range from the highest to slow; slow ones are more frequent.
            let speed = 1_000.0 + (rate - 1_000.0) * f64::from(random.rand_float()).powi(3);
            let start = speed * f64::from(random.rand_float());
            let limits = Limits { start_speed_steps_s: start, top_speed_steps_s: speed, ..LIMITS };
            let steps = 1 + random.rand_range(0..steps) as i32;
            Plan::within(if random.rand_range(0..2) == 0 { steps } else { -steps }, limits)
        };
        Self::new(capabilities.tick_hz, (0..100).map(plan))
    }

    /// Adds a move that lasts so long.
    pub fn push(&mut self, plan: Plan, lasts_ticks: u64) {
        self.moves.push((self.end_ticks, plan));
        self.end_ticks += lasts_ticks;
    }

    /// Their target, steps.
    #[must_use]
    pub fn steps(&self) -> i32 {
        self.moves.iter().map(|(_, plan)| plan.steps()).sum()
    }

    /// The items for the port, the end included.
    pub fn items(&self) -> Vec<StreamItem> {
        let later = |(begin_ticks, plan): &(u64, Plan)| {
            let begin_ticks = *begin_ticks;
            plan.items(self.tick_hz).map(move |item| delayed(item, begin_ticks))
        };
        self.moves.iter().flat_map(later).chain([StreamItem::End]).collect()
    }

    /// The closed-form instants of the steps, ns since power-up, and their direction.
    pub fn instants_ns(&self, start: Instant) -> impl Iterator<Item = (f64, i32)> {
        let ns_per_tick = 1e9 / f64::from(self.tick_hz);
        self.moves.iter().flat_map(move |(begin_ticks, plan)| {
            let begin_ns = *begin_ticks as f64 * ns_per_tick;
            plan.instants_ns(start).map(move |(at_ns, direction)| (at_ns + begin_ns, direction))
        })
    }
}

/// The item, later.
#[must_use]
pub(crate) fn delayed(item: StreamItem, ticks: u64) -> StreamItem {
    match item {
        StreamItem::Steps { segment, direction } => StreamItem::Steps { segment: segment.delayed(ticks), direction },
        StreamItem::Rest { until_ticks } => StreamItem::Rest { until_ticks: until_ticks + ticks },
        StreamItem::End => StreamItem::End,
    }
}
