//! A VFD by Modbus: it turns the spindle as the machine's state says, and says how it does.
//!
//! Everything here may take its time: an exchange is some 30 milliseconds, of which the processor spends microseconds. What has to
//! be at once, a stop, is not done by the wire but by the enable output, which is cut off with the others.

mod exchange;
mod report;
mod types;
mod watch;

use core::cell::Cell;

use embassy_time::Duration;
use isostep_motion::SpindleWanted;

use self::report::VfdHealth;

/// The connection of a board to a VFD: RS-485, on which one side speaks at a time.
#[allow(async_fn_in_trait, reason = "a wire stays on the executor of the consoles: no Send bound is wanted")]
pub trait VfdWire {
    /// Sends `sent`, which is one frame, and releases the wire within 3.5 characters. Then waits until `heard` is full, or for
    /// `limit` at most. Returns how many bytes were heard. What was heard before the end of the frame is dropped: modules may hear
    /// the board itself.
    ///
    /// # Cancellation
    /// The frame is sent or not. Bytes that are left are dropped by the next exchange.
    async fn exchange(&mut self, line: LineFormat, sent: &[u8], heard: &mut [u8], limit: Duration) -> usize;
}

/// The longest request of any VFD, bytes, and the longest reply.
pub const VFD_SENT_BYTES_MAX: usize = 11;
/// The longest reply of any VFD, bytes.
pub const VFD_HEARD_BYTES_MAX: usize = 15;

/// The form of characters on the wire: a start bit, eight bits, parity if there is one, a stop bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineFormat {
    /// Bits a second.
    pub baud: u32,
    /// Its parity.
    pub parity: Parity,
}

/// The parity of a character.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// None.
    None,
    /// Even.
    Even,
    /// Odd.
    Odd,
}

impl LineFormat {
    /// The time that so many characters take.
    #[must_use]
    pub fn time(self, characters: usize) -> Duration {
        let bits = characters as u64 * if self.parity == Parity::None { 10 } else { 11 };
        Duration::from_micros((bits * 1_000_000).div_ceil(self.baud.into()))
    }
}

/// The VFD, as far as the controller knows it.
pub(crate) struct Vfd {
    /// The type that is served: `$395` when the board started; 0 for none.
    served: Cell<u16>,
    known: Cell<VfdKnown>,
    /// How it was when the machine was locked because of it.
    failed: Cell<Option<VfdKnown>>,
    /// What it was wanted to do when it did it, or had failed.
    settled: Cell<Option<SpindleWanted>>,
    exchanges: Cell<u32>,
    repeats: Cell<u32>,
}

/// The state of the VFD at one instant.
#[derive(Clone, Copy)]
struct VfdKnown {
    health: VfdHealth,
    /// The register that the health is about.
    register: u16,
    rpm: f32,
    wanted_rpm: f32,
    amperes: Option<f32>,
}

impl Vfd {
    pub const fn new() -> Self {
        Self {
            served: Cell::new(0),
            known: Cell::new(VfdKnown {
                health: VfdHealth::Unknown,
                register: 0,
                rpm: 0.0,
                wanted_rpm: 0.0,
                amperes: None,
            }),
            failed: Cell::new(None),
            settled: Cell::new(None),
            exchanges: Cell::new(0),
            repeats: Cell::new(0),
        }
    }

    /// True if the setting says how to reach the VFD.
    pub fn is_about(number: u16) -> bool {
        matches!(number, 374 | 375 | 395 | 461..=476 | 681)
    }

    fn is_served(&self) -> bool {
        self.served.get() != 0
    }

    /// The speed of the spindle, if a VFD turns it.
    pub fn actual_rpm(&self) -> Option<f32> {
        self.is_served().then(|| self.known.get().rpm)
    }
}
