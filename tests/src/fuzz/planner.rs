//! Makes machines, moves and interruptions from bytes, and checks what the chain's own tests check with random ones.

#[path = "../../../crates/profile/tests/chain/bent.rs"]
#[allow(dead_code, missing_docs, reason = "the tests of the profile's chain: what else they have is not of use here")]
mod bent;
#[path = "../../../crates/profile/tests/chain/case.rs"]
#[allow(dead_code, missing_docs, reason = "as above")]
mod case;
#[path = "../../../crates/profile/tests/chain/drive.rs"]
#[allow(dead_code, missing_docs, reason = "as above")]
mod drive;
#[path = "../../../crates/profile/tests/chain/follow.rs"]
#[allow(dead_code, missing_docs, reason = "as above")]
mod follow;
#[path = "../../../crates/profile/tests/chain/model.rs"]
#[allow(dead_code, missing_docs, reason = "as above")]
mod model;
#[path = "../../../crates/profile/tests/chain/sees.rs"]
#[allow(dead_code, missing_docs, reason = "as above")]
mod sees;

use std::array;

use arbitrary::{Result, Unstructured};
use isostep_profile::chain::{Chain, Chunk, ChunkKind, Effort, Request};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile};

use self::case::{AXES, Case};
use self::drive::{Event, drive};
use self::model::OverrideRatios;

const MOVES: usize = 24;
const EVENTS: usize = 40;
/// The tick rates of both step ports.
const RATES_HZ: [u32; 2] = [1_000_000, 125_000_000];
/// Cases with more steps than this are not compiled, because it would take too long.
const COMPILED_STEPS: u32 = 20_000;

/// Plans and makes the moves that `bytes` describe.
///
/// # Panics
/// When a chunk does not continue the previous one, a limit is exceeded, a step is missing or made twice, or the chain
/// does not come to rest. The message contains the case.
pub fn run(bytes: &[u8]) {
    let mut bytes = Unstructured::new(bytes);
    // When the bytes run out, the case ends.
    let Ok((case, events, is_short)) = read(&mut bytes, false) else { return };
    let driven = if is_short { drive::<4>(&case, &events) } else { drive::<64>(&case, &events) };
    if let Err(error) = driven {
        panic!("{error}\n{case:?}\n{events:?}");
    }
    if case.moves.iter().flat_map(|wanted| wanted.steps).map(i32::unsigned_abs).sum::<u32>() <= COMPILED_STEPS {
        RATES_HZ.into_iter().for_each(|tick_hz| compiles(&case, &events, tick_hz));
    }
}

/// Plans and makes the moves that `bytes` describe, whose corners are blends.
///
/// # Panics
/// As [`run`], and when the path is further from a corner than was asked for.
pub fn run_bent(bytes: &[u8]) {
    let mut bytes = Unstructured::new(bytes);
    let Ok((case, events, is_short)) = read(&mut bytes, true) else { return };
    let case = Case { speed_profile: SpeedProfile::Trapezoid, interval_split: IntervalSplit::Fastest, ..case };
    let driven = if is_short { bent::drive::<4>(&case, &events) } else { bent::drive::<64>(&case, &events) };
    if let Err(error) = driven {
        panic!("{error}\n{case:?}\n{events:?}");
    }
}

fn read(bytes: &mut Unstructured<'_>, is_bent: bool) -> Result<(Case, Vec<Event>, bool)> {
    let speed_profile = *bytes.choose(&SpeedProfile::ALL)?;
    let interval_split = if bytes.ratio(1, 16)? { IntervalSplit::Thirds } else { IntervalSplit::Fastest };
    let deviation_mm = if bytes.ratio(1, 8)? { 0.0 } else { log(bytes, 1e-3, 0.1)? };
    let is_short = bytes.arbitrary()?;
    let axes = [axis(bytes, speed_profile)?, axis(bytes, speed_profile)?, axis(bytes, speed_profile)?];
    let (mut limits, mm_per_step) = (axes.map(|axis| axis.0), axes.map(|axis| axis.1));
    if is_bent && !bytes.ratio(1, 16)? {
        limits.iter_mut().for_each(|limits| limits.start_speed_steps_s = 0.0);
    }
    let mut moves: Vec<Request<AXES>> = Vec::new();
    for tag in 0..bytes.int_in_range(1..=MOVES)? {
        let last = moves.last().copied();
        let plain = Request { tag: tag as u64, ..wanted(bytes, last)? };
        moves.push(if is_bent { bends(bytes, plain)? } else { plain });
    }
    let mut events = Vec::new();
    while !bytes.is_empty() && events.len() < EVENTS {
        events.push(event(bytes)?);
    }
    Ok((
        Case { limits, mm_per_step, deviation_mm, interval_split, speed_profile, effort: Effort::NONE, moves },
        events,
        is_short,
    ))
}

