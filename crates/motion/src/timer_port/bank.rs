//! Between the ports and the task that makes their edges.

use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};

use critical_section::CriticalSection;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant};

use crate::port::{PortFault, StreamItem};

/// What the [`TimerPort`](super::TimerPort)s of `N` axes share with the task that makes their edges. A static of the
/// board's, so that its brakes are plain functions.
pub struct TimerBank<const N: usize> {
    pub(super) mailboxes: [Mailbox; N],
    pub(super) wake: WakeSignal,
    /// The gate at which the axes of a run wait for their start: opened once for all of them, and closed when taken.
    pub(super) gate: Flag,
}

impl<const N: usize> TimerBank<N> {
    /// All axes at rest.
    #[must_use]
    pub const fn new() -> Self {
        Self { mailboxes: [const { Mailbox::new() }; N], wake: WakeSignal::new(), gate: Flag::new() }
    }

    /// Engages or releases the brake of an axis, in any context. See [`Brake`](crate::Brake).
    ///
    /// # Panics
    /// When there is no such axis.
    pub fn brake(&self, axis: usize, engaged: bool) {
        self.mailboxes[axis].brake(engaged);
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
pub(super) struct WakeSignal {
    rung: Flag,
    wakes: Signal<CriticalSectionRawMutex, ()>,
}

impl WakeSignal {
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
pub(super) struct RunRequest {
    pub direction_inverted: bool,
    /// From a change of DIR to a rise.
    pub setup: Duration,
    /// STEP stays high at least this long, ns.
    pub pulse_ns: u32,
    /// From a fall of STEP to its next rise, at least.
    pub low_min: Duration,
}

/// Where a port and the driving task leave things for each other.
pub(super) struct Mailbox {
    contents: Mutex<CriticalSectionRawMutex, Contents>,
    room: Signal<CriticalSectionRawMutex, ()>,
    begun: Signal<CriticalSectionRawMutex, Instant>,
    end: Signal<CriticalSectionRawMutex, Result<(), PortFault>>,
}

struct Contents {
    /// Not taken yet.
    request: Cell<Option<RunRequest>>,
    /// The request was taken, and is neither done nor given up.
    live: Cell<bool>,
    braked: Cell<bool>,
    /// The one that follows what the driving task has.
    next: Cell<Option<StreamItem>>,
    /// The driving task waits for it.
    wanted: Cell<bool>,
    /// Steps of the run that have risen, those back less.
    travelled: Cell<i32>,
}

impl Mailbox {
    const fn new() -> Self {
        let contents = Contents {
            request: Cell::new(None),
            live: Cell::new(false),
            braked: Cell::new(false),
            next: Cell::new(None),
            wanted: Cell::new(false),
            travelled: Cell::new(0),
        };
        Self { contents: Mutex::new(contents), room: Signal::new(), begun: Signal::new(), end: Signal::new() }
    }

    fn brake(&self, engaged: bool) {
        self.contents.lock(|contents| contents.braked.set(engaged));
    }
}

/// For the port.
impl Mailbox {
    /// Asks for a run.
    pub fn ask(&self, request: RunRequest) {
        self.contents.lock(|contents| {
            self.room.reset();
            self.begun.reset();
            self.end.reset();
            contents.request.set(Some(request));
            contents.travelled.set(0);
        });
    }

    /// Lays down what comes next, if there is room; whether it was taken, and whether it is waited for.
    pub fn offer(&self, item: StreamItem) -> (bool, bool) {
        self.contents.lock(|contents| {
            let room = contents.next.get().is_none();
            if room {
                contents.next.set(Some(item));
            }
            (room, contents.wanted.get())
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
        self.contents.lock(|contents| contents.travelled.get())
    }

    /// Ends the run, if it has not ended: no further step rises.
    pub fn close(&self) {
        self.contents.lock(|contents| {
            contents.request.set(None);
            contents.next.set(None);
            contents.live.set(false);
        });
    }
}

/// For the driving task.
impl Mailbox {
    /// A run asked for, which thereby goes live.
    pub fn take_request(&self) -> Option<RunRequest> {
        self.contents.lock(|contents| {
            let request = contents.request.take()?;
            contents.live.set(true);
            Some(request)
        })
    }

    /// Says that the run counts from then.
    pub fn begin(&self, at: Instant) {
        self.begun.signal(at);
    }

    /// What comes next, if it is there and the run has not ended.
    pub fn take(&self) -> Option<StreamItem> {
        self.contents.lock(|contents| {
            let item = if contents.live.get() { contents.next.take() } else { None };
            contents.wanted.set(item.is_none());
            if item.is_some() {
                self.room.signal(());
            }
            item
        })
    }

    /// Has a step rise and counts it, by its `sign`, if the run has not ended and the brake is off. A brake ends the run:
    /// its steps would be late; the port is to be stopped too.
    #[inline(always)]
    pub fn step(&self, section: CriticalSection<'_>, sign: i32, rise: impl FnOnce()) -> bool {
        let contents = self.contents.borrow(section);
        let may = contents.live.get() && !contents.braked.get();
        if may {
            rise();
            contents.travelled.set(contents.travelled.get().wrapping_add(sign));
        } else {
            contents.live.set(false);
        }
        may
    }

    /// Ends the run, unless its port has.
    pub fn conclude(&self, result: Result<(), PortFault>) {
        self.contents.lock(|contents| {
            if contents.live.replace(false) {
                self.end.signal(result);
            }
        });
    }
}
