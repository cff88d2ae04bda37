//! Events in random order, which change a chain while it is made.

use isostep_profile::SpeedProfile;
use isostep_profile::chain::{Chain, Chunk, ChunkKind, Request};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

use super::case::{AXES, Case, line};
use super::follow::Follower;
use super::model::{Move, OverrideRatios, fastest};

#[derive(Clone, Copy, Debug)]
pub enum Event {
    /// Pushes this many moves, if there is room.
    Push(usize),
    /// Asks for this many chunks, each of this duration at most, s.
    Advance(usize, f64),
    /// `Hold` asks for a hold, `Settle` also brakes to rest and starts again, `Start` only starts.
    Hold,
    Settle,
    Start,
    Override(OverrideRatios),
}

/// Some chunks: mostly of 1 ms to 1 s, some as long as possible.
fn advance() -> impl Strategy<Value = Event> {
    let most_s = prop_oneof![4 => (-3.0..0.0f64).prop_map(|log| 10f64.powf(log)), 1 => Just(f64::INFINITY)];
    (1..6usize, most_s).prop_map(|(chunks, most_s)| Event::Advance(chunks, most_s))
}

fn push() -> impl Strategy<Value = Event> {
    prop_oneof![3 => 1..3usize, 1 => 1..20usize].prop_map(Event::Push)
}

/// Pushes and chunks.
pub fn pushes() -> impl Strategy<Value = Vec<Event>> {
    prop::collection::vec(prop_oneof![push(), advance()], 0..40)
}

/// Pushes, chunks and holds.
pub fn holds() -> impl Strategy<Value = Vec<Event>> {
    let hold = prop_oneof![2 => Just(Event::Hold), 2 => Just(Event::Settle), 1 => Just(Event::Start)];
    prop::collection::vec(prop_oneof![1 => push(), 2 => advance(), 1 => hold], 0..40)
}

/// Pushes, chunks, holds and overrides.
pub fn overrides() -> impl Strategy<Value = Vec<Event>> {
    let ratios = (0.1..2.0f64, 0.25..1.0f64).prop_map(|(feed, rapid)| Event::Override(OverrideRatios { feed, rapid }));
    let hold = prop_oneof![1 => Just(Event::Hold), 2 => Just(Event::Settle), 1 => Just(Event::Start)];
    prop::collection::vec(prop_oneof![2 => push(), 4 => advance(), 1 => hold, 2 => ratios], 0..40)
}

/// Makes the moves of the case with these events, and then all moves that are left.
pub fn drive<const LEN: usize>(case: &Case, events: &[Event]) -> TestCaseResult {
    make::<LEN>(case, events, Follower::new(case), false)
}

/// The same, but a move that goes straight on lengthens the one before it, if it can.
pub fn drive_lengthened<const LEN: usize>(case: &Case, events: &[Event]) -> TestCaseResult {
    make::<LEN>(case, events, Follower::new(&Case { moves: Vec::new(), ..case.clone() }), true)
}

fn make<const LEN: usize>(case: &Case, events: &[Event], follower: Follower, lengthens: bool) -> TestCaseResult {
    let mut drive = Drive::<LEN> {
        chain: Chain::new(case.config()),
        follower,
        asked: &case.moves,
        lengthens,
        known: 0,
        is_plain: case.speed_profile == SpeedProfile::Trapezoid,
        least: None,
    };
    for event in events {
        drive.happens(*event)?;
    }
    drive.start()?;
    while !drive.asked.is_empty() {
        drive.happens(Event::Push(LEN))?;
        drive.happens(Event::Advance(1, f64::INFINITY))?;
    }
    while drive.advance(f64::INFINITY)? {}
    prop_assert!(drive.chain.is_empty() && drive.chain.is_at_rest());
    drive.follower.ends(drive.known - 1)
}

struct Drive<'a, const LEN: usize> {
    chain: Chain<AXES, LEN>,
    /// Its moves are those of the chain: if they are lengthened, those that have been pushed.
    follower: Follower,
    /// The moves that have not been pushed.
    asked: &'a [Request<AXES>],
    lengthens: bool,
    /// The number of moves that have been pushed, without those that have only lengthened another.
    known: usize,
    /// True if there were only pushes so far. Then the chain must be as fast as the known moves allow.
    is_plain: bool,
    /// The squared speed at which the move under way began, (mm/s)², and the lowest at which it may end.
    least: Option<(f64, f64)>,
}

