//! The state that the ports share with the task that makes their edges.

use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};

use critical_section::CriticalSection;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant};

use crate::port::{Motors, PortFault, StreamItem};

/// The state that the [`TimerPort`](super::TimerPort)s of `N` axes share with the task that makes their edges. It has to be a
/// static of the board, so that the inhibits can be plain functions.
pub struct TimerBank<const N: usize> {
    pub(super) mailboxes: [Mailbox; N],
    pub(super) wake: WakeSignal,
    /// The start barrier at which the axes of a run wait for their start. It is opened once for all of them, and closes when the
    /// driving task takes it.
    pub(super) barrier: Flag,
}

impl<const N: usize> TimerBank<N> {
    /// All axes at rest.
    #[must_use]
    pub const fn new() -> Self {
        Self { mailboxes: [const { Mailbox::new() }; N], wake: WakeSignal::new(), barrier: Flag::new() }
    }

    /// Engages or releases the inhibit of an axis, in any context. See [`Inhibit`](crate::Inhibit).
    ///
    /// # Panics
    /// When there is no such axis.
    pub fn inhibit(&self, axis: usize, engaged: bool) {
        self.mailboxes[axis].inhibit(engaged);
    }
}

impl<const N: usize> Default for TimerBank<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// A flag that one task sets and another takes. To take it costs a load, where a signal would cost a critical section.
pub(super) struct Flag(AtomicBool);

impl Flag {
    const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    pub fn set(&self) {
        self.0.store(true, Ordering::Release);
    }

    /// True if it was set since the last call.
    #[inline(always)]
    pub fn take(&self) -> bool {
        let is_set = self.0.load(Ordering::Acquire);
        if is_set {
            self.0.store(false, Ordering::Release);
        }
        is_set
    }
}

/// Wakes the driving task.
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

    /// True if it was rung since the last call.
    #[inline(always)]
    pub fn take(&self) -> bool {
        self.rung.take()
    }

    pub async fn wait(&self) {
        self.wakes.wait().await;
    }
}

/// A run as the port asks the driving task for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunRequest {
    pub motors: Motors,
    /// Shortest time from a change of DIR to a rise of STEP.
    pub setup: Duration,
    /// STEP stays high at least this long, ns.
    pub pulse_ns: u32,
    /// No pulse takes more of the clock's ticks.
    pub pulse: Duration,
    /// A step later than this is a fault.
    pub late_max: Duration,
    /// Shortest time from a fall of STEP to its next rise.
    pub low_min: Duration,
}

/// The state that one port and the driving task share: here they leave things for each other.
pub(super) struct Mailbox {
    /// A run request, or an item that the driving task waits for, is there.
    news: Flag,
    contents: Mutex<CriticalSectionRawMutex, Contents>,
    room: Signal<CriticalSectionRawMutex, ()>,
    begun: Signal<CriticalSectionRawMutex, Instant>,
    end: Signal<CriticalSectionRawMutex, Result<(), PortFault>>,
}

struct Contents {
    /// The run request that the driving task has not taken yet.
    request: Cell<Option<RunRequest>>,
    /// A run is under way: its request was taken, and the run has neither ended nor been dropped.
    live: Cell<bool>,
    inhibited: Cell<bool>,
    /// The stream items that follow what the driving task has, in order. Two: the last segment of a ramp may have one
    /// step, in whose time the axis task, of a lower priority, could not bring the one after it.
    next: [Cell<Option<StreamItem>>; 2],
    /// The driving task waits for the next item.
    wanted: Cell<bool>,
    /// Steps of the run that have risen, positive minus negative.
    travelled: Cell<i32>,
}

impl Mailbox {
    const fn new() -> Self {
        let contents = Contents {
            request: Cell::new(None),
            live: Cell::new(false),
            inhibited: Cell::new(false),
            next: [Cell::new(None), Cell::new(None)],
            wanted: Cell::new(false),
            travelled: Cell::new(0),
        };
        Self {
            news: Flag::new(),
            contents: Mutex::new(contents),
            room: Signal::new(),
            begun: Signal::new(),
            end: Signal::new(),
        }
    }

