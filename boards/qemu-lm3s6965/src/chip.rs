//! Registers and interrupts of the LM3S6965, as far as QEMU has them and this board needs them.
#![expect(unsafe_code, reason = "registers are memory, and the table of interrupts is a symbol that the linker knows")]

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;

/// A register at a fixed address.
#[derive(Clone, Copy)]
pub struct Register(u32);

impl Register {
    /// The register with this offset from the base of a peripheral.
    pub const fn at(base: u32, offset: u32) -> Self {
        Self(base + offset)
    }

    #[inline(always)]
    pub fn read(self) -> u32 {
        // SAFETY: the addresses in this package are registers and flash of the chip, which may be read at any time.
        unsafe { (self.0 as *const u32).read_volatile() }
    }

    #[inline(always)]
    pub fn write(self, value: u32) {
        // SAFETY: as above; no register of this package changes memory that belongs to the program.
        unsafe { (self.0 as *mut u32).write_volatile(value) }
    }
}

/// The interrupts of this board.
#[derive(Clone, Copy)]
#[repr(u16)]
pub enum Irq {
    /// The console's bytes.
    Uart0 = 5,
    /// The executor of the switches; a peripheral's interrupt that nothing raises.
    Switches = 7,
    /// The executor of the task that makes the steps; likewise.
    Steps = 8,
    /// The executor of the axes; likewise.
    Axes = 9,
    /// The executor of all that may wait; likewise.
    Rest = 10,
    /// The time driver's alarm.
    Timer0A = 19,
}

// SAFETY: these are numbers of interrupts of the chip.
unsafe impl InterruptNumber for Irq {
    fn number(self) -> u16 {
        self as u16
    }
}

impl Irq {
    /// Unmasks it at this priority: 0 is the highest of eight.
    pub fn enable(self, priority: u8) {
        self.set_priority(priority);
        // SAFETY: its handler is in the table below, and no code relies on it being masked.
        unsafe { NVIC::unmask(self) };
    }

    /// Sets its priority: 0 is the highest of eight.
    pub fn set_priority(self, priority: u8) {
        // SAFETY: only this function writes priorities, before the tasks of the board run.
        unsafe { cortex_m::Peripherals::steal().NVIC.set_priority(self, priority << 5) };
    }
}

/// The handler of an interrupt.
type Handler = extern "C" fn();

extern "C" fn unexpected() {
    panic!("an interrupt without a handler");
}

const INTERRUPTS: usize = Irq::Timer0A as usize + 1;

/// The handlers, which the runtime puts behind the exceptions.
// SAFETY: the section is the runtime's for this table, and nothing else has the name.
#[unsafe(link_section = ".vector_table.interrupts")]
// SAFETY: as above.
#[unsafe(no_mangle)]
static __INTERRUPTS: [Handler; INTERRUPTS] = {
    let mut table: [Handler; INTERRUPTS] = [unexpected; INTERRUPTS];
    table[Irq::Uart0 as usize] = crate::uart::on_interrupt;
    table[Irq::Switches as usize] = crate::executors::on_switches;
    table[Irq::Steps as usize] = crate::executors::on_steps;
    table[Irq::Axes as usize] = crate::executors::on_axes;
    table[Irq::Rest as usize] = crate::executors::on_rest;
    table[Irq::Timer0A as usize] = crate::time_driver::on_alarm;
    table
};
