//! The motions that are asked for and wait.

use core::future::poll_fn;
use core::task::{Context, Poll};

use embassy_time::Duration;

use super::life::{Kind, Life, Trigger};
use super::{Busy, CHAIN_MOVES, Machine};
use crate::axes::AXES;
use crate::tool::power::Power;

/// The number of motions that wait in the queue before the chain takes them. Grbl's planner has as many blocks in all.
pub(super) const QUEUE_MOVES: usize = 15;
/// The number of moves that can be asked for at rest without waiting.
pub const MOVES_AHEAD: usize = CHAIN_MOVES + QUEUE_MOVES;

/// A straight move.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Move {
    /// The place where it ends, steps.
    pub target_steps: [i32; AXES],
    /// The distance of the place that is meant from it: see [`Request::offsets`](isostep_profile::chain::Request::offsets).
    pub offsets: [i8; AXES],
    /// Speed along the path, mm/s, more than 0; infinite if it is to be as fast as the limits allow.
    pub feed_mm_s: f64,
    /// It ends at rest, instead of flowing into the next move.
    pub exact_stop: bool,
    /// The distance by which the path may leave the corner where it begins, mm: see
    /// [`Request::deviation_mm`](isostep_profile::chain::Request::deviation_mm).
    pub deviation_mm: f32,
    /// The length of it that is for the blend there, mm, if it is a side of a curve; 0 if it is not: see
    /// [`Request::reach_mm`](isostep_profile::chain::Request::reach_mm).
    pub reach_mm: f32,
    /// The distance by which the path may be beside the place where it ends, mm, if it is so short that it is made together with
    /// the moves around it; less than the deviation. 0, if each move is to be made as it is.
    pub together_mm: f32,
    /// The power at which a laser shines meanwhile.
    pub power: Power,
    /// The line number (N) of its block, for [`Status::line`](super::Status::line); 0 for none.
    pub line: u32,
    /// The line that asks for it, counted from 1 by who asks; 0 for none. The machine only passes it on, in [`Event::Taken`].
    ///
    /// [`Event::Taken`]: crate::Event::Taken
    pub source: u32,
    /// It is a part of an arc, and more parts of the same arc follow.
    pub in_arc: bool,
}

impl Move {
    /// To a place as fast as the limits allow, to the corner exactly, on without a stop, without a laser, and of no line.
    #[must_use]
    pub const fn to(target_steps: [i32; AXES]) -> Self {
        Self {
            target_steps,
            offsets: [0; AXES],
            feed_mm_s: f64::INFINITY,
            exact_stop: false,
            deviation_mm: 0.0,
            reach_mm: 0.0,
            together_mm: 0.0,
            power: Power::Off,
            line: 0,
            source: 0,
            in_arc: false,
        }
    }
}

/// A motion. Motions are carried out in the order in which they are asked for.
// Its kind is a word of its own. Otherwise it is a byte of a move, and the others are copied byte by byte, at seven cycles each.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u32)]
pub enum Motion {
    /// Go to a place in a straight line.
    Move(Move),
    /// Go to a place by hand: it may be cancelled, and has a feed that no override changes.
    Jog(Move),
    /// Go to a place until the probe finds what it looks for: see [`Machine::probed`].
    Probe(ProbeMove),
    /// Stand still.
    Dwell(Duration),
    /// Find the zero of these axes, one after the other in the configured order. In an alarm this unlocks the machine,
    /// and the other axes are as trusted as the alarm left them. If it fails, no axis is trusted.
    Home {
        /// The axes.
        axes: [bool; AXES],
    },
}

impl Motion {
    fn kind(&self) -> Kind {
        match self {
            Self::Move(_) | Self::Probe(_) | Self::Dwell(_) => Kind::Program,
            Self::Jog(_) => Kind::Jog,
            Self::Home { .. } => Kind::Homing,
        }
    }
}

