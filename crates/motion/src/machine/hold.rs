//! Holds, jog cancels and overrides: what is asked of the coordinator while the machine moves.

use core::sync::atomic::Ordering;

use embassy_futures::select::select;
use embassy_time::{Instant, Timer};

use super::life::Forget;
use super::{Machine, Reaction, Trigger};

/// The speed at which to move, in percent of what is asked for; never faster than the limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpeedOverrides {
    /// Percentage of a feed, above 0.
    pub feed_percent: u8,
    /// Percentage of the limits' speed where no feed was asked for, 1 to 100.
    pub rapid_percent: u8,
}

impl SpeedOverrides {
    /// No override.
    pub const NONE: Self = Self { feed_percent: 100, rapid_percent: 100 };
}

impl Machine {
    /// Brakes the move under way on its path, as fast as the limits allow, and holds the waiting motions until
    /// [`resume`](Self::resume). Braking begins some 60 ms after this call. A jog is cancelled instead. Homing goes on,
    /// and in an alarm nothing happens.
    pub fn hold(&self) {
        self.on(Trigger::Hold);
    }

    /// Goes on after a [`hold`](Self::hold), if the machine stands still and the safety door is closed. A spindle that
    /// was stopped meanwhile reaches its speed first.
    pub fn resume(&self) {
        let reaction = self.with(|inner| {
            let before = inner.effective();
            let reaction = self.apply(inner, Trigger::Resume);
            if reaction == Reaction::Wake {
                inner.outputs.stopped = None;
                inner.spin_up(before);
            }
            reaction
        });
        if reaction == Reaction::Wake {
            self.wake();
        }
    }

    /// Brakes a jog on its path, and forgets the waiting jogs. In any other state nothing happens.
    pub fn cancel_jog(&self) {
        self.on(Trigger::CancelJog);
    }

    /// True if cancelled jogs are being forgotten: the one under way still brakes, and no other is taken.
    #[must_use]
    pub fn is_cancelling_jogs(&self) -> bool {
        self.life().forget == Forget::Jogs
    }

    /// Changes the speed of moves, the one under way included, some 60 ms after this call.
    pub fn set_overrides(&self, overrides: SpeedOverrides) {
        self.with(|inner| inner.overrides = overrides);
        self.wake();
    }

    /// The overrides in force.
    #[must_use]
    pub fn overrides(&self) -> SpeedOverrides {
        self.with(|inner| inner.overrides)
    }
}

/// For the coordinator.
impl Machine {
    /// Wakes the coordinator, because something has been asked of it. Not inlined: see [`with`](Self::with).
    #[inline(never)]
    pub(super) fn wake(&self) {
        self.asked.signal(());
    }

    /// True if the move under way is to brake.
    pub(crate) fn is_to_brake(&self) -> bool {
        self.with(|inner| inner.life.is_to_brake())
    }

    /// Notes whether the switch that a seek goes to has been touched, and wakes the coordinator. This needs no critical section,
    /// because only the coordinator's own task asks for it.
    pub(crate) fn set_touched(&self, touched: bool) {
        self.touched.store(touched, Ordering::Relaxed);
        self.wake();
    }

    /// True if it has been.
    pub(crate) fn is_touched(&self) -> bool {
        self.touched.load(Ordering::Relaxed)
    }

    /// Waits for a hold, a resume, other overrides, or more motions than there is room for.
    pub(crate) async fn wait_asked(&self) {
        self.asked.wait().await;
    }

    /// Waits until the motion under way is held, stopped, or to be forgotten.
    pub(crate) async fn wait_interrupted(&self) {
        while !self.life().is_interrupted() {
            select(self.asked.wait(), self.stopped.wait()).await;
        }
    }

    /// Notes that a run begins or has ended. So it is known at any time whether a hold finds the machine at rest.
    pub(crate) fn set_moving(&self, moving: bool) {
        self.on(Trigger::Moving(moving));
        self.tool.ask();
    }

    /// Notes that homing begins; returns false if it is held or stopped before.
    pub(crate) fn begin_homing(&self) -> bool {
        self.ask(Trigger::Homing).is_ok()
    }

    /// Waits at rest until a hold is over and the spindle has its speed; false if the held motion is to be forgotten.
    pub(crate) async fn outlast_hold(&self) -> bool {
        loop {
            if self.is_to_forget() {
                return false;
            }
            let changed = select(self.asked.wait(), self.stopped.wait());
            let (held, ready_at) = self.with(|inner| (inner.life.held, inner.outputs.ready_at));
            if held || ready_at == Instant::MAX {
                changed.await;
            } else if Instant::now() < ready_at {
                select(changed, Timer::at(ready_at)).await;
            } else {
                self.on(Trigger::GoesOn);
                return true;
            }
        }
    }

    /// True if the motion that is held or under way is to be forgotten.
    pub(crate) fn is_to_forget(&self) -> bool {
        self.life().is_to_forget()
    }
}