/// A fraction from 0 to 1.
fn ratio(bytes: &mut Unstructured<'_>) -> Result<f64> {
    Ok(f64::from(bytes.arbitrary::<u16>()?) / f64::from(u16::MAX))
}

fn log(bytes: &mut Unstructured<'_>, from: f64, to: f64) -> Result<f64> {
    Ok(from * (to / from).powf(ratio(bytes)?))
}

/// An axis with limits that real machines have, as in the chain's tests.
fn axis(bytes: &mut Unstructured<'_>, speed_profile: SpeedProfile) -> Result<(Limits, f64)> {
    let per_mm = log(bytes, 10.0, 400.0)?;
    let (top, accel) = (log(bytes, 1.0, 500.0)? * per_mm, log(bytes, 5.0, 5e3)? * per_mm);
    let decel = if bytes.arbitrary()? { 1.0 } else { log(bytes, 0.5, 2.0)? };
    let start = if bytes.arbitrary()? { 0.0 } else { 0.3 * ratio(bytes)? };
    let least = if speed_profile.is_over_displacement() { 0.01 } else { 0.0 };
    let jerk = if bytes.ratio(1, 4)? { f64::INFINITY } else { log(bytes, 0.1, 100.0)? };
    let limits = Limits {
        start_speed_steps_s: top * start.max(least),
        top_speed_steps_s: top,
        accel_steps_s2: accel,
        decel_steps_s2: accel * decel,
        jerk_steps_s3: jerk * accel * accel / top,
    };
    Ok((limits, 1.0 / per_mm))
}

/// A move that is new, repeats the previous direction, goes back, or deviates slightly from the previous direction.
fn wanted(bytes: &mut Unstructured<'_>, last: Option<Request<AXES>>) -> Result<Request<AXES>> {
    let before = last.map_or([1, 0, 0], |last| last.steps);
    let steps = match bytes.int_in_range(0..=3)? {
        0 => {
            let by: [i8; AXES] = bytes.arbitrary()?;
            by.map(i32::from)
        }
        1 => {
            let by: [i16; AXES] = bytes.arbitrary()?;
            by.map(|steps| i32::from(steps) / 4)
        }
        2 => {
            let times = bytes.int_in_range(-1..=3)?;
            before.map(|steps| (steps * times).clamp(-10_000, 10_000))
        }
        _ => {
            let by = [bytes.int_in_range(-2..=2)?, bytes.int_in_range(-2..=2)?, bytes.int_in_range(-2..=2)?];
            array::from_fn(|axis| before[axis] + by[axis])
        }
    };
    let steps = if steps == [0; AXES] { [1, 0, 0] } else { steps };
    let feed_mm_s = match (bytes.int_in_range(0..=3)?, last) {
        (0, _) => None,
        (1, _) | (_, None) => Some(log(bytes, 1.0 / 60.0, 500.0)?),
        (_, Some(last)) => last.feed_mm_s,
    };
    let stops = bytes.ratio(1, 12)?;
    Ok(Request { feed_mm_s, stops, ..Request::new(steps) })
}

/// The move with a blend at the corner before it, mostly, and with an end beside whole steps.
fn bends(bytes: &mut Unstructured<'_>, plain: Request<AXES>) -> Result<Request<AXES>> {
    let deviation_mm = if bytes.ratio(1, 5)? { 0.0 } else { log(bytes, 1e-3, 0.3)? };
    let mut offsets = [0; AXES];
    if bytes.ratio(3, 4)? {
        offsets = [bytes.int_in_range(-64..=64)?, bytes.int_in_range(-64..=64)?, bytes.int_in_range(-64..=64)?];
    }
    Ok(Request { deviation_mm: deviation_mm as f32, offsets, ..plain })
}

