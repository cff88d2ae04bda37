//! What a TMC2209 reads and says.

use ::tmc2209::{MASTER_ADDR, SYNC_AND_RESERVED, crc};

/// The bit of a register's address that says that it is written.
const WRITES: u8 = 0x80;

/// What a master asks of the drivers that have this address.
#[derive(Clone, Copy)]
pub(super) enum Request {
    Read { node: u8, register: u8 },
    Write { node: u8, register: u8, data: u32 },
}

impl Request {
    /// `None` for what a driver ignores: another length, another first nibble, a wrong CRC.
    pub(super) fn decode(sent: &[u8]) -> Option<Self> {
        let (&checked, body) = sent.split_last()?;
        if body.first()? & 0xF != SYNC_AND_RESERVED || checked != crc(body) {
            return None;
        }
        match *body {
            [_, node, register] if register < WRITES => Some(Self::Read { node, register }),
            [_, node, register, d3, d2, d1, d0] if register >= WRITES => {
                let data = u32::from_be_bytes([d3, d2, d1, d0]);
                Some(Self::Write { node, register: register - WRITES, data })
            }
            _ => None,
        }
    }
}

/// The reply to a read.
pub(super) fn reply(register: u8, data: u32) -> [u8; 8] {
    let [d3, d2, d1, d0] = data.to_be_bytes();
    let mut bytes = [SYNC_AND_RESERVED, MASTER_ADDR, register, d3, d2, d1, d0, 0];
    bytes[7] = crc(&bytes[..7]);
    bytes
}

/// What is heard of two replies at once: low wins, and as no two clocks are equal, the second is a bit behind.
pub(super) fn collide(first: [u8; 8], second: [u8; 8]) -> [u8; 8] {
    std::array::from_fn(|byte| first[byte] & second[byte] << 1)
}
