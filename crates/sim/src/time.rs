//! Virtual time: an Embassy time driver whose clock moves only when the executor says so.
//!
//! # Design
//! The clock counts nanoseconds; Embassy sees the microseconds of it, and what is finer waits by [`Clock::until`].
//!
//! Embassy reaches its time driver through two free functions, hence through a static. Here that static
//! holds nothing: every thread has a *current* [`Clock`], installed by [`Clock::enter`] for as long as
//! an executor runs. So tests run in parallel, two simulations may take turns on one thread, and none
//! sees another's time.
//!
//! Deadlines are ordered by (instant, sequence number): two that fall on the same instant wake their tasks
//! in the order in which they were asked for. As with Embassy's own queue a task has one deadline, its
//! earliest; a woken task polls all its timers again, and so asks again for what it still needs.
//! That also keeps abandoned timers from piling up.
//!
//! Code takes no time here, but a blocking delay does, for the task that makes it alone: as if every task had a core of
//! its own. [`Clock::spend`] moves that task's time on until its poll is over, and the executor polls it
//! again only when the others have caught up.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Poll, Waker};

use embassy_time::Instant;
use embassy_time_driver::Driver;

thread_local! {
    static CURRENT: RefCell<Option<Clock>> = const { RefCell::new(None) };
}

/// A virtual clock with its queue of deadlines. Clones share the same time.
#[derive(Clone, Default)]
pub struct Clock(Rc<RefCell<State>>);

#[derive(Default)]
struct State {
    now_ns: u64,
    /// What the task being polled has spent in blocking delays.
    spent_ns: u64,
    sequence: u64,
    /// By instant, ns, and sequence number.
    deadlines: BTreeMap<(u64, u64), Waker>,
}

impl Clock {
    /// A clock that stands at zero: power-up.
    pub fn new() -> Self {
        Self::default()
    }

    /// The present instant, of the task being polled.
    pub fn now(&self) -> Instant {
        Instant::from_ticks(self.now_ns() / NS_PER_TICK)
    }

    /// Nanoseconds since power-up, of the task being polled.
    pub fn now_ns(&self) -> u64 {
        let state = self.0.borrow();
        state.now_ns + state.spent_ns
    }

    /// The task being polled spends `ns` in a blocking delay.
    pub fn spend(&self, ns: u64) {
        self.0.borrow_mut().spent_ns += ns;
    }

    /// Has the task being polled have spent `ns` in blocking delays; returns what it was before. An interrupt delays what it
    /// interrupts by none of its own.
    pub(crate) fn set_spent_ns(&self, ns: u64) -> u64 {
        std::mem::replace(&mut self.0.borrow_mut().spent_ns, ns)
    }

    /// Waits until `at_ns` since power-up, to the nanosecond.
    ///
    /// # Cancellation
    /// Safe: it only waits.
    pub async fn until(&self, at_ns: u64) {
        poll_fn(|context| {
            if self.now_ns() >= at_ns {
                return Poll::Ready(());
            }
            self.0.borrow_mut().schedule(at_ns, context.waker());
            Poll::Pending
        })
        .await;
    }

    /// The poll is over, and the next task starts at the common time; returns when this one is through with its delays,
    /// ns since power-up.
    pub fn end_poll(&self) -> u64 {
        let mut state = self.0.borrow_mut();
        state.now_ns + std::mem::take(&mut state.spent_ns)
    }

    /// Makes this the clock of the current thread's `embassy_time`, until the guard is dropped.
    pub fn enter(&self) -> Entered {
        Entered(CURRENT.replace(Some(self.clone())))
    }

    /// The earliest instant that a task waits for, ns since power-up.
    pub fn next_deadline_ns(&self) -> Option<u64> {
        let state = self.0.borrow();
        let (&(at_ns, _), _) = state.deadlines.first_key_value()?;
        Some(at_ns)
    }

    /// Moves time forward to `at_ns` since power-up (never back) and wakes, in order, every task whose deadline has come.
    pub fn advance_to(&self, at_ns: u64) {
        let due = self.0.borrow_mut().advance_to(at_ns);
        // Woken outside the borrow: a waker may ask for the time.
        due.into_values().for_each(Waker::wake);
    }
}

impl State {
    fn advance_to(&mut self, at_ns: u64) -> BTreeMap<(u64, u64), Waker> {
        self.now_ns = self.now_ns.max(at_ns);
        let later = self.deadlines.split_off(&(self.now_ns + 1, 0));
        std::mem::replace(&mut self.deadlines, later)
    }

    fn schedule(&mut self, at_ns: u64, waker: &Waker) {
        let known = self.deadlines.iter().find(|(_, other)| other.will_wake(waker));
        if let Some((&key, _)) = known {
            if key.0 <= at_ns {
                return;
            }
            self.deadlines.remove(&key);
        }
        self.deadlines.insert((at_ns, self.sequence), waker.clone());
        self.sequence += 1;
    }
}

/// Keeps a [`Clock`] current; gives the thread back its previous one when dropped.
#[must_use = "the clock is current only while this guard lives"]
pub struct Entered(Option<Clock>);

impl Drop for Entered {
    fn drop(&mut self) {
        CURRENT.set(self.0.take());
    }
}

const NS_PER_TICK: u64 = 1_000_000_000 / embassy_time_driver::TICK_HZ;

/// Nanoseconds since power-up of an Embassy instant.
pub fn ns(instant: Instant) -> u64 {
    instant.as_ticks().saturating_mul(NS_PER_TICK)
}

struct ThreadClock;

impl Driver for ThreadClock {
    /// Zero where no clock is current: Embassy asks that this never fails.
    fn now(&self) -> u64 {
        CURRENT.with_borrow(|clock| clock.as_ref().map_or(0, |clock| clock.now().as_ticks()))
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        CURRENT.with_borrow(|clock| {
            let clock = clock.as_ref().expect("a Timer is awaited outside the simulated executor");
            // Embassy asks for the end of time when it waits for nothing.
            clock.0.borrow_mut().schedule(at.saturating_mul(NS_PER_TICK), waker);
        });
    }
}

embassy_time_driver::time_driver_impl!(static DRIVER: ThreadClock = ThreadClock);
