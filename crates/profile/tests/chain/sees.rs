//! Makes random chains before somebody who looks at each chunk.

use isostep_profile::chain::{Chain, Chunk, Request};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

use super::case::{AXES, Case};
use super::drive::Event;

/// Looks at what a chain hands out.
pub trait Sees {
    /// Sees the next chunk.
    fn see(&mut self, chunk: &Chunk<AXES>) -> TestCaseResult;

    /// The chain is at rest, and goes on on another clock.
    fn restart(&mut self) -> TestCaseResult;

    /// The speed has been overridden.
    fn is_overridden(&mut self) {}

    /// True if a move that goes straight on is to lengthen the one before it, if it can.
    fn lengthens(&self) -> bool {
        false
    }

    /// This move has been pushed, or lengthens the last one.
    fn is_pushed(&mut self, _request: &Request<AXES>, _lengthens: bool) {}
}

/// Makes the moves of the case with these events, and then all moves that are left.
pub fn make<const LEN: usize>(case: &Case, events: &[Event], watch: &mut impl Sees) -> TestCaseResult {
    let mut chain = Chain::<AXES, LEN>::new(case.config());
    let mut asked = case.moves.iter();
    let mut tag = 0;
    let mut push = |chain: &mut Chain<AXES, LEN>, watch: &mut _, count: usize| {
        for _ in 0..count {
            if chain.is_full() {
                break;
            }
            let Some(request) = asked.next() else { break };
            push(chain, watch, &mut tag, request);
        }
        asked.len()
    };
    for event in events {
        match *event {
            Event::Push(count) => _ = push(&mut chain, watch, count),
            Event::Advance(chunks, most_s) => {
                for _ in 0..chunks {
                    if !advance(&mut chain, watch, most_s)? {
                        break;
                    }
                }
            }
            Event::Hold => chain.hold(),
            Event::Settle => {
                chain.hold();
                while advance(&mut chain, watch, f64::INFINITY)? {}
                prop_assert!(chain.is_at_rest());
                start(&mut chain, watch)?;
            }
            Event::Start => start(&mut chain, watch)?,
            Event::Override(ratios) => {
                watch.is_overridden();
                chain.override_speed(ratios.feed, ratios.rapid);
            }
        }
    }
    start(&mut chain, watch)?;
    while push(&mut chain, watch, LEN) > 0 {
        advance(&mut chain, watch, f64::INFINITY)?;
    }
    while advance(&mut chain, watch, f64::INFINITY)? {}
    prop_assert!(chain.is_empty() && chain.is_at_rest());
    Ok(())
}

fn push<const LEN: usize>(chain: &mut Chain<AXES, LEN>, watch: &mut impl Sees, tag: &mut u64, request: &Request<AXES>) {
    let lengthens = watch.lengthens() && chain.lengthen(request, |last, _| Some(last));
    if !lengthens {
        chain.push(Request { tag: *tag, ..*request }).unwrap();
        *tag += 1;
    }
    watch.is_pushed(request, lengthens);
}

fn start<const LEN: usize>(chain: &mut Chain<AXES, LEN>, watch: &mut impl Sees) -> TestCaseResult {
    if chain.is_at_rest() {
        watch.restart()?;
    }
    chain.start();
    Ok(())
}

fn advance<const LEN: usize>(
    chain: &mut Chain<AXES, LEN>,
    watch: &mut impl Sees,
    most_s: f64,
) -> Result<bool, TestCaseError> {
    let before_s = chain.at_s();
    let Some(chunk) = chain.advance(most_s) else {
        prop_assert!(chain.is_at_rest());
        return Ok(false);
    };
    prop_assert!(chunk.plan.blend().is_some() || chunk.until_s <= before_s + most_s * (1.0 + 1e-9));
    watch.see(&chunk)?;
    Ok(true)
}
