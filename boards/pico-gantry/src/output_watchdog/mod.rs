//! An output watchdog: the tool's outputs are forced low by hardware when the core has not said for 20 ms that it is
//! well.
//!
//! # Design
//! A core that hangs stops no output: a laser would burn until the watchdog restarts the chip. So a state machine of
//! PIO1 counts down (`program`), and the executor of the axes feeds it every few milliseconds. When it has run out, it
//! says the same word again and again, and DMA takes one at a time into the registers of the tool's pads. The word
//! forces a pad low, whatever drives it. No instruction of the core has a part in that.
//!
//! If the core comes back the machine is told, and is in an alarm. Only then is the switch set again, and the tool's
//! inhibit decides about the pads as always.
//!
//! While the core is halted by a debug probe the output watchdog runs out too: a laser must not burn at a breakpoint.

mod program;

use embassy_rp::pac::dma::regs::CtrlTrig;
use embassy_rp::pac::dma::vals::{DataSize, TreqSel};
use embassy_rp::pac::io::regs::GpioCtrl;
use embassy_rp::pac::io::vals::{Oeover, Outover};
use embassy_rp::pac::{DMA, IO_BANK0, PIO1};
use embassy_time::Duration;
use isostep_motion::Machine;

use self::program::{ORIGIN, forced};
use crate::chip;
use crate::pins::{self, Group};

const CYCLES_PER_US: u32 = chip::CLOCK_HZ / 1_000_000;
/// The time that the tool stays on without a core. Longer than anything masks interrupts in motion, and four times as long
/// as the time between two feeds.
const PATIENCE: Duration = Duration::from_millis(20);
/// An erase of the flash masks all interrupts. It takes 400 ms at most, by the flash's datasheet.
const FLASH_PATIENCE: Duration = Duration::from_millis(450);

/// The guard has the first.
const STATE_MACHINE: usize = 1;
/// Of the first group; each other has the channel before.
const CHANNEL: usize = 11;
/// The tool's pads.
const PADS: [usize; 5] = pins::ascending([
    pins::TOOL_PWM,
    pins::TOOL_SWITCHES[0],
    pins::TOOL_SWITCHES[1],
    pins::TOOL_SWITCHES[2],
    pins::TOOL_SWITCHES[3],
]);
const GROUPS: [Group; pins::count_groups(&PADS)] = pins::groups(&PADS);
const _: () = assert!(
    GROUPS.len() == pins::CUT_OFF_CHANNELS && GROUPS.len() <= 3,
    "each group of the tool's pads needs a channel, and `set` arms three"
);
/// Of no peripheral.
const NO_FUNCTION: u8 = 31;

/// Starts to count. From now on it is to be [fed](feed).
pub fn start(channels: pins::CutOffChannels) {
    let count_down = program::count_down();
    for (address, &instruction) in (usize::from(ORIGIN)..).zip(&count_down.code) {
        PIO1.instr_mem(address).write(|slot| slot.set_instr_mem(instruction));
    }
    PIO1.sm(STATE_MACHINE).execctrl().write(|exec| {
        exec.set_wrap_bottom(ORIGIN + count_down.wrap.target);
        exec.set_wrap_top(ORIGIN + count_down.wrap.source);
    });
    PIO1.txf(STATE_MACHINE).write_value(force_low().0);
    force(forced::PULL);
    force(forced::SET_WORD);
    set();
    PIO1.ctrl().modify(|ctrl| ctrl.set_sm_enable(ctrl.sm_enable() | 1 << STATE_MACHINE));
    // The output watchdog keeps the channels for ever.
    let _ = channels;
}

/// The core is well, as far as the caller knows. If the output watchdog has run out, `machine` is reported, and the output
/// watchdog is set again.
pub fn feed(machine: &Machine) {
    if has_run_out() {
        machine.tool_cut_off();
        set();
    }
    force(forced::FEED);
}

/// Does what masks interrupts for as long as an erase of the flash, while the output watchdog is more patient.
pub fn outlast<R>(work: impl FnOnce() -> R) -> R {
    set_patience(FLASH_PATIENCE);
    let result = work();
    set_patience(PATIENCE);
    result
}

/// True if it forces the tool's pads low, or is about to.
pub fn has_run_out() -> bool {
    PIO1.sm(STATE_MACHINE).addr().read().addr() != ORIGIN
}

/// The value of CTRL with which a pad is driven low. It names no peripheral, so that none can release the pad.
fn force_low() -> GpioCtrl {
    let mut ctrl = GpioCtrl(0);
    ctrl.set_funcsel(NO_FUNCTION);
    ctrl.set_outover(Outover::LOW);
    ctrl.set_oeover(Oeover::ENABLE);
    ctrl
}

/// Sets the output watchdog, which may have run out.
fn set() {
    // What it does when it runs out must be over: the channels start each other in this order.
    for group in 0..GROUPS.len() {
        while DMA.ch(CHANNEL - group).ctrl_trig().read().busy() {}
    }
    set_patience(PATIENCE);
    force(forced::COUNT);
    // Both drop what is in the FIFO.
    PIO1.sm(STATE_MACHINE).shiftctrl().modify(|shift| shift.set_fjoin_rx(true));
    PIO1.sm(STATE_MACHINE).shiftctrl().modify(|shift| shift.set_fjoin_rx(false));
    // The first is started last. One by one: a loop would read its table from flash.
    if GROUPS.len() > 2 {
        arm::<2>();
    }
    if GROUPS.len() > 1 {
        arm::<1>();
    }
    arm::<0>();
}

/// Has a channel write the registers CTRL of a group of pads, and STATUS between two of them, which ignores what is written.
/// Then it starts that of the next group.
fn arm<const GROUP: usize>() {
    let Group { first, pins } = const { if GROUP < GROUPS.len() { GROUPS[GROUP] } else { GROUPS[0] } };
    let channel = DMA.ch(CHANNEL - GROUP);
    channel.read_addr().write_value(PIO1.rxf(STATE_MACHINE).as_ptr() as u32);
    channel.write_addr().write_value(IO_BANK0.gpio(first).ctrl().as_ptr() as u32);
    chip::set_transfers(channel, 2 * pins as u32 - 1);
    let mut ctrl = CtrlTrig(0);
    ctrl.set_en(true);
    ctrl.set_high_priority(true);
    ctrl.set_data_size(DataSize::SIZE_WORD);
    ctrl.set_incr_write(true);
    ctrl.set_treq_sel(TreqSel::PIO1_RX1);
    ctrl.set_irq_quiet(true);
    // The last starts itself, which means none.
    let is_last = GROUP + 1 == GROUPS.len();
    ctrl.set_chain_to((CHANNEL - GROUP - usize::from(!is_last)) as u8);
    if GROUP == 0 {
        channel.ctrl_trig().write_value(ctrl);
    } else {
        channel.al1_ctrl().write_value(ctrl.0);
    }
}

/// Counts from this time on, now and at every feed.
fn set_patience(patience: Duration) {
    PIO1.txf(STATE_MACHINE).write_value(patience.as_micros() as u32 * CYCLES_PER_US);
    force(forced::PULL);
    force(forced::FEED);
}

fn force(instruction: u16) {
    PIO1.sm(STATE_MACHINE).instr().write(|slot| slot.set_instr(instruction));
}
