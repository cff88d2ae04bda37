//! When the firmware cannot continue, or starts the boot loader, the machine is left still: no step, motors and tool
//! off. Then the chip restarts.
//!
//! # Design
//! The state machines are halted, and STEP is given back to SIO. Its latches take effect in one cycle and need no
//! owner, no clock and no interrupt. So this works whatever state the rest is in. The cause is written to a watchdog
//! scratch register, which survives the restart, and is reported after it. The watchdog restarts the chip, not the
//! handler: so a debug probe has the watchdog's time-out to read the log.
#![expect(unsafe_code, reason = "cortex-m-rt has fault handlers declared unsafe")]

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m_rt::{ExceptionFrame, exception};
use embassy_rp::pac;

use crate::{chip, pins, tool};

/// Why the chip restarted.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum RestartCause {
    /// A panic; its message went to the log.
    Panic,
    /// The core met an instruction or an address it cannot use.
    HardFault,
    /// An executor stood still until the watchdog ran out.
    Stall,
}

impl RestartCause {
    /// The cause that ended the previous run, which this call clears. `None` after power-up, or after a restart by the
    /// reset pin, a debug probe or the boot loader.
    pub fn of_last_restart() -> Option<Self> {
        let reason = pac::WATCHDOG.reason().read();
        let last = pac::WATCHDOG.scratch0().read();
        mark(MARK_RUNNING);
        let restarted = reason.timer() || reason.force();
        match last {
            _ if !restarted => None,
            MARK_PANIC => Some(Self::Panic),
            MARK_HARD_FAULT => Some(Self::HardFault),
            MARK_RUNNING => Some(Self::Stall),
            // The boot loader also restarts the chip by the watchdog, after it has used this register itself.
            _ => None,
        }
    }

    /// The message for the consoles.
    pub fn message(self) -> &'static str {
        match self {
            Self::Panic => "[MSG:Restarted after a panic, position lost: home, and report what the log says]\r\n",
            Self::HardFault => "[MSG:Restarted after a hard fault, position lost: home, and report it]\r\n",
            Self::Stall => "[MSG:Restarted by the watchdog, position lost: home, and report it]\r\n",
        }
    }
}

static ENABLE_INVERTED: AtomicBool = AtomicBool::new(false);

/// Sets which level of ENABLE frees the motors. This is setting `$4`, which a fault handler cannot look up safely.
pub fn set_enable_inverted(inverted: bool) {
    ENABLE_INVERTED.store(inverted, Ordering::Relaxed);
}

/// The number of the function SIO, which is the same for every pin.
const SIO_FUNCTION: u8 = 5;
const MARK_PANIC: u32 = 0x50_41_4E_49;
const MARK_HARD_FAULT: u32 = 0x46_41_55_4C;
const MARK_RUNNING: u32 = 0x52_55_4E_53;

/// 2 us of the chip's clock. No driver needs a longer pulse of STEP.
const PULSE_CYCLES: u32 = chip::CLOCK_HZ / 500_000;

/// Sets STEP low and switches the motors and the tool off, whoever owns the pins.
fn stop_all() {
    cortex_m::interrupt::disable();
    tool::inhibit(true);
    pac::PIO0.ctrl().write_value(pac::pio::regs::Ctrl(0));
    #[cfg(five_motors)]
    pac::PIO2.ctrl().write_value(pac::pio::regs::Ctrl(0));
    // Keeps the present level, so that a pulse that has just begun has its full length.
    cortex_m::asm::delay(PULSE_CYCLES);
    let latch = pac::SIO.gpio_out(0);
    latch.value_clr().write_value(pins::STEP_MASK);
    pac::SIO.gpio_oe(0).value_set().write_value(pins::STEP_MASK);
    for pin in pins::STEP {
        pac::IO_BANK0.gpio(pin).ctrl().write(|ctrl| ctrl.set_funcsel(SIO_FUNCTION));
    }
    let enable_off = if ENABLE_INVERTED.load(Ordering::Relaxed) { latch.value_clr() } else { latch.value_set() };
    enable_off.write_value(pins::ENABLE_MASK);
}

fn mark(cause: u32) {
    pac::WATCHDOG.scratch0().write_value(cause);
}

/// Starts the boot loader in the ROM. It restarts the chip with all pins free, and the board becomes a USB drive.
pub fn start_boot_loader() -> ! {
    stop_all();
    chip::start_boot_loader(pins::LED_MASK);
    await_watchdog()
}

fn await_watchdog() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    stop_all();
    mark(MARK_PANIC);
    defmt::error!("{}", defmt::Display2Format(info));
    await_watchdog()
}

// SAFETY: the handler only reads the frame that it is given, writes registers, and never returns.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    stop_all();
    mark(MARK_HARD_FAULT);
    defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
    await_watchdog()
}