impl<const LEN: usize> Drive<'_, LEN> {
    fn happens(&mut self, event: Event) -> TestCaseResult {
        match event {
            Event::Push(count) => self.push(count)?,
            Event::Advance(chunks, most_s) => {
                for _ in 0..chunks {
                    if !self.advance(most_s)? {
                        break;
                    }
                }
            }
            Event::Hold => self.hold(),
            Event::Settle => {
                self.hold();
                while self.advance(f64::INFINITY)? {}
                prop_assert!(self.chain.is_at_rest());
                self.follower.rests()?;
                self.start()?;
            }
            Event::Start => self.start()?,
            Event::Override(ratios) => {
                (self.is_plain, self.follower.has_changed) = (false, true);
                self.follower.ratios = ratios;
                self.chain.override_speed(ratios.feed, ratios.rapid);
            }
        }
        Ok(())
    }

    fn push(&mut self, count: usize) -> TestCaseResult {
        for _ in 0..count {
            let Some((asked, others)) = self.asked.split_first() else { break };
            if !(self.lengthens && self.lengthen(asked)?) {
                if self.chain.is_full() {
                    break;
                }
                let request = Request { tag: self.known as u64, ..*asked };
                prop_assert_eq!(self.chain.push(request), Ok(()));
                self.known += 1;
                if self.lengthens {
                    self.follower.case.moves.push(request);
                }
            }
            self.asked = others;
        }
        Ok(())
    }

    /// Lengthens the last move of the chain, if it can.
    fn lengthen(&mut self, asked: &Request<AXES>) -> Result<bool, TestCaseError> {
        let mut joined = None;
        let is_one = self.chain.lengthen(asked, |tag, place| {
            joined = Some((tag, place));
            Some(tag)
        });
        prop_assert_eq!(is_one, joined.is_some());
        let Some((tag, place)) = joined else { return Ok(false) };
        prop_assert_eq!(tag as usize, self.known - 1);
        let last = self.follower.case.moves.last_mut().unwrap();
        prop_assert_eq!(place, last.steps.map(i32::unsigned_abs).into_iter().max().unwrap());
        last.steps = core::array::from_fn(|axis| last.steps[axis] + asked.steps[axis]);
        Ok(true)
    }

    fn hold(&mut self) {
        (self.is_plain, self.follower.is_held) = (false, true);
        self.chain.hold();
    }

    fn start(&mut self) -> TestCaseResult {
        if self.chain.is_at_rest() {
            self.follower.restart()?;
        }
        self.follower.is_held = false;
        self.chain.start();
        prop_assert_eq!(self.chain.at_s(), self.follower.at_s());
        Ok(())
    }

    /// Returns false at rest.
    fn advance(&mut self, most_s: f64) -> Result<bool, TestCaseError> {
        let before_s = self.chain.at_s();
        let Some(chunk) = self.chain.advance(most_s) else {
            prop_assert!(self.chain.is_at_rest());
            self.follower.rests()?;
            return Ok(false);
        };
        prop_assert!(chunk.until_s <= before_s + most_s * (1.0 + 1e-9));
        prop_assert_eq!(self.chain.at_s(), chunk.until_s);
        self.follower.follow(chunk)?;
        if self.is_plain {
            self.is_as_fast_as_known(&chunk)?;
        }
        Ok(true)
    }

    /// A move ends at least as fast as the moves known at its beginning allow, and at most as fast as those known at
    /// its end.
    fn is_as_fast_as_known(&mut self, chunk: &Chunk<AXES>) -> TestCaseResult {
        let tag = chunk.tag as usize;
        let best = |entry| {
            let case = &self.follower.case;
            let moves =
                case.moves[tag..self.known].iter().map(|request| Move::new(case, *request, OverrideRatios::ALL));
            fastest(case, &moves.collect::<Vec<_>>(), Some(entry))[0].exit
        };
        if chunk.kind == ChunkKind::Move {
            self.least = None;
        }
        let (entry, least) = *self.least.get_or_insert_with(|| {
            let entry = line(chunk).profile.entry_speed_steps_s() * chunk.mm_per_step;
            (entry * entry, best(entry * entry))
        });
        if chunk.until_s >= line(chunk).end_s() && chunk.until_steps >= line(chunk).distance_steps() - 1e-5 {
            let (exit, slack) = (self.follower.speed_mm_s(), self.follower.unit_mm_s());
            prop_assert!(exit >= least.sqrt() * (1.0 - 1e-6) - slack, "move {tag}: {exit} for {}", least.sqrt());
            let most = best(entry).sqrt();
            prop_assert!(exit <= most * (1.0 + 1e-6) + slack, "move {tag}: {exit} for {most}");
        }
        Ok(())
    }
}
