//! The firmware's flash and RAM against their budgets.

use anyhow::{Result, bail};
use serde_json::{Value, json};

use crate::firmware::Firmware;
use crate::workspace;

/// A Pico has 2 MiB; this is so that growth is noticed.
const FLASH_BUDGET_BYTES: u64 = 192 * 1024;
const RAM_BUDGET_BYTES: u64 = 64 * 1024;
/// What the stack may take of the RAM budget. The chip gives it all RAM above the statics, so this is a promise to
/// whoever adds statics, not a limit the hardware knows.
const STACK_RESERVE_BYTES: u64 = 16 * 1024;

/// The figures, in bytes.
pub struct Footprint {
    flash: u64,
    static_ram: u64,
}

impl Footprint {
    pub fn new(firmware: &Firmware) -> Self {
        Self { flash: firmware.flash_bytes(), static_ram: firmware.static_ram_bytes }
    }

    fn ram(&self) -> u64 {
        self.static_ram + STACK_RESERVE_BYTES
    }

    /// One row each for flash and RAM.
    pub fn table(&self) -> String {
        let row = |name, used: u64, budget: u64| {
            let [used_kib, budget_kib] = [used, budget].map(|bytes| bytes as f64 / 1024.0);
            format!("{name:<24}{used_kib:>7.1} KiB  of {budget_kib:>4.0} KiB  {:>4} %\n", used * 100 / budget)
        };
        row("flash", self.flash, FLASH_BUDGET_BYTES) + &row("RAM (statics + stack)", self.ram(), RAM_BUDGET_BYTES)
    }

    /// The figures and their budgets, for other tools.
    pub fn json(&self) -> Value {
        json!({
            "elf": workspace::shown(&workspace::firmware_elf()),
            "flash_bytes": self.flash,
            "flash_budget_bytes": FLASH_BUDGET_BYTES,
            "static_ram_bytes": self.static_ram,
            "stack_reserve_bytes": STACK_RESERVE_BYTES,
            "ram_bytes": self.ram(),
            "ram_budget_bytes": RAM_BUDGET_BYTES,
        })
    }

    /// An error that names what is over its budget.
    pub fn check(&self) -> Result<()> {
        let rows = [("flash", self.flash, FLASH_BUDGET_BYTES), ("RAM", self.ram(), RAM_BUDGET_BYTES)];
        for (name, used, budget) in rows {
            if used > budget {
                bail!(
                    "{name}: {used} bytes are {} over the budget of {budget} (see xtask/src/footprint.rs)",
                    used - budget
                );
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_may_be_used_up_but_not_exceeded() {
        let static_ram = RAM_BUDGET_BYTES - STACK_RESERVE_BYTES;
        assert!(Footprint { flash: FLASH_BUDGET_BYTES, static_ram }.check().is_ok());
        let over = Footprint { flash: 0, static_ram: static_ram + 1 }.check().unwrap_err();
        assert_eq!(over.to_string(), "RAM: 65537 bytes are 1 over the budget of 65536 (see xtask/src/footprint.rs)");
    }

    #[test]
    fn the_table_shows_kibibytes_and_shares() {
        assert_eq!(
            Footprint { flash: 65536, static_ram: 16384 }.table(),
            "flash                      64.0 KiB  of  192 KiB    33 %\n\
             RAM (statics + stack)      32.0 KiB  of   64 KiB    50 %\n"
        );
    }
}
