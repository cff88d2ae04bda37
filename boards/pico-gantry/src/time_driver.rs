//! The time driver: the first alarm of the chip's timer wakes each task when its time comes.
//!
//! # Why not that of embassy-rp
//! The alarm fires in the microsecond of its target, and not when that has passed. In its interrupt, embassy-rp 0.10
//! may set the alarm again without a look at the clock afterwards. If the target's microsecond begins in between, the
//! alarm is lost, and no task wakes until one sets an alarm for another reason (embassy's issue 6528). With `TimerPort`
//! on the emulated board, a step came late by that. Here the clock is read after every write to the alarm.
//!
//! # Deadline
//! The interrupt has the priority of the highest task, and takes some microseconds. What delays it delays every task that
//! waits for its time; a task never misses its time for good. The guard delays it, and is not delayed by it.

use core::cell::RefCell;
use core::task::Waker;

use embassy_rp::interrupt;
use embassy_sync::blocking_mutex::Mutex;
use embassy_time_driver::{Driver, time_driver_impl};
use embassy_time_queue_utils::Queue;

use crate::chip::TIMER;
use crate::priority::{self, BelowGuard};
use crate::two_words;

const ALARM: usize = 0;

time_driver_impl!(static DRIVER: TimeDriver = TimeDriver { timers: Mutex::new(RefCell::new(Timers::new())) });

struct TimeDriver {
    timers: Mutex<BelowGuard, RefCell<Timers>>,
}

/// The tasks that wait for their times.
struct Timers {
    queue: Queue,
    /// The instant that the alarm is set for, us. When that has passed, the interrupt is about to come.
    alarm_us: u64,
}

/// Lets the alarm interrupt. What it was set for before is not lost.
pub fn start() {
    TIMER.inte().modify(|enabled| enabled.set_alarm(ALARM, true));
    priority::enable_timer();
}

impl Driver for TimeDriver {
    /// The time since power-up, us.
    fn now(&self) -> u64 {
        two_words::read(|| TIMER.timerawh().read(), || TIMER.timerawl().read())
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        self.timers.lock(|timers| {
            let timers = &mut *timers.borrow_mut();
            // Most tasks wait for longer than until the next alarm. Looking at all of them takes microseconds.
            if timers.queue.schedule_wake(at, waker) && at < timers.alarm_us {
                timers.wake_due();
            }
        });
    }
}

impl Timers {
    const fn new() -> Self {
        Self { queue: Queue::new(), alarm_us: u64::MAX }
    }

    /// Wakes the tasks whose time has come, and sets the alarm for the next one.
    fn wake_due(&mut self) {
        loop {
            self.alarm_us = self.queue.next_expiration(DRIVER.now());
            // What is due was woken. An alarm that has come meanwhile would only look through all of them once more.
            TIMER.intr().write(|raised| raised.set_alarm(ALARM, true));
            // The alarm compares the lower words only. If it fires an hour early, no task is due, and it is set again.
            TIMER.alarm(ALARM).write_value(self.alarm_us as u32);
            if DRIVER.now() < self.alarm_us {
                return;
            }
        }
    }
}

#[cfg(not(rp2350))]
#[interrupt]
fn TIMER_IRQ_0() {
    on_alarm();
}

#[cfg(rp2350)]
#[interrupt]
fn TIMER0_IRQ_0() {
    on_alarm();
}

#[inline(always)]
fn on_alarm() {
    if TIMER.intr().read().alarm(ALARM) {
        DRIVER.timers.lock(|timers| timers.borrow_mut().wake_due());
    }
}
