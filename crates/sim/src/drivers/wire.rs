//! The wire that drivers share with the board.

use super::DriverFault;
use super::datagram::{Request, collide, reply};
use super::tmc2209::Tmc2209;

/// How a driver is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriverSetup {
    /// Microsteps of a full step.
    pub microsteps: u16,
    /// Effective current of a motor that moves, mA.
    pub run_ma: u32,
    /// Effective current of one that stands, mA.
    pub hold_ma: u32,
    /// It chops by SpreadCycle now, not by StealthChop.
    pub is_spread_cycle: bool,
    /// It tells stalls: at some speed (`TCOOLTHRS`), below some load (`SGTHRS`).
    pub tells_stalls: bool,
}

/// Four TMC2209s on one wire, by which the board sends and hears. The `driver` of its methods is an index of the
/// addresses, and one beyond them panics.
#[derive(Debug)]
pub struct Wire {
    nodes: [Node; 4],
    /// Replies that come before the next echo.
    late: Vec<u8>,
}

#[derive(Debug)]
struct Node {
    driver: Tmc2209,
    /// Since its present fault.
    replies: usize,
}

impl Wire {
    /// Drivers of these addresses, 0 to 3, after power-up.
    pub fn new(addresses: [u8; 4]) -> Self {
        let node = |index| Node { driver: Tmc2209::new(addresses[index], index as u64), replies: 0 };
        Self { nodes: std::array::from_fn(node), late: Vec::new() }
    }

    /// What the board hears when it sends this: the bytes themselves, and the reply if they are a valid read of a driver
    /// that is there. Bytes that are no whole datagram no driver heeds. Drivers of one address reply at once, and nobody
    /// can read it.
    pub fn exchange(&mut self, sent: &[u8]) -> Vec<u8> {
        let mut heard = std::mem::take(&mut self.late);
        heard.extend(sent);
        match Request::decode(sent) {
            Some(Request::Read { node, register }) => heard.extend(self.read(node, register).into_iter().flatten()),
            Some(Request::Write { node, register, data }) => self.write(node, register, data),
            None => {}
        }
        heard
    }

    fn read(&mut self, address: u8, register: u8) -> Option<[u8; 8]> {
        let mut now = None;
        for node in self.nodes.iter_mut().filter(|node| node.hears(address)) {
            let reply = node.reply(register);
            if node.driver.fault() == Some(DriverFault::Late) {
                self.late.extend(reply);
            } else {
                now = Some(now.map_or(reply, |first| collide(first, reply)));
            }
        }
        now
    }

    fn write(&mut self, address: u8, register: u8, data: u32) {
        for node in self.nodes.iter_mut().filter(|node| node.hears(address)) {
            node.driver.write(register, data);
        }
    }

    /// From now on this is wrong with a driver, and nothing else.
    pub fn fault(&mut self, driver: usize, fault: DriverFault) {
        self.nodes[driver].set_fault(Some(fault));
    }

    /// Nothing is wrong with a driver any more.
    pub fn mend(&mut self, driver: usize) {
        self.nodes[driver].set_fault(None);
    }

    /// What a motor does: steps at its pin STEP a second, and its load from 0, free, to 1, a stall. `SG_RESULT` is measured
    /// where a full step ends: on a straight line of the load from 400 to 0, with noise of 10 at most, in StealthChop and
    /// from 50 full steps a second on. Elsewhere it is 0.
    pub fn set_load(&mut self, driver: usize, speed_steps_s: f64, load: f64) {
        self.nodes[driver].driver.set_load(speed_steps_s, load);
    }

    /// Steps at a driver's pin STEP, backward if negative: they count in `MSCNT`, of whose full steps each is 256.
    pub fn step(&mut self, driver: usize, steps: i32) {
        self.nodes[driver].driver.step(steps);
    }

    /// Whether a driver's pin DIAG is high: in StealthChop, from the speed of `TCOOLTHRS` on, if `SG_RESULT` is at most
    /// twice `SGTHRS`; and while an error keeps the motor off. A stall is judged where a full step ends, and when a
    /// register is written; it ends too when the motor becomes slower than `TCOOLTHRS`, or stands.
    pub fn diag(&self, driver: usize) -> bool {
        self.nodes[driver].driver.diag()
    }

    /// How long after its last step a motor whose stall DIAG tells is slower than `TCOOLTHRS`, ns.
    pub(crate) fn stall_ends_after_ns(&self, driver: usize) -> Option<u64> {
        self.nodes[driver].driver.stall_ends_after_ns()
    }

    /// Whether a driver has no supply, or its motor is switched off, by itself or by `TOFF`.
    pub(crate) fn is_off(&self, driver: usize) -> bool {
        self.nodes[driver].driver.is_off()
    }

    /// How a driver is set.
    pub fn setup(&self, driver: usize) -> DriverSetup {
        DriverSetup {
            microsteps: self.microsteps(driver),
            run_ma: self.run_current_ma(driver),
            hold_ma: self.hold_current_ma(driver),
            is_spread_cycle: self.is_spread_cycle(driver),
            tells_stalls: self.nodes[driver].driver.tells_stalls(),
        }
    }

    /// Microsteps of a full step.
    pub fn microsteps(&self, driver: usize) -> u16 {
        self.nodes[driver].driver.microsteps()
    }

    /// Effective current of a motor that moves, with resistors of 0.11 ohm.
    pub fn run_current_ma(&self, driver: usize) -> u32 {
        self.nodes[driver].driver.run_current_ma()
    }

    /// Effective current of a motor that stands, with resistors of 0.11 ohm.
    pub fn hold_current_ma(&self, driver: usize) -> u32 {
        self.nodes[driver].driver.hold_current_ma()
    }

    /// Whether a driver is in SpreadCycle at the present speed, not in StealthChop.
    pub fn is_spread_cycle(&self, driver: usize) -> bool {
        self.nodes[driver].driver.is_spread_cycle()
    }
}

impl Node {
    fn set_fault(&mut self, fault: Option<DriverFault>) {
        self.driver.set_fault(fault);
        self.replies = 0;
    }

    fn hears(&self, address: u8) -> bool {
        self.driver.address() == address && self.driver.fault() != Some(DriverFault::Off)
    }

    fn reply(&mut self, register: u8) -> [u8; 8] {
        let mut bytes = reply(register, self.driver.read(register));
        self.replies += 1;
        if self.driver.fault() == Some(DriverFault::Garbled) && self.replies.is_multiple_of(2) {
            // Another bit each time.
            bytes[self.replies / 2 % 8] ^= 1 << (self.replies % 7);
        }
        bytes
    }
}
