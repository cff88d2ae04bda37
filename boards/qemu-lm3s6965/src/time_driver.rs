//! The time driver: SysTick counts cycles of the system clock, and a one-shot timer is the alarm.
//!
//! # Design
//! SysTick has 24 bits, so it overflows every 0.84 s at 20 MHz, and its exception counts that. QEMU's timers cannot be
//! read, so the alarm is a timer of its own, started for what is left. It may come early, never late: then it is started
//! again.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::Waker;

use cortex_m_rt::exception;
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_time_driver::{Driver, time_driver_impl};
use embassy_time_queue_utils::Queue;

use crate::chip::{Irq, Register};

const SYSTICK: u32 = 0xE000_E010;
const SYSTICK_CONTROL: Register = Register::at(SYSTICK, 0x0);
const SYSTICK_RELOAD: Register = Register::at(SYSTICK, 0x4);
const SYSTICK_CURRENT: Register = Register::at(SYSTICK, 0x8);
/// The exception's pending bit is 26.
const INTERRUPT_CONTROL: Register = Register::at(0xE000_ED04, 0);
const SYSTICK_PENDING: u32 = 1 << 26;
const SYSTICK_MAX: u32 = 0xFF_FFFF;

/// Clock: system clock from the PLL, divided by 10.
const RUN_CLOCK: Register = Register::at(0x400F_E000, 0x60);
const DIVIDER_SHIFT: u32 = 23;
const DIVIDER_MASK: u32 = 0xF << DIVIDER_SHIFT;

const TIMER0: u32 = 0x4003_0000;
const ALARM_MODE: Register = Register::at(TIMER0, 0x04);
const ALARM_CONTROL: Register = Register::at(TIMER0, 0x0C);
const ALARM_MASK: Register = Register::at(TIMER0, 0x18);
const ALARM_CLEAR: Register = Register::at(TIMER0, 0x24);
const ALARM_LOAD: Register = Register::at(TIMER0, 0x28);
/// A longer wait is made in parts.
const ALARM_MAX_TICKS: u64 = 1 << 31;

time_driver_impl!(static DRIVER: TimeDriver = TimeDriver {
    overflows: AtomicU32::new(0),
    timers: CriticalSectionMutex::new(RefCell::new(Timers { queue: Queue::new(), alarm: u64::MAX })),
});

struct TimeDriver {
    overflows: AtomicU32,
    timers: CriticalSectionMutex<RefCell<Timers>>,
}

/// The tasks that wait for their times.
struct Timers {
    queue: Queue,
    /// The instant that the alarm is set for, ticks. When that has passed, the interrupt is about to come.
    alarm: u64,
}

/// Starts the clock.
pub fn start() {
    RUN_CLOCK.write(RUN_CLOCK.read() & !DIVIDER_MASK | 9 << DIVIDER_SHIFT);
    SYSTICK_RELOAD.write(SYSTICK_MAX);
    SYSTICK_CURRENT.write(0);
    // On, with its exception, from the system clock.
    SYSTICK_CONTROL.write(0b111);
    ALARM_MODE.write(1);
    ALARM_MASK.write(1);
    Irq::Timer0A.enable(0);
}

/// The ticks that SysTick has left. At 0, which lasts a tick, it may or may not have reported its overflow, so that is waited
/// out.
fn left() -> u32 {
    loop {
        match SYSTICK_CURRENT.read() {
            0 => {}
            left => return left,
        }
    }
}

impl Driver for TimeDriver {
    /// The time since power-up, ticks of 50 ns.
    fn now(&self) -> u64 {
        cortex_m::interrupt::free(|_| {
            let mut left = left();
            let mut overflows = self.overflows.load(Ordering::Relaxed);
            if INTERRUPT_CONTROL.read() & SYSTICK_PENDING != 0 {
                // It has overflowed, before or after the first reading.
                left = self::left();
                overflows += 1;
            }
            u64::from(overflows) << 24 | u64::from(SYSTICK_MAX - left)
        })
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        self.timers.lock(|timers| {
            let timers = &mut *timers.borrow_mut();
            if timers.queue.schedule_wake(at, waker) && at < timers.alarm {
                timers.wake_due();
            }
        });
    }
}

impl Timers {
    /// Wakes the tasks whose time has come, and sets the alarm for the next one.
    fn wake_due(&mut self) {
        loop {
            let now = DRIVER.now();
            self.alarm = self.queue.next_expiration(now);
            if self.alarm > now {
                ALARM_CONTROL.write(0);
                ALARM_LOAD.write((self.alarm - now).min(ALARM_MAX_TICKS) as u32);
                ALARM_CONTROL.write(1);
                return;
            }
        }
    }
}

/// The timer has run out. If that was early, it is set again.
pub extern "C" fn on_alarm() {
    DRIVER.timers.lock(|timers| {
        ALARM_CLEAR.write(1);
        timers.borrow_mut().wake_due();
    });
}

#[exception]
fn SysTick() {
    // Only this exception writes it, and a Cortex-M0+, for which this is compiled, has no read-modify-write.
    DRIVER.overflows.store(DRIVER.overflows.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
}
