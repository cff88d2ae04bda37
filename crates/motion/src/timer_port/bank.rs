//! Between the ports and the task that makes their edges.

use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};

use critical_section::CriticalSection;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant};

use crate::port::{Feed, PortFault};

/// What the [`TimerPort`](super::TimerPort)s of `N` axes share with the task that makes their edges. A static of the
/// board's, so that its brakes are plain functions.
pub struct TimerBank<const N: usize> {
    pub(super) desks: [Desk; N],
    pub(super) bell: Doorbell,
    /// The gate at which the axes of a run wait for their start: opened once for all of them, and closed when taken.
    pub(super) gate: Flag,
}

impl<const N: usize> TimerBank<N> {
    /// All axes at rest.
    #[must_use]
    pub const fn new() -> Self {
        Self { desks: [const { Desk::new() }; N], bell: Doorbell::new(), gate: Flag::new() }
    }

    /// Engages or releases the brake of an axis, in any context. See [`Brake`](crate::Brake).
    ///
    /// # Panics
    /// When there is no such axis.
    pub fn brake(&self, axis: usize, engaged: bool) {
        self.desks[axis].brake(engaged);
    }
}

impl<const N: usize> Default for TimerBank<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Something that one task sets and another takes: a load, where a signal is a critical section.
pub(super) struct Flag(AtomicBool);

impl Flag {
    const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    pub fn set(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// Whether it was set since the last look.
    #[inline(always)]
    pub fn take(&self) -> bool {
        let is_set = self.0.load(Ordering::Acquire);
        if is_set {
            self.0.store(false, Ordering::Release);
        }
        is_set
    }
}

/// Calls the driving task.
pub(super) struct Doorbell {
    rung: Flag,
    wakes: Signal<CriticalSectionRawMutex, ()>,
}

impl Doorbell {
    const fn new() -> Self {
        Self { rung: Flag::new(), wakes: Signal::new() }
    }

    pub fn ring(&self) {
        self.rung.set();
        self.wakes.signal(());
    }

    /// Whether it was rung since the last look.
    #[inline(always)]
    pub fn take(&self) -> bool {
        self.rung.take()
    }

    pub async fn wait(&self) {
        self.wakes.wait().await;
    }
}

/// A run as the driving task needs it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    pub direction_inverted: bool,
    /// From a change of DIR to a rise.
    pub setup: Duration,
    /// STEP stays high at least this long, ns.
    pub pulse_ns: u32,
    /// From a fall of STEP to its next rise, at least.
    pub low_min: Duration,
}

/// Where a port and the driving task leave things for each other.
pub(super) struct Desk {
    papers: Mutex<CriticalSectionRawMutex, Papers>,
    room: Signal<CriticalSectionRawMutex, ()>,
    begun: Signal<CriticalSectionRawMutex, Instant>,
    end: Signal<CriticalSectionRawMutex, Result<(), PortFault>>,
}

struct Papers {
    /// Not taken yet.
    order: Cell<Option<Order>>,
    /// The order was taken, and is neither done nor given up.
    live: Cell<bool>,
    braked: Cell<bool>,
    /// The one that follows what the driving task has.
    next: Cell<Option<Feed>>,
    /// The driving task waits for it.
    wanted: Cell<bool>,
    /// Steps of the run that have risen, those back less.
    travelled: Cell<i32>,
}

impl Desk {
    const fn new() -> Self {
        let papers = Papers {
            order: Cell::new(None),
            live: Cell::new(false),
            braked: Cell::new(false),
            next: Cell::new(None),
            wanted: Cell::new(false),
            travelled: Cell::new(0),
        };
        Self { papers: Mutex::new(papers), room: Signal::new(), begun: Signal::new(), end: Signal::new() }
    }

    fn brake(&self, engaged: bool) {
        self.papers.lock(|papers| papers.braked.set(engaged));
    }
}

/// For the port.
impl Desk {
    /// Asks for a run.
    pub fn ask(&self, order: Order) {
        self.papers.lock(|papers| {
            self.room.reset();
            self.begun.reset();
            self.end.reset();
            papers.order.set(Some(order));
            papers.travelled.set(0);
        });
    }

    /// Lays down what comes next, if there is room; whether it was taken, and whether it is waited for.
    pub fn offer(&self, feed: Feed) -> (bool, bool) {
        self.papers.lock(|papers| {
            let room = papers.next.get().is_none();
            if room {
                papers.next.set(Some(feed));
            }
            (room, papers.wanted.get())
        })
    }

    pub async fn room(&self) {
        self.room.wait().await;
    }

    /// Whether the driving task has begun the run.
    pub fn has_begun(&self) -> bool {
        self.begun.signaled()
    }

    /// The instant from which the segments of the run count, once it has begun.
    pub async fn begun(&self) -> Instant {
        self.begun.wait().await
    }

    pub async fn end(&self) -> Result<(), PortFault> {
        self.end.wait().await
    }

    /// Steps of the run that have risen: those in the positive direction, less those in the negative.
    pub fn travelled(&self) -> i32 {
        self.papers.lock(|papers| papers.travelled.get())
    }

    /// Ends the run, if it has not ended: no further step rises.
    pub fn close(&self) {
        self.papers.lock(|papers| {
            papers.order.set(None);
            papers.next.set(None);
            papers.live.set(false);
        });
    }
}

/// For the driving task.
impl Desk {
    /// A run asked for, which thereby goes live.
    pub fn take_order(&self) -> Option<Order> {
        self.papers.lock(|papers| {
            let order = papers.order.take()?;
            papers.live.set(true);
            Some(order)
        })
    }

    /// Says that the run counts from then.
    pub fn begin(&self, at: Instant) {
        self.begun.signal(at);
    }

    /// What comes next, if it is there and the run has not ended.
    pub fn take(&self) -> Option<Feed> {
        self.papers.lock(|papers| {
            let feed = if papers.live.get() { papers.next.take() } else { None };
            papers.wanted.set(feed.is_none());
            if feed.is_some() {
                self.room.signal(());
            }
            feed
        })
    }

    /// Has a step rise and counts it, by its `sign`, if the run has not ended and the brake is off. A brake ends the run:
    /// its steps would be late; the port is to be stopped too.
    #[inline(always)]
    pub fn step(&self, section: CriticalSection<'_>, sign: i32, rise: impl FnOnce()) -> bool {
        let papers = self.papers.borrow(section);
        let may = papers.live.get() && !papers.braked.get();
        if may {
            rise();
            papers.travelled.set(papers.travelled.get().wrapping_add(sign));
        } else {
            papers.live.set(false);
        }
        may
    }

    /// Ends the run, unless its port has.
    pub fn conclude(&self, result: Result<(), PortFault>) {
        self.papers.lock(|papers| {
            if papers.live.replace(false) {
                self.end.signal(result);
            }
        });
    }
}