/// A straight move until the probe touches, or until it no longer touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeMove {
    /// The place where it ends if the probe finds nothing, steps.
    pub target_steps: [i32; AXES],
    /// Speed along the path, mm/s.
    pub feed_mm_s: f64,
    /// It looks for the end of the contact.
    pub away: bool,
    /// Finding nothing is an alarm.
    pub must: bool,
    /// The program line that it comes from; 0 for none.
    pub line: u32,
}

impl Machine {
    /// Asks for a motion; waits while the queue is full.
    ///
    /// # Errors
    /// [`Busy`], if the machine does not take the motion now:
    /// - In an alarm it takes homing only, and not even that while the emergency stop is pressed, or before the motions
    ///   that waited when the alarm came have been passed over.
    /// - While it jogs it takes jogs only, and while it does anything else it takes no jog.
    /// - While the safety door is open it takes neither homing nor jogs. Other motions are taken, and wait for the
    ///   door.
    /// - While a reset brakes, or a cancelled jog, it takes nothing. A motion that waits for room at that time is
    ///   forgotten.
    ///
    /// # Cancellation
    /// Safe: the motion is either in the queue or was never asked for.
    pub async fn submit(&self, motion: Motion) -> Result<(), Busy> {
        let Life { resets, .. } = self.ask(Trigger::Asked(motion.kind()))?;
        let mut place = QueueSlot { machine: self, taken: false };
        poll_fn(|context| self.poll_enqueue(context, motion)).await;
        place.taken = true;
        // If a reset came while the motion waited for room, the motion is forgotten.
        if self.life().resets == resets { Ok(()) } else { Err(Busy(self.state())) }
    }
}

/// For the tasks of this crate.
impl Machine {
    /// The next motion asked for.
    pub(crate) async fn next_motion(&self) -> Motion {
        self.queue.receive().await
    }

    /// The next motion asked for, if there is one. Not inlined: see [`with`](Self::with).
    #[inline(never)]
    pub(crate) fn try_motion(&self) -> Option<Motion> {
        self.queue.try_receive().ok()
    }

    /// True if a motion waits; if none does, the caller is woken when there is one. Not inlined: see
    /// [`with`](Self::with).
    #[inline(never)]
    pub(crate) fn poll_motion(&self, context: &mut Context<'_>) -> Poll<()> {
        self.queue.poll_ready_to_receive(context)
    }

    /// Takes one motion off those that are pending, without having carried it out.
    pub(crate) fn pass_over(&self) {
        self.on(Trigger::PassedOver);
    }

    /// Sets how many motions would be taken off the queue at once, if nothing is to brake.
    pub(crate) fn set_room(&self, room: usize) {
        self.with(|inner| inner.room = room);
    }

    /// Puts a motion into the queue, or has the caller woken when there is room. Not inlined: see [`with`](Self::with).
    #[inline(never)]
    fn poll_enqueue(&self, context: &mut Context<'_>, motion: Motion) -> Poll<()> {
        loop {
            if self.queue.try_send(motion).is_ok() {
                return Poll::Ready(());
            }
            if self.queue.poll_ready_to_send(context).is_pending() {
                // The coordinator may wait a while to gather motions, but no more fit, so wake it.
                self.wake();
                return Poll::Pending;
            }
        }
    }

    /// Room in the queue. Not inlined: see [`with`](Self::with).
    #[inline(never)]
    pub(super) fn queue_free(&self) -> usize {
        self.queue.free_capacity()
    }

    /// True if no other motion can be asked for without waiting.
    pub(crate) fn is_crowded(&self) -> bool {
        self.queue.is_full()
    }
}

/// A place in the queue that is given back if the motion never enters it.
struct QueueSlot<'a> {
    machine: &'a Machine,
    taken: bool,
}

impl Drop for QueueSlot<'_> {
    fn drop(&mut self) {
        if !self.taken {
            self.machine.pass_over();
        }
    }
}
