//! A TMC2209 by its registers, as its data sheet (revision 1.09) has them.

use ::tmc2209::reg::{Address, GCONF, GSTAT, IHOLD_IRUN, IOIN, MSCNT, Map, State};
use ::tmc2209::{INTERNAL_CLOCK_HZ, vsense_cs_to_rms_current};
use oorandom::Rand32;

use super::wire::reply;
use super::{DriverFault, DriverSetup};

/// Of the resistors that measure the current, as on a BIGTREETECH SKR Pico. VREF is at 2.5 V, which is the whole current.
const SENSE_OHM: f32 = 0.11;
/// The microsteps that the pins MS1 and MS2, which are the address too, select.
const PIN_MICROSTEPS: [u16; 4] = [8, 32, 64, 16];
/// `TSTEP` of a motor that stands.
const STANDING: u32 = (1 << 20) - 1;
/// `SG_RESULT` of a motor without load; at a stall it is 0, and between them the line is straight.
const SG_FREE: f64 = 400.0;
/// The distance that noise takes `SG_RESULT` off the line at most.
const SG_NOISE: u32 = 10;
/// Slower motors induce too little to be measured: `SG_RESULT` is 0, as at a stall. A quarter of a turn of most motors.
const SG_MIN_FULL_STEPS_S: f64 = 50.0;
/// Bits of `GSTAT`.
const RESET: u32 = 1;
const DRV_ERR: u32 = 1 << 1;

/// A driver, and what its motor does.
#[derive(Debug)]
pub struct Tmc2209 {
    address: u8,
    registers: Map,
    fault: Option<DriverFault>,
    /// Number of replies since its present fault.
    replies: usize,
    speed_steps_s: f64,
    load: f64,
    /// As it was measured last.
    sg_result: u32,
    /// True if that was a stall when it was judged.
    is_stalled: bool,
    /// Its motor is off until it has been switched off itself.
    has_found_short: bool,
    noise: Rand32,
}

impl Tmc2209 {
    /// A driver after power-up, its motor standing.
    pub(super) fn new(address: u8, seed: u64) -> Self {
        let (registers, noise) = (at_reset(), Rand32::new(seed));
        Self {
            address,
            registers,
            fault: None,
            replies: 0,
            speed_steps_s: 0.0,
            load: 0.0,
            sg_result: 0,
            is_stalled: false,
            has_found_short: false,
            noise,
        }
    }

    pub(super) fn fault(&self) -> Option<DriverFault> {
        self.fault
    }

    /// From now on this is wrong with it, and nothing else; or nothing is.
    pub fn set_fault(&mut self, fault: Option<DriverFault>) {
        (self.fault, self.replies) = (fault, 0);
        if fault == Some(DriverFault::Off) {
            (self.registers, self.has_found_short) = (at_reset(), false);
            self.judge();
        }
        self.look();
    }

    pub(super) fn hears(&self, address: u8) -> bool {
        self.address == address && self.fault != Some(DriverFault::Off)
    }

    /// The reply to a read of this register.
    pub(super) fn reply(&mut self, register: u8) -> [u8; 8] {
        let mut bytes = reply(register, self.read(register));
        self.replies += 1;
        if self.fault == Some(DriverFault::Garbled) && self.replies.is_multiple_of(2) {
            // Another bit each time.
            bytes[self.replies / 2 % 8] ^= 1 << (self.replies % 7);
        }
        bytes
    }

    /// Looks for an error, as it always does while it is switched on.
    fn look(&mut self) {
        let has_short = self.has_found_short || self.fault == Some(DriverFault::Shorted);
        self.has_found_short = has_short && self.is_switched_on();
        if self.has_stopped() {
            let reported = u32::from(*self.registers.gstat()) | DRV_ERR;
            self.registers.set_state(GSTAT::from(reported).into());
        }
    }

    fn is_switched_on(&self) -> bool {
        self.registers.chopconf().toff() > 0
    }

    /// The motion of its motor: steps at the pin STEP a second, and its load from 0, free, to 1, a stall. One that comes to
    /// rest stalls no more.
    pub fn set_load(&mut self, speed_steps_s: f64, load: f64) {
        (self.speed_steps_s, self.load) = (speed_steps_s.abs(), load);
        self.is_stalled &= self.is_fast();
    }

