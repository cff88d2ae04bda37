//! Virtual time: an Embassy time driver whose clock is moved only by the executor.
//!
//! # Design
//! The clock counts nanoseconds. Embassy sees its ticks, of microseconds unless a program chooses others; finer waits use
//! [`Clock::until`].
//!
//! Embassy reaches its time driver through two free functions, and therefore through a static. Here this static has no
//! state: every thread has a *current* [`Clock`], set by [`Clock::enter`] for as long as an executor runs. So tests run
//! in parallel, two simulations can alternate on one thread, and none sees another's time.
//!
//! Deadlines are ordered by (instant, sequence number): deadlines at the same instant wake their tasks in the order in
//! which they were set. As in Embassy's own queue, a task has one deadline, its earliest. A woken task polls all its
//! timers again, and so sets those again that it still needs. This also keeps abandoned timers from piling up.
//!
//! Code takes no time here, but a blocking delay does, for its own task only, as if every task had its own core.
//! [`Clock::spend`] advances that task's time until its poll is over. The executor polls the task again only when the
//! others have caught up.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::future::poll_fn;
use std::pin::pin;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Wake, Waker};

use embassy_time::Instant;
use embassy_time_driver::{Driver, TICK_HZ};

thread_local! {
    static CURRENT: RefCell<Option<Clock>> = const { RefCell::new(None) };
}

/// A virtual clock with its queue of deadlines. Clones share one time.
#[derive(Clone, Default)]
pub struct Clock(Rc<RefCell<State>>);

#[derive(Default)]
struct State {
    now_ns: u64,
    /// Time that the task being polled has spent in blocking delays.
    spent_ns: u64,
    sequence: u64,
    /// Keys: instant, ns, and sequence number.
    deadlines: BTreeMap<(u64, u64), Deadline>,
    /// What is being polled runs in this background.
    background: Option<usize>,
    /// For each background: somebody waits for what runs there.
    counts: Vec<bool>,
}

struct Deadline {
    waker: Waker,
    background: Option<usize>,
}

impl Clock {
    /// A clock at zero, which is power-up.
    pub fn new() -> Self {
        Self::default()
    }

    /// The present instant for the task being polled.
    pub fn now(&self) -> Instant {
        Instant::from_ticks(self.now_ns() * TICKS / TICKS_NS)
    }

    /// Nanoseconds since power-up for the task being polled.
    pub fn now_ns(&self) -> u64 {
        let state = self.0.borrow();
        state.now_ns + state.spent_ns
    }

    /// Spends `ns` of the polled task's time in a blocking delay.
    pub fn spend(&self, ns: u64) {
        self.0.borrow_mut().spent_ns += ns;
    }

    /// Sets the time that the task being polled has spent in blocking delays; returns the previous value. With this,
    /// the delays of an interrupt do not delay the interrupted task.
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

    /// Ends a poll: the next task starts at the common time. Returns when the delays of this task are over, ns since
    /// power-up.
    pub(crate) fn end_poll(&self) -> u64 {
        let mut state = self.0.borrow_mut();
        state.now_ns + std::mem::take(&mut state.spent_ns)
    }

    /// Makes this the clock of `embassy_time` on the current thread, until the guard is dropped.
    pub fn enter(&self) -> Entered {
        Entered(CURRENT.replace(Some(self.clone())))
    }

    /// A background of its own, which does not count.
    fn background(&self) -> usize {
        let counts = &mut self.0.borrow_mut().counts;
        counts.push(false);
        counts.len() - 1
    }

    /// Calls `poll`, which polls a future in this background. A run ends although that future still waits for a time.
    fn in_background<R>(&self, background: usize, poll: impl FnOnce() -> R) -> R {
        self.0.borrow_mut().background = Some(background);
        let polled = poll();
        self.0.borrow_mut().background = None;
        polled
    }

    /// Says whether somebody waits for what runs in this background, so that it counts.
    fn count_background(&self, background: usize, counts: bool) {
        self.0.borrow_mut().counts[background] = counts;
    }

    /// True if anything waits for an instant, without what runs in backgrounds that do not count.
    pub(crate) fn has_deadlines(&self) -> bool {
        let state = self.0.borrow();
        state.deadlines.values().any(|deadline| deadline.background.is_none_or(|background| state.counts[background]))
    }

