//! The RP2040 of a Pico or an SKR Pico: two Cortex-M0+, of which one is used.
#![expect(unsafe_code, reason = "interrupts are masked one by one")]

use cortex_m::peripheral::NVIC;
use embassy_rp::interrupt::Interrupt;
use embassy_rp::pac::dma::Channel;
use embassy_rp::pac::pio::{StateMachine, vals::SmExecctrlStatusSel};
use embassy_rp::rom_data;
use isostep_controller::least_times;
use isostep_motion::LeastTimes;
use portable_atomic as _;

pub use embassy_rp::interrupt::TIMER_IRQ_0 as TIMER_INTERRUPT;
pub use embassy_rp::pac::TIMER;
/// Looks up the ROM's functions for doubles.
pub use rp2040_floats::link as link_floats;

/// The name of the board that has this chip and the pins of a Pico.
pub const PICO: &str = "Raspberry Pi Pico";
/// Raspberry Pi's id for a serial port on this chip, which senders and udev rules know.
pub const USB_PRODUCT_ID: u16 = 0x000A;
pub const USB_PRODUCT: &str = "RP2040 gantry";
/// The name of the drive that the boot loader in the ROM is.
pub const BOOT_DRIVE: &str = "RPI-RP2";

/// The clock of the core, the state machines and the PWM.
pub const CLOCK_HZ: u32 = 125_000_000;
/// The least cycles of a round of `cortex_m::asm::delay`.
pub const DELAY_ROUND_CYCLES: u32 = 3;
/// The least times that moves last, with which an image is linked.
pub const LEAST_TIMES: LeastTimes = least_times::RP2040;
/// The flash of a Pico, and of an SKR Pico.
pub const FLASH_BYTES: usize = 2 * 1024 * 1024;

/// The number of interrupts.
pub const INTERRUPTS: usize = 32;
/// The core requires a table of vectors to begin at a multiple of this type's alignment.
#[repr(align(256))]
pub struct VectorAlignment;

/// The interrupts of P0, by their bits (`priority`).
const P0: u32 =
    1 << Interrupt::PIO1_IRQ_1 as u32 | if cfg!(feature = "prove") { 1 << Interrupt::PWM_IRQ_WRAP as u32 } else { 0 };

/// Does something while every interrupt is masked but those of P0. This core cannot mask by priority, so each is disabled. It may
/// not be called while it is doing something, and after start-up nobody else may enable or disable an interrupt.
#[inline(always)]
pub fn masked_below_p0<R>(work: impl FnOnce() -> R) -> R {
    // SAFETY: the address is that of the NVIC, whose registers may be written in any context.
    let nvic = unsafe { &*NVIC::PTR };
    let enabled = nvic.iser[0].read() & !P0;
    // SAFETY: masking interrupts breaks nothing but time.
    unsafe { nvic.icer[0].write(enabled) };
    // None of them comes after these.
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    let result = work();
    // SAFETY: they were enabled before.
    unsafe { nvic.iser[0].write(enabled) };
    result
}

/// The number of transfers that a channel of DMA has still to make.
#[inline(always)]
pub fn transfers_left(channel: Channel) -> u32 {
    channel.trans_count().read()
}

/// Sets how many transfers a channel of DMA makes when it is started.
#[inline(always)]
pub fn set_transfers(channel: Channel, count: u32) {
    channel.trans_count().write_value(count);
}

/// Makes the STATUS of a state machine all ones while the level of its RX FIFO is below `level`, and 0 otherwise.
#[inline(always)]
pub fn set_status_below(machine: StateMachine, level: u8) {
    machine.execctrl().modify(|exec| {
        exec.set_status_sel(SmExecctrlStatusSel::RXLEVEL);
        exec.set_status_n(level);
    });
}

/// Sets what the watchdog resets: here nothing has to be done, because the HAL names all but the oscillators.
#[inline(always)]
pub fn set_watchdog_resets() {}

/// Starts the boot loader in the ROM, which lights the LED while it works.
pub fn start_boot_loader(led_mask: u32) {
    /// It offers both the USB drive and picotool's interface.
    const ALL_INTERFACES: u32 = 0;

    rom_data::reset_to_usb_boot(led_mask, ALL_INTERFACES);
}

#[cfg(feature = "prove")]
pub mod prove {
    //! What a proving image alone needs.

    use embassy_rp::flash::{Blocking, Flash};
    use embassy_rp::pac::{PWM, XIP_CTRL};
    use embassy_rp::peripherals::FLASH;

    pub use embassy_rp::interrupt::PWM_IRQ_WRAP as WRAP_INTERRUPT;

    /// Flash by the alias that neither looks into the cache nor fills it.
    pub const UNCACHED_FLASH: usize = 0x1300_0000;

    /// The number of the board, which the flash's maker gave to the flash; 0 if it cannot be read.
    pub fn board_id(flash: &mut Flash<'static, FLASH, Blocking, { super::FLASH_BYTES }>) -> u64 {
        let mut id = [0; 8];
        flash.blocking_unique_id(&mut id).map_or(0, |()| u64::from_be_bytes(id))
    }

    /// Empties the cache of flash.
    pub fn empty_cache() {
        XIP_CTRL.flush().write(|flush| flush.set_flush(true));
        // The chip holds this read up until all lines have gone.
        XIP_CTRL.flush().read();
    }

    /// Lets a slice of the PWM interrupt when it wraps.
    pub fn interrupt_at_wrap(slice: usize) {
        PWM.inte().modify(|enabled| enabled.0 |= 1 << slice);
    }
}