    fn inhibit(&self, engaged: bool) {
        self.contents.lock(|contents| contents.inhibited.set(engaged));
    }
}

/// For the port.
impl Mailbox {
    /// Leaves a run request.
    pub fn ask(&self, request: RunRequest) {
        self.contents.lock(|contents| {
            self.room.reset();
            self.begun.reset();
            self.end.reset();
            contents.request.set(Some(request));
            contents.travelled.set(0);
            self.news.set();
        });
    }

    /// Leaves the next item, if there is room. Returns whether there was, and whether the driving task waits for an
    /// item.
    pub fn offer(&self, item: StreamItem) -> (bool, bool) {
        self.contents.lock(|contents| {
            let free = contents.next.iter().find(|next| next.get().is_none());
            if let Some(next) = free {
                next.set(Some(item));
            }
            let is_wanted = contents.wanted.get();
            if is_wanted {
                self.news.set();
            }
            (free.is_some(), is_wanted)
        })
    }

    pub async fn room(&self) {
        self.room.wait().await;
    }

    /// True if the driving task has begun the run.
    pub fn has_begun(&self) -> bool {
        self.begun.signaled()
    }

    /// Waits until the run has begun. Returns the instant from which its segments count.
    pub async fn begun(&self) -> Instant {
        self.begun.wait().await
    }

    pub async fn end(&self) -> Result<(), PortFault> {
        self.end.wait().await
    }

    /// Steps of the run that have risen: those in the positive direction minus those in the negative direction.
    pub fn travelled(&self) -> i32 {
        self.contents.lock(|contents| contents.travelled.get())
    }

    /// Ends the run, if it has not ended: no further step rises.
    pub fn close(&self) {
        self.contents.lock(|contents| {
            contents.request.set(None);
            contents.next.iter().for_each(|next| next.set(None));
            contents.live.set(false);
        });
    }
}

/// For the driving task.
impl Mailbox {
    /// True if there is a run request, or an item that was waited for, since the last call.
    #[inline(always)]
    pub fn has_news(&self) -> bool {
        self.news.take()
    }

    /// Takes the run request, if there is one. The run is under way from then on.
    pub fn take_request(&self) -> Option<RunRequest> {
        self.contents.lock(|contents| {
            let request = contents.request.take()?;
            contents.live.set(true);
            Some(request)
        })
    }

    /// Reports that the run counts from `at`.
    pub fn begin(&self, at: Instant) {
        self.begun.signal(at);
    }

    /// Takes the next item, if there is one and the run has not ended.
    pub fn take(&self) -> Option<StreamItem> {
        self.contents.lock(|contents| {
            let [next, after] = &contents.next;
            let item = if contents.live.get() { next.replace(after.take()) } else { None };
            contents.wanted.set(item.is_none());
            if item.is_some() {
                self.room.signal(());
            }
            item
        })
    }

    /// Raises a step and counts it, by its `sign`, if the run has not ended and the inhibit is off. An inhibit ends the run,
    /// because its next steps would be late; the port has to be stopped, too.
    #[inline(always)]
    pub fn step(&self, section: CriticalSection<'_>, sign: i32, rise: impl FnOnce()) -> bool {
        let contents = self.contents.borrow(section);
        let may = contents.live.get() && !contents.inhibited.get();
        if may {
            rise();
            contents.travelled.set(contents.travelled.get().wrapping_add(sign));
        } else {
            contents.live.set(false);
        }
        may
    }

    /// No further step of the run rises. The port, which is not told, has to be stopped, too.
    pub fn cut_off(&self) {
        self.contents.lock(|contents| contents.live.set(false));
    }

    /// Ends the run with `result`, unless it has ended already; returns whether it does.
    pub fn conclude(&self, result: Result<(), PortFault>) -> bool {
        self.contents.lock(|contents| {
            let ends = contents.live.replace(false);
            if ends {
                self.end.signal(result);
            }
            ends
        })
    }
}
