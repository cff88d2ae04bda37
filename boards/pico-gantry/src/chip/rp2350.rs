//! The RP2350A of a Pico 2: two Cortex-M33, of which one is used, in secure state and without its FPU.
//!
//! # Software interrupts
//! embassy names them `SWI_IRQ_0` to `SWI_IRQ_5` and gives them the numbers 47 to 52, but the chip has 46 to 51. So `SWI_IRQ_5` is
//! none. The others interrupt as they should, because nothing but their number matters.
#![expect(unsafe_code, reason = "interrupts are masked, and a cache is emptied by addresses")]

use cortex_m::register::basepri;
use embassy_rp::interrupt::Priority;
use embassy_rp::pac::PSM;
use embassy_rp::pac::dma::{Channel, regs::ChTransCount};
use embassy_rp::pac::pio::StateMachine;
use embassy_rp::pac::pio::vals::{ExecctrlStatusN, ExecctrlStatusSel};
use embassy_rp::pac::psm::regs::Wdsel;
use embassy_rp::rom_data;
use isostep_controller::least_times;
use isostep_motion::LeastTimes;

pub use embassy_rp::interrupt::TIMER0_IRQ_0 as TIMER_INTERRUPT;
pub use embassy_rp::pac::TIMER0 as TIMER;
/// Prepares what doubles need.
pub use rp2350_floats::link as link_floats;

/// The name of the board that has this chip and the pins of a Pico.
pub const PICO: &str = "Raspberry Pi Pico 2";
/// Raspberry Pi's id for a serial port on this chip, which senders and udev rules know.
pub const USB_PRODUCT_ID: u16 = 0x0009;
pub const USB_PRODUCT: &str = "RP2350 gantry";
/// The name of the drive that the boot loader in the ROM is.
pub const BOOT_DRIVE: &str = "RP2350";

/// The clock of the core, the state machines and the PWM.
pub const CLOCK_HZ: u32 = 150_000_000;
/// The least cycles of a round of `cortex_m::asm::delay`: its subtraction, and a branch that costs no more.
pub const DELAY_ROUND_CYCLES: u32 = 2;
/// The least times that moves last, with which an image is linked.
pub const LEAST_TIMES: LeastTimes = least_times::RP2350;
/// The flash of a Pico 2.
pub const FLASH_BYTES: usize = 4 * 1024 * 1024;

/// The number of interrupts.
pub const INTERRUPTS: usize = 52;
/// The core requires a table of vectors to begin at a multiple of this type's alignment: the table's size, as a power of 2.
#[repr(align(512))]
pub struct VectorAlignment;

/// Does something while every interrupt is masked but those of P0.
#[inline(always)]
pub fn masked_below_p0<R>(work: impl FnOnce() -> R) -> R {
    let before = basepri::read();
    // SAFETY: masking interrupts breaks nothing but time.
    unsafe { basepri::write(Priority::P1 as u8) };
    let result = work();
    // SAFETY: they were as masked before.
    unsafe { basepri::write(before) };
    result
}

/// The number of transfers that a channel of DMA has still to make.
#[inline(always)]
pub fn transfers_left(channel: Channel) -> u32 {
    channel.trans_count().read().count()
}

/// Sets how many transfers a channel of DMA makes when it is started. The upper bits, which are 0, say that it makes them once.
#[inline(always)]
pub fn set_transfers(channel: Channel, count: u32) {
    channel.trans_count().write_value(ChTransCount(count));
}

/// Makes the STATUS of a state machine all ones while the level of its RX FIFO is below `level`, and 0 otherwise.
#[inline(always)]
pub fn set_status_below(machine: StateMachine, level: u8) {
    machine.execctrl().modify(|exec| {
        exec.set_status_sel(ExecctrlStatusSel::RXLEVEL);
        exec.set_status_n(ExecctrlStatusN(level));
    });
}

/// Sets what the watchdog resets: all but the oscillators. The HAL's bits are those of an RP2040, which here leave out the cores, and
/// what they are reset with, and name the oscillators.
pub fn set_watchdog_resets() {
    const ALL: u32 = 0x01FF_FFFF;

    let mut reset = Wdsel(ALL);
    reset.set_rosc(false);
    reset.set_xosc(false);
    PSM.wdsel().write_value(reset);
}

/// Starts the boot loader in the ROM, which lights the LED while it works. It offers both the USB drive and picotool's interface.
pub fn start_boot_loader(led_mask: u32) {
    /// To the boot loader, from which the call does not return (RP2350 datasheet, section 5.4.8.24).
    const BOOT_LOADER: u32 = 0x0002 | 0x0100;
    /// The ROM restarts the chip by the watchdog, after this time.
    const AFTER_MS: u32 = 10;
    /// The LED's pin is given.
    const HAS_LED: u32 = 0x20;

    let flags = if led_mask == 0 { 0 } else { HAS_LED };
    rom_data::reboot(BOOT_LOADER, AFTER_MS, flags, led_mask.trailing_zeros());
}

#[cfg(feature = "prove")]
pub mod prove {
    //! What a proving image alone needs.

    use embassy_rp::flash::{Blocking, Flash};
    use embassy_rp::otp;
    use embassy_rp::pac::PWM;
    use embassy_rp::peripherals::FLASH;

    pub use embassy_rp::interrupt::PWM_IRQ_WRAP_0 as WRAP_INTERRUPT;

    /// Flash by the alias that neither looks into the cache nor fills it.
    pub const UNCACHED_FLASH: usize = 0x1400_0000;

    /// The number of the board, which the chip has got from its maker; 0 if it cannot be read.
    pub fn board_id(_: &mut Flash<'static, FLASH, Blocking, { super::FLASH_BYTES }>) -> u64 {
        otp::get_chipid().unwrap_or(0)
    }

    /// Empties the cache of flash: a write to each place of it, by the addresses at which that means so.
    pub fn empty_cache() {
        const INVALIDATE: usize = 0x1800_0000;
        const CACHE_BYTES: usize = 16 * 1024;
        const LINE_BYTES: usize = 8;

        for place in (0..CACHE_BYTES).step_by(LINE_BYTES) {
            // SAFETY: nothing is written there. What the cache holds of flash is in flash too, and is read anew.
            unsafe { ((INVALIDATE + place) as *mut u8).write_volatile(0) };
        }
        cortex_m::asm::dsb();
    }

    /// Lets a slice of the PWM interrupt when it wraps.
    pub fn interrupt_at_wrap(slice: usize) {
        PWM.irq0_inte().modify(|enabled| enabled.0 |= 1 << slice);
    }
}
