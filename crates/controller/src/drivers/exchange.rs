//! Datagrams: reading and writing a register, as often as a disturbed wire needs.

use embassy_time::{Duration, Timer};
use tmc2209::reg::{IFCNT, ReadableRegister, WritableRegister};
use tmc2209::{ReadRequest, ReadResponse, Reader, WriteRequest};

use super::Wire;

/// The number of times that a datagram is tried, and the pause after which a driver has forgotten half of one: at 9,600 baud it
/// forgets after 63 bit times.
const TRIES: usize = 3;
const PAUSE_MS: u64 = 7;

/// A driver on a wire with others must wait longer than 8 bit times before it answers: 24.
pub const SEND_DELAY: u8 = 2;
const SEND_DELAY_BITS: u64 = 24;
/// Start, eight, stop.
const BYTE_BITS: u64 = 10;
/// A driver's clock is off by some percent, and so is what it measures of the board's.
const SPARE_BITS: u64 = 22;

const HEARD: usize = ReadRequest::LEN_BYTES + ReadResponse::LEN_BYTES;

/// The time for which a [`Wire`](super::Wire) of this baud rate waits for `bytes`: an echo, and a reply if it is longer.
pub fn exchange_time(bytes: usize, baud: u32) -> Duration {
    let bits = bytes as u64 * BYTE_BITS + SEND_DELAY_BITS + SPARE_BITS;
    Duration::from_micros((bits * 1_000_000).div_ceil(baud.into()))
}

/// Why a register was not read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// No try was answered.
    Silent,
    /// The driver did not count what was written.
    NotTaken,
}

/// One driver on the wire.
pub struct DriverOnWire<'a, W> {
    pub wire: &'a mut W,
    pub address: u8,
}

impl<W: Wire> DriverOnWire<'_, W> {
    /// Reads a register.
    pub async fn read<R: ReadableRegister>(&mut self) -> Result<R, Failure> {
        let request = ReadRequest::new::<R>(self.address);
        for _ in 0..TRIES {
            let mut heard = [0; HEARD];
            let count = self.wire.exchange(request.bytes(), &mut heard).await;
            // The board hears itself first.
            let reply = heard[..count].strip_prefix(request.bytes());
            let response = reply.and_then(|reply| Reader::default().read_response(reply).1);
            if let Some(register) = response.filter(ReadResponse::crc_is_valid).and_then(|r| r.register::<R>().ok()) {
                return Ok(register);
            }
            Timer::after_millis(PAUSE_MS).await;
        }
        Err(Failure::Silent)
    }

    /// Writes registers, and makes sure that the driver has taken each of them.
    pub async fn write(&mut self, requests: &[WriteRequest]) -> Result<(), Failure> {
        for _ in 0..TRIES {
            let before: IFCNT = self.read().await?;
            for request in requests {
                self.wire.exchange(request.bytes(), &mut [0; WriteRequest::LEN_BYTES]).await;
            }
            let after: IFCNT = self.read().await?;
            // It counts to 255 and begins again.
            if after.get() as u8 == (before.get() as u8).wrapping_add(requests.len() as u8) {
                return Ok(());
            }
            Timer::after_millis(PAUSE_MS).await;
        }
        Err(Failure::NotTaken)
    }

    /// The datagram that writes `register`.
    pub fn request<R: WritableRegister>(&self, register: R) -> WriteRequest {
        WriteRequest::new(self.address, register)
    }
}