    /// The earliest instant that a task waits for, ns since power-up.
    pub(crate) fn next_deadline_ns(&self) -> Option<u64> {
        let state = self.0.borrow();
        let (&(at_ns, _), _) = state.deadlines.first_key_value()?;
        Some(at_ns)
    }

    /// Advances time to `at_ns` since power-up, never backwards, and wakes in order every task whose deadline has come.
    pub fn advance_to(&self, at_ns: u64) {
        let due = self.0.borrow_mut().advance_to(at_ns);
        // Woken outside the borrow, because a waker may read the time.
        due.into_values().for_each(|deadline| deadline.waker.wake());
    }
}

impl State {
    fn advance_to(&mut self, at_ns: u64) -> BTreeMap<(u64, u64), Deadline> {
        self.now_ns = self.now_ns.max(at_ns);
        let later = self.deadlines.split_off(&(self.now_ns + 1, 0));
        std::mem::replace(&mut self.deadlines, later)
    }

    fn schedule(&mut self, at_ns: u64, waker: &Waker) {
        let known = self.deadlines.iter().find(|(_, other)| other.waker.will_wake(waker));
        if let Some((&key, _)) = known {
            if key.0 <= at_ns {
                return;
            }
            self.deadlines.remove(&key);
        }
        let deadline = Deadline { waker: waker.clone(), background: self.background };
        self.deadlines.insert((at_ns, self.sequence), deadline);
        self.sequence += 1;
    }
}

/// Polls `future` as part of the task that awaits it, in a background of its own unless `counts`: somebody in the task waits for it.
pub(crate) async fn in_background<F: Future>(clock: &Clock, counts: impl Fn() -> bool, future: F) -> F::Output {
    let mut future = pin!(future);
    let background = clock.background();
    let watcher = Arc::new(Watcher(Mutex::new(None)));
    // A waker of its own, so that its deadlines are not those of the task.
    let waker = Waker::from(watcher.clone());
    poll_fn(|context| {
        watcher.set(context.waker());
        let polled = clock.in_background(background, || future.as_mut().poll(&mut Context::from_waker(&waker)));
        clock.count_background(background, counts());
        polled
    })
    .await
}

/// Wakes the task that it is a part of.
struct Watcher(Mutex<Option<Waker>>);

impl Watcher {
    fn set(&self, task: &Waker) {
        *self.0.lock().expect("nothing panics here") = Some(task.clone());
    }
}

impl Wake for Watcher {
    fn wake(self: Arc<Self>) {
        if let Some(task) = &*self.0.lock().expect("nothing panics here") {
            task.wake_by_ref();
        }
    }
}

/// Keeps a [`Clock`] current; restores the thread's previous clock when dropped.
#[must_use = "the clock is current only while this guard lives"]
pub struct Entered(Option<Clock>);

impl Drop for Entered {
    fn drop(&mut self) {
        CURRENT.set(self.0.take());
    }
}

const SECOND_NS: u64 = 1_000_000_000;
/// The fewest ticks that take a whole number of nanoseconds, and that number.
const TICKS: u64 = TICK_HZ / common_divisor(TICK_HZ, SECOND_NS);
const TICKS_NS: u64 = SECOND_NS / common_divisor(TICK_HZ, SECOND_NS);

const fn common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// Nanoseconds since power-up of an Embassy instant: the first at which the clock shows it.
pub fn ns(instant: Instant) -> u64 {
    instant.as_ticks().saturating_mul(TICKS_NS).div_ceil(TICKS)
}

/// The first instant of Embassy's that is not before `ns` since power-up.
pub fn instant_from(ns: u64) -> Instant {
    Instant::from_ticks((ns * TICKS).div_ceil(TICKS_NS))
}

struct ThreadClock;

impl Driver for ThreadClock {
    /// Zero if no clock is current: Embassy requires that this never fails.
    fn now(&self) -> u64 {
        CURRENT.with_borrow(|clock| clock.as_ref().map_or(0, |clock| clock.now().as_ticks()))
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        CURRENT.with_borrow(|clock| {
            let clock = clock.as_ref().expect("a Timer is awaited outside the simulated executor");
            // Embassy passes the end of time when it waits for nothing.
            clock.0.borrow_mut().schedule(ns(Instant::from_ticks(at)), waker);
        });
    }
}

embassy_time_driver::time_driver_impl!(static DRIVER: ThreadClock = ThreadClock);
