//! UART drivers: TMC2209 on one wire. They are set by the settings, read back, and watched.
//!
//! Everything here may take its time: an exchange is some milliseconds, of which the processor spends microseconds. A motor
//! needs none of it to make its steps.

mod exchange;
mod health;
mod measure;
mod registers;
mod report;
mod stall;
mod watch;

use core::cell::{Cell, RefCell};

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use isostep_console::Settings;
use isostep_motion::{AXES, Axis, Motor};

pub use self::exchange::exchange_time;
use self::health::Health;
use self::measure::Readings;
use self::registers::Registers;

/// The drivers of a board: those of X, Y and Z, then of the fourth motor.
const DRIVERS: usize = 4;

/// The connection of a board to its drivers: one wire, on which both sides speak, at 9,600 to 500,000 baud.
#[allow(async_fn_in_trait, reason = "a wire stays on the executor of the consoles: no Send bound is wanted")]
pub trait Wire {
    /// Sends `sent`, which is one datagram, and waits as long as its echo and a reply need to fill `heard`:
    /// [`exchange_time`]. Returns how many bytes were heard; it never waits for more.
    ///
    /// # Cancellation
    /// Safe: bytes that are left are heard by the next exchange, which takes none of them for its own.
    async fn exchange(&mut self, sent: &[u8], heard: &mut [u8]) -> usize;
}

/// The drivers of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriverHardware {
    /// Their addresses on the wire, 0 to 3: of X, Y, Z and the fourth motor.
    pub addresses: [u8; DRIVERS],
    /// Their sense resistors, milliohms.
    pub sense_milliohms: u16,
}

/// The drivers, as far as the controller knows them.
pub(crate) struct Drivers {
    hardware: DriverHardware,
    known: RefCell<[Known; DRIVERS]>,
    /// Settings have changed.
    asked: Signal<NoopRawMutex, ()>,
    /// Not all drivers are set to them yet.
    pending: Cell<bool>,
    /// They are.
    done: Signal<NoopRawMutex, ()>,
    /// The axes whose motors are looked at for a stall, because they home.
    looks_mask: Cell<u16>,
    /// The driver whose motor is being measured, and what was read.
    measured: Cell<Option<usize>>,
    readings: Cell<Readings>,
}

/// The state of a driver, as far as it is known.
#[derive(Clone, Copy)]
struct Known {
    health: Health,
    /// The registers to which it has been set; `None` until it has taken that.
    set: Option<Registers>,
    /// DRV_STATUS, as it was read last.
    status: u32,
    /// SG_RESULT, 0 to 510: the less, the nearer the motor is to a stall.
    sg_result: u16,
    /// The number of times in a row that a coil seemed open.
    open: u8,
    /// Rounds since its settings were read back.
    rounds: u8,
    /// The machine was locked because of this driver when it was asked last.
    has_locked: bool,
}

impl Known {
    /// Of one that has not been asked yet.
    const UNKNOWN: Self =
        Self { health: Health::Unknown, set: None, status: 0, sg_result: 0, open: 0, rounds: 0, has_locked: false };
}

/// The change of a motor's driver.
#[derive(Clone, Copy)]
pub(crate) struct DriverNews {
    pub motor: Motor,
    pub health: Health,
}

impl Drivers {
    pub fn new(hardware: DriverHardware) -> Self {
        Self {
            hardware,
            known: RefCell::new([Known::UNKNOWN; DRIVERS]),
            asked: Signal::new(),
            pending: Cell::new(false),
            done: Signal::new(),
            looks_mask: Cell::new(0),
            measured: Cell::new(None),
            readings: Cell::new(Readings::NONE),
        }
    }

    /// Has the drivers set anew.
    pub fn settings_changed(&self) {
        self.pending.set(true);
        self.asked.signal(());
    }
}

/// The motor of a driver, if it has one.
fn motor(driver: usize, settings: &Settings) -> Option<Motor> {
    match Axis::ALL.get(driver) {
        Some(&axis) => Some(Motor::first(axis)),
        None if driver == AXES.max(DRIVERS - 1) => settings.second_motor().map(|axis| Motor::second(Axis::ALL[axis])),
        None => None,
    }
}

/// True if the settings have this motor's driver set and watched.
fn is_watched(motor: Motor, settings: &Settings) -> bool {
    settings.trinamic_mask & (1 << motor.axis as u16) != 0
}