fn event(bytes: &mut Unstructured<'_>) -> Result<Event> {
    Ok(match bytes.int_in_range(0..=7)? {
        0 => Event::Push(bytes.int_in_range(1..=20)?),
        1 => Event::Advance(bytes.int_in_range(1..=5)?, f64::INFINITY),
        2 | 3 => Event::Advance(bytes.int_in_range(1..=5)?, log(bytes, 1e-3, 1.0)?),
        4 => Event::Hold,
        5 => Event::Settle,
        6 => Event::Start,
        _ => {
            let (feed, rapid) = (0.1 + 1.9 * ratio(bytes)?, 0.25 + 0.75 * ratio(bytes)?);
            Event::Override(OverrideRatios { feed, rapid })
        }
    })
}

/// Runs the case again, compiled at `tick_hz`. The steps of an axis must be in ascending order of time, whatever
/// happens.
fn compiles(case: &Case, events: &[Event], tick_hz: u32) {
    let mut chain = Chain::<AXES, 4>::new(case.config());
    let mut compiled = Compiled { tick_hz, axes: array::from_fn(|_| Made::default()) };
    let mut left = case.moves.iter();
    let mut push = |chain: &mut Chain<AXES, 4>| {
        while !chain.is_full()
            && let Some(wanted) = left.next()
        {
            assert_eq!(chain.push(*wanted), Ok(()));
        }
    };
    let finish = Event::Advance(usize::MAX, f64::INFINITY);
    for event in events.iter().chain([&Event::Start, &finish]) {
        push(&mut chain);
        match *event {
            Event::Push(_) => {}
            Event::Advance(chunks, most_s) => {
                for _ in 0..chunks {
                    let Some(chunk) = chain.advance(most_s) else { break };
                    compiled.goes_on(&chunk);
                    push(&mut chain);
                }
            }
            Event::Hold => chain.hold(),
            Event::Settle => {
                chain.hold();
                while let Some(chunk) = chain.advance(f64::INFINITY) {
                    compiled.goes_on(&chunk);
                }
                compiled.starts(&mut chain);
            }
            Event::Start => compiled.starts(&mut chain),
            Event::Override(OverrideRatios { feed, rapid }) => chain.override_speed(feed, rapid),
        }
    }
    assert!(chain.is_empty() && left.len() == 0);
}

struct Compiled {
    tick_hz: u32,
    axes: [Made; AXES],
}

/// The progress of an axis.
#[derive(Default)]
struct Made {
    /// The remaining instants of the current plan.
    left: Option<Box<dyn Iterator<Item = u64>>>,
    /// The number of the axis's last step in the move, and the tick of that step on the run's clock.
    steps: u32,
    last_ticks: Option<u64>,
}

impl Compiled {
    /// Starts the chain. From rest the steps are on a new clock; in motion the clock continues.
    fn starts(&mut self, chain: &mut Chain<AXES, 4>) {
        let begins = chain.is_at_rest();
        chain.start();
        self.axes.iter_mut().filter(|_| begins).for_each(|axis| axis.last_ticks = None);
    }

    fn goes_on(&mut self, chunk: &Chunk<AXES>) {
        let line = chunk.plan.line().expect("no move asks for a blend");
        for (index, made) in self.axes.iter_mut().enumerate() {
            if chunk.kind != ChunkKind::Continuation {
                let segments: Vec<_> = line.segments(index, self.tick_hz).collect();
                made.left = Some(Box::new(segments.into_iter().flat_map(|segment| segment.ticks())));
                made.steps = line.step_numbers(index).start - 1;
            }
            let until = line.steps_before(index, chunk.until_steps);
            let left = made.left.get_or_insert_with(|| Box::new(std::iter::empty()));
            for ticks in left.take((until - made.steps) as usize) {
                assert!(made.last_ticks < Some(ticks), "axis {index}: {ticks} after {:?}", made.last_ticks);
                (made.last_ticks, made.steps) = (Some(ticks), made.steps + 1);
            }
            assert_eq!(made.steps, until, "axis {index}");
        }
    }
}