    /// Steps at the pin STEP, backward if negative: they count in `MSCNT`, of whose full steps each is 256. `SG_RESULT` is measured
    /// where a full step ends: on a straight line of the load from 400 to 0, with noise of 10 at most, in StealthChop and
    /// from 50 full steps a second on. Elsewhere it is 0.
    pub fn step(&mut self, steps: i32) {
        let forward = if self.registers.gconf().shaft() { -1 } else { 1 };
        let moved = steps.wrapping_mul(forward * 256 / i32::from(self.microsteps()));
        let before = i32::from(self.registers.mscnt().get());
        let count = before.wrapping_add(moved);
        self.registers.set_state(MSCNT::from(count.rem_euclid(1024).unsigned_abs()).into());
        if count.div_euclid(256) != before.div_euclid(256) {
            self.measure();
        }
    }

    fn measure(&mut self) {
        let full_steps_s = self.speed_steps_s / f64::from(self.microsteps());
        let is_measured = !self.is_spread_cycle() && full_steps_s >= SG_MIN_FULL_STEPS_S;
        let noise = f64::from(self.noise.rand_range(0..2 * SG_NOISE + 1)) - f64::from(SG_NOISE);
        let reading = SG_FREE * (1.0 - self.load) + noise;
        // Bits 9 and 0 are always 0.
        self.sg_result = if is_measured { reading.clamp(0.0, 510.0) as u32 & !1 } else { 0 };
        self.judge();
    }

    fn judge(&mut self) {
        let is_loaded = self.sg_result <= 2 * u32::from(self.registers.sgthrs().get());
        self.is_stalled = is_loaded && self.is_fast() && !self.is_spread_cycle();
    }

    /// The value that a read of this register gives: 0 where nothing can be read.
    fn read(&self, register: u8) -> u32 {
        match Address::try_from(register) {
            Ok(Address::IOIN) => self.pins().into(),
            Ok(Address::TSTEP) => self.tstep(),
            Ok(Address::SG_RESULT) => self.sg_result,
            Ok(Address::DRV_STATUS) => self.status(),
            Ok(address) if address.readable() => (*self.registers.state(address)).into(),
            _ => 0,
        }
    }

    /// Writes this register, if it can be written. The datagram is counted in any case.
    pub(super) fn write(&mut self, register: u8, data: u32) {
        let counted = self.registers.ifcnt().get().wrapping_add(1);
        self.registers.ifcnt_mut().set(counted);
        match Address::try_from(register) {
            Ok(Address::GSTAT) => self.clear(data),
            Ok(address) if address.writable() => {
                self.registers.set_state(State::from_addr_and_data(address, data & bits(address)));
            }
            _ => {}
        }
        self.look();
        self.judge();
    }

    /// An error that is still there is reported again at once.
    fn clear(&mut self, flags: u32) {
        let left = u32::from(*self.registers.gstat()) & !flags;
        self.registers.set_state(GSTAT::from(left).into());
    }

    /// STEP, DIR and ENABLE low; MS1 and MS2 as the address is.
    fn pins(&self) -> IOIN {
        const PDN_UART: u32 = 1 << 6;
        const VERSION: u32 = 0x21 << 24;
        IOIN::from(VERSION | PDN_UART | u32::from(self.diag()) << 4 | u32::from(self.address & 3) << 2)
    }

    /// Clocks between two 1/256 steps.
    fn tstep(&self) -> u32 {
        let rate = self.speed_steps_s * 256.0 / f64::from(self.microsteps());
        // Also of a motor that stands, whose quotient is infinite.
        (f64::from(INTERNAL_CLOCK_HZ) / rate).clamp(1.0, STANDING.into()) as u32
    }

    /// True if the motor turns, and from the speed of `TCOOLTHRS` on.
    fn is_fast(&self) -> bool {
        let tstep = self.tstep();
        tstep < STANDING && tstep <= self.registers.tcoolthrs().get()
    }

