//! The wire that drivers share with the board, and the datagrams on it.

use std::ops::{Index, IndexMut};

use ::tmc2209::{MASTER_ADDR, SYNC_AND_RESERVED, crc};

use super::DriverFault;
use super::tmc2209::Tmc2209;

/// Four TMC2209s on one wire, by which the board sends and hears. Its indices are those of the addresses.
#[derive(Debug)]
pub struct Wire {
    drivers: [Tmc2209; 4],
    /// Replies that come before the next echo.
    late: Vec<u8>,
}

impl Wire {
    /// Drivers of these addresses, 0 to 3, after power-up.
    pub fn new(addresses: [u8; 4]) -> Self {
        let driver = |index| Tmc2209::new(addresses[index], index as u64);
        Self { drivers: std::array::from_fn(driver), late: Vec::new() }
    }

    /// The bytes that the board hears when it sends this: the bytes themselves, and the reply if they are a valid read of a
    /// driver that is there. Bytes that are no whole datagram no driver heeds. Drivers of one address reply at once, and nobody
    /// can read it.
    pub fn exchange(&mut self, sent: &[u8]) -> Vec<u8> {
        let mut heard = std::mem::take(&mut self.late);
        heard.extend(sent);
        match Request::decode(sent) {
            Some(Request::Read { node, register }) => heard.extend(self.read(node, register).into_iter().flatten()),
            Some(Request::Write { node, register, data }) => {
                self.of(node).for_each(|driver| driver.write(register, data));
            }
            None => {}
        }
        heard
    }

    fn read(&mut self, address: u8, register: u8) -> Option<[u8; 8]> {
        let (mut now, mut late) = (None, Vec::new());
        for driver in self.of(address) {
            let reply = driver.reply(register);
            if driver.fault() == Some(DriverFault::Late) {
                late.extend(reply);
            } else {
                now = Some(now.map_or(reply, |first| collide(first, reply)));
            }
        }
        self.late.extend(late);
        now
    }

    fn of(&mut self, address: u8) -> impl Iterator<Item = &mut Tmc2209> {
        self.drivers.iter_mut().filter(move |driver| driver.hears(address))
    }
}

impl Index<usize> for Wire {
    type Output = Tmc2209;

    fn index(&self, driver: usize) -> &Tmc2209 {
        &self.drivers[driver]
    }
}

impl IndexMut<usize> for Wire {
    fn index_mut(&mut self, driver: usize) -> &mut Tmc2209 {
        &mut self.drivers[driver]
    }
}

/// The bit of a register's address that says that it is written.
const WRITES: u8 = 0x80;

/// A request of a master to the drivers that have this address.
#[derive(Clone, Copy)]
enum Request {
    Read { node: u8, register: u8 },
    Write { node: u8, register: u8, data: u32 },
}

impl Request {
    /// `None` for what a driver ignores: another length, another first nibble, a wrong CRC.
    fn decode(sent: &[u8]) -> Option<Self> {
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

/// The bytes that are heard of two replies at once: low wins, and as no two clocks are equal, the second is a bit behind.
fn collide(first: [u8; 8], second: [u8; 8]) -> [u8; 8] {
    std::array::from_fn(|byte| first[byte] & second[byte] << 1)
}
