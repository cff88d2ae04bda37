//! Compares the firmware's flash and RAM with their budgets.

use anyhow::{Result, bail};
use isostep::chip::Chip;

use crate::firmware::Firmware;
use crate::variant::{Axes, Variant};

const KIB: u64 = 1024;
/// RAM reserved for the stack. The chip gives the stack all RAM above the statics, so this is not a hardware limit: it
/// keeps added statics from taking too much.
const STACK_RESERVE_BYTES: u64 = 16 * KIB;
/// The room that an image may take.
#[derive(Clone, Copy)]
struct Budget {
    flash: u64,
    code: u64,
    statics: u64,
}

/// A Pico has 2 MiB of flash; the smaller budget makes growth visible. What senders of grblHAL read takes 8 KiB of it, a change of the
/// tool 18 KiB, a spindle with a VFD 16 KiB and crossed belts 9 KiB. The RP2040 has 264 KiB of RAM in total; the smaller budgets keep
/// room for what is to come. 1.5 KiB of the statics are the table of 32 tools and nine work coordinate systems, in force and as the
/// flash has them; 1 KiB of code and 1 KiB of statics are a VFD, alarms of drives and crossed belts.
const RP2040_BUDGET: Budget = Budget { flash: 420 * KIB, code: 125 * KIB, statics: 84 * KIB };
/// A Pico 2 has 4 MiB of flash, and the RP2350 520 KiB of RAM: the budgets alone make growth visible.
const RP2350_BUDGET: Budget = Budget { flash: 420 * KIB, code: 131 * KIB, statics: 84 * KIB };
/// The room that a fourth axis may take, of code and of statics.
const FOURTH_AXIS_BUDGET_BYTES: [u64; 2] = [KIB, 14 * KIB];
/// The room that an image that measures itself may take, of code and of statics.
const PROVE_BUDGET_BYTES: [u64; 2] = [KIB, 7 * KIB];

/// The firmware's use of memory, in bytes.
pub struct Footprint {
    flash: u64,
    code: u64,
    statics: u64,
    budget: Budget,
}

/// A figure and its budget, in bytes.
struct Row {
    name: &'static str,
    used: u64,
    budget: u64,
}

impl Footprint {
    /// That of a variant of the firmware.
    pub fn new(firmware: &Firmware, variant: Variant) -> Self {
        let fourth = if variant.axes == Axes::Four { FOURTH_AXIS_BUDGET_BYTES } else { [0; 2] };
        let prove = if variant.prove { PROVE_BUDGET_BYTES } else { [0; 2] };
        let [code, statics] = std::array::from_fn(|part| fourth[part] + prove[part]);
        let budget = budget(variant.chip());
        Self {
            flash: firmware.flash_bytes(),
            code: firmware.ram_code_bytes,
            statics: firmware.static_ram_bytes,
            budget: Budget { code: budget.code + code, statics: budget.statics + statics, ..budget },
        }
    }

    fn ram_budget(&self) -> u64 {
        self.budget.code + self.budget.statics + STACK_RESERVE_BYTES
    }

    fn ram(&self) -> u64 {
        self.code + self.statics + STACK_RESERVE_BYTES
    }

    fn rows(&self) -> [Row; 5] {
        let row = |name, used, budget| Row { name, used, budget };
        [
            row("flash", self.flash, self.budget.flash),
            row("RAM: code", self.code, self.budget.code),
            row("RAM: statics", self.statics, self.budget.statics),
            row("RAM: stack, reserved", STACK_RESERVE_BYTES, STACK_RESERVE_BYTES),
            row("RAM, in all", self.ram(), self.ram_budget()),
        ]
    }

    /// A row for flash, and for each part of RAM.
    pub fn table(&self) -> String {
        let kib = |bytes: u64| bytes as f64 / KIB as f64;
        let line = |Row { name, used, budget }| {
            format!("{name:<24}{:>7.1} KiB  of {:>4.0} KiB  {:>4} %\n", kib(used), kib(budget), used * 100 / budget)
        };
        self.rows().map(line).concat()
    }

    /// An error that names a figure that exceeds its budget.
    pub fn check(&self) -> Result<()> {
        if let Some(Row { name, used, budget }) = self.rows().into_iter().find(|row| row.used > row.budget) {
            bail!(
                "{name}: {used} bytes are {} over the budget of {budget} (see xtask/src/footprint.rs)",
                used - budget
            );
        }
        Ok(())
    }
}

fn budget(chip: Chip) -> Budget {
    match chip {
        Chip::Rp2040 => RP2040_BUDGET,
        Chip::Rp2350 => RP2350_BUDGET,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL: Footprint = Footprint {
        flash: RP2040_BUDGET.flash,
        code: RP2040_BUDGET.code,
        statics: RP2040_BUDGET.statics,
        budget: RP2040_BUDGET,
    };

    #[test]
    fn a_budget_may_be_used_up_but_not_exceeded() {
        assert!(FULL.check().is_ok());
        let over = Footprint { code: RP2040_BUDGET.code + 1, ..FULL }.check().unwrap_err();
        let expected = "RAM: code: 128001 bytes are 1 over the budget of 128000 (see xtask/src/footprint.rs)";
        assert_eq!(over.to_string(), expected);
    }

    #[test]
    fn the_table_shows_kibibytes_and_shares() {
        assert_eq!(
            Footprint { flash: 196_608, code: 73_728, statics: 18_432, ..FULL }.table(),
            "flash                     192.0 KiB  of  420 KiB    45 %\n\
             RAM: code                  72.0 KiB  of  125 KiB    57 %\n\
             RAM: statics               18.0 KiB  of   84 KiB    21 %\n\
             RAM: stack, reserved       16.0 KiB  of   16 KiB   100 %\n\
             RAM, in all               106.0 KiB  of  225 KiB    47 %\n"
        );
    }
}