    /// The time after its last step at which a motor that is stalled is slower than `TCOOLTHRS`, ns.
    pub(crate) fn stall_ends_after_ns(&self) -> Option<u64> {
        let clocks = u64::from(self.registers.tcoolthrs().get() + 1) * 256 / u64::from(self.microsteps());
        self.is_stalled.then_some(clocks * 1_000_000_000 / INTERNAL_CLOCK_HZ as u64 + 1)
    }

    fn status(&self) -> u32 {
        let stands = self.speed_steps_s * f64::from(STANDING) < f64::from(INTERNAL_CLOCK_HZ);
        let scale = if stands { self.hold_scale() } else { self.registers.ihold_irun().irun() };
        self.fault.map_or(0, DriverFault::status)
            | u32::from(self.has_found_short) << 2
            | u32::from(scale) << 16
            | u32::from(!self.is_spread_cycle()) << 30
            | u32::from(stands) << 31
    }

    /// True if an error keeps the motor off, which it tells by `GSTAT.drv_err` and DIAG.
    fn has_stopped(&self) -> bool {
        self.has_found_short || self.fault == Some(DriverFault::Overheated)
    }

    /// True if it has no supply, or its motor is switched off, by itself or by `TOFF`.
    pub(crate) fn is_off(&self) -> bool {
        self.has_stopped() || !self.is_switched_on() || self.fault == Some(DriverFault::Off)
    }

    /// True if DIAG is high: in StealthChop, from the speed of `TCOOLTHRS` on, if `SG_RESULT` is at most twice `SGTHRS`; and
    /// while an error keeps the motor off. A stall is judged where a full step ends, and when a register is written; it ends
    /// too when the motor becomes slower than `TCOOLTHRS`, or stands.
    pub fn diag(&self) -> bool {
        self.has_stopped() || self.is_stalled
    }

    /// True if it chops by current now, by its configuration or above the speed of `TPWMTHRS`. (Without the hysteresis of
    /// that speed, which is a sixteenth.)
    fn is_spread_cycle(&self) -> bool {
        self.registers.gconf().en_spread_cycle() || self.tstep() < self.registers.tpwmthrs().get()
    }

    /// Microsteps of a full step: by the register, if that is selected, or else by the pins.
    pub fn microsteps(&self) -> u16 {
        if !self.registers.gconf().mstep_reg_select() {
            return PIN_MICROSTEPS[usize::from(self.address & 3)];
        }
        let resolution = u32::from(*self.registers.chopconf()) >> 24 & 0xF;
        256 >> resolution.min(8)
    }

    /// Its settings.
    pub fn setup(&self) -> DriverSetup {
        DriverSetup {
            microsteps: self.microsteps(),
            run_ma: self.current_ma(self.registers.ihold_irun().irun()),
            hold_ma: self.current_ma(self.hold_scale()),
            is_spread_cycle: self.is_spread_cycle(),
            reports_stalls: self.registers.tcoolthrs().get() > 0,
        }
    }

    /// That of the run, where the pin PDN_UART, which idles high, says that the current is not reduced.
    fn hold_scale(&self) -> u8 {
        let scales = self.registers.ihold_irun();
        if self.registers.gconf().pdn_disable() { scales.ihold() } else { scales.irun() }
    }

    fn current_ma(&self, scale: u8) -> u32 {
        vsense_cs_to_rms_current(SENSE_OHM, self.registers.chopconf().vsense(), scale).round() as u32
    }
}

/// Those that a register has which can be read back.
fn bits(register: Address) -> u32 {
    match register {
        Address::GCONF => 0x3FF,
        Address::FACTORY_CONF => 0x31F,
        _ => u32::MAX,
    }
}

/// The registers after power-up. Where the data sheet and the crate differ, as the data sheet says.
fn at_reset() -> Map {
    let mut registers = Map::default();
    // Current by VREF, steps filtered; by the pins: what PDN_UART does, and microsteps.
    registers.set_state(GCONF::from(0x101).into());
    // Hold with half of the whole current, reached in steps of 2^18 clocks.
    registers.set_state(IHOLD_IRUN::from(0x1_1F10).into());
    registers.set_state(GSTAT::from(RESET).into());
    registers
}
