//! A firmware that cannot go on leaves the machine still: no step, motors off, then a restart.
//!
//! # Design
//! The output latches belong to SIO, whose registers take effect in one cycle and need no owner, no clock and no
//! interrupt: so this works whatever state the rest is in. The cause goes into a watchdog scratch register, which
//! survives the restart, and is reported after it. The watchdog, not the handler, restarts the chip: a probe has its
//! time-out to fetch the log.
#![expect(unsafe_code, reason = "cortex-m-rt has fault handlers declared unsafe")]

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use embassy_rp::pac;

use crate::pins;

/// Why the chip restarted.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum Cause {
    /// A panic; its message went to the log.
    Panic,
    /// The core met an instruction or an address it cannot use.
    HardFault,
    /// An executor stood still until the watchdog ran out.
    Stall,
}

impl Cause {
    /// What the previous run ended with; `None` after power-up, the reset pin or a probe. Forgets it.
    pub fn of_last_restart() -> Option<Self> {
        let reason = pac::WATCHDOG.reason().read();
        let mark = pac::WATCHDOG.scratch0().read();
        pac::WATCHDOG.scratch0().write_value(0);
        let restarted = reason.timer() || reason.force();
        restarted.then_some(match mark {
            MARK_PANIC => Self::Panic,
            MARK_HARD_FAULT => Self::HardFault,
            _ => Self::Stall,
        })
    }
}

const MARK_PANIC: u32 = 0x50_41_4E_49;
const MARK_HARD_FAULT: u32 = 0x46_41_55_4C;

/// STEP low and ENABLE high, without asking who owns the pins.
fn stop_motors(mark: u32) {
    cortex_m::interrupt::disable();
    pac::SIO.gpio_out(0).value_clr().write_value(pins::STEP_MASK);
    pac::SIO.gpio_out(0).value_set().write_value(pins::ENABLE_MASK);
    pac::WATCHDOG.scratch0().write_value(mark);
}

fn await_watchdog() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    stop_motors(MARK_PANIC);
    defmt::error!("{}", defmt::Display2Format(info));
    await_watchdog()
}

// SAFETY: the handler reads the frame it is given, writes registers and never returns.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    stop_motors(MARK_HARD_FAULT);
    defmt::error!("hard fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
    await_watchdog()
}
