//! From the settings to a driver's registers. Formulas are those of the TMC2209's data sheet.

use isostep_console::Settings;
use tmc2209::data::MicroStepResolution;
use tmc2209::reg::{CHOPCONF, GCONF, IHOLD_IRUN};
use tmc2209::{INTERNAL_CLOCK_HZ, rms_current_to_vsense_cs};

use super::stall::{LOOKS_FROM, seek_mm_min};

/// TSTEP counts clocks between steps of this size, whatever the microsteps.
const FINEST_MICROSTEPS: f32 = 256.0;
/// The longest time that the registers hold, clocks.
const LONGEST_CLOCKS: f32 = 1_048_575.0;
/// From the last step to the current at standstill: this many of 2^18 clocks, 22 ms each, for each step down.
const HOLD_DELAY: u8 = 8;

/// The registers to which a driver is set.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Registers {
    pub gconf: u32,
    pub chopconf: u32,
    pub ihold_irun: u32,
    pub tpwmthrs: u32,
    pub tcoolthrs: u32,
    pub sgthrs: u32,
}

impl Registers {
    /// `looks` has it tell stalls.
    pub fn new(settings: &Settings, axis: usize, sense_milliohms: u16, looks: bool) -> Self {
        let sense_ohms = f32::from(sense_milliohms) / 1000.0;
        let (is_sensitive, run) = rms_current_to_vsense_cs(sense_ohms, settings.run_current_ma[axis].into());
        let stealth_mm_min = settings.stealth_mm_min[axis];
        let looks_mm_min = if looks { LOOKS_FROM * seek_mm_min(settings, axis) } else { 0.0 };
        Self {
            gconf: gconf(stealth_mm_min == 0.0),
            chopconf: chopconf(settings.microsteps[axis], is_sensitive, settings.interpolate_mask & (1 << axis) != 0),
            ihold_irun: ihold_irun(run, settings.hold_percent[axis]),
            tpwmthrs: clocks(settings, axis, stealth_mm_min),
            tcoolthrs: clocks(settings, axis, looks_mm_min),
            sgthrs: settings.stall_threshold[axis].into(),
        }
    }

    /// The same with the motor off, which clears a short that the driver has found.
    pub fn off(self) -> u32 {
        let mut off = CHOPCONF(self.chopconf);
        off.set_toff(0);
        off.0
    }

    /// The microsteps, and the current of the moving and the standing motor, mA.
    pub fn shown(self, sense_milliohms: u16) -> (u32, u16, u16) {
        let (chopconf, currents) = (CHOPCONF(self.chopconf), IHOLD_IRUN(self.ihold_irun));
        let sense_ohms = f32::from(sense_milliohms) / 1000.0;
        let ma = |scale| tmc2209::vsense_cs_to_rms_current(sense_ohms, chopconf.vsense(), scale) as u16;
        (chopconf.mres().number_of_microsteps(), ma(currents.irun()), ma(currents.ihold()))
    }
}

/// The wire sets microsteps and current, not the pins.
fn gconf(is_spread_cycle: bool) -> u32 {
    let mut gconf = GCONF(0);
    gconf.set_en_spread_cycle(is_spread_cycle);
    gconf.set_pdn_disable(true);
    gconf.set_mstep_reg_select(true);
    gconf.set_multistep_filt(true);
    gconf.0
}

/// The chopper as the data sheet's example has it.
fn chopconf(microsteps: u16, is_sensitive: bool, interpolates: bool) -> u32 {
    let mut chopconf = CHOPCONF(0);
    chopconf.set_toff(3);
    chopconf.set_hstrt(5);
    chopconf.set_tbl(2);
    chopconf.set_vsense(is_sensitive);
    chopconf.set_intpol(interpolates);
    // The settings' check lets no other number pass.
    let microsteps = microsteps.clamp(1, 256).next_power_of_two();
    chopconf.set_mres(MicroStepResolution::from_microsteps(microsteps.into()));
    chopconf.0
}

fn ihold_irun(run: u8, hold_percent: u16) -> u32 {
    let mut currents = IHOLD_IRUN(0);
    currents.set_irun(run);
    // The current is as a scale + 1.
    currents.set_ihold(((u16::from(run) + 1) * hold_percent / 100).saturating_sub(1) as u8);
    currents.set_ihold_delay(HOLD_DELAY);
    currents.0
}

/// The time between the finest steps at this speed, clocks: what a speed is to TPWMTHRS, from which on SpreadCycle chops, and
/// TCOOLTHRS, from which on stalls are reported. 0, which is never reached, at no speed.
pub fn clocks(settings: &Settings, axis: usize, mm_min: f32) -> u32 {
    if mm_min == 0.0 {
        return 0;
    }
    let steps_s = mm_min / 60.0 * settings.steps_per_mm[axis];
    let finest_s = steps_s * FINEST_MICROSTEPS / f32::from(settings.microsteps[axis]);
    (INTERNAL_CLOCK_HZ / finest_s).clamp(1.0, LONGEST_CLOCKS) as u32
}
